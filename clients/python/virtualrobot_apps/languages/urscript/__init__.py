"""URScript, the language of Universal Robots' controllers: read, checked, and run in cycles of a controller."""
