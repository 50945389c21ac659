"""Worlds of faults: random clients, failing components and kills against a real kernel, and what must hold always."""
