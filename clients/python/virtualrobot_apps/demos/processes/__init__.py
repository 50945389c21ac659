"""Demos of processes: for each a cell, a process in it, and bodies from files."""
