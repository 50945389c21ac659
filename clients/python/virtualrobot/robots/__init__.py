"""Robots: what they are, where they are, and what is computed of them."""
