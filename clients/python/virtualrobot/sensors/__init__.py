"""Sensors: their settings, what they say, and rays."""
