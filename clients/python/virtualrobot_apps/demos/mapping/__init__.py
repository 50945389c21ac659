"""Occupancy map of a cell, by a laser or by ultrasound on an arm. `virtualrobot map` runs it."""
