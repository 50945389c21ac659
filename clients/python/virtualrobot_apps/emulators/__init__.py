"""Emulated controllers: programs that speak to a real robot by its own protocol find a simulated one there."""
