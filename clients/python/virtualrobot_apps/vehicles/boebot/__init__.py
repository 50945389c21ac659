"""The Boe-Bot: it follows a line by its camera, and passes mazes by its sonars, as a client drives it."""
