"""Demos of processes: for each a cell, a process in it, and bodies from files."""

from pathlib import Path

CELLS = Path(__file__).parent / "cells"
"""Folder of their files."""
