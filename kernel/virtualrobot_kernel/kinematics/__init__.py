"""Kinematics components: the interface that all have, and `chain` for any serial chain."""
