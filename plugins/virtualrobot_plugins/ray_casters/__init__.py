"""The bundled ray casters, one a file; `reference` is the one to read and to replace."""
