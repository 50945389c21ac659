"""The kernel of VirtualRobot: one process that owns one world; `kernel.py` joins its rooms."""
