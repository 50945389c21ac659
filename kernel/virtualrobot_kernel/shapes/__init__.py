"""Geometry of figures as triangles and solids: what is read from files and seen by sensors, collisions and pictures."""
