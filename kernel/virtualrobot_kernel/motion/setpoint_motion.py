"""Motion that follows setpoints: positions or velocities that somebody sends as it goes. Pure, as `running` is.

In each tick the joints go on towards the newest setpoint, each on its own, within their limits of position, velocity,
acceleration and jerk (`online`). Position setpoints that come one after the other are taken for a goal that moves on at
their own speed, so that they are followed without the lag that stopping at each of them would have.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from operator import add, gt, lt
from typing import Self

import numpy as np

from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.motion import brake, online, setpoint_turning
from virtualrobot_kernel.motion.limits import TOLERANCE, JointLimits, checked_joints
from virtualrobot_kernel.motion.online import Bounds, Coupling, JointState, StoppableTrajectory
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.quick import maker
from virtualrobot_kernel.motion.running_motion import ENDED, NOTHING, Phase, TickContext
from virtualrobot_kernel.motion.setpoint_turning import Turning, begun, check_rates, correction, gone_on, led_to
from virtualrobot_kernel.motion.signals import SignalValue

AHEAD_SECONDS = 0.05
"""Allowance (s) for jitter of clients and networks: a setpoint may be ahead by so much time at its greatest speed."""

SMOOTHING_SECONDS = 0.02
"""Time constant (s) of the filter that makes a steady goal of position setpoints: they come at uneven times."""

SETTLED = 1e-9
"""Distance (rad or m) and speed per second below which a goal stands on its setpoint."""

MOST_DRIFT = 0.95
"""Greatest speed of a goal, as a share of its joint's: what is left is for catching up with it."""

_ROUNDING = 1e-9


class SetpointMode(Enum):
    """Quantity that setpoints give; the names equal those of `SetpointMode` in the contract."""

    POSITION = "POSITION"
    VELOCITY = "VELOCITY"
    TOOL_TWIST = "TOOL_TWIST"
    TOOL_POSE = "TOOL_POSE"


@dataclass(frozen=True, slots=True, eq=False)
class SetpointMotion:
    """State of a motion of k joints that follow setpoints.

    timeout: after how long without a setpoint it stops (s). newest: the last setpoint that came, (k,); fresh: since the
    last tick. counted: the setpoint that the last tick followed; age: how old it is (s), interval: how old the one
    before it became (s). goal, drift: where position setpoints seem to be now and how fast they move, (k,). ahead: by
    how much each joint's setpoint may still be sooner than the joint could be, (k,) (s). closed: no more setpoints will
    come. turning: orientations of quaternions, whose columns are quasi-coordinates in all else.
    """

    mode: SetpointMode
    limits: JointLimits
    bounds: Bounds
    timeout: float
    phase: Phase
    now: JointState
    newest: tuple[float, ...]
    fresh: bool
    counted: tuple[float, ...]
    age: float
    interval: float
    goal: tuple[float, ...]
    drift: tuple[float, ...]
    ahead: tuple[float, ...]
    turning: tuple[Turning, ...] = ()
    closed: bool = False
    fault: tuple[str, str] | None = None

    @property
    def ended(self) -> bool:
        """True once it has succeeded or been cancelled."""
        return self.phase in ENDED

    @property
    def progress(self) -> float:
        """Share that is done: 0 until it has succeeded, since nobody knows how long setpoints will come."""
        return 1.0 if self.phase is Phase.SUCCEEDED else 0.0

    @property
    def duration(self) -> float:
        """Duration in s; always 0, since it is unknown."""
        return 0.0

    @property
    def signals(self) -> Mapping[str, SignalValue]:
        """Signals that it sets with this tick; always none."""
        return {}

    @property
    def steps_done(self) -> int:
        """Number of steps done: 1 once it has succeeded, 0 before."""
        return int(self.phase is Phase.SUCCEEDED)

    @property
    def step_path(self) -> str:
        """Nothing: it has no steps."""
        return ""

    @property
    def found(self) -> bool | None:
        """Result of a search; always None."""
        return None

    @property
    def orders(self) -> tuple[object, ...]:
        """Nothing: it changes nothing but joints."""
        return ()

    def sample(self) -> tuple[Array, Array, Array]:
        """Return joint positions, velocities and accelerations (k,): rad or m, per s, per s²."""
        q, v, a = map(np.array, self.now)
        for one in self.turning:
            q[one.columns] = one.now
        return q, v, a

    def stop_ahead(self, dt: float, most: int) -> Array | None:
        """Return the joint positions (m, k), now and at most so many ticks on, if it is cancelled now, or was.

        None where it stands.
        """
        if self.ended or self.phase is Phase.PAUSED:
            return None
        lower, upper, acceleration, jerk, _ = self.bounds
        states = brake.joints_stop_ahead(self.now, (lower, upper, acceleration, jerk), dt, most)
        return setpoint_turning.positions(self.turning, self.now.q, states) if self.turning else states

    def set(self, values: Sequence[float]) -> SetpointMotion:
        """Return the motion with a newer setpoint (k,); one that stops, has ended or was closed follows no more.

        Raises KernelError when the values are not k finite numbers; LimitError, which names joint, value and limit, for
        a velocity above the joint's limit, a position outside its limits, and one farther from the setpoint before than
        the joint at its greatest speed gets in the time since then and `AHEAD_SECONDS`. Of these seconds so much is
        left as earlier setpoints have not used up; they come back while setpoints are slower than the joint.
        """
        if self.closed or self.ended or self.phase is Phase.STOPPING:
            return self
        wanted = _checked(values, len(self.newest))
        turning = self.turning
        if self.mode is SetpointMode.VELOCITY:
            check_rates(self.limits, wanted)
            self._check_velocities(wanted)
        else:
            inside = self._clamped(wanted)
            if inside != wanted or turning:
                self.limits.check(np.array(wanted), "a setpoint is refused")
            if turning:
                turning, wanted = led_to(turning, self.now.q, wanted)
                inside = self._clamped(wanted)
            for coupling in self.bounds.couplings:
                _check_coupling(coupling, wanted, "a setpoint is refused")
            # They may be outside by rounding; no joint goes there.
            wanted = inside
            self._check_jump(wanted)
        return _made(
            *(self.mode, self.limits, self.bounds, self.timeout, self.phase, self.now, wanted, True, self.counted),
            *(self.age, self.interval, self.goal, self.drift, self.ahead, turning, self.closed, self.fault),
        )

    def close(self) -> Self:
        """Return the motion going on to its newest setpoint, or to standstill, where it will have succeeded.

        Where an actuator's limits keep the joints from that setpoint it is cancelled as they stand.
        """
        return replace(self, closed=True, fresh=False, counted=self.newest, goal=self.newest, drift=self._at_rest)

    def advance(self, dt: float, override: float, context: TickContext = NOTHING) -> SetpointMotion:
        """Return the motion `dt` seconds later; no joint goes faster than `override` in (0, 1] times its limit."""
        del context  # it looks at its setpoints alone
        if self.ended:
            return self
        heard = self.heard()
        goal = tuple([place + speed * dt for place, speed in zip(heard.goal, heard.drift, strict=True)])
        if heard.phase is Phase.PAUSED or heard.ended:
            return replace(heard, goal=goal, age=heard.age + dt)
        _, now = heard.way(dt, override)
        phase, fault = heard._phase_at(now), heard.fault
        if phase is Phase.RUNNING and self.closed and now == self.now:
            off, name = max(zip(map(_distance, now.q, self.counted), self.limits.names, strict=True))
            phase = Phase.SUCCEEDED if off <= TOLERANCE else Phase.CANCELLED
            if phase is Phase.CANCELLED:
                kept = " and ".join(repr(coupling.name) for coupling in self.bounds.couplings)
                why = f": the limits of {kept} keep it from there" if kept else ""
                message = f"the joint {name!r} comes no nearer than {off:.6g} to its last setpoint{why}"
                fault = ("SETPOINT_REFUSED", message)
        later = _made(
            *(self.mode, self.limits, self.bounds, self.timeout, phase, now, heard.newest, heard.fresh, heard.counted),
            *(heard.age + dt, heard.interval, goal, heard.drift, heard.ahead, self.turning, self.closed, fault),
        )
        return later._turned(heard.now.q) if self.turning else later

    def way(self, dt: float, override: float) -> tuple[StoppableTrajectory, JointState]:
        """Return the way of the joints in the next `dt` seconds, and where they are then."""
        if self.phase is not Phase.RUNNING or (self.closed and self.mode is SetpointMode.VELOCITY):
            return online.brake(self.now, self.bounds, dt)
        greatest = (self.limits.velocity * override).tolist()
        if self.mode is SetpointMode.VELOCITY:
            wanted = [max(-most, min(most, value)) for value, most in zip(self.counted, greatest, strict=True)]
            return online.follow_velocities(self.now, wanted, self.bounds, greatest, dt)
        origin, drift = self._clamped(self.goal), self.drift
        fastest = [MOST_DRIFT * most for most in greatest]
        if origin != self.goal or any(map(gt, map(abs, drift), fastest)):
            drift = [
                max(-most, min(most, speed)) if inside == place else 0.0
                for speed, most, inside, place in zip(drift, fastest, origin, self.goal, strict=True)
            ]
        return online.follow_positions(self.now, origin, drift, self.bounds, greatest, dt)

    def pause(self) -> Self:
        """Return the motion slowing to standstill; a pausing or paused one as it is.

        It goes on hearing setpoints, and is cancelled when none come. Raises KernelError (WRONG_STATE) when it is
        stopping or has ended.
        """
        if self.phase in (Phase.PAUSING, Phase.PAUSED):
            return self
        self._refuse("paused")
        return replace(self, phase=Phase.PAUSING)

    def resume(self) -> Self:
        """Return the motion going on with the newest setpoint; a running one as it is.

        Raises KernelError (WRONG_STATE) when it is stopping or has ended.
        """
        if self.phase is Phase.RUNNING:
            return self
        self._refuse("resumed")
        return replace(self, phase=Phase.RUNNING)

    def step(self) -> Self:
        """Return the motion going on, as it has no steps."""
        return self.resume()

    def cancel(self) -> Self:
        """Return the motion braking to its end; a paused one ends at once, one that stops or has ended stays."""
        if self.phase in (*ENDED, Phase.STOPPING):
            return self
        return replace(self, phase=Phase.CANCELLED if self.phase is Phase.PAUSED else Phase.STOPPING)

    def obeyed(self) -> Self:
        """Return itself, as it has no orders."""
        return self

    def abort(self) -> Self:
        """Return the motion ended where it is: what it moved is gone."""
        return replace(self, phase=Phase.CANCELLED)

    def heard(self) -> SetpointMotion:
        """Return the motion that counts its newest setpoint; the goal of an old one stands, a too old one stops it."""
        if self.fresh:
            spare = tuple([min(AHEAD_SECONDS, value) for value in self._spare(self.newest)])
            newest, (goal, drift) = self.newest, self._next_goal()
            return _made(
                *(self.mode, self.limits, self.bounds, self.timeout, self.phase, self.now, newest, False, newest),
                *(0.0, self.age, goal, drift, spare, self.turning, self.closed, self.fault),
            )
        if self.closed or self.phase is Phase.STOPPING:
            return self
        if self.age < self.timeout - _ROUNDING:
            stands = self.age >= 2.0 * self.interval + SMOOTHING_SECONDS and self.goal != self.counted
            return replace(self, goal=self.counted, drift=self._at_rest) if stands else self
        return self._timed_out()

    def _timed_out(self) -> Self:
        """Return the motion stopped because its newest setpoint is too old."""
        phase = Phase.CANCELLED if self.phase is Phase.PAUSED else Phase.STOPPING
        return replace(self, phase=phase, fault=("SETPOINT_TIMEOUT", f"no setpoint came for {self.timeout:g} s"))

    def _turned(self, before: Sequence[float]) -> Self:
        """Return the motion with the orientations to which it has turned, and setpoints as seen from there."""
        turning = gone_on(self.turning, before, self.now.q)
        if self.mode is SetpointMode.VELOCITY:
            return replace(self, turning=turning)
        off = correction(turning, self.now.q, self.counted, SETTLED)
        newest, counted, goal = (tuple(map(add, seen, off)) for seen in (self.newest, self.counted, self.goal))
        return replace(self, turning=turning, newest=newest, counted=counted, goal=goal)

    @property
    def _at_rest(self) -> tuple[float, ...]:
        return (0.0,) * len(self.counted)

    def _next_goal(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return the filtered positions and velocities (k,) of the setpoints, the newest one included.

        The critically damped g-h filter (Brookner, Tracking and Kalman Filtering Made Easy, 1998, section 1.2.6: the
        least squares line whose memory fades): setpoints of constant speed are met exactly.
        """
        if self.mode is SetpointMode.VELOCITY or self.age <= 0.0:
            return self.newest, self._at_rest
        fading = math.exp(-self.age / SMOOTHING_SECONDS)
        g, h = 1.0 - fading**2, (1.0 - fading) ** 2
        goal, drift = [], []
        for seen, place, speed in zip(self.newest, self.goal, self.drift, strict=True):
            off = seen - place
            if abs(off) < SETTLED and abs(speed) < SETTLED:
                goal.append(seen)
                drift.append(0.0)
            else:
                goal.append(place + g * off)
                drift.append(speed + h * off / self.age)
        return tuple(goal), tuple(drift)

    def _spare(self, wanted: Sequence[float]) -> list[float]:
        """Return how much longer than each joint at its greatest speed the setpoints have taken, (k,) (s)."""
        if self.mode is SetpointMode.VELOCITY:
            return list(self.ahead)
        return [
            ahead + self.age - abs(after - before) / most
            for ahead, before, after, most in zip(
                self.ahead, self.counted, wanted, self.limits.velocity.tolist(), strict=True
            )
        ]

    def _check_velocities(self, wanted: Sequence[float]) -> None:
        for name, value, most in zip(self.limits.names, wanted, self.limits.velocity.tolist(), strict=True):
            if abs(value) > most * (1.0 + _ROUNDING):
                raise LimitError(
                    f"a setpoint is refused: joint {name!r} would move at {value:.6g}, its limit is {most:.6g}",
                    joint=name,
                    value=value,
                    limit=most,
                )

    def _clamped(self, wanted: tuple[float, ...]) -> tuple[float, ...]:
        bounds = self.bounds
        if not (any(map(lt, wanted, bounds.lower)) or any(map(gt, wanted, bounds.upper))):
            return wanted  # as it mostly is
        return tuple(map(min, map(max, wanted, self.bounds.lower), self.bounds.upper))

    def _check_jump(self, wanted: Sequence[float]) -> None:
        left = self._spare(wanted)
        if min(left) >= -_ROUNDING:
            return
        for joint, spare in enumerate(left):
            if spare < -_ROUNDING:
                name, most = self.limits.names[joint], float(self.limits.velocity[joint])
                before, value = self.counted[joint], wanted[joint]
                reach = most * (self.age + self.ahead[joint])
                raise LimitError(
                    f"a setpoint is refused: joint {name!r} would go from {before:.6g} to {value:.6g} within "
                    f"{self.age:.3g} s; at its greatest speed {most:.6g} it gets {reach:.6g} far",
                    joint=name,
                    value=value,
                    limit=before + (reach if value > before else -reach),
                )

    def _phase_at(self, now: JointState) -> Phase:
        if any(now.v) or any(now.a):
            return self.phase
        if self.phase is Phase.RUNNING:
            there = self.mode is SetpointMode.VELOCITY or now.q == self.counted
            return Phase.SUCCEEDED if self.closed and there else self.phase
        return {Phase.PAUSING: Phase.PAUSED, Phase.STOPPING: Phase.CANCELLED}[self.phase]

    def _refuse(self, what: str) -> None:
        if self.ended or self.phase is Phase.STOPPING:
            doing = "has ended" if self.ended else "is stopping"
            raise KernelError(f"the motion {doing} and cannot be {what}", reason=Reason.WRONG_STATE)


_made = maker(SetpointMotion)


def _checked(values: Sequence[float] | Array, count: int) -> tuple[float, ...]:
    """Return a setpoint (count,); raise KernelError as `checked_joints` does, which is not needed for good floats."""
    if isinstance(values, list | tuple) and len(values) == count and {*map(type, values)} == {float}:
        if math.isfinite(sum(values)):
            return tuple(values)
    return tuple(checked_joints(values, count, "a setpoint").tolist())


def _distance(a: float, b: float) -> float:
    return abs(a - b)


def _check_coupling(coupling: Coupling, q: Sequence[float], what: str) -> None:
    value = coupling.value(q)
    room = TOLERANCE * max(1.0, *(abs(ratio) for _, ratio in coupling.terms))
    if not coupling.lower - room <= value <= coupling.upper + room:
        raise LimitError(
            f"{what}: the actuator {coupling.name!r} would be at {value:.6g}, its limits are {coupling.lower:.6g} to "
            f"{coupling.upper:.6g}",
            actuator=coupling.name,
            value=value,
            lower=coupling.lower,
            upper=coupling.upper,
        )


def start(
    mode: SetpointMode,
    limits: JointLimits,
    q: Sequence[float] | Array,
    timeout: float,
    couplings: Sequence[Coupling] = (),
) -> SetpointMotion:
    """Return the motion at its start: at rest at `q` (k,), which is its first setpoint (a velocity of 0).

    Raises LimitError when a joint or an actuator is outside its limits, KernelError when the timeout is not finite and
    above 0.
    """
    places = checked_joints(q, len(limits.names), "the start")
    limits.check(places, "setpoints cannot be followed from here")
    if not 0.0 < timeout < float("inf"):
        raise KernelError(f"the timeout of setpoints must be finite and above 0, not {timeout}", value=timeout)
    for coupling in couplings:
        _check_coupling(coupling, places.tolist(), "setpoints cannot be followed from here")
    for name, velocity, acceleration, jerk in zip(
        limits.names, limits.velocity, limits.acceleration, limits.jerk, strict=True
    ):
        if not max(velocity / acceleration, acceleration / jerk) <= online.MOST_SECONDS:
            raise KernelError(
                f"setpoints cannot be followed: joint {name!r} with limits of velocity {velocity:g}, acceleration "
                f"{acceleration:g} and jerk {jerk:g} takes longer than {online.MOST_SECONDS:g} s to stop",
                joint=name,
            )
    # Joints and actuators may be outside their limits by rounding; there they begin.
    limits = replace(limits, lower=np.minimum(limits.lower, places), upper=np.maximum(limits.upper, places))
    values = [coupling.value(places.tolist()) for coupling in couplings]
    couplings = [
        coupling._replace(lower=min(coupling.lower, value), upper=max(coupling.upper, value))
        for coupling, value in zip(couplings, values, strict=True)
    ]
    turning, places = begun(limits, places)
    at = tuple(places.tolist())
    rest = (0.0,) * len(at)
    first = rest if mode is SetpointMode.VELOCITY else at
    return SetpointMotion(
        mode=mode,
        limits=limits,
        bounds=Bounds.of(limits, couplings),
        timeout=float(timeout),
        phase=Phase.RUNNING,
        now=JointState(at, rest, rest),
        newest=first,
        fresh=False,
        counted=first,
        age=0.0,
        interval=0.0,
        goal=first,
        drift=rest,
        ahead=(AHEAD_SECONDS,) * len(at),
        turning=turning,
    )
