"""DXF drawings: 3D faces, meshes, polyface meshes and extruded outlines."""
