"""Collisions: what touches, what may, and how far things are apart."""
