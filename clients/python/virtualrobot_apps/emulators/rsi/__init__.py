"""An emulated KUKA controller with the Robot Sensor Interface (RSI)."""
