"""Programs: many moves, signals, waits and dwells, one after the other, as one motion."""

from __future__ import annotations

from pathlib import Path
from typing import Unpack

from google.protobuf.internal.containers import RepeatedCompositeFieldContainer

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import value_or_default
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.signal_values import GivenValue, condition, value_message
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.motions import motion, plans
from virtualrobot.motions.moves import Move, messages_of
from virtualrobot.v1 import motion_pb2


@checked
class Program:
    """Steps that one motion makes one after the other, planned as a whole before anything moves.

    Each method adds a step and returns the program. Moves are those of `Robot.ptp`, `Robot.linear` and their like.

    Example:
        >>> program = client.program()
        >>> program.move(robot.linear(above), zone=0.02)
        >>> program.move(robot.linear(at))
        >>> program.set("gripper", True)
        >>> program.wait("part", True, timeout=5.0)
        >>> program.dwell(0.2)
        >>> program.move(robot.linear(above))
        >>> program.start()
    """

    def __init__(self, services: Services, spec: motion_pb2.MotionSpec | None = None) -> None:
        """Begin empty, or with what a spec says; `Client.program` makes one."""
        self._services = services
        self._spec = motion_pb2.MotionSpec() if spec is None else spec

    def move(self, *moves: Move, zone: float | None = None, zone_percent: float | None = None) -> Program:
        """Add moves that start and end together.

        With `zone`, in meters of the tool centre point's way, or `zone_percent`, of these moves and of the next ones,
        up to 50, the corner is rounded off towards the next moves instead of stopping there; `Motion.notes` tells what
        became of it.
        """
        if zone is not None and zone_percent is not None:
            raise InvalidArgumentError("a zone has a distance or a percentage: give one of zone and zone_percent")
        given = messages_of(moves)
        step = self._steps.add().move
        step.moves.extend(given)
        if zone is not None:
            step.blend_distance_meters = zone
        if zone_percent is not None:
            step.blend_percent = zone_percent
        return self

    def set(self, signal: str, value: GivenValue = True) -> Program:
        """Add a step that sets a signal; between moves with a zone it is set in the zone's middle."""
        self._steps.add(set_signal=motion_pb2.SetSignalStep(signal=signal, value=value_message(value)))
        return self

    def wait(
        self, signal: str, value: GivenValue = True, timeout: float | None = None, comparison: str = "=="
    ) -> Program:
        """Add a step that stands still until a signal compares so with a value (`==`, `!=`, `<`, `<=`, `>`, `>=`).

        After `timeout` seconds of simulation time, if given, the motion is aborted as SIGNAL_TIMEOUT.
        """
        seconds = value_or_default(timeout, "timeout")
        wait = motion_pb2.WaitSignalStep(condition=condition(signal, value, comparison), timeout_seconds=seconds)
        self._steps.add(wait_signal=wait)
        return self

    def dwell(self, duration: float) -> Program:
        """Add a step that stands still for `duration` seconds of simulation time, at most 86,400 (a day)."""
        self._steps.add(dwell=motion_pb2.DwellStep(seconds=duration))
        return self

    def start(self, *, open: bool = False, **options: Unpack[motion.StartOptions]) -> motion.Motion:
        """Plan all steps and start; the options are those of `Robot`.

        An `open` program is not waited for: `Motion.append` gives it more steps while it runs. An error of
        the planner names the step, in its message and as `metadata["step"]`; then nothing moves.
        """
        return motion.start_spec(self._services, self._spec, open=open, **options)

    def plan(self, **options: Unpack[plans.PlanOptions]) -> plans.MotionPlan:
        """Return what it would do, in samples; see `Client.plan`. Nothing moves."""
        return plans.plan(self._services, self._spec, **options)

    def check(self, **options: Unpack[plans.CheckOptions]) -> plans.MotionCheck:
        """Return whether it keeps all limits and touches nothing, and else what it violates; see `Client.check`.

        Example:
            >>> found = program.check()
            >>> if not found.ok:
            ...     print(found.first_violation.step, found.first_violation)
        """
        return plans.check(self._services, self._spec, **options)

    def __len__(self) -> int:
        """Return the number of steps."""
        return len(self._spec.steps) or int(bool(self._spec.moves))

    @property
    def _steps(self) -> RepeatedCompositeFieldContainer[motion_pb2.ProgramStep]:
        """Steps, to be appended or appended to; moves that a file gives without steps become the first one."""
        if self._spec.moves:
            self._spec.steps.add().move.moves.extend(self._spec.moves)
            del self._spec.moves[:]
        return self._spec.steps

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Program of {len(self)} step{'s' * (len(self) != 1)}>"


def read(services: Services, file: str | Path) -> Program:
    """Return what a program file says; see `Client.read_program`."""
    try:
        text = Path(file).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidArgumentError(f"{file} is no program file: {error}") from error
    request = motion_pb2.ReadProgramRequest(text=text, uri=str(file))
    return Program(services, services.motion.ReadProgram(request, timeout=LONG_TIMEOUT_SECONDS).spec)
