"""Reasons for which an arm can't lead its tool along a path: the place, the frame that is nearest, and the joint."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.motion.free_path import FramePath, FreePath, within_hull
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.paths.tool_grid import Ladder

Floats = NDArray[np.float64]


class Places:
    """Places of a robot's tool path, in words and values."""

    def __init__(self, robot: str, frames: FramePath, rungs: Floats) -> None:
        """Tell places by the frames' path; rungs (n,): some parameters of it."""
        self._robot = robot
        self._path = FreePath(frames.pose(0.0), frames, within_hull(rungs, np.zeros((len(rungs) + 2, 6))))
        self.rungs = rungs

    def error(self, s: float, why: str, reason: Reason, **metadata: object) -> KernelError:
        """Return the error that something can't be at a parameter of the path."""
        where, place = self._path.place(s)
        kind = LimitError if reason is Reason.LIMIT_EXCEEDED else KernelError
        return kind(
            f"{self._robot!r} can't lead its tool along the path {where} since {why}",
            reason=reason,
            robot=self._robot,
            **{**place, **metadata},
        )


def no_way(
    places: Places,
    ladder: Ladder,
    limits: JointLimits,
    rung: int,
    touching: Mapping[int, tuple[str, str]],
    failed: Mapping[int, KernelError],
) -> KernelError:
    """Return the error that a ladder's search gets no farther than to the rung before this one.

    touching: names of two nodes that touch, by the rungs where something does. failed: refusals of motions, by the
    rungs nearest to where they were.
    """
    s = float(places.rungs[rung])
    excess = ladder.excess()[rung]
    exists, within = np.isfinite(excess).all(axis=2), excess.max(axis=2) <= 0.0
    if not exists.any():
        return places.error(s, "no posture reaches there within the tolerances", Reason.UNREACHABLE)
    if not within.any():
        nearest = np.unravel_index(np.where(exists, excess.max(axis=2), np.inf).argmin(), exists.shape)
        joint = int(excess[nearest].argmax())
        return places.error(
            s,
            f"all postures that reach there are beyond joint limits: joint {limits.names[joint]!r} by "
            f"{excess[nearest][joint]:.4g} {'rad' if ladder.turning[joint] else 'm'} at least",
            Reason.LIMIT_EXCEEDED,
            joint=limits.names[joint],
            value=float(excess[nearest][joint]),
            lower=float(limits.lower[joint]),
            upper=float(limits.upper[joint]),
        )
    if (near := _nearest(failed, rung)) is not None and (ladder.blocked[rung].any() or rung in failed):
        return near
    if rung in touching and ladder.blocked[rung][within].any():
        first, second = touching[rung]
        return places.error(s, f"{first!r} would touch {second!r} there", Reason.COLLISION, first=first, second=second)
    return _too_fast(places, ladder, limits, rung, within)


def _nearest(failed: Mapping[int, KernelError], rung: int) -> KernelError | None:
    close = [(abs(other - rung), other) for other in failed if abs(other - rung) <= 4]
    return failed[min(close)[1]] if close else None


def _too_fast(places: Places, ladder: Ladder, limits: JointLimits, rung: int, within: NDArray[np.bool_]) -> KernelError:
    """Return the error that no posture on a rung is reached from the rung before, with the joint that lacks least."""
    s, best = float(places.rungs[rung]), (np.inf, 0)
    q, before = ladder.q[rung], ladder.q[rung - 1]
    stays = within & (ladder.blocked[rung] == 0)
    left = (ladder.excess()[rung - 1].max(axis=2) <= 0.0) & (ladder.blocked[rung - 1] == 0)
    for others in ladder.grid.neighbours.T:
        goes = stays & left[others] & (others >= 0)[:, None]
        way = (q - before[others])[goes]
        shares = np.abs(way - 2.0 * np.pi * np.round(way / (2.0 * np.pi))) / ladder.most[rung - 1]
        if len(shares):
            row = shares[shares.max(axis=1).argmin()]
            best = min(best, (float(row.max()), int(row.argmax())))
    share, joint = best
    if not 1.0 < share < np.inf:
        why = "the postures that reach there can't be reached from those before, within joint limits and turns"
        return places.error(s, why, Reason.LIMIT_EXCEEDED)
    return places.error(
        s,
        f"joint {limits.names[joint]!r} would have to be {share:.3g} times as fast as it may be to come there in time; "
        "go slower, or give more freedom",
        Reason.LIMIT_EXCEEDED,
        joint=limits.names[joint],
        value=share * float(limits.velocity[joint]),
        limit=float(limits.velocity[joint]),
    )
