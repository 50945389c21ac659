"""Lead of a tool centre point by setpoints: how its twist changes in a tick, and how fast joints let it go. Pure.

The joints' rates are J^+ twist (resolved-rate motion, D. E. Whitney, IEEE Trans. Man-Machine Systems 10(2), 1969). Near
a singularity, singular values below `SMALLEST` count less and less (A. A. Maciejewski, C. A. Klein, Numerical filtering
for the operation of robotic manipulators through kinematically singular configurations, J. Robotic Systems 5(6), 1988).

Twists (6,) and what goes with them are in the axes of the arm's base here, linear parts times `weight` (1/m), so that
they compare with angular ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from virtualrobot_sdk.kinematics import SerialChain
from virtualrobot_sdk.poses import rotation_matrix, rotation_vector

from virtualrobot_kernel.motion import online
from virtualrobot_kernel.motion.brake_together import plane
from virtualrobot_kernel.motion.limits import CartesianLimits, JointLimits
from virtualrobot_kernel.motion.online import Bounds, JointState
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.resolved_rate import SMALLEST_SINGULAR_VALUE as SMALLEST
from virtualrobot_kernel.numeric import following

SHARE = 0.4
"""Share of a joint's limits of acceleration and jerk that a change of the tool's twist takes, and another such one that
the bend of the joints' way takes; the rest is for what these two leave out."""

APPROACH_SECONDS = 0.2
"""Time constant (s) with which the tool comes to where a singularity or a joint's limit holds it, at the least."""

SLOWEST = 1e-4
"""Speed (rad/s, or m/s over the lever arm) below which a tool that is held up stands."""

BEYOND = 0.02
"""Share of a tool's greatest speed by which it goes beyond it at most, where joints keep it from slowing down."""

SINGULARITY = "singularity"

PLACES = 3
"""Number of places on the way of the tool's brake that its speed is chosen by."""

_EACH = np.arange(PLACES + 1)
_BEFORE = np.minimum(_EACH, PLACES - 1)
"""Number of each place, and of the way from it or, of the last one, to it."""

_NEVER, _NOTHING = 1e-6, 1e-12
"""Smallest singular value below which the arm is singular whatever it does next: nothing leads farther into it."""

LEFT = 0.2
"""Share of its speed that a tool has at least on its way to a pose, however fast it still moves beside that."""

SLOWER = 0.98
"""Share of its greatest speed that a goal moves with at most: a tool comes nearer to it."""

_FARTHEST = 0.5
"""Farthest (rad or m) that joints are looked ahead to a pose."""

_ALONG = 1e-5
"""Way (rad or m) of the fastest joint over which differences are taken."""


@dataclass(frozen=True, eq=False)
class ToolLead:
    """Lead of a tool centre point: the chain of k joints to it, and the limits of its speed.

    weight: 1/m; the lever arm at the start is 1. in_tool: whether twists are in the axes of the tool centre point, else
    in those of the chain's base.
    """

    chain: SerialChain
    weight: float
    in_tool: bool
    limits: CartesianLimits

    @property
    def weights(self) -> Array:
        """Weights (6,) of a twist."""
        return np.array([self.weight] * 3 + [1.0] * 3)

    def at(self, q: Array) -> Place:
        """Return the pose of the tool centre point at joints (k,), and what moves it there."""
        pose, jacobian = np.empty((4, 4)), np.empty((6, len(q)))
        following.place_at(*self.arrays, np.ascontiguousarray(q), pose, jacobian)
        left, values, right = np.linalg.svd(jacobian, full_matrices=False)
        inverses = np.where(values >= SMALLEST, 1.0 / np.maximum(values, SMALLEST), values / SMALLEST**2)
        inverse = (right.T * inverses) @ left.T
        return Place(q, pose, jacobian, inverse, left[:, -1], float(values[-1]), right[-1])

    def jacobian(self, q: Array) -> Array:
        """Return the Jacobian (6, k) of the tool centre point at joints (k,)."""
        pose, jacobian = np.empty((4, 4)), np.empty((6, len(q)))
        following.place_at(*self.arrays, np.ascontiguousarray(q), pose, jacobian)
        return jacobian

    def step(self, place: Place, begin: Array, end: Array, way: Array, seconds: float, goal: Array) -> Array | None:
        """Return the joints (k,) that have the tool at the pose `goal` after a tick, on their branch.

        begin, end: its twists (6,) then; way (6,): how far it goes meanwhile. None where no joints are found.
        """
        q = np.empty_like(place.q)
        middle = (6.0 * way / seconds - begin - end) / 4.0  # with which Simpson's rule gives the way
        twists = middle / self.weights, end / self.weights
        found = following.step_along(*self.arrays, place.q, place.inverse @ begin, seconds, *twists, goal, q)
        return q if found else None

    def moved(self, base_t_tcp: Array, way: Array) -> Array:
        """Return a pose after a small way (6,): a shift, and a turn about the tool centre point."""
        pose = np.eye(4)
        pose[:3, 3] = base_t_tcp[:3, 3] + way[:3] / self.weight
        turned = rotation_matrix(way[3:]) @ base_t_tcp[:3, :3]
        # A step of Newton's method to the nearest rotation: products of many drift from it.
        pose[:3, :3] = 1.5 * turned - 0.5 * turned @ turned.T @ turned
        return pose

    def way(self, begin: Array, end: Array) -> Array:
        """Return the way (6,) from a pose (4, 4) to another one: a shift, and the shorter turn."""
        turn = rotation_vector(end[:3, :3] @ begin[:3, :3].T)
        return np.concatenate([self.weight * (end[:3, 3] - begin[:3, 3]), turn])

    @property
    def arrays(self) -> tuple[Any, ...]:
        """Arrays of the chain, and the weight, as `numeric.following` takes them."""
        return (*self.chain[:6], self.chain.post[None], self.weight)


class Place(NamedTuple):
    """Tool centre point at joints q (k,): its pose (4, 4), its Jacobian (6, k), and the inverse (k, 6) of that.

    smallest: the Jacobian's smallest singular value, with its unit vectors left (6,) and right (k,).
    """

    q: Array
    pose: Array
    jacobian: Array
    inverse: Array
    left: Array
    smallest: float
    right: Array

    @property
    def is_free(self) -> bool:
        """True where the joints can move it in every direction."""
        return len(self.q) >= 6 and self.smallest >= SMALLEST


class Speed(NamedTuple):
    """Greatest speed of a tool centre point in a direction, and what holds it up: a joint's name or `SINGULARITY`."""

    value: float
    held_by: str


def greatest_speed(
    lead: ToolLead, place: Place, twist: Array, direction: Array, limits: JointLimits, override: float
) -> Speed:
    """Return the greatest speed in a direction, a unit vector (6,), from which joints still keep all their limits.

    A joint goes no faster towards its limit than it can brake, nor the tool towards a singularity than it comes to its
    edge evenly; and where the joints' way bends, no faster than their accelerations and jerks let it bend. What holds
    at `PLACES` on the way of the tool's brake counts, too, as far as that slows it down until there. `override` in
    (0, 1] multiplies the greatest speeds of joints and tool. twist (6,): that of the tool now.
    """
    rates = place.inverse @ direction
    size = float(np.abs(rates).max())
    if size < _NEVER:
        return Speed(0.0, SINGULARITY)
    speed = max(float(twist @ direction), 0.0)
    brake = SHARE * float((limits.acceleration / np.maximum(np.abs(rates), _NEVER)).min())
    brake = min(brake, _least(lead.limits.acceleration, lead.limits.rotation_acceleration, lead, direction))
    foresight = 2.0 * float((limits.acceleration / limits.jerk).max())
    step = max(_ALONG / size, speed * (foresight + speed / brake) / PLACES)
    ways, smallest, slopes = np.empty((PLACES + 1, len(rates))), np.empty(PLACES + 1), np.empty(PLACES + 1)
    following.look_along(*lead.arrays, place.q, direction, step, SMALLEST, ways, smallest, slopes)
    bends = np.diff(ways, axis=0) / step
    twice = np.maximum(np.abs(np.diff(bends, axis=0)).max(axis=0) / step, _NOTHING)
    pace, bend = np.maximum(np.abs(ways), _NOTHING), np.maximum(np.abs(bends), _NOTHING)[_BEFORE]
    q = place.q + step * (np.cumsum(ways, axis=0) - ways)
    room = np.maximum(np.where(ways > 0.0, limits.upper - q, q - limits.lower), 0.0)
    time = np.maximum(APPROACH_SECONDS, 2.0 * limits.acceleration / limits.jerk)
    each = np.minimum(limits.velocity * override, room / time) / pace
    each = np.minimum(each, np.sqrt(SHARE * limits.acceleration / bend))
    each = np.minimum(each, np.cbrt(SHARE * limits.jerk / twice))
    slowest = each.argmin(axis=1)
    by_joints = each[_EACH, slowest]
    closing = (smallest > _NEVER) & (slopes < -_NEVER)
    edge = np.maximum(smallest - SMALLEST, 0.0) / (np.where(closing, -slopes, 1.0) * APPROACH_SECONDS)
    most = np.minimum(by_joints, np.where(closing, edge, math.inf))
    slower = SHARE * (limits.acceleration / pace).min(axis=1)
    speeds = np.sqrt(most**2 + 2.0 * slower * _EACH * step)
    first = int(speeds.argmin())
    by_tool = override * _least(lead.limits.velocity, lead.limits.rotation_velocity, lead, direction)
    if by_tool <= speeds[first]:
        return Speed(by_tool, "")
    held_by = limits.names[slowest[first]] if by_joints[first] <= most[first] else SINGULARITY
    return Speed(float(speeds[first]), held_by)


def led_by_twist(
    lead: ToolLead, place: Place, twist: Array, slope: Array, wanted: Array, limits: JointLimits, dt: float
) -> tuple[Array, Array, Array]:
    """Return the way (6,) of the tool in the next `dt` seconds, and its twist and slope, the derivative, at their end.

    It gets from its twist to the wanted one in a straight line, as fast as the limits of acceleration and jerk allow.
    """
    axes = plane(twist - wanted, slope)
    if not len(axes):
        return wanted * dt, wanted, np.zeros(6)
    still = (0.0,) * len(axes)
    now = JointState(still, tuple((axes @ (twist - wanted)).tolist()), tuple((axes @ slope).tolist()))
    _, then = online.brake(now, _bounds(lead, place, axes, limits), dt)
    way, speed, change = (np.array(one) @ axes for one in then)
    return wanted * dt + way, wanted + speed, change


def led_to_pose(
    lead: ToolLead,
    place: Place,
    twist: Array,
    slope: Array,
    ahead: Array,
    way: Array,
    drift: Array,
    speed: float,
    limits: JointLimits,
    dt: float,
) -> tuple[Array, Array, Array]:
    """Return what `led_by_twist` does of a tool that shall go a way (6,) to a goal, and rest there as seen from it.

    The goal moves with the twist `drift` (6,). The tool goes no faster than `speed` along `ahead` (6,), where both go.
    """
    axes = plane(ahead, way, twist, slope, drift)
    if not len(axes):
        return np.zeros(6), np.zeros(6), np.zeros(6)
    before = axes @ -way
    # What it is still moving beside its way takes a part of the speed.
    beside = float(np.linalg.norm(twist - (axes[0] @ twist) * axes[0]))
    speed = math.sqrt(max(speed**2 - beside**2, (LEFT * speed) ** 2))
    # The brake must be possible up to its end, where joints may allow less.
    joints = place.inverse @ way
    there = lead.at(place.q + joints * min(1.0, _FARTHEST / max(float(np.abs(joints).max()), _NEVER)))
    here, later = (_bounds(lead, one, axes, limits) for one in (place, there))
    least = (list(map(min, *both)) for both in zip(here[2:4], later[2:4], strict=True))
    bounds = Bounds(*here[:2], *least, couplings=())
    now = JointState(*(tuple(one.tolist()) for one in (before, axes @ twist, axes @ slope)))
    still = (0.0,) * len(axes)
    moves = axes @ drift * min(1.0, SLOWER * speed / max(float(np.linalg.norm(drift)), _NOTHING))
    _, then = online.follow_positions(now, still, tuple(moves.tolist()), bounds, (speed,) * len(axes), dt)
    after, speeds, changes = map(np.array, then)
    return (after - before) @ axes, speeds @ axes, changes @ axes


def _bounds(lead: ToolLead, place: Place, axes: Array, limits: JointLimits) -> Bounds:
    """Return the limits of acceleration and jerk along axes (m, 6): half as great along those beside the first."""
    count, own = len(axes), lead.limits
    shares = np.array([SHARE] + [0.5 * SHARE] * (count - 1))
    rates = np.maximum(np.abs(axes @ place.inverse.T), 1e-12)
    by_joints = (shares * (limit / rates).min(axis=1) for limit in (limits.acceleration, limits.jerk))
    by_tool = (
        [_least(linear, turning, lead, axis) for axis in axes]
        for linear, turning in ((own.acceleration, own.rotation_acceleration), (own.jerk, own.rotation_jerk))
    )
    both = (np.minimum(one, other).tolist() for one, other in zip(by_joints, by_tool, strict=True))
    return Bounds([-math.inf] * count, [math.inf] * count, *both, couplings=())


def _least(linear: float, turning: float, lead: ToolLead, axis: Array) -> float:
    """Return how much of an axis (6,) keeps a limit of the linear part (in m) and one of the turning part."""
    shift, turn = float(np.linalg.norm(axis[:3])) / lead.weight, float(np.linalg.norm(axis[3:]))
    return min(linear / max(shift, 1e-12), turning / max(turn, 1e-12))
