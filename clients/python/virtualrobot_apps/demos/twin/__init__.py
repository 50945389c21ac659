"""Twins in the palletizing cell, and two emulated controllers that follow them. `virtualrobot demo twin` runs it."""
