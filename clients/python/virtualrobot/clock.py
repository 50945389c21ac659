"""Time: the wall clock times a factor, or only steps."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Unpack

from virtualrobot._wire.arguments import Count, checked
from virtualrobot._wire.messages import Stamp, stamp_of, value_or_default, whole
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import shown, told
from virtualrobot._wire.signal_values import GivenValue, SignalValue, value_of
from virtualrobot._wire.transport import without_hanging
from virtualrobot.errors import CallTimeoutError, InvalidArgumentError, VirtualRobotError
from virtualrobot.motions.motion import Motion
from virtualrobot.motions.state import MotionState
from virtualrobot.robots.values import RobotState
from virtualrobot.scene.editor import Batch
from virtualrobot.sensors.readings import Reading, reading_of
from virtualrobot.sensors.sensors import ReadingOptions, reading_options
from virtualrobot.stepping import Event, Values, setpoints
from virtualrobot.v1 import kernel_pb2

_MOST_TICKS = 25
"""Most ticks of one step of `run`."""

_MODES = {kernel_pb2.CLOCK_MODE_REALTIME: "realtime", kernel_pb2.CLOCK_MODE_STEPPED: "stepped"}


@shown
@dataclass(frozen=True, slots=True)
class ClockState:
    """State of the simulation clock.

    Attributes:
        stamp: the instant of this state.
        mode: `realtime` or `stepped`.
        speed_factor: simulated seconds for each second of the wall clock that are aimed at.
        tick_length: length of a tick (s).
        real_time_factor: simulated seconds for each second of the wall clock that were reached lately.
        late_ticks: ticks that began late since the kernel started.
        recorded: of a replay: its first and its last moment (s of simulation time), as `seek` takes them; else None.
    """

    stamp: Stamp
    mode: str
    speed_factor: float
    tick_length: float
    real_time_factor: float
    late_ticks: int
    recorded: tuple[float, float] | None = None


@shown
@dataclass(frozen=True, slots=True)
class Observation:
    """Observation after a step.

    Attributes:
        stamp: the instant.
        robots: all robots by name.
        signals: all signals by name.
        motions: the motions that run or ended meanwhile.
        readings: those of the sensors that were asked for, by name.
        ticks: how many ticks there were.
        events: the places of those events that ended it; empty where it came to its end without.
    """

    stamp: Stamp
    robots: dict[str, RobotState]
    signals: dict[str, SignalValue]
    motions: tuple[MotionState, ...]
    readings: dict[str, Reading] = field(default_factory=dict)
    ticks: int = 0
    events: tuple[int, ...] = ()


@checked
class ClockHold:
    """Time that goes on by steps alone for as long as this program holds it; `Clock.hold_stepped` makes one.

    A context manager.
    """

    def __init__(self, services: Services) -> None:
        """Begin to hold."""
        self._over = threading.Event()
        self._call = services.kernel.HoldClock(self._requests())
        try:
            next(self._call)
        except BaseException:
            self._over.set()
            raise

    def close(self) -> None:
        """Let time go on as before; may be called again."""
        self._over.set()
        without_hanging(self._wait)

    def __enter__(self) -> ClockHold:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self.close()

    def _wait(self) -> None:
        with suppress(VirtualRobotError):  # the kernel has gone
            for _ in self._call:
                pass

    def _requests(self) -> Iterator[kernel_pb2.HoldClockRequest]:
        yield kernel_pb2.HoldClockRequest()
        self._over.wait()


@checked
class Clock:
    """The clock of one kernel.

    Example:
        >>> client.clock.set_stepped()
        >>> client.clock.step(250).robots["iiwa"].positions
    """

    def __init__(self, services: Services) -> None:
        """Handle the clock of one kernel."""
        self._services = services

    def read(self) -> ClockState:
        """Return how time runs now."""
        response = self._services.kernel.GetClock(kernel_pb2.GetClockRequest())
        return _state(response)

    def watch(self, max_rate: float | None = None) -> Iterator[ClockState]:
        """Yield how time runs, now, at each change of mode, and `max_rate` (1 by default) times a second."""
        request = kernel_pb2.WatchClockRequest(max_rate_hertz=value_or_default(max_rate, "max_rate"))
        with self._services.kernel.WatchClock(request) as stream:
            yield from map(_state, stream)

    @property
    def mode(self) -> str:
        """Mode of the simulation clock: `realtime` or `stepped`."""
        return self.read().mode

    @property
    def simulation_time(self) -> float:
        """Seconds of simulation time."""
        return self.read().stamp.simulation_time

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds for each second of the wall clock that were reached lately."""
        return self.read().real_time_factor

    @property
    def speed_factor(self) -> float:
        """Simulated seconds for each second of the wall clock that are aimed at; set it for REALTIME."""
        return self.read().speed_factor

    @speed_factor.setter
    def speed_factor(self, factor: float) -> None:
        self.set_realtime(factor)

    def set_realtime(self, speed_factor: float = 1.0) -> ClockState:
        """Let time follow the wall clock times a factor of 0.01 to 100."""
        mode = kernel_pb2.CLOCK_MODE_REALTIME
        return _state(self._services.kernel.SetClock(kernel_pb2.SetClockRequest(mode=mode, speed_factor=speed_factor)))

    def set_stepped(self) -> ClockState:
        """Let time go on only by `step`."""
        return _state(self._services.kernel.SetClock(kernel_pb2.SetClockRequest(mode=kernel_pb2.CLOCK_MODE_STEPPED)))

    def hold_stepped(self) -> ClockHold:
        """Let time go on only by `step` for as long as this program lives, and as before at the end of the block.

        When the program is gone, even by a kill, time goes on as before, too, and what its steps have moved stops.

        Raises:
            WrongStateError: while another program holds the clock, and where time must follow the wall clock.

        Example:
            >>> with client.clock.hold_stepped():
            ...     client.clock.step(250)
        """
        return ClockHold(self._services)

    def step(
        self,
        ticks: Count = 1,
        *,
        twists: Mapping[str, Values] | None = None,
        positions: Mapping[str, Values] | None = None,
        velocities: Mapping[str, Values] | None = None,
        signals: Mapping[str, GivenValue] | None = None,
        changes: Batch | None = None,
        until: Iterable[Event] | None = None,
        sensors: Iterable[str] | None = None,
        setpoint_timeout: float = 10.0,
        preempt: bool = False,
        **options: Unpack[ReadingOptions],
    ) -> Observation:
        """Set what is given, let time go on by some ticks, and return the state after the last one: in one call.

        So an outside controller has one call a period. What is refused has changed nothing, and no time has gone by.

        Args:
            ticks: how many; with `until` the most.
            twists: of crafts by name: (vx, vy, omega) in m/s and rad/s; None lets one come to rest.
            positions: of joints of robots by name, each by name or in order (rad, m); None as well.
            velocities: likewise (rad/s, m/s).
            signals: values of signals by name.
            changes: other changes of the scene, as of `Scene.batch`.
            until: events that end the step early, of `virtualrobot.stepping`.
            sensors: those to read after it, by name: of one that reads at its rate the latest, else one made then.
            setpoint_timeout: after how many seconds of simulation time without a setpoint a robot stops.
            preempt: cancel motions in the way of setpoints instead of being refused.
            options: of the readings, as of `Sensor.read`.

        Raises:
            WrongStateError: when time follows the wall clock, or when a motion that followed setpoints was stopped.
            RobotBusyError: when something else moves a robot that has a setpoint.
            UnknownNameError, InvalidArgumentError, LimitError: for what is refused.

        Example:
            >>> client.clock.step(12, twists={"ugv": (0.3, 0.0, 0.1)}, sensors=["ugv.lidar"]).robots["ugv"].world_t_tcp
        """
        batch = changes if changes is not None else Batch()
        for name, value in (signals or {}).items():
            batch.set_signal(name, value)
        given = {"twists": twists, "positions": positions, "velocities": velocities}
        wanted = list(sensors or ())
        request = kernel_pb2.StepClockRequest(
            ticks=whole(ticks, "ticks"),
            commands=batch._commands,
            setpoints=[one for kind, of in given.items() for one in setpoints(kind, of, setpoint_timeout, preempt)],
            until=[event._message for event in until or ()],
            sensors=wanted,
            reading_options=reading_options(options) if wanted else None,
        )
        response = self._services.kernel.StepClock(request, timeout=LONG_TIMEOUT_SECONDS)
        return Observation(
            stamp_of(response.stamp),
            {robot.name: RobotState.of(robot, response.stamp) for robot in response.robots},
            {signal.name: value_of(signal.value) for signal in response.signals},
            tuple(map(MotionState.of, response.motions)),
            dict(zip(wanted, map(reading_of, response.readings), strict=True)),
            response.ticks,
            tuple(response.events),
        )

    def seek(self, simulation_time: float) -> ClockState:
        """Go to a moment of a replay (`virtualrobot replay`), back or forth; return the clock there.

        Args:
            simulation_time: seconds of simulation time, rounded to the next tick. `read().recorded` has the
                first and the last one.

        Raises:
            InvalidArgumentError: when the replay has no such moment.
            WrongStateError: when the kernel is no replay: its time goes forwards only.

        Example:
            >>> client.clock.seek(12.5)
        """
        if not 0.0 <= simulation_time < math.inf:
            raise InvalidArgumentError(f"a replay has moments from 0 s on, not {simulation_time:g} s")
        tick = round(simulation_time / self.read().tick_length)
        return _state(self._services.kernel.SeekClock(kernel_pb2.SeekClockRequest(tick=tick)))

    def run(self, *motions: Motion, timeout: float | None = None) -> ClockState:
        """Let time go on by steps until these motions have ended; return the clock as it is then.

        It steps by no more ticks than the motions still need, so equal programs end in the same tick; one that is
        stopped on its way may have ended up to 25 ticks before. Ctrl-C cancels the motions.

        Args:
            motions: started with `wait=False`.
            timeout: seconds of simulation time after which it gives up.

        Raises:
            MotionCancelledError: when one was cancelled; the message says why.
            MotionAbortedError: when the kernel had to end one before its goal.
            CallTimeoutError: after `timeout` seconds of simulation time; the motions go on.
            WrongStateError: when time follows the wall clock.

        Example:
            >>> client.clock.set_stepped()
            >>> client.clock.run(robot.move_joints(goal, wait=False)).stamp.simulation_time
            1.236
        """
        tick = self.read().tick_length
        left = math.inf if timeout is None else round(timeout / tick)
        try:
            while going := [state for state in (motion.state for motion in motions) if not state.phase.ended]:
                if left <= 0:
                    names = ", ".join(state.id for state in going)
                    raise CallTimeoutError(f"{names} has not ended after {timeout} s of simulation time; it goes on")
                needed = min((1.0 - state.progress) * state.planned_duration for state in going)
                ticks = min(max(int(needed / tick), 1), _MOST_TICKS, left)
                self.step(int(ticks))
                left -= ticks
        except KeyboardInterrupt as interrupted:
            for motion in motions:
                motion.cancel(str(interrupted) or "interrupted from the keyboard")
            raise
        for motion in motions:
            motion.state.raise_early_end()
        return self.read()

    def __repr__(self) -> str:
        """Return a line for people."""

        def say() -> str:
            now = self.read()
            pace = f"{now.real_time_factor:.2f} s a second" if now.mode == "realtime" else "goes on by step()"
            return f"{now.mode}, {now.stamp.simulation_time:.3f} s, {pace}, ticks of {1e3 * now.tick_length:g} ms"

        return told("Clock", say)


def _state(
    response: kernel_pb2.GetClockResponse
    | kernel_pb2.SetClockResponse
    | kernel_pb2.SeekClockResponse
    | kernel_pb2.WatchClockResponse,
) -> ClockState:
    clock = response.clock
    tick_length = clock.tick_nanoseconds / 1e9
    ticks = (clock.recorded.first_tick, clock.recorded.last_tick) if clock.HasField("recorded") else None
    return ClockState(
        stamp_of(response.stamp),
        _MODES.get(clock.mode, "unknown"),
        clock.speed_factor,
        tick_length,
        clock.real_time_factor,
        clock.late_ticks,
        ticks and (ticks[0] * tick_length, ticks[1] * tick_length),
    )
