"""Client applications: programs like anybody's, written with the client library alone."""
