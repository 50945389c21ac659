"""Bodies of the demos of processes, as their files in `cells` have them: `python -m ...workpieces` writes these anew.

Lengths in m. A tool's origin is at the flange, its z out of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import trimesh
from trimesh import Trimesh

from virtualrobot_apps.demos.processes import CELLS

NECK = 0.06
"""Radius of the bend of a torch's neck."""
BENT = np.radians(45.0)
"""Angle by which a torch's neck is bent, and a spray gun."""
GROOVE, GROOVES, MITRE = 0.088, (0.2, 0.5), np.radians(6.0)
"""Radius of the grooves of a pipe, where they are on its axis, and how far their planes lean."""
BALL, CAP = 0.25, 0.08
"""Radius of the ball whose cap a lid is, and its height."""


def _rod(radius: float, first: Sequence[float], last: Sequence[float], sections: int = 32) -> Trimesh:
    return trimesh.creation.cylinder(radius, segment=[first, last], sections=sections)


def _joined(*bodies: Trimesh) -> Trimesh:
    return trimesh.boolean.union(bodies, engine="manifold")


def pipes() -> Trimesh:
    """Return a pipe along y with a branch upwards: their seam is a saddle."""
    return _joined(_rod(0.09, [0, -0.25, 0], [0, 0.25, 0], 72), _rod(0.05, [0, 0, 0], [0, 0, 0.22], 72))


def pipe() -> Trimesh:
    """Return a pipe along x of three mitred segments, between them grooves; a groove's bottom is a circle of 88 mm."""
    whole = trimesh.boolean.difference(
        [_rod(0.1, [0, 0, 0], [0.7, 0, 0], 96), _rod(0.075, [-0.1, 0, 0], [0.8, 0, 0], 96)], engine="manifold"
    )
    profile = [[GROOVE, 0.0], [GROOVE + 0.04, -0.04], [GROOVE + 0.04, 0.04], [GROOVE, 0.0]]
    for place in GROOVES:
        ring = trimesh.creation.revolve(profile, sections=72)
        ring.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2.0 + MITRE, [0, 1, 0]))
        ring.apply_translation([place, 0, 0])
        whole = trimesh.boolean.difference([whole, ring], engine="manifold")
    return whole


def flange() -> Trimesh:
    """Return a disc of 30 mm with a hub: blank of a pipe's flange, which is milled and drilled."""
    return _joined(_rod(0.12, [0, 0, 0], [0, 0, 0.03], 96), _rod(0.05, [0, 0, 0.02], [0, 0, 0.06], 72))


def bent(width: float, length: float, thickness: float, radii: tuple[float, float]) -> Trimesh:
    """Return a sheet that is bent both ways: its top goes down from the origin as x^2 / 2 r and y^2 / 2 r do."""
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 25) * width, np.linspace(-0.5, 0.5, 31) * length, indexing="ij")
    top = np.stack([x, y, -(x**2) / (2.0 * radii[0]) - y**2 / (2.0 * radii[1])], axis=-1).reshape(-1, 3)
    rows = np.arange(len(top)).reshape(x.shape)
    a, b, c, d = rows[:-1, :-1].ravel(), rows[1:, :-1].ravel(), rows[1:, 1:].ravel(), rows[:-1, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    rim = np.concatenate([rows[:, 0], rows[-1, 1:], rows[-2::-1, -1], rows[0, -2:0:-1]])
    on, below = np.roll(rim, -1), len(top)
    sides = [np.stack([rim, rim + below, on + below], axis=1), np.stack([rim, on + below, on], axis=1)]
    corners = np.concatenate([top, top - [0.0, 0.0, thickness]])
    return Trimesh(corners, np.concatenate([faces, faces[:, ::-1] + below, *sides]))


def hood() -> Trimesh:
    """Return a hood of 0.5 x 0.6 m, 4 mm thick, bent to radii of 0.9 and 1.2 m."""
    return bent(0.5, 0.6, 0.004, (0.9, 1.2))


def torch() -> Trimesh:
    """Return a welding torch, bent about y; its wire ends 15 mm before the nozzle, at (0.0883, 0, 0.2331)."""
    angles = np.linspace(0.0, BENT, 9)
    neck = [[0.0, 0.0, 0.09], *([NECK * (1.0 - np.cos(t)), 0.0, 0.12 + NECK * np.sin(t)] for t in angles)]
    ahead = np.array([np.sin(BENT), 0.0, np.cos(BENT)])
    parts = [_rod(0.025, [0, 0, 0], [0, 0, 0.1])]
    for first, last in pairwise(neck):
        on = np.subtract(last, first)
        parts.append(_rod(0.011, first, last + 0.002 * on / np.linalg.norm(on), 20))
    parts.append(_rod(0.011, neck[-1], neck[-1] + 0.05 * ahead, 20))
    parts.append(_rod(0.009, neck[-1] + 0.045 * ahead, neck[-1] + 0.085 * ahead, 20))
    return _joined(*parts)


def spindle() -> Trimesh:
    """Return a spindle with a cutter of 10 mm, whose end is at (0, 0, 0.26)."""
    return _joined(
        _rod(0.045, [0, 0, 0], [0, 0, 0.16]),
        _rod(0.018, [0, 0, 0.15], [0, 0, 0.2]),
        _rod(0.005, [0, 0, 0.19], [0, 0, 0.26], 24),
    )


def lid() -> Trimesh:
    """Return the cap of a ball of 0.25 m, 80 mm high, its base at the origin."""
    angles = np.linspace(np.arccos(1.0 - CAP / BALL), 0.0, 21)
    profile = np.stack([BALL * np.sin(angles), BALL * np.cos(angles) - (BALL - CAP)], axis=1)
    profile[0, 1] = profile[-1, 0] = 0.0
    return trimesh.creation.revolve(np.concatenate([[[0.0, 0.0]], profile]), sections=96)


def gun() -> Trimesh:
    """Return a spray gun, bent by 45 degrees about y; its nozzle ends at (0.07, 0, 0.17)."""
    ahead = np.array([np.sin(BENT), 0.0, np.cos(BENT)])
    elbow = np.array([0.0, 0.0, 0.1])
    return _joined(
        _rod(0.03, [0, 0, 0], [0, 0, 0.11]),
        _rod(0.022, elbow.tolist(), (elbow + 0.06 * ahead).tolist()),
        _rod(0.012, (elbow + 0.055 * ahead).tolist(), (elbow + 0.07 * np.sqrt(2.0) * ahead).tolist(), 24),
    )


def dispenser() -> Trimesh:
    """Return a gun for glue, whose needle ends at (0, 0, 0.2)."""
    return _joined(
        _rod(0.028, [0, 0, 0], [0, 0, 0.12]),
        _rod(0.01, [0, 0, 0.11], [0, 0, 0.165], 24),
        _rod(0.0015, [0, 0, 0.16], [0, 0, 0.2], 16),
    )


def head() -> Trimesh:
    """Return the head of a laser, whose nozzle ends at (0, 0, 0.24)."""
    profile = [[0.0, 0.0], [0.035, 0.0], [0.035, 0.15], [0.003, 0.24], [0.0, 0.24]]
    return trimesh.creation.revolve(profile, sections=32)


def disc() -> Trimesh:
    """Return a motor with a pad of 40 mm to polish with, whose middle is at (0, 0, 0.18)."""
    return _joined(
        _rod(0.035, [0, 0, 0], [0, 0, 0.12]),
        _rod(0.01, [0, 0, 0.11], [0, 0, 0.175], 24),
        _rod(0.02, [0, 0, 0.17], [0, 0, 0.18], 48),
    )


def electrode() -> Trimesh:
    """Return a gun that welds spots from one side, whose electrode ends at (0, 0, 0.22)."""
    return _joined(
        _rod(0.04, [0, 0, 0], [0, 0, 0.13]),
        _rod(0.015, [0, 0, 0.12], [0, 0, 0.2], 24),
        _rod(0.004, [0, 0, 0.19], [0, 0, 0.22], 16),
    )


def probe() -> Trimesh:
    """Return a probe, the middle of whose ball of 4 mm is at (0, 0, 0.2)."""
    ball = trimesh.creation.icosphere(3, 0.002)
    ball.apply_translation([0, 0, 0.2])
    return _joined(_rod(0.03, [0, 0, 0], [0, 0, 0.12]), _rod(0.0012, [0, 0, 0.11], [0, 0, 0.2], 16), ball)


def cup() -> Trimesh:
    """Return a suction cup, whose rim is at (0, 0, 0.15)."""
    profile = [[0.0, 0.0], [0.05, 0.0], [0.05, 0.02], [0.02, 0.02], [0.02, 0.12], [0.045, 0.15], [0.0, 0.15]]
    return trimesh.creation.revolve(profile, sections=32)


BODIES: tuple[Callable[[], Trimesh], ...] = (
    *(pipes, pipe, flange, hood, lid),
    *(torch, spindle, gun, dispenser, head, disc, electrode, probe, cup),
)
"""Functions that make the bodies; a file has the name of its function."""


if __name__ == "__main__":
    for body in BODIES:
        body().export(CELLS / f"{body.__name__}.stl")
