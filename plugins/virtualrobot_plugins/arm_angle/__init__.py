"""The kinematics component `arm_angle`: seven-axis arms with spherical shoulder and wrist, in closed form."""
