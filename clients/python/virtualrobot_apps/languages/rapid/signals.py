"""Signals and time of a program's world, and the queue through which it gives both."""

from __future__ import annotations

from collections.abc import Iterable

from virtualrobot import Client
from virtualrobot.errors import WrongStateError

from virtualrobot_apps.languages.core.motion import MotionQueue, SignalTimeout
from virtualrobot_apps.languages.core.task import Task
from virtualrobot_apps.languages.core.together import Group, GroupQueue
from virtualrobot_apps.languages.rapid.faults import RapidFault, RapidStopped
from virtualrobot_apps.languages.rapid.symbols import Use


class Signals:
    """Signals of a kernel, for one program, in the order in which it touches them and its robot moves."""

    can_be_guided = True
    """True where a computer can guide the robot, by EGM."""

    def __init__(self, client: Client) -> None:
        """Begin without a program."""
        self.client = client
        self._types: dict[str, type] = {}
        self._names: dict[str, str] = {}
        self._queue: MotionQueue | None = None

    @property
    def queue(self) -> MotionQueue:
        """The motions of the program."""
        if self._queue is None:
            raise RapidStopped("no program works with this robot yet")
        return self._queue

    def begin(self, task: Task) -> None:
        """Belong to a task."""
        self._queue = MotionQueue(self.client, task)

    def join(self, task: Task, group: Group, name: str) -> None:
        """Move together with others from now on, as a member of this name; the robot must stand."""
        self.queue.close()
        self._queue = GroupQueue(self.client, task, group, name)

    def leave(self, task: Task) -> None:
        """Move alone again, when the robot stands."""
        self.queue.close()
        self.begin(task)

    @property
    def group(self) -> Group | None:
        """The robots with which this one moves together; None: it moves alone."""
        return self._queue.group if isinstance(self._queue, GroupQueue) else None

    def find_signals(self, uses: Iterable[Use]) -> None:
        """Look up the signals of a program; raises WrongStateError, with first places, for those that are not there."""
        found = {one.name.lower(): one for one in self.client.signals.read()}
        lacking = []
        for use in uses:
            signal = found.get(use.name.lower())
            if signal is None:
                lacking.append(f"{use.name} ({use.source.file}:{use.source.line(use.at)})")
            elif isinstance(signal.value, str | tuple):
                raise WrongStateError(f"the signal {signal.name!r} is a text or a group, which RAPID has not here")
            else:
                self._names[use.name.lower()] = signal.name
                self._types[signal.name] = type(signal.value)
        if lacking:
            raise WrongStateError(
                f"the world has no signal {', '.join(lacking)}; create it by 'virtualrobot signal NAME --create', or "
                "all by --create-signals"
            )

    def close(self) -> None:
        """Wait until all is done."""
        self.queue.close()

    def cancel(self, why: str) -> None:
        """Stop what is being done."""
        self.queue.cancel(why)

    def settle(self) -> None:
        """Wait until the world may be looked at or told something."""
        self.queue.settle()

    def time(self) -> float:
        """Return the time of the simulation (s)."""
        return self.client.clock.simulation_time

    def signal_name(self, name: str) -> str:
        """Return a signal's name as the world has it."""
        return self._names.get(name.lower(), name)

    def signal_value(self, name: str) -> float:
        """Return the value of a signal as a number, when the program has come so far."""
        self.settle()
        return float(self.client.signals[self.signal_name(name)])  # pyright: ignore[reportArgumentType] looked up

    def typed(self, name: str, value: float) -> bool | int | float:
        """Return a number as a value of a signal's type."""
        kind = self._types.get(self.signal_name(name), bool)
        if kind is bool and value not in (0.0, 1.0):
            raise RapidFault("ERR_ARGVALERR", f"the signal {name!r} is 0 or 1, not {value:g}")
        return kind(value)

    def set_signal(self, name: str, value: float, lead: float = 0.0) -> None:
        """Set a signal, in the zone of the last move, or when that is done, or `lead` s earlier."""
        self.queue.set(self.signal_name(name), self.typed(name, value), lead)

    def signal_later(self, values: list[tuple[float, str, float]]) -> None:
        """Give signals values after some seconds each, counted from the one before, while the program goes on."""
        self.settle()
        self.start_later(values)

    def start_later(self, values: list[tuple[float, str, float]]) -> None:
        """Do so from now on; any thread may call it."""
        program = self.client.program()
        for seconds, name, value in values:
            program = program.dwell(seconds) if seconds > 0.0 else program
            program.set(self.signal_name(name), self.typed(name, value))
        program.start(wait=False, on_disconnect="continue")

    def wait_signal(self, name: str, value: float, timeout: float | None, comparison: str = "==") -> None:
        """Stand until a signal compares so with a value; raises the fault ERR_WAIT_MAXTIME after `timeout` (s).

        Where the program goes on while the robot moves, it moves on.
        """
        wait = self.queue.look if self.queue.free else self.queue.wait_signal
        try:
            wait(self.signal_name(name), self.typed(name, value), timeout, comparison)
        except SignalTimeout as error:
            raise RapidFault("ERR_WAIT_MAXTIME", str(error)) from error
