"""Compiled code for plugins and kernel (numba, without the GIL): where it is kept, and steps on rigid transforms."""
