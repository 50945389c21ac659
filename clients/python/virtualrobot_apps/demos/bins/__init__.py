"""Boxes fall from a conveyor into a bin, from which an arm takes them by friction. `virtualrobot demo bins` runs it."""
