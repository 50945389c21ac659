"""Demonstrations: a palletizing cell, an arm that avoids obstacles, an arm that maps a cell."""
