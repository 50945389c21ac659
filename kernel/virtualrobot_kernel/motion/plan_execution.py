"""Execution of a plan: nominal time tau, advanced at a rate. Pure: functions take a PlanExecution and return one.

Pause, resume and speed override change the rate dtau/dt alone, so they never leave the path. A change is a ramp that is
twice differentiable, hence joint acceleration stays continuous, and short enough as the limits allow; while no ramp
fits (braking harder than the limits during a motion's own braking), the motion goes on and it is tried again, at the
latest for the time that a stop from top speed takes. A cancel brakes each track on its own path, at once, or lets the
motion run to its goal when that is where it stands still soonest; only where no brake keeps the limits (on timed
trajectories, rarely on a curved joint path) it is a ramp of the rate, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion import brake
from virtualrobot_kernel.motion.brake import (
    END_TOLERANCE,
    RETRY,
    PathState,
    RateState,
    StopAhead,
    brake_state,
    nominal_time,
)
from virtualrobot_kernel.motion.limits import checked_scale
from virtualrobot_kernel.motion.planned import Plan, sample_plans
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.quick import maker
from virtualrobot_kernel.motion.ramp import RateRamp
from virtualrobot_kernel.motion.running_motion import ENDED, NOTHING, Phase, TickContext

_SLOWING = (Phase.PAUSING, Phase.STOPPING)
_STANDING = (*_SLOWING, Phase.PAUSED)


@dataclass(frozen=True, slots=True, eq=False)
class PlanExecution:
    """State of a motion on its plan.

    tau: nominal time gone by (s); rate: dtau/dt; rate_slope: d2tau/dt2 (1/s). override: the rate that is wanted while
    it runs, in (0, 1]. ramp, ramp_tau, elapsed: the rate's law, tau at its start and the time since (s). waiting: for
    how long a wanted change has found no ramp that fits (s). brakes: the laws u(t) of the tracks that brake, instead
    of the plan's own; none while it does not. Then `elapsed` counts from their start, `tau` is the nominal time of
    the track that is furthest behind, and the rate and its ramp are what they were before. left: what it did not need
    of the last seconds that it was advanced by, because it reached its goal.
    """

    plan: Plan
    phase: Phase
    override: float
    tau: float
    rate: float
    rate_slope: float
    ramp: RateRamp
    ramp_tau: float
    elapsed: float
    waiting: float = 0.0
    brakes: tuple[PiecewisePolynomial, ...] = ()
    left: float = 0.0

    @property
    def ended(self) -> bool:
        """True once the motion has succeeded or been cancelled."""
        return self.phase in ENDED

    @property
    def duration(self) -> float:
        """Duration of the motion at full rate, in s."""
        return self.plan.duration

    @property
    def progress(self) -> float:
        """Share of the plan's duration that is done, 0 to 1; 1 for a motion without length."""
        return self.tau / self.plan.duration if self.plan.duration > 0.0 else 1.0

    @property
    def signals(self) -> Mapping[str, bool]:
        """Signals that it sets with this tick; always none."""
        return {}

    @property
    def fault(self) -> tuple[str, str] | None:
        """Cause of an end by itself; always None: it stops by itself only at its goal."""
        return None

    @property
    def steps_done(self) -> int:
        """Number of steps done: 1 once it has succeeded, 0 before."""
        return 1 if self.phase is Phase.SUCCEEDED else 0

    @property
    def found(self) -> bool | None:
        """Result of a search; always None."""
        return None

    @property
    def path_states(self) -> list[PathState]:
        """Path parameter u of each track and its first two derivatives by time, in 1/s and 1/s²."""
        if self.brakes:
            return [brake_state(brake, self.elapsed) for brake in self.brakes]
        states = [track.time_law.scalar_state(self.tau) for track in self.plan.tracks]
        return [(u, u1 * self.rate, u2 * self.rate**2 + u1 * self.rate_slope) for u, u1, u2 in states]

    def sample(self) -> tuple[Array, Array, Array]:
        """Return joint positions, velocities and accelerations (n,): rad or m, per s, per s²."""
        return sample_all([self])

    @property
    def settled(self) -> float:
        """Nominal time (s) from which on its rate does not change by what is under way."""
        if self.elapsed >= self.ramp.length:
            return self.tau
        return max(self.tau, self.ramp_tau + self.ramp.state(self.ramp.length)[3])

    def on(self, plan: Plan, cut: float) -> PlanExecution | None:
        """Return the motion on a plan that is the same up to the nominal time `cut` (s); None when it is too late."""
        if self.ended or self.brakes or self.settled > cut + END_TOLERANCE:
            return None
        return replace(self, plan=plan)

    def advance(self, dt: float, override: float, context: TickContext = NOTHING) -> PlanExecution:
        """Return the motion `dt` seconds later, with the speed `override` in (0, 1] that holds from now on."""
        del context  # what it does is in its plan
        if self.ended:
            return self
        return _advanced(self if override == self.override else self.set_override(override), dt)

    def set_override(self, override: float) -> PlanExecution:
        """Return the motion with another speed override in (0, 1]; a paused or stopping one remembers it."""
        return _retarget(replace(self, override=checked_scale(override, "speed override"), waiting=0.0))

    def pause(self) -> PlanExecution:
        """Return the motion slowing to standstill; a pausing or paused one as it is.

        Raises KernelError (WRONG_STATE) when it is stopping or has ended.
        """
        if self.phase in (Phase.PAUSING, Phase.PAUSED):
            return self
        _refuse(self, "paused")
        return _retarget(replace(self, phase=Phase.PAUSING, waiting=0.0))

    def resume(self) -> PlanExecution:
        """Return the motion going on after a pause; a running one as it is.

        Raises KernelError (WRONG_STATE) when it is stopping or has ended.
        """
        if self.phase is Phase.RUNNING:
            return self
        _refuse(self, "resumed")
        return _retarget(replace(self, phase=Phase.RUNNING, waiting=0.0))

    def abort(self) -> PlanExecution:
        """Return the motion ended where it is: what it moved is gone."""
        return replace(self, phase=Phase.CANCELLED)

    def cancel(self) -> PlanExecution:
        """Return the motion braking to its end; a paused one ends at once; one that stops or has ended stays as it is.

        A motion that stands still no later at its goal than by braking runs on to it, and has succeeded then.
        """
        if self.phase in (*ENDED, Phase.STOPPING):
            return self
        if self.phase is Phase.PAUSED:
            return replace(self, phase=Phase.CANCELLED)
        waiting = self.waiting if self.phase is Phase.PAUSING else 0.0
        return _retarget(replace(self, phase=Phase.STOPPING, waiting=waiting))

    def stop_ahead(self, dt: float, override: float, most: int) -> StopAhead | None:
        """Return the stop of the motion if it is cancelled now, as `cancel` and at most so many ticks would have it.

        None where it stands, and where that can't be told at once.
        """
        anew = override != self.override
        if self.phase in (*ENDED, Phase.PAUSED) or (anew and self.phase is Phase.PAUSING):
            return None
        now = _rate_state(self)
        if anew or self.phase is Phase.RUNNING:
            now = now._replace(waiting=0.0)
        asks = anew or self.phase is not Phase.STOPPING
        return brake.stop_ahead(self.plan, now, self.brakes, dt, most, asks=asks)


_made = maker(PlanExecution)


def start(plan: Plan, override: float) -> PlanExecution:
    """Return the motion at the start of its plan, at rest; a plan of duration 0 has succeeded already.

    The rate is `override` from the first moment on: the plan itself starts at rest.
    """
    rate = checked_scale(override, "speed override")
    phase = Phase.RUNNING if plan.duration > 0.0 else Phase.SUCCEEDED
    return PlanExecution(plan, phase, rate, 0.0, rate, 0.0, RateRamp(rate), 0.0, 0.0)


def sample_all(running: Sequence[PlanExecution]) -> tuple[Array, Array, Array]:
    """Return what `PlanExecution.sample` does for motions, one after another: one call for all."""
    states = [(one.tau, one.rate, one.rate_slope, 1.0 if one.brakes else 0.0) for one in running]
    brakes = {place: one.path_states for place, one in enumerate(running) if one.brakes}
    return sample_plans(tuple(one.plan for one in running), states, brakes)


def _advanced(running: PlanExecution, dt: float) -> PlanExecution:
    if running.phase is Phase.PAUSED:
        return running
    if running.brakes:
        return _brake_on(running, dt)
    waiting, ramp = 0.0, running.ramp
    if (0.0 if running.phase in _STANDING else running.override) != ramp.goal:
        waiting = running.waiting + dt
        if int(waiting / RETRY) != int(running.waiting / RETRY):
            running = _retarget(replace(running, waiting=waiting))
            if running.brakes:
                return _brake_on(running, dt)
            waiting, ramp = running.waiting, running.ramp
    elapsed = running.elapsed + dt
    rate, slope, _, gone = ramp.state(elapsed)
    tau = max(running.tau, running.ramp_tau + gone)
    phase, left = running.phase, 0.0
    if tau >= running.plan.duration - END_TOLERANCE:
        left = min(dt, max(0.0, tau - running.plan.duration) / rate) if rate > 0.0 else 0.0
        phase, tau, rate, slope = Phase.SUCCEEDED, running.plan.duration, 0.0, 0.0
    elif elapsed >= ramp.length and ramp.goal == 0.0 and phase in _SLOWING:
        phase = Phase.PAUSED if phase is Phase.PAUSING else Phase.CANCELLED
    override, begun = running.override, running.ramp_tau
    return _made(running.plan, phase, override, tau, rate, slope, ramp, begun, elapsed, waiting, (), left)


def _wanted(running: PlanExecution) -> float:
    return 0.0 if running.phase in _STANDING else running.override


def _brake_on(running: PlanExecution, dt: float) -> PlanExecution:
    elapsed = running.elapsed + dt
    taus = [
        nominal_time(track.time_law, brake_state(brake, elapsed)[0], running.tau)
        for track, brake in zip(running.plan.tracks, running.brakes, strict=True)
        if brake.end > 0.0  # else it does not move, and says nothing about how far the motion is
    ]
    stands = all(elapsed >= brake.end for brake in running.brakes)
    phase = Phase.CANCELLED if stands else running.phase
    return replace(running, phase=phase, tau=min(taus, default=running.tau), elapsed=elapsed)


def _retarget(running: PlanExecution) -> PlanExecution:
    """Start the brakes or the ramp to the wanted rate when they fit, or when waiting has taken long enough."""
    wanted, stops = _wanted(running), running.phase is Phase.STOPPING
    if running.brakes:
        return running
    if running.phase in ENDED or (wanted == running.ramp.goal and not stops):
        return replace(running, waiting=0.0)
    change = brake.change(running.plan, _rate_state(running), wanted, stops=stops)
    if change.brakes:
        return replace(running, brakes=change.brakes, elapsed=0.0, waiting=0.0)
    if change.ramp:
        return replace(running, ramp=change.ramp, ramp_tau=running.tau, elapsed=0.0, waiting=0.0)
    return running if change.waits else replace(running, waiting=0.0)


def _rate_state(running: PlanExecution) -> RateState:
    return RateState(running.tau, running.ramp_tau, running.elapsed, running.waiting, running.ramp)


def _refuse(running: PlanExecution, what: str) -> None:
    if running.phase in (*ENDED, Phase.STOPPING):
        raise KernelError(
            f"a motion that is {running.phase.value} cannot be {what}; only one that is RUNNING, PAUSING or PAUSED can",
            reason=Reason.WRONG_STATE,
            phase=running.phase.value,
        )
