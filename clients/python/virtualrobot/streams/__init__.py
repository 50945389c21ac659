"""Streams: all that a world tells, again and again, in one table: name, rate, unit, frame, type. No ROS is needed."""
