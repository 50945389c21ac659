"""Collisions as people are shown them: what touches is red, dots tell where, the background is rose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.report import Touch
from virtualrobot_kernel.drawing.figure_glb import Rgba
from virtualrobot_kernel.drawing.view import Color, ViewSettings
from virtualrobot_kernel.sensing.appearance import Appearances, linear

Touching = tuple[Touch, ...]
"""Touches that the collision monitor has found."""

RED: Color = (0.86, 0.10, 0.09)
"""Of nodes that touch and may not."""

ROSE: Color = (1.0, 0.50, 0.48)
ROSE_SHARE = 0.3
"""Colour that is mixed into the background while anything touches, and the part of it."""


def shown(settings: ViewSettings, touching: Touching) -> Touching:
    """Return what is to be shown of what touches."""
    return () if settings.collisions_hidden else touching


def red_nodes(touching: Touching) -> frozenset[int]:
    """Return the nodes (uids) that touch."""
    return frozenset(uid for touch in touching for uid in (touch.pair.first, touch.pair.second))


def contact_points(touching: Touching) -> NDArray[np.float64]:
    """Return where the nodes began to touch, (n, 3) meters in the world's frame."""
    found = [contacts.points for touch in touching for contacts in touch.pair.contacts]
    return np.concatenate([np.zeros((0, 3)), *found])


def alarmed(background: Color) -> Color:
    """Return the colour of a background while something touches."""
    red, green, blue = (
        (1.0 - ROSE_SHARE) * own + ROSE_SHARE * rose for own, rose in zip(background, ROSE, strict=True)
    )
    return red, green, blue


def reddened(color: Rgba | None) -> Rgba:
    """Return the colour of what touches instead of its own; glass stays glass."""
    return *RED, 1.0 if color is None else color[3]


def red_looks(looks: Appearances, uids: NDArray[np.int64], red: frozenset[int]) -> Appearances:
    """Return the looks of elements of the nodes `uids` (e,) with those of `red` nodes red."""
    rows = np.isin(uids, list(red))
    if not rows.any():
        return looks
    colors, starts = looks.colors.copy(), looks.starts.copy()
    colors[rows, :3] = linear(np.array([[*RED, 1.0]]))[0, :3]
    starts[rows, 3] = True
    return replace(looks, colors=colors, starts=starts)
