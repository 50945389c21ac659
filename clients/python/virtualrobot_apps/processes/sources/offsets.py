"""Ways beside others: offsets across a way and out of the part, and the passes of a seam in layers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.curves.way import Floats, Way, place


def offset(way: Way, across: float = 0.0, away: float = 0.0) -> Way:
    """Return a way beside another.

    Args:
        way: points close enough to each other to show its bends (`sampling.sampled`).
        across: how far to the left, along the surface, seen from outside and along the way (m).
        away: how far out of the part, along the normal or the bisector of two (m).

    Raises:
        InvalidArgumentError: for lengths that are not finite, and where the way bends closer than it is to be offset.
    """
    for what, value in (("across", across), ("away", away)):
        if not np.isfinite(value):
            raise InvalidArgumentError(f"the offset {what} is {value} m; it must be finite")
    out = way.outward
    left = np.cross(out, way.tangents)
    sizes = np.linalg.norm(left, axis=1)
    if (sizes < 1e-6).any():
        raise InvalidArgumentError(f"{place(way, int(sizes.argmin()))} the normal is along the way")
    points = way.points + across * left / sizes[:, None] + away * out
    bent = folded(way.points, points)
    if bent is not None:
        raise InvalidArgumentError(
            f"{place(way, bent)} the way bends closer than {1e3 * np.hypot(across, away):.6g} mm, by which it is to be "
            "offset: there it would go back"
        )
    return Way(points, way.normals, way.closed)


def passes(way: Way, offsets: Sequence[tuple[float, float]], *, back_and_forth: bool = False) -> list[Way]:
    """Return the passes of a way, each beside it by (across, away) of `offset`, in m; every other one turned if asked.

    Raises InvalidArgumentError where there are none, and for what `offset` refuses.
    """
    if not len(offsets):
        raise InvalidArgumentError("there are no passes: give (across, away) in m for each")
    found = [offset(way, *one) for one in offsets]
    return [one.reversed() if back_and_forth and row % 2 else one for row, one in enumerate(found)]


def folded(points: Floats, beside: Floats) -> int | None:
    """Return the first line between points (n, 3) that goes back between the points (n, 3) beside them, or None."""
    back = np.einsum("ij,ij->i", np.diff(points, axis=0), np.diff(beside, axis=0)) <= 0.0
    return int(back.argmax()) if back.any() else None
