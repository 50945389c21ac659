"""Sensors: elements of the world as shapes for rays, range sensors, cameras, contacts, and how things move."""
