"""VRML97 worlds: shapes, transforms, prototypes and inlined files."""
