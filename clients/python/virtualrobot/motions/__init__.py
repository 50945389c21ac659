"""Motions: moves, programs, plans, paths and setpoints."""
