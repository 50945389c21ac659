"""Server of the rosbridge protocol 2 over WebSocket, for roslibpy, roslib and whoever else speaks it."""
