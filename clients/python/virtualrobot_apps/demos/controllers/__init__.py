"""A cell whose three robots have emulated controllers, at which programs of other people work."""
