"""Limits of a motion, per joint and for the tool centre point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, replace

import numpy as np

from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.motion.orientation import unit
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.units import degrees_question, millimetres_question

#: Tolerance (radians or metres) of a joint outside its limits by rounding, and of a start from the current joints.
TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Limits of k joints, arrays (k,): rad (m for prismatic joints), per s, s², s³.

    `lower` and `upper` are infinite for continuous joints; the other three are finite and above 0. vectors: columns of
    which the limits are those of a vector's length, such as x and y of a planar joint. quaternions: the columns of the
    components x, y, z, w; the limits are those of the angular velocity about x, y, z, and those of w don't count.
    sliding: the names of prismatic joints, whose values are in m.
    """

    names: tuple[str, ...]
    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    _: KW_ONLY
    vectors: tuple[tuple[int, ...], ...] = ()
    quaternions: tuple[tuple[int, ...], ...] = ()
    sliding: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        """Freeze the arrays; raise KernelError naming the joint whose limits are impossible."""
        object.__setattr__(self, "names", tuple(self.names))
        for field in ("lower", "upper", "velocity", "acceleration", "jerk"):
            values = np.array(getattr(self, field), dtype=np.float64)
            if values.shape != (len(self.names),):
                raise KernelError(f"{field} limits must have one value for each of {len(self.names)} joints")
            values.setflags(write=False)
            object.__setattr__(self, field, values)
        for index, name in enumerate(self.names):
            if not self.lower[index] <= self.upper[index]:
                raise KernelError(
                    f"joint {name!r} has lower limit {self.lower[index]} above its upper limit {self.upper[index]}",
                    joint=name,
                )
            for field in ("velocity", "acceleration", "jerk"):
                value = getattr(self, field)[index]
                if not (np.isfinite(value) and value > 0.0):
                    raise KernelError(
                        f"joint {name!r} needs a finite {field} limit above 0 to be planned for, not {value}",
                        joint=name,
                        value=value,
                    )

    def scaled(self, velocity: float = 1.0, acceleration: float = 1.0, jerk: float = 1.0) -> JointLimits:
        """Return the limits with velocities, accelerations and jerks times scales in (0, 1]."""
        return replace(
            self,
            velocity=self.velocity * checked_scale(velocity, "velocity scale"),
            acceleration=self.acceleration * checked_scale(acceleration, "acceleration scale"),
            jerk=self.jerk * checked_scale(jerk, "jerk scale"),
        )

    def along(self, way: Array) -> JointLimits:
        """Return the limits on a straight way (k,), on which each component of a vector has its share of the length."""
        share = np.ones(len(self.names))
        for columns in map(list, self.vectors):
            length = float(np.linalg.norm(way[columns]))
            if length > 0.0:
                share[columns] = np.where(way[columns] == 0.0, 1.0, np.abs(way[columns]) / length)
        if not self.vectors:
            return self
        parts = {field: getattr(self, field) * share for field in ("velocity", "acceleration", "jerk")}
        return replace(self, **parts)

    def check(self, q: Array, what: str) -> None:
        """Raise LimitError naming the first joint of `q` (k,) outside its position limits; `what` says which q.

        Raise KernelError for a quaternion that has not length 1.
        """
        for columns in map(list, self.quaternions):
            unit(q[columns], f"{what}: joint {self.names[columns[0]].removesuffix('/qx')!r}")
        for index in np.flatnonzero((q < self.lower - TOLERANCE) | (q > self.upper + TOLERANCE)):
            raise self.error(int(index), float(q[index]), what)

    def error(self, index: int, value: float, what: str, **metadata: object) -> LimitError:
        """Return the LimitError for joint `index` at `value`; the message starts with `what`."""
        name, lower, upper = self.names[index], float(self.lower[index]), float(self.upper[index])
        short, question = ("m", millimetres_question) if name in self.sliding else ("rad", degrees_question)
        return LimitError(
            f"{what}: joint {name!r} would be at {value:.6g} {short}, its limits are {lower:.6g} to {upper:.6g} {short}"
            f"{question(value)}",
            joint=name,
            value=value,
            lower=lower,
            upper=upper,
            reason=Reason.LIMIT_EXCEEDED,
            **metadata,
        )


@dataclass(frozen=True)
class CartesianLimits:
    """Limits of the tool centre point on a line or an arc: m, rad, and per s, s², s³ of each; all above 0."""

    velocity: float = 1.0
    acceleration: float = 5.0
    jerk: float = 50.0
    rotation_velocity: float = 2.0
    rotation_acceleration: float = 10.0
    rotation_jerk: float = 100.0

    def __post_init__(self) -> None:
        """Raise KernelError naming the limit that is not finite or not above 0."""
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0.0):
                raise KernelError(f"the Cartesian {name} limit must be finite and above 0, not {value}", value=value)

    def scaled(self, velocity_scale: float) -> CartesianLimits:
        """Return the limits with both velocities times `velocity_scale` in (0, 1]; the others stay."""
        scale = checked_scale(velocity_scale, "velocity scale")
        return replace(self, velocity=self.velocity * scale, rotation_velocity=self.rotation_velocity * scale)


def checked_scale(value: float, what: str) -> float:
    """Return `value` when it is in (0, 1], else raise KernelError; `what` names it."""
    if not 0.0 < value <= 1.0:
        raise KernelError(f"a {what} must be above 0 and at most 1, not {value}", value=value)
    return float(value)


def checked_joints(q: Sequence[float] | Array, count: int, what: str) -> Array:
    """Return `q` as a float array (count,), or raise KernelError when it has another shape or is not finite."""
    values = np.array(q, dtype=np.float64)
    if values.shape != (count,):
        raise KernelError(f"{what} needs {count} joint values, not an array of shape {values.shape}")
    if not np.isfinite(values).all():
        bad = int(np.flatnonzero(~np.isfinite(values))[0])
        raise KernelError(f"{what} has the value {values[bad]} for joint {bad + 1} of {count}; it must be finite")
    return values
