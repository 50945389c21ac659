"""Robots' own languages."""
