"""ROS: what a world tells and hears, under the names and messages that ROS users expect, by thin transports."""
