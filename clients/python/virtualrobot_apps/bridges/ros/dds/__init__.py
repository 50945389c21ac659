"""A node of ROS 2 by Eclipse Cyclone DDS, without ROS."""
