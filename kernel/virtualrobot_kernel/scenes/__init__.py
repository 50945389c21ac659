"""Scenes and models that are asked for, as commands for the world; and the world as a scene file."""
