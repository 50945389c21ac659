"""The driver `dynamixel`: servos of the X series on one bus, by their makers' library."""
