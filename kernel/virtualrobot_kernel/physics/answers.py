"""Answers of engines, of which none is believed unseen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.arrays import is_finite
from virtualrobot_sdk.physics import BodyJoint, PhysicsModel, Stepped, TouchingBodies, jointed, places, sizes

from virtualrobot_kernel.errors import KernelError

FARTHEST = 1e9
"""Greatest coordinate (m, rad), velocity (per s) and effort (N, N m) that an engine may come to."""
UNIT_TOLERANCE = 2e-6
"""Tolerance of the square of a quaternion's length."""


class Answers:
    """Checks of what an engine answers of one model."""

    def __init__(self, engine: str, model: PhysicsModel) -> None:
        """Find what is to be looked at; `engine` is for errors."""
        self._engine = engine
        self._bodies = model.bodies
        self._counts = *sizes(model.bodies), len(jointed(model.bodies))
        starts = places(model.bodies)[0].tolist()
        free = [at for at, body in enumerate(model.bodies) if body.joint is BodyJoint.FREE and starts[at] >= 0]
        self._free = [model.bodies[at].name for at in free]
        self._quaternions = np.array([starts[at] + 3 for at in free], np.int32)[:, None] + np.arange(4)

    def checked(self, answer: object) -> Stepped:
        """Return an answer, its arrays of float64; raise KernelError, by the engine's name, for what is wrong in it."""
        if not isinstance(answer, Stepped):
            raise self._nonsense(f"step returned {type(answer).__name__}; it must be Stepped")
        q, v, efforts = (
            self._numbers(name, getattr(answer, name), count)
            for name, count in zip(("q", "v", "efforts"), self._counts, strict=True)
        )
        if self._free:
            turns = q[self._quaternions]
            lengths = np.einsum("ij,ij->i", turns, turns)
            if lengths.max() > 1.0 + UNIT_TOLERANCE or lengths.min() < 1.0 - UNIT_TOLERANCE:
                at, lengths = int(np.abs(lengths - 1.0).argmax()), np.sqrt(lengths)
                raise self._nonsense(f"the quaternion of {self._free[at]!r} must have length 1, not {lengths[at]:g}")
        if not _makes_sense(answer.contacts, len(self._bodies)):
            raise self._nonsense(f"contacts must be TouchingBodies of {len(self._bodies)} bodies, all finite")
        return Stepped(q, v, answer.contacts, efforts)

    def _numbers(self, name: str, value: object, count: int) -> NDArray[np.float64]:
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiu" or value.shape != (count,):
            what = f"an array {value.shape} of {value.dtype}" if isinstance(value, np.ndarray) else type(value).__name__
            raise self._nonsense(f"{name} is {what}; it must be a float64 array ({count},)")
        numbers = np.ascontiguousarray(value, float)
        if count and not np.abs(numbers).max() <= FARTHEST:  # nor is NaN
            at = int((~(np.abs(numbers) <= FARTHEST)).argmax())
            raise self._nonsense(f"{name}[{at}] is {numbers[at]:g}; all must be finite, and at most {FARTHEST:g}")
        return numbers

    def _nonsense(self, said: str) -> KernelError:
        return KernelError(f"what the physics engine {self._engine!r} answers is nonsense: {said}")


def _makes_sense(found: object, bodies: int) -> bool:
    """Return whether contacts are some of so many bodies."""
    if not isinstance(found, TouchingBodies):
        return False
    rows, vectors = np.asarray(found.bodies), (found.positions, found.normals, found.forces)
    if rows.dtype.kind not in "iu" or any(np.asarray(one).dtype.kind != "f" for one in vectors):
        return not len(rows)
    if not len(rows):
        return True
    if rows.shape != (len(rows), 2) or not (0 <= rows.min() and rows.max() < bodies):
        return False
    return all(np.shape(one) == (len(rows), 3) and is_finite(one) for one in vectors)
