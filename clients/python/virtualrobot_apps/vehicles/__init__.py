"""Missions of vehicles under water: paths, guidance, control and thrusters, as a client gives them."""
