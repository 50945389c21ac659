"""The client library of VirtualRobot."""
