"""Exporters to other programs' formats: a part of the world as glTF, a robot as URDF."""
