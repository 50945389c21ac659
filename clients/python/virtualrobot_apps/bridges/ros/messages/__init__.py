"""Messages of ROS without ROS: types, values, and each message encoded once for all who read it."""
