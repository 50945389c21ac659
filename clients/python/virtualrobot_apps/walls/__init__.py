"""Walls and rooms of walls that people stand before: what each shows, for the eyes that look at it."""
