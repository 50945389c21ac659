"""Programs in RAPID as programs of the kernel: what one gives is written down, and nothing moves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

import numpy as np
from virtualrobot import Client
from virtualrobot.motions.program import Program

from virtualrobot_apps.languages.core.motion import MotionQueue, SignalValue, Step
from virtualrobot_apps.languages.core.task import Task
from virtualrobot_apps.languages.rapid.apart import stands
from virtualrobot_apps.languages.rapid.faults import RapidStopped
from virtualrobot_apps.languages.rapid.frames import matrix_of
from virtualrobot_apps.languages.rapid.symbols import Use
from virtualrobot_apps.languages.rapid.task import Loaded, RapidTask
from virtualrobot_apps.languages.rapid.world import World

SAME = 1e-6
"""Difference (m, and in rotation matrices) below which two tool centre points are the same."""


def recorded(
    client: Client,
    robot: str,
    program: Loaded,
    routine: str = "main",
    say: Callable[[str], None] = lambda _: None,
    write: Callable[[str], None] = print,
) -> Program:
    """Return what a program in RAPID gives an arm from where it stands, as a program of the kernel; nothing moves.

    The tools that it names are the one that the robot has chosen. `say` gets notes, `write` the pendant's lines.

    Raises:
        RapidStopped: for an error of the program, and where it looks at the world or does what a program of the kernel
            has no step for, with file and line.
    """
    world = _Paper(client, robot, say)
    RapidTask(program, world, write).run(routine)
    return world.record.program()


class _Record(MotionQueue):
    """Steps as they come; nothing is sent."""

    def __init__(self, client: Client, task: Task) -> None:
        super().__init__(client, task)
        self._batch = self._steps = list[Step]()

    def program(self) -> Program:
        """Return the steps as a program."""
        program = self._client.program()
        for step in self._steps:
            program = step.add(program)
        return program

    def set(self, signal: str, value: SignalValue, lead: float = 0.0) -> None:
        """Write down that a signal is set: in the zone after the last move, or when all before it is done."""
        step = Step(lambda program: program.set(signal, value, lead=lead))
        if self._zone:
            self._held.append(step)
        else:
            self._send([step])

    @contextmanager
    def together(self) -> Iterator[None]:
        """Write the steps of a block down as all others."""
        yield

    def cancel(self, why: str) -> None:
        """Nothing moves."""

    def look(self, signal: str, value: SignalValue, timeout: float | None, comparison: str = "==") -> NoReturn:
        """Refuse."""
        _refuse("waits for a signal while it moves")

    def search(self, program: Program) -> NoReturn:
        """Refuse."""
        _refuse("searches")

    def stop(self) -> NoReturn:
        """Refuse."""
        _refuse("stops its own motion")

    def store(self) -> NoReturn:
        """Refuse."""
        _refuse("puts its path aside")

    def call_at(self, what: Callable[[], None], lead: float = 0.0) -> NoReturn:
        """Refuse."""
        _refuse("does something on its way")


class _Paper(World):
    """World of a program that is written down: it has the robot's places, and no signals to read."""

    record: _Record
    can_be_guided = False

    def begin(self, task: Task) -> None:
        """Write down what a task gives."""
        self._queue = self.record = _Record(self.client, task)

    def find_signals(self, uses: Iterable[Use]) -> None:
        """Look up the signals that the world has; others are on or off."""
        known = {one.name.lower() for one in self.client.signals.read()}
        super().find_signals(use for use in uses if use.name.lower() in known)

    def use_tool(self, tool: list[Any], wobj: list[Any] | None = None) -> None:
        """Work with the chosen tool, which must be this one."""
        if stands(tool, wobj):
            _refuse("works with a stationary tool")
        state = self.robot.state
        chosen = np.linalg.inv(self.client.scene.pose(self.robot.flange)) @ state.world_t_tcp
        if np.abs(chosen - matrix_of(tool[1])).max() > SAME:
            raise RapidStopped(
                f"this tool's centre point is not that of the robot's chosen tool ({state.tool or 'none'}); choose one "
                "that has it"
            )
        self.tool = tool

    def signal_value(self, name: str) -> NoReturn:
        """Refuse."""
        _refuse(f"reads the signal {name}")

    def start_later(self, values: list[tuple[float, str, float]]) -> NoReturn:
        """Refuse."""
        _refuse("sets signals while it goes on")

    def close(self) -> None:
        """Write down what is left."""
        self.record.finish()


def _refuse(what: str) -> NoReturn:
    raise RapidStopped(f"the program {what}, for which a program of the kernel has no step")
