"""Mapping of streams to the names and messages of ROS, and back: pure functions."""
