"""The compiled core of the world (numba, without the GIL): the forward pass of the whole scene."""
