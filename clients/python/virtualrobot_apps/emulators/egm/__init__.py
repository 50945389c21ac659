"""An emulated ABB controller with Externally Guided Motion (EGM)."""
