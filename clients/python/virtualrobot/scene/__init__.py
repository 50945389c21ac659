"""The scene: its nodes, their shapes, and changes of both."""
