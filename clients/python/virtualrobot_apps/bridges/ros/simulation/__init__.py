"""Services of `simulation_interfaces`, by which ROS 2 spawns, moves, steps and resets what any simulator simulates."""
