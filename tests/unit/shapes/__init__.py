"""Tests of figures as triangles and solids."""
