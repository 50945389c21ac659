"""A motion that runs: nominal time tau on a plan, advanced at a rate. Pure: functions take a Running and return one.

Pause, resume, cancel and speed override change the rate dtau/dt alone, so they never leave the path. A change is a
ramp that is twice differentiable, hence joint acceleration stays continuous, and short enough as the limits allow;
while no ramp fits (braking harder than the limits during a motion's own braking), the motion goes on and it is tried
again, at the latest for the time that a stop from top speed takes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.limits import checked_scale
from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.ramp import RateRamp, choose_ramp

_RETRY = 0.02
_SHORTEST_PATIENCE = 0.1
_END_TOLERANCE = 1e-9


class Phase(Enum):
    """What a motion is doing; the names equal those of `MotionPhase` in the contract."""

    RUNNING = "RUNNING"
    PAUSING = "PAUSING"
    PAUSED = "PAUSED"
    STOPPING = "STOPPING"
    SUCCEEDED = "SUCCEEDED"
    CANCELLED = "CANCELLED"


_ENDED = (Phase.SUCCEEDED, Phase.CANCELLED)
_SLOWING = (Phase.PAUSING, Phase.STOPPING)


@dataclass(frozen=True, slots=True, eq=False)
class Running:
    """Where a motion is on its plan.

    tau: nominal time gone by (s); rate: dtau/dt; rate_slope: d2tau/dt2 (1/s). override: the rate that is wanted while
    it runs, in (0, 1]. ramp, ramp_tau, elapsed: the rate's law, tau at its start and the time since (s). waiting: for
    how long a wanted change has found no ramp that fits (s).
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

    @property
    def ended(self) -> bool:
        """Whether the motion has succeeded or been cancelled."""
        return self.phase in _ENDED

    @property
    def progress(self) -> float:
        """The share of the plan's duration that is done, 0 to 1; 1 for a motion without length."""
        return self.tau / self.plan.duration if self.plan.duration > 0.0 else 1.0

    @property
    def path_state(self) -> tuple[float, float, float]:
        """The path parameter u of the (first) track and its first two derivatives by time, in 1/s and 1/s²."""
        u, u1, u2 = self.plan.tracks[0].time_law.scalar_state(self.tau)
        return u, u1 * self.rate, u2 * self.rate**2 + u1 * self.rate_slope

    def sample(self) -> tuple[Array, Array, Array]:
        """Return joint positions, velocities and accelerations (n,): rad or m, per s, per s²."""
        return self.plan.sample(self.tau, self.rate, self.rate_slope)


def start(plan: Plan, override: float) -> Running:
    """Return the motion at the start of its plan, at rest; a plan of duration 0 has succeeded already.

    The rate is `override` from the first moment on: the plan itself starts at rest.
    """
    rate = checked_scale(override, "speed override")
    phase = Phase.RUNNING if plan.duration > 0.0 else Phase.SUCCEEDED
    return Running(plan, phase, rate, 0.0, rate, 0.0, RateRamp(rate), 0.0, 0.0)


def advance(running: Running, dt: float, override: float) -> Running:
    """Return the motion `dt` seconds later, with the speed `override` in (0, 1] that holds from now on."""
    if running.phase in _ENDED:
        return running
    if override != running.override:
        running = set_override(running, override)
    if running.phase is Phase.PAUSED:
        return running
    waiting = 0.0
    if _wanted(running) != running.ramp.goal:
        waiting = running.waiting + dt
        if int(waiting / _RETRY) != int(running.waiting / _RETRY):
            running = _retarget(replace(running, waiting=waiting))
            waiting = running.waiting
    elapsed = running.elapsed + dt
    rate, slope, _, gone = running.ramp.state(elapsed)
    tau = max(running.tau, running.ramp_tau + gone)
    phase = running.phase
    if tau >= running.plan.duration - _END_TOLERANCE:
        phase, tau, rate, slope = Phase.SUCCEEDED, running.plan.duration, 0.0, 0.0
    elif elapsed >= running.ramp.length and running.ramp.goal == 0.0 and phase in _SLOWING:
        phase = Phase.PAUSED if phase is Phase.PAUSING else Phase.CANCELLED
    return Running(
        running.plan,
        phase,
        running.override,
        tau,
        rate,
        slope,
        running.ramp,
        running.ramp_tau,
        elapsed,
        waiting,
    )


def set_override(running: Running, override: float) -> Running:
    """Return the motion with another speed override in (0, 1]; a paused or stopping one remembers it."""
    return _retarget(replace(running, override=checked_scale(override, "speed override"), waiting=0.0))


def pause(running: Running) -> Running:
    """Return the motion slowing to standstill; a pausing or paused one as it is.

    Raises KernelError (WRONG_STATE) when it is stopping or has ended.
    """
    if running.phase in (Phase.PAUSING, Phase.PAUSED):
        return running
    _refuse(running, "paused")
    return _retarget(replace(running, phase=Phase.PAUSING, waiting=0.0))


def resume(running: Running) -> Running:
    """Return the motion going on after a pause; a running one as it is.

    Raises KernelError (WRONG_STATE) when it is stopping or has ended.
    """
    if running.phase is Phase.RUNNING:
        return running
    _refuse(running, "resumed")
    return _retarget(replace(running, phase=Phase.RUNNING, waiting=0.0))


def cancel(running: Running) -> Running:
    """Return the motion slowing to its end; a paused one ends at once; one that stops or has ended stays as it is.

    A motion that reaches its goal before it stands still has succeeded.
    """
    if running.phase in (*_ENDED, Phase.STOPPING):
        return running
    if running.phase is Phase.PAUSED:
        return replace(running, phase=Phase.CANCELLED)
    waiting = running.waiting if running.phase is Phase.PAUSING else 0.0
    return _retarget(replace(running, phase=Phase.STOPPING, waiting=waiting))


def _wanted(running: Running) -> float:
    return 0.0 if running.phase in (*_SLOWING, Phase.PAUSED) else running.override


def _retarget(running: Running) -> Running:
    """Start the ramp to the wanted rate when one fits, or when waiting for one has taken long enough."""
    wanted = _wanted(running)
    if running.phase in _ENDED or wanted == running.ramp.goal:
        return replace(running, waiting=0.0)
    rate, slope, curvature, _ = running.ramp.state(running.elapsed)
    # At standstill, waiting would change nothing. While there is patience, a better moment for a short ramp is likely
    # nearer than the end of a long one.
    patience = max(running.plan.braking.stop_time, _SHORTEST_PATIENCE) if rate > 0.0 else 0.0
    patient = running.waiting < patience
    choice = choose_ramp(
        running.plan,
        running.tau,
        rate,
        slope,
        curvature,
        wanted,
        prompt=patient,
        joints_only=running.phase is Phase.STOPPING,
    )
    if choice.ramp is None or (patient and not choice.fits):
        return running
    return replace(running, ramp=choice.ramp, ramp_tau=running.tau, elapsed=0.0, waiting=0.0)


def _refuse(running: Running, what: str) -> None:
    if running.phase in (*_ENDED, Phase.STOPPING):
        raise KernelError(
            f"a motion that is {running.phase.value} cannot be {what}; only one that is RUNNING, PAUSING or PAUSED can",
            reason=Reason.WRONG_STATE,
            phase=running.phase.value,
        )
