"""Messages that describe a world, and the values of the world: both ways, for files and for calls alike."""
