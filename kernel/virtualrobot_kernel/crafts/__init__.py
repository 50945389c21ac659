"""Crafts: robots whose base is moved by their drives, as their components say."""
