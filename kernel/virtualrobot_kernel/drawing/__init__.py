"""The draw loop and the viewer: a picture of the world in a browser; nothing else draws."""
