"""Robots that see and act on it: clients that know what sensors tell; the true scene serves measuring only."""
