"""Motion whose setpoints are twists or poses of a tool centre point. Pure, as `running` is.

In each tick the tool's twist goes on towards the wanted one, in a straight line, and the joints are put exactly where
the tool is then, as long as that keeps their limits. Where it does not, such as when the way bends too soon, the joints
brake together (`brake_together`), and the tool goes on from where they have it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import Self

import numpy as np
from virtualrobot_sdk.poses import from_quaternion, quaternion

from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.motion import brake_together, online, setpoint_motion
from virtualrobot_kernel.motion.limits import TOLERANCE, JointLimits
from virtualrobot_kernel.motion.online import Coupling, JointState
from virtualrobot_kernel.motion.orientation import unit
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.running_motion import NOTHING, Phase, TickContext
from virtualrobot_kernel.motion.setpoint_motion import SMOOTHING_SECONDS, SetpointMode, SetpointMotion
from virtualrobot_kernel.motion.tool_lead import (
    APPROACH_SECONDS,
    BEYOND,
    SINGULARITY,
    SLOWEST,
    Place,
    ToolLead,
    greatest_speed,
    led_by_twist,
    led_to_pose,
)

TWIST = ("vx", "vy", "vz", "wx", "wy", "wz")
"""Names of the values of a twist: m/s, then rad/s by the right hand."""

POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
"""Names of the values of a pose: m, then a unit quaternion."""

NAMES = {SetpointMode.TOOL_TWIST: TWIST, SetpointMode.TOOL_POSE: POSE}

SETTLED = 1e-8
"""Way (rad, or m over the lever arm) to a pose, and so far in a tick, from which the tool is put there."""

APART_SECONDS = 0.1
"""Longest time between poses that are places on one way, whose next ones are foreseen."""

JITTER_SECONDS = 0.05
"""Time by which a pose may come sooner than the tool could go there, and still be one on the way."""

_ROUNDING, _NOTHING = 1e-9, 1e-12
_STILL = np.zeros(6)


@dataclass(frozen=True, slots=True, eq=False)
class ToolSetpointMotion(SetpointMotion):
    """State of a motion of k joints that lead a tool centre point.

    lead: what leads it. base_t_tcp (4, 4): where it is to be by now. twist, slope (6,): its twist and the derivative of
    that, in the base's axes, m parts times the lead's weight. held_by: what keeps it slower than wanted: a joint's
    name, or `singularity`; empty when nothing does. goal, drift: where poses seem to be by now (7,), and their twist
    (6,), told as `twist` is; twists, and poses that stand, have no drift. axes (m, k): those of the joints' brake, on
    which the tool keeps its greatest speed; None: as they are found (motions of older journals).
    """

    _: KW_ONLY
    lead: ToolLead
    base_t_tcp: Array
    twist: Array
    slope: Array
    held_by: str = ""
    axes: Array | None = None

    def set(self, values: Sequence[float]) -> Self:
        """Return the motion with a newer setpoint: a twist (6,) or a pose (7,), in m and rad.

        Raises KernelError for values that are not finite, and a quaternion that has not length 1; LimitError for a
        twist that is faster than the lead's limits.
        """
        if self.closed or self.ended or self.phase is Phase.STOPPING:
            return self
        names = NAMES[self.mode]
        given = np.array(values, dtype=np.float64)
        if given.shape != (len(names),) or not np.isfinite(given).all():
            raise KernelError(f"a setpoint has a finite number for each of {', '.join(names)}, not {list(values)}")
        if self.mode is SetpointMode.TOOL_TWIST:
            most = self.lead.limits
            _check_speed(given[:3], most.velocity, "max_velocity_meters_per_second", "m/s")
            _check_speed(given[3:], most.rotation_velocity, "max_rotation_velocity_radians_per_second", "rad/s")
        else:
            given[3:] = unit(given[3:], "a setpoint")
        return replace(self, newest=tuple(given.tolist()), fresh=True)

    def close(self) -> Self:
        """Return the motion going on to its newest pose, or to standstill, where it will have succeeded.

        Where the tool comes to rest before that pose the motion is cancelled there.
        """
        newest = (0.0,) * 6 if self.mode is SetpointMode.TOOL_TWIST else self.newest
        return replace(self, closed=True, fresh=False, newest=newest, counted=newest, goal=newest, drift=())

    def advance(self, dt: float, override: float, context: TickContext = NOTHING) -> Self:
        """Return the motion `dt` seconds later; neither tool nor joint is faster than `override` times its limit."""
        del context  # it looks at its setpoints alone
        if self.ended:
            return self
        heard = self.heard()
        heard = replace(heard, age=heard.age + dt)
        if heard.phase is Phase.PAUSED or heard.ended:
            return heard
        later = heard._led(dt, override) if heard.phase is Phase.RUNNING else heard._braked(dt)
        later = later._moved_on(dt)
        if any(later.now.v) or any(later.now.a):
            return later
        if later.phase is not Phase.RUNNING:
            return replace(later, phase={Phase.PAUSING: Phase.PAUSED, Phase.STOPPING: Phase.CANCELLED}[later.phase])
        if not later.closed or later.now != heard.now:
            return later
        off = np.abs(later.off) if later.mode is SetpointMode.TOOL_POSE else np.zeros(6)
        if off.max() <= TOLERANCE:
            return replace(later, phase=Phase.SUCCEEDED)
        shift, turn = float(np.linalg.norm(off[:3])), float(np.linalg.norm(off[3:]))
        words = f"the tool centre point comes no nearer than {shift:.6g} m and {turn:.6g} rad to its last setpoint"
        if later.held_by:
            words += ": a singularity is in the way" if later.held_by == SINGULARITY else f": {later.held_by!r} ends it"
        return replace(later, phase=Phase.CANCELLED, fault=("SETPOINT_REFUSED", words))

    @property
    def off(self) -> Array:
        """Way (6,) from where the tool is to be to the setpoint that counts, a pose: m and rad, base axes."""
        return self.lead.way(self.base_t_tcp, _pose(self.counted)) / self.lead.weights

    @property
    def base_twist(self) -> Array:
        """Twist (6,) of the tool centre point in the base's axes, m/s and rad/s."""
        place = self.lead.at(np.array(self.now.q))
        return place.jacobian @ np.array(self.now.v) / self.lead.weights

    def stop_ahead(self, dt: float, most: int) -> Array | None:
        """Return the joint positions (m, k), now and at most so many ticks on, if it is cancelled now, or was.

        None where it stands.
        """
        if self.ended or self.phase is Phase.PAUSED:
            return None
        axes, now, found = self._brake_axes, self.now, [self.now.q]
        if brake_together.is_kept(now, axes, self.limits, self.bounds, dt):
            return brake_together.positions(now, axes, self.bounds, dt, most)
        while len(found) <= most and (any(now.v) or any(now.a)):
            now = brake_together.brake(now, axes, self.limits, self.bounds, dt)
            found.append(now.q)
        return np.array(found)

    def heard(self) -> Self:
        """Return the motion that counts its newest setpoint; a too old one stops it."""
        if self.fresh:
            goal, drift = self._foreseen()
            now = self.newest
            return replace(self, fresh=False, counted=now, goal=goal, drift=drift, interval=self.age, age=0.0)
        if self.closed or self.phase is Phase.STOPPING:
            return self
        if self.age >= self.timeout - _ROUNDING:
            return self._timed_out()
        stands = self.drift and self.age >= 2.0 * self.interval + SMOOTHING_SECONDS
        return replace(self, goal=self.counted, drift=()) if stands else self

    def _foreseen(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return where poses seem to be now, and how fast they move: the filter of positions of joints, for a pose.

        A pose that is too far from the one before, or comes too long after it, is no place on a way: it stands.
        """
        if self.mode is SetpointMode.TOOL_TWIST or not 0.0 < self.age <= APART_SECONDS:
            return self.newest, ()
        lead, here, seen = self.lead, _pose(self.goal), _pose(self.newest)
        most, gone = self.age + JITTER_SECONDS, lead.way(_pose(self.counted), seen) / lead.weights
        if (
            np.linalg.norm(gone[:3]) > most * lead.limits.velocity
            or np.linalg.norm(gone[3:]) > most * lead.limits.rotation_velocity
        ):
            return self.newest, ()
        off, drift = lead.way(here, seen), np.array(self.drift or _STILL)
        if max(np.abs(off).max(), np.abs(drift).max()) < SETTLED:
            return self.newest, ()
        fading = math.exp(-self.age / SMOOTHING_SECONDS)
        goal = _values(lead.moved(here, (1.0 - fading**2) * off))
        return goal, tuple((drift + (1.0 - fading) ** 2 * off / self.age).tolist())

    def _moved_on(self, dt: float) -> Self:
        """Return the motion whose goal has gone on by a tick."""
        if not self.drift:
            return self
        return replace(self, goal=_values(self.lead.moved(_pose(self.goal), np.array(self.drift) * dt)))

    def _led(self, dt: float, override: float) -> Self:
        """Return the motion whose tool has gone on by a tick."""
        lead, limits, (q, v, a) = self.lead, self.limits, map(np.array, self.now)
        place = lead.at(q)
        way, twist, slope, held_by = self._next(place, override, dt)
        if not (twist.any() or way.any() or v.any() or a.any()):
            return replace(self, held_by=held_by, twist=twist, slope=slope)
        goal = lead.moved(self.base_t_tcp, way)
        if place.is_free:
            joints = lead.step(place, self.twist, twist, way, dt, goal)
        else:
            # Not every way can be gone: the tool goes the part of it that joints can.
            joints = q + place.inverse @ way
        there = None if joints is None else lead.at(joints)
        if joints is not None and there is not None:
            speeds = there.inverse @ twist
            slopes = (speeds - v) / dt
            then = JointState(*(tuple(one.tolist()) for one in (joints, speeds, slopes)))
            axes = brake_together.plane_of(then)
            if (
                brake_together.keeps(self.now, then, limits, dt)
                and online.can_stop(self.now, then, self.bounds, dt)
                and brake_together.is_kept(then, axes, limits, self.bounds, dt, self._is_slow)
            ):
                if not place.is_free:
                    goal, twist = there.pose, there.jacobian @ speeds
                return replace(self, now=then, base_t_tcp=goal, twist=twist, slope=slope, held_by=held_by, axes=axes)
        return replace(self._braked(dt), held_by=held_by)

    def _next(self, place: Place, override: float, dt: float) -> tuple[Array, Array, Array, str]:
        """Return the way (6,) of the tool in this tick, its twist and slope after that, and what holds it up."""
        lead, limits = self.lead, self.limits
        values = np.array(self.counted)
        if self.mode is SetpointMode.TOOL_TWIST:
            wanted = values * lead.weights
            if lead.in_tool:
                wanted = (self.base_t_tcp[:3, :3] @ wanted.reshape(2, 3).T).T.ravel()
        else:
            wanted = lead.way(self.base_t_tcp, _pose(self.goal))
            if not self.drift and np.abs(wanted).max() < SETTLED and np.abs(self.twist).max() < SETTLED / dt:
                return np.where(np.abs(wanted) > _NOTHING, wanted, 0.0), np.zeros(6), np.zeros(6), ""
        way, drift = wanted, np.array(self.drift or _STILL)
        wanted = way + APPROACH_SECONDS * drift
        if not place.is_free:
            way, drift, wanted = (place.jacobian @ (place.inverse @ one) for one in (way, drift, wanted))
        length = float(np.linalg.norm(wanted))
        if length <= _ROUNDING * lead.weight and self.mode is SetpointMode.TOOL_TWIST:
            return *led_by_twist(lead, place, self.twist, self.slope, np.zeros(6), limits, dt), ""
        most = greatest_speed(lead, place, self.twist, wanted / length, limits, override) if length else None
        if most is None or most.value < SLOWEST:
            held_by = most.held_by if most is not None else ""
            return *led_by_twist(lead, place, self.twist, self.slope, np.zeros(6), limits, dt), held_by
        if self.mode is SetpointMode.TOOL_POSE:
            led = led_to_pose(lead, place, self.twist, self.slope, wanted, way, drift, most.value, limits, dt)
            return *led, most.held_by
        share = min(1.0, most.value / length)
        held_by = most.held_by if share < 1.0 else ""
        return *led_by_twist(lead, place, self.twist, self.slope, share * wanted, limits, dt), held_by

    @property
    def _brake_axes(self) -> Array:
        return brake_together.plane_of(self.now) if self.axes is None else self.axes

    def _is_slow(self, q: Array, v: Array) -> bool:
        """Return whether the tool goes and turns beyond its greatest speeds by no more than half of `BEYOND`."""
        lead, most = self.lead, 1.0 + 0.5 * BEYOND
        twist = lead.jacobian(q) @ v / lead.weights
        speed, turning = float(np.linalg.norm(twist[:3])), float(np.linalg.norm(twist[3:]))
        return speed <= most * lead.limits.velocity and turning <= most * lead.limits.rotation_velocity

    def _braked(self, dt: float) -> Self:
        """Return the motion whose joints brake together; the tool is where they have it."""
        now = brake_together.brake(self.now, self._brake_axes, self.limits, self.bounds, dt)
        place = self.lead.at(np.array(now.q))
        twist, slope = (place.jacobian @ np.array(one) for one in (now.v, now.a))
        return replace(self, now=now, base_t_tcp=place.pose, twist=twist, slope=slope)


def _check_speed(vector: Array, most: float, field: str, unit_name: str) -> None:
    speed = float(np.linalg.norm(vector))
    if speed > most * (1.0 + _ROUNDING):
        raise LimitError(
            f"a setpoint is refused: the tool centre point would move at {speed:.6g} {unit_name}, and the stream's "
            f"{field} is {most:.6g}",
            value=speed,
            limit=most,
        )


def _pose(values: Sequence[float]) -> Array:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = from_quaternion(np.array(values[3:])), values[:3]
    return pose


def _values(pose: Array) -> tuple[float, ...]:
    return (*pose[:3, 3].tolist(), *quaternion(pose[:3, :3]))


def start(
    mode: SetpointMode,
    lead: ToolLead,
    limits: JointLimits,
    q: Sequence[float] | Array,
    timeout: float,
    couplings: Sequence[Coupling] = (),
) -> ToolSetpointMotion:
    """Return the motion at its start: at rest at `q` (k,), where the tool stays until a setpoint comes.

    Raises as `setpoint_motion.start` does.
    """
    begun = setpoint_motion.start(SetpointMode.VELOCITY, limits, q, timeout, couplings)
    pose = lead.at(np.array(begun.now.q)).pose
    first = (0.0,) * 6 if mode is SetpointMode.TOOL_TWIST else _values(pose)
    return ToolSetpointMotion(
        mode=mode,
        limits=begun.limits,
        bounds=begun.bounds,
        timeout=begun.timeout,
        phase=begun.phase,
        now=begun.now,
        newest=first,
        fresh=False,
        counted=first,
        age=0.0,
        interval=0.0,
        goal=first,
        drift=(),
        ahead=(),
        lead=lead,
        base_t_tcp=pose,
        twist=np.zeros(6),
        slope=np.zeros(6),
    )
