"""Triangles as a binary STL file."""

from __future__ import annotations

import struct

import numpy as np

from virtualrobot_kernel.shapes.submesh import Submesh

FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write_stl(part: Submesh) -> bytes:
    """Return the triangles as binary STL, meters; normals are those of the faces."""
    facets = np.zeros(len(part.faces), FACET)
    facets["corners"] = corners = part.vertices[part.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).astype(np.float64)
    facets["normal"] = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-30)
    # A header that begins with "solid" would be taken for text.
    return b"binary STL, meters".ljust(80) + struct.pack("<I", len(facets)) + facets.tobytes()
