"""Files in and out: assets by content, URDF and mesh files, scene files. Everything here runs off the world thread."""
