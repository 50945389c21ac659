"""The driver `kuka_rsi`: KUKA robots by the Robot Sensor Interface."""
