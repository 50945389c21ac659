"""Frames of a tool along ways, by work and travel angle, as `client.paths.find_tool_path` takes them; and weaves."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot import path_frames
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.curves.way import Floats, Way, above_zero, place, units
from virtualrobot_apps.processes.sources.offsets import folded
from virtualrobot_apps.processes.sources.sections import unit

STEEPEST = np.radians(80.0)
"""The greatest travel angle (rad)."""
WAVES = {"sine": 12, "triangle": 8, "trapezoid": 12}
"""Shapes of weaves, and the frames of one wave."""


def tool_frames(
    way: Way,
    *,
    work: float | None = None,
    base: ArrayLike = (0.0, 0.0, 1.0),
    travel: float = 0.0,
    standoff: float = 0.0,
) -> Floats:
    """Return frames (n, 4, 4) along a way: z against the surface, x along the way as far as that is across z.

    Angles are those of AWS A3.0, *Standard Welding Terms and Definitions*.

    Args:
        way: where the tool goes.
        work: the angle (rad) between the tool and the normal of the face that looks most along `base`, towards the
            normal of the other face; on a surface, to the left. By default the tool is along the bisector, or the
            normal.
        base: (3,) where the face looks that `work` is measured from.
        travel: the angle (rad) by which the tool leans along the way: above 0 it points forward (push), below 0 back
            (drag); at most 80 degrees.
        standoff: the distance (m) that the tool centre point stays before the way, along z.

    Raises:
        InvalidArgumentError: for angles beyond these, where faces leave the angle open, and where the tool would be
            along the way.
    """
    if not (np.isfinite(travel) and abs(travel) <= STEEPEST):
        raise InvalidArgumentError(f"the travel angle is {np.degrees(travel):.6g} degrees; it is from -80 to 80")
    if not np.isfinite(standoff):
        raise InvalidArgumentError(f"the standoff is {standoff} m; it must be finite")
    tangents = way.tangents
    out = way.outward if work is None else _turned(way, tangents, work, unit("base", base))
    out = out - np.einsum("ij,ij->i", out, tangents)[:, None] * tangents
    sizes = np.linalg.norm(out, axis=1)
    if sizes.min() < 1e-3:
        raise InvalidArgumentError(f"{place(way, int(sizes.argmin()))} the tool would be along the way")
    z = -np.cos(travel) * out / sizes[:, None] + np.sin(travel) * tangents
    points = way.points - standoff * z
    if not way.closed:
        return path_frames(points, z)
    # Round a loop, so that it ends as it begins.
    return path_frames(*(np.concatenate([one[-2:-1], one, one[1:2]]) for one in (points, z)))[1:-1]


def heading_frames(way: Way, heading: ArrayLike = (1.0, 0.0, 0.0), *, standoff: float = 0.0) -> Floats:
    """Return frames (n, 4, 4) along a way: z against the surface, x along one direction as far as that is across z.

    For tools that are the same all around and that plunge along their axis, as those of G-code do.

    Args:
        way: where the tool goes.
        heading: (3,) along which x is.
        standoff: the distance (m) that the tool centre point stays before the way, along z.

    Raises:
        InvalidArgumentError: for a standoff that is not finite, and where the heading is along a normal.
    """
    if not np.isfinite(standoff):
        raise InvalidArgumentError(f"the standoff is {standoff} m; it must be finite")
    z = -way.outward
    x = unit("heading", heading) - (z @ unit("heading", heading))[:, None] * z
    sizes = np.linalg.norm(x, axis=1)
    if sizes.min() < 1e-3:
        raise InvalidArgumentError(
            f"{place(way, int(sizes.argmin()))} the heading is along the normal; give another one"
        )
    x = x / sizes[:, None]
    frames = np.tile(np.eye(4), (len(z), 1, 1))
    frames[:, :3, :3] = np.stack([x, np.cross(z, x), z], axis=2)
    frames[:, :3, 3] = way.points - standoff * z
    return frames


def _turned(way: Way, tangents: Floats, work: float, base: Floats) -> Floats:
    """Return directions (n, 3) at a work angle (rad) to the normal of a face."""
    if not (np.isfinite(work) and abs(work) < 0.5 * np.pi):
        raise InvalidArgumentError(f"the work angle is {np.degrees(work):.6g} degrees; it is between -90 and 90")
    if way.normals.shape[1] == 1:
        normal = way.normals[:, 0]
        aside = np.cross(normal, tangents)
    else:
        first = int((way.normals.mean(axis=0) @ base).argmax())
        normal, aside = way.normals[:, first], way.normals[:, 1 - first]
    aside = aside - np.einsum("ij,ij->i", aside, normal)[:, None] * normal
    sizes = np.linalg.norm(aside, axis=1)
    if sizes.min() < 1e-3:
        raise InvalidArgumentError(f"{place(way, int(sizes.argmin()))} the faces leave open where the work angle goes")
    return np.cos(work) * normal + np.sin(work) * aside / sizes[:, None]


def weave(frames: ArrayLike, width: float, length: float, shape: str = "sine") -> Floats:
    """Return frames (m, 4, 4) that swing along y about others: 12 or 8 of them a wave, a whole number of waves.

    Args:
        frames: (n, 4, 4) along a way, such as `tool_frames` makes; what is between them is on the lines between.
        width: from side to side (m).
        length: of a wave along the way (m), as near to it as makes them whole.
        shape: `sine`, `triangle`, or `trapezoid`, which stays at the side for a sixth of the wave.

    Raises:
        InvalidArgumentError: for lengths that are not above 0, another shape, a wave longer than the way, and where the
            way bends closer than half the width.
    """
    along = np.array(frames, dtype=np.float64)
    if along.ndim != 3 or along.shape[1:] != (4, 4) or len(along) < 2 or not np.isfinite(along).all():
        raise InvalidArgumentError(f"frames have the shape (n, 4, 4), n at least 2, and are finite, not {along.shape}")
    above_zero("width of a weave", width)
    above_zero("length of a wave", length)
    if shape not in WAVES:
        raise InvalidArgumentError(f"a weave is one of {', '.join(WAVES)}, not {shape!r}")
    points = along[:, :3, 3]
    for side in (0.5 * width, -0.5 * width):
        bent = folded(points, points + side * along[:, :3, 1])
        if bent is not None:
            raise InvalidArgumentError(
                f"at frames[{bent}] the way bends closer than {500.0 * width:.6g} mm, half the width of the weave: it "
                "would go back there; make the weave narrower"
            )
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    if length > at[-1]:
        raise InvalidArgumentError(f"a wave of {1e3 * length:.6g} mm is longer than its way, {1e3 * at[-1]:.6g} mm")
    waves = max(1, round(float(at[-1]) / length))
    phases = np.arange(waves * WAVES[shape] + 1) / WAVES[shape]
    found = _between(along, at, phases * at[-1] / waves)
    found[:, :3, 3] += (0.5 * width * _swing(phases, shape))[:, None] * found[:, :3, 1]
    return found


def _swing(phases: Floats, shape: str) -> Floats:
    """Return where a weave is from -1 to 1 at phases in waves; it begins in the middle."""
    if shape == "sine":
        return np.sin(2.0 * np.pi * phases)
    saw = 1.0 - np.abs((4.0 * phases + 1.0) % 4.0 - 2.0)
    return saw if shape == "triangle" else np.clip(1.5 * saw, -1.0, 1.0)


def _between(frames: Floats, knots: Floats, at: Floats) -> Floats:
    """Return frames (m, 4, 4) at places (m,) between those (n, 4, 4) at knots (n,): z and x are blended."""
    row = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2)
    part = ((at - knots[row]) / (knots[row + 1] - knots[row]))[:, None, None]
    found = (1.0 - part) * frames[row] + part * frames[row + 1]
    z = units(found[:, :3, 2])
    x = units(found[:, :3, 0] - np.einsum("ij,ij->i", found[:, :3, 0], z)[:, None] * z)
    found[:, :3, :3] = np.stack([x, np.cross(z, x), z], axis=2)
    return found
