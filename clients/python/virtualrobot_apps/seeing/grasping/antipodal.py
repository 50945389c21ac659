"""Antipodal grasps: pairs of places where two fingers hold a body by friction, and how fingers get there.

V.-D. Nguyen, Constructing Force-Closure Grasps, The International Journal of Robotics Research 7, 1988: two contacts of
soft fingers are in force closure where the line between them lies in both friction cones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.seeing.given import finite
from virtualrobot_apps.seeing.grasping.jaw import Jaw
from virtualrobot_apps.seeing.grasping.surface import Floats, Surface

THINNEST = 0.002
"""Least width (m) of what is gripped."""
BESIDE = 2.0
"""Distance from the line between contacts, in the spacing of a surface's points, up to which a point is on it."""
PAD = 8
"""Number of points about a contact whose normals are in its friction cone, too."""
ROOM = 0.002
"""Distance (m) that an open finger keeps from the body on either side."""
_AT_ONCE = 2_000_000


class GraspError(InvalidArgumentError):
    """Raised where a jaw can't hold a body, with the numbers that are against it."""


@dataclass(frozen=True, slots=True, eq=False)
class Grasp:
    """Grasp: pose (4, 4) of the tool centre point in the frame of the surface, and the width between contacts (m).

    quality: 1 where the line between contacts is along both normals, 0 at the edge of a friction cone.
    """

    pose: Floats
    width: float
    quality: float


def grasps(
    surface: Surface,
    jaw: Jaw,
    rng: np.random.Generator,
    *,
    friction: float = 0.5,
    samples: int = 500,
    approaches: int = 8,
    obstacles: Floats | None = None,
) -> list[Grasp]:
    """Return grasps of a body, the best first: those whose open fingers are free of it and of `obstacles` (n, 3).

    Args:
        surface: the body's.
        jaw: two fingers.
        rng: draws where contacts are tried.
        friction: coefficient between fingers and body.
        samples: number of first contacts that are tried.
        approaches: number of directions about the line between contacts that each pair is approached from.
        obstacles: points of what stands around, in the frame of the surface.

    Raises:
        GraspError: where there is none, with the reason.
    """
    if not friction > 0.0:
        raise InvalidArgumentError(f"a friction coefficient is above 0, not {friction}")
    middles, axes, widths, qualities = _pairs(surface, rng, friction, samples)
    if not len(middles):
        raise GraspError(f"no two places of this body are opposite within the friction cones of {friction:g}")
    fit = widths < jaw.opening - 2.0 * ROOM
    if not fit.any():
        raise GraspError(
            f"the jaw opens to {jaw.opening:.3f} m, and this body is {widths.min():.3f} m wide at its narrowest"
        )
    middles, axes, widths, qualities = middles[fit], axes[fit], widths[fit], qualities[fit]
    poses = _approached(middles, axes, approaches)
    around = surface.points if obstacles is None else np.vstack([surface.points, finite(obstacles, 3, "obstacles")])
    of, number = np.nonzero(_free(poses, jaw, around))
    if not len(of):
        raise GraspError(
            f"fingers {jaw.thick:g} m thick have no room on both sides of any of {len(middles)} pairs of contacts"
        )
    # Among grasps alike that nearest to the middle of the body turns it least.
    away = np.linalg.norm(middles - surface.points.mean(axis=0), axis=1)
    order = np.argsort(-(qualities - 0.5 * away / max(float(away.max()), 1e-9))[of], kind="stable")
    return [Grasp(poses[of[at], number[at]], float(widths[of[at]]), float(qualities[of[at]])) for at in order]


def _pairs(
    surface: Surface, rng: np.random.Generator, friction: float, samples: int
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return middles and axes (m, 3), widths (m) and qualities (m,) of pairs of contacts in force closure."""
    points, normals, cone = surface.points, surface.normals, float(np.arctan(friction))
    first = rng.integers(0, len(points), samples)
    across = np.cross(normals[first], rng.normal(size=(samples, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    tilt = (0.5 * cone * np.sqrt(rng.random(samples)))[:, None]
    axes = -normals[first] * np.cos(tilt) + across * np.sin(tilt)
    second, widths, known = np.zeros(samples, int), np.zeros(samples), np.zeros(samples, bool)
    beside, least = BESIDE * surface.spacing, np.cos(cone)
    step = max(1, _AT_ONCE // len(points))
    for begin in range(0, samples, step):
        part = slice(begin, begin + step)
        off = points[None] - points[first[part], None]
        along = np.einsum("ijk,ik->ij", off, axes[part])
        aside = np.einsum("ijk,ijk->ij", off, off) - along**2
        # The far side of the body: the last place at which the line comes out of it.
        out = (along > THINNEST) & (aside < beside**2) & (axes[part] @ normals.T > 0.0)
        far = np.where(out, along, -np.inf)
        second[part], known[part] = far.argmax(axis=1), out.any(axis=1)
        widths[part] = far.max(axis=1)
    facing = (axes * normals[second]).sum(axis=1)
    good = known & (facing > least)
    # A finger is a pad, and no point: about a contact all looks the same way, or, of a thin body, the opposite one.
    tree = KDTree(points)
    for contact in (first, second):
        _, beside_it = tree.query(points[contact], k=PAD)
        good &= (np.abs((normals[beside_it] * axes[:, None]).sum(axis=2)) > least).all(axis=1)
    angles = np.maximum(tilt[:, 0], np.arccos(np.clip(facing, -1.0, 1.0)))[good]
    middles = points[first[good]] + 0.5 * widths[good, None] * axes[good]
    return middles, axes[good], widths[good], 1.0 - angles / cone


def _approached(middles: Floats, axes: Floats, approaches: int) -> Floats:
    """Return poses (m, approaches, 4, 4) of the tool centre point whose y is the axis between fingers."""
    helper = np.where(np.abs(axes[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    level = np.cross(axes, helper)
    level /= np.linalg.norm(level, axis=1, keepdims=True)
    up = np.cross(level, axes)
    turns = np.arange(approaches) * 2.0 * np.pi / approaches
    c, s = np.cos(turns)[:, None], np.sin(turns)[:, None]
    poses = np.zeros((len(middles), approaches, 4, 4))
    poses[..., 3, 3] = 1.0
    poses[..., :3, 2] = c * up[:, None] + s * level[:, None]
    poses[..., :3, 1] = axes[:, None]
    poses[..., :3, 0] = np.cross(poses[..., :3, 1], poses[..., :3, 2])
    poses[..., :3, 3] = middles[:, None]
    return poses


def _free(poses: Floats, jaw: Jaw, around: Floats) -> np.ndarray:
    """Return which poses (m, k) open fingers can be at: no point (n, 3) is in a finger, or in the palm behind them."""
    free = np.zeros(poses.shape[:2], bool)
    half, palm = 0.5 * jaw.opening, jaw.long - jaw.tip
    turns = np.arange(poses.shape[1]) * 2.0 * np.pi / poses.shape[1]
    step = max(1, _AT_ONCE // len(around))
    for begin in range(0, len(poses), step):
        part = poses[begin : begin + step, 0]
        level, across, up = (
            part[:, :3, column] @ around.T - (part[:, :3, column] * part[:, :3, 3]).sum(axis=1)[:, None]
            for column in range(3)
        )
        across, away = np.abs(across), level**2 + up**2
        near = (across < half + jaw.thick) & (away < (2.0 * jaw.long) ** 2 + (0.5 * jaw.wide) ** 2)
        of, at = np.nonzero(near & ((across > half) | (away > palm**2)))
        beyond, level, up = across[of, at] > half, level[of, at], up[of, at]
        for number, turn in enumerate(turns):
            c, s = np.cos(turn), np.sin(turn)
            x, z = c * level - s * up, c * up + s * level
            finger = beyond & (z > -palm) & (z < jaw.tip)
            hit = (np.abs(x) < 0.5 * jaw.wide) & (finger | ((z <= -palm) & (z > -2.0 * jaw.long)))
            free[begin : begin + step, number] = np.bincount(of[hit], minlength=len(part)) == 0
    return free
