"""Scenes and models read as commands for the world; and the world written as a scene file."""
