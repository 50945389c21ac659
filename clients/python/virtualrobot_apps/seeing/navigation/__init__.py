"""Navigation of mobile bases by lidar and odometry: mapping, localisation, planning and driving."""
