"""History of the world: how commands and states are written, and what is made of them later."""
