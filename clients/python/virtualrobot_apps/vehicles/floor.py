"""Floors of vehicles that move by forces: the engine that is none, and how floors rub."""

NO_PHYSICS = "none"
"""Name that stands for no engine: nothing moves by forces."""
FRICTION = 0.8
"""Friction of floors and ground: that of the UGV's document for its wheels."""
