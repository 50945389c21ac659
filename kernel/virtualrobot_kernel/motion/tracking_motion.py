"""Motion that goes along with a frame which another robot's joint moves, such as a conveyor's belt. Pure.

The motion itself is any other one, planned as if the frame stood still where it was. In each tick the joints that it
has are taken along: to where the tool centre point is the same seen from the frame, which the belt has moved. First the
arm catches up with the frame, and the motion waits; then the tool centre point is where the motion has it in the
frame, exactly, in each tick; when the motion is over, or stops, the arm leaves the frame by a law of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.conveyor_tracking import CatchUp, ConveyorTracking, Leave, catch_up, leave
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.running_motion import ENDED, NOTHING, Phase, RunningMotion, TickContext
from virtualrobot_kernel.motion.signals import SignalValue

WINDOW_LEFT, TRACKING_LOST = "WINDOW_LEFT", "TRACKING_LOST"
"""Names of `EndCause`."""

_ROUNDING = 1e-9
#: Factor of the stated velocity and acceleration that the frame's joint may reach; a ramp may exceed a limit by 0.5%.
_SLACK = 1.02
#: Time between the points that velocity and acceleration come from, in s.
_STEP = 1e-4
_TIMES = np.array([0.0, -_STEP, _STEP])
#: The largest error of a posture that is taken, in rad, or in m over the longest lever arm.
_LARGEST_ERROR = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class TrackingMotion:
    """State of a motion that tracks a frame.

    inner: the motion as if the frame stood still. place, speed, slope: the displacement of the frame that the arms are
    at, and its derivatives by time. seen: the joint's displacement and velocity in the last tick; None before the first
    one. catching: how the arms catch up, for `elapsed` s; None before. leaving: how they leave, for `elapsed` s. early:
    whether they leave before the motion is over. trouble: why, if nobody asked for it. q, v, a (n,): the joints.
    """

    inner: RunningMotion
    tracking: ConveyorTracking
    phase: Phase
    q: Array
    v: Array
    a: Array
    signals: Mapping[str, SignalValue]
    place: float = 0.0
    speed: float = 0.0
    slope: float = 0.0
    elapsed: float = 0.0
    seen: tuple[float, float] | None = None
    catching: CatchUp | None = None
    leaving: Leave | None = None
    early: bool = False
    trouble: tuple[str, str] | None = None

    @property
    def ended(self) -> bool:
        """True once it has succeeded or been cancelled."""
        return self.phase in ENDED

    @property
    def progress(self) -> float:
        """Share of the motion in the frame that is done, 0 to 1."""
        return self.inner.progress

    @property
    def duration(self) -> float:
        """Duration of the motion in the frame, in s, without catching up and leaving."""
        return self.inner.duration

    @property
    def fault(self) -> tuple[str, str] | None:
        """Cause of its end, in itself or in the frame that it goes along with: name and text; None without one."""
        return self.trouble or self.inner.fault

    @property
    def steps_done(self) -> int:
        """Number of steps done of the motion in the frame."""
        return self.inner.steps_done

    @property
    def step_path(self) -> str:
        """Step of the motion in the frame as its program's text calls it."""
        return self.inner.step_path

    @property
    def found(self) -> bool | None:
        """Result of the search of the motion in the frame; None as there."""
        return self.inner.found

    @property
    def in_step(self) -> bool:
        """True while the arms have caught up with the frame and have not begun to leave it."""
        return self.catching is not None and self.leaving is None and self.elapsed >= self.catching.length

    @property
    def orders(self) -> tuple[object, ...]:
        """Orders of the motion in the frame."""
        return self.inner.orders if self.in_step else ()

    def sample(self) -> tuple[Array, Array, Array]:
        """Return joint positions, velocities and accelerations (n,): rad or m, per s, per s²."""
        return self.q, self.v, self.a

    def advance(self, dt: float, override: float, context: TickContext = NOTHING) -> TrackingMotion:
        """Return the motion `dt` seconds later; `context` must tell where the frame's joint is by then."""
        if self.ended:
            return self
        now = self if self.leaving else _gone_along(self, dt, context)
        if now.leaving:
            now = _left(now, dt, override, context)
        elif now.in_step:
            inner = now.inner.advance(dt, override, context)
            now = replace(now, inner=inner, signals=inner.signals, phase=inner.phase)
            if inner.ended:
                now = replace(now, leaving=_leave(now), elapsed=0.0, phase=Phase.STOPPING)
        return _posed(now, dt)

    def pause(self) -> TrackingMotion:
        """Return the motion slowing to standstill in the frame, with which it goes on; see `RunningMotion.pause`."""
        return self._asked(self.inner.pause, "paused")

    def resume(self) -> TrackingMotion:
        """Return the motion going on after a pause; see `RunningMotion.resume`."""
        return self._asked(self.inner.resume, "resumed")

    def step(self) -> TrackingMotion:
        """Return the motion going on to the end of its step in the frame, where it pauses."""
        return self._asked(self.inner.step, "stepped")

    def cancel(self) -> TrackingMotion:
        """Return the motion braking to its end while it leaves the frame; one that stops or has ended as it is."""
        if self.leaving or self.ended:
            return self
        return _stopping(self)

    def obeyed(self) -> TrackingMotion:
        """Return the motion after the orders of the motion in the frame were done."""
        inner = self.inner.obeyed()
        return replace(self, inner=inner, phase=inner.phase)

    def abort(self) -> TrackingMotion:
        """Return the motion ended where it is: what it moved is gone."""
        return replace(self, phase=Phase.CANCELLED)

    def _asked(self, change: Callable[[], RunningMotion], what: str) -> TrackingMotion:
        if self.leaving or self.ended:
            raise KernelError(
                f"a motion that is {self.phase.value} cannot be {what}; only one that is RUNNING, PAUSING, PAUSED or "
                "WAITING can",
                reason=Reason.WRONG_STATE,
                phase=self.phase.value,
            )
        inner = change()
        return replace(self, inner=inner, phase=inner.phase)


def start(inner: RunningMotion, tracking: ConveyorTracking) -> TrackingMotion:
    """Return the motion at its start, at rest where the frame was when it was planned; `inner` has just started."""
    q, v, a = inner.sample()
    return TrackingMotion(inner, tracking, Phase.RUNNING, q, v, a, {})


def _gone_along(now: TrackingMotion, dt: float, context: TickContext) -> TrackingMotion:
    """Return the motion with the frame where it is by now, or stopping when it can't or mustn't be followed there."""
    tracking = now.tracking
    if context.tracked is None:
        return _stopping(now, (TRACKING_LOST, "the joint that it went along with is gone"))
    place, speed = context.tracked[0] - tracking.start, context.tracked[1]
    if trouble := _trouble(now, place, speed, dt):
        return _stopping(now, trouble)
    slope = 0.0 if now.seen is None else (speed - now.seen[1]) / dt
    catching, elapsed = now.catching, now.elapsed + dt
    if catching is None:
        if now.seen is None and (place or speed):
            return replace(now, seen=(place, speed))  # how fast the frame accelerates is known with the next tick
        catching, elapsed = catch_up(tracking, place, speed, slope), 0.0
    gap, gap_speed, gap_slope = catching.state(elapsed)
    at = leave(tracking, place - gap, speed - gap_speed, slope - gap_slope)
    if not tracking.low - _ROUNDING <= at.end <= tracking.high + _ROUNDING:
        words = (
            f"what it went along with is {place:.6g} from where it was when the motion was planned, and its window "
            f"is {tracking.low:.6g} to {tracking.high:.6g}"
        )
        return _stopping(now, (WINDOW_LEFT, words))
    return replace(
        now,
        place=at.place,
        speed=at.speed,
        slope=at.slope,
        elapsed=elapsed,
        seen=(place, speed),
        catching=catching,
        signals={},
    )


def _trouble(now: TrackingMotion, place: float, speed: float, dt: float) -> tuple[str, str] | None:
    tracking = now.tracking
    if abs(speed) > _SLACK * tracking.max_velocity + _ROUNDING:
        words = f"what it went along with moves at {speed:.6g} per second; {tracking.max_velocity:.6g} was the most"
        return TRACKING_LOST, words
    if now.seen is None:
        return None
    most = _SLACK * tracking.max_acceleration * dt + _ROUNDING
    if abs(speed - now.seen[1]) > most:
        words = (
            f"what it went along with accelerates by {(speed - now.seen[1]) / dt:.6g} per second squared; the arm "
            f"keeps up with {tracking.max_acceleration:.6g}"
        )
        return TRACKING_LOST, words
    jump = place - now.seen[0] - 0.5 * (speed + now.seen[1]) * dt
    if abs(jump) > most * dt + _ROUNDING:
        return TRACKING_LOST, f"what it went along with has jumped by {jump:.6g}"
    return None


def _leave(now: TrackingMotion) -> Leave:
    return leave(now.tracking, now.place, now.speed, now.slope)


def _stopping(now: TrackingMotion, trouble: tuple[str, str] | None = None) -> TrackingMotion:
    """Return the motion leaving the frame from where it is; while it had not caught up yet, it had not begun."""
    inner = now.inner.cancel() if now.in_step else now.inner.abort()
    return replace(
        now, inner=inner, leaving=_leave(now), elapsed=0.0, early=True, trouble=trouble, phase=Phase.STOPPING
    )


def _left(now: TrackingMotion, dt: float, override: float, context: TickContext) -> TrackingMotion:
    assert now.leaving
    elapsed = now.elapsed + dt
    place, speed, slope = now.leaving.state(elapsed)
    inner, signals = now.inner, {}
    if not inner.ended:
        inner = inner.advance(dt, override, context)
        signals = inner.signals
    phase = now.phase
    if inner.ended and elapsed >= now.leaving.length:
        phase = Phase.CANCELLED if now.early else inner.phase
    return replace(
        now, inner=inner, signals=signals, place=place, speed=speed, slope=slope, elapsed=elapsed, phase=phase
    )


def _posed(now: TrackingMotion, dt: float) -> TrackingMotion:
    """Return the motion with its joints where its own motion and the frame's have them, by now."""
    q, v, a = (array.copy() for array in now.inner.sample())
    place = now.place + _TIMES * (now.speed + 0.5 * _TIMES * now.slope)
    for arm in now.tracking.arms:
        columns = arm.columns
        nominal = q[columns] + _TIMES[:, None] * (v[columns] + 0.5 * _TIMES[:, None] * a[columns])
        near = now.q[columns] + dt * (now.v[columns] + 0.5 * dt * now.a[columns])
        found, error = arm.postures(nominal, place, np.repeat(near[None], 3, axis=0))
        if not error.max() < _LARGEST_ERROR:
            words = "no posture near the one before takes the tool centre point along"
            return replace(now, trouble=(TRACKING_LOST, words), phase=Phase.CANCELLED)
        q[columns] = found[0]
        v[columns] = (found[2] - found[1]) / (2.0 * _STEP)
        a[columns] = (found[2] - 2.0 * found[0] + found[1]) / _STEP**2
    return replace(now, q=q, v=v, a=a)
