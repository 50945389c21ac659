"""Frames of a tool along ways: z against the surface, or along an axis, and x along the way."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.curves.way import Floats, Way, place

ALONG = 1e-3
"""Sine of the angle between tool and way below which it is open how the tool is turned about itself."""


def frames(way: Way, axis: ArrayLike, *, turn: bool = True) -> Floats:
    """Return frames (n, 4, 4) of the tool centre point: z along `axis` (3,), x along the way as far as it is across z.

    Where the way has normals of the surface, z is against them. Without `turn` the tool is turned about itself as
    little as can be, beginning along the way.

    Raises InvalidArgumentError for an axis along the way, and for one without length.
    """
    z = -way.facing(axis).outward
    tangents = way.tangents
    found = np.tile(np.eye(4), (len(z), 1, 1))
    along = tangents[0]
    for row, point in enumerate(way.points):
        if turn:
            along = tangents[row]
        across = along - (along @ z[row]) * z[row]
        size = np.linalg.norm(across)
        if size < ALONG:
            raise InvalidArgumentError(
                f"{place(way, row)} the tool's axis is along the way, which leaves open how the tool is turned "
                "about it; give another --tool-axis"
            )
        x = across / size
        found[row, :3, :] = np.stack([x, np.cross(z[row], x), z[row], point], axis=1)
        along = x
    return found
