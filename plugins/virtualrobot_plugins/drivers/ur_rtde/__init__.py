"""The driver `ur_rtde`: Universal Robots by Real-Time Data Exchange."""
