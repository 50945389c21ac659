"""Solids that are modelled: a file says how bodies are made of others, and Manifold makes them."""
