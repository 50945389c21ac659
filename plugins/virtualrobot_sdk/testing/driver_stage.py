"""A robot driver in its worker process, with a plain host: it reads and sends in the driver's pace, in rad and m.

The loop runs here, beside the driver, since the way to another process would take longer than a cycle.
"""

from __future__ import annotations

import dataclasses
import importlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from virtualrobot_sdk.drivers import About, DriverFault, Mode, Pace, Reading
from virtualrobot_sdk.drivers.driver import finite, wrong_reading
from virtualrobot_sdk.errors import ComponentFault, FaultKind
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.testing.stage import Stage

READINGS = 10
"""Number of readings that are taken where a robot is watched."""
SHARE = 0.5
"""Share of its greatest speed at which a controller that plans by itself is asked to go."""


@dataclass(frozen=True, slots=True)
class Complaint:
    """A DriverFault, and when it came (s) after what it is about."""

    text: str
    code: str
    clears: bool
    seconds: float = 0.0

    def __str__(self) -> str:
        """Return the words as a person would read them."""
        return f"{self.code}: {self.text}" if self.code else self.text


@dataclass(frozen=True, slots=True)
class Script:
    """Ways of a robot, and what ends them.

    Attributes:
        ways: how far (k,) in rad and m from where it is held it goes, one after the other, each to rest.
        seconds: duration of a way.
        settle_seconds: longest time to get to its end after that.
        tolerance: distance (rad, m) at which it is there.
        cut: share of the last way after which the ending comes.
        ending: `end`, `stop`, or the `module:function` that does something to the driver.
    """

    ways: tuple[Floats, ...]
    seconds: float
    settle_seconds: float
    tolerance: float
    cut: float = 1.0
    ending: str = "end"


@dataclass(slots=True)
class Session:
    """Outcome of a script; positions and velocities in rad and m, by the controller's order.

    Attributes:
        about: what the driver says of its controller.
        held: where the robot was held (k,).
        holding: readings while it was told to stay.
        going: readings of each way.
        after: readings after the ending.
        late: longest time (s) between two setpoints; of JOBS, from the last reading to the ending.
        took: longest time (s) of a `run`.
        running: whether the controller said RUNNING after `begin`.
        complaint: what it complained of; the rest was not done then.
    """

    about: About
    held: Floats
    holding: list[Reading] = field(default_factory=list)
    going: list[list[Reading]] = field(default_factory=list)
    after: list[Reading] = field(default_factory=list)
    late: float = 0.0
    took: float = 0.0
    running: bool = False
    complaint: Complaint | None = None


class DriverStage(Stage):
    """Owns the driver and connects it; what it complains of is told as a Complaint."""

    _about: About | None = None
    _units: Floats
    _due = 0.0
    _read_at = 0.0
    _sent_at: float | None = None

    def connected(self) -> About | Complaint:
        """Connect, and return what the driver says of its controller."""
        try:
            about = self._ask("connect")
        except DriverFault as fault:
            return _complaint(fault, 0.0)
        if not isinstance(about, About):
            raise _nonsense(f"connect returned {type(about).__name__}; it must be About")
        self._about = about
        self._units = np.broadcast_to(np.asarray(about.units, dtype=np.float64), (about.joints,))
        return about

    def let_go(self) -> None:
        """Stop, end and close, whatever comes of it: another one may want the robot."""
        for name in ("stop", "end", "close"):
            try:
                self._ask(name)
            except (DriverFault, ComponentFault):
                continue

    def act(self, path: str) -> None:
        """Call `module:function` with the driver."""
        module, _, name = path.partition(":")
        self._contained(path, getattr(importlib.import_module(module), name), self._component)

    def attempt(self, name: str, *arguments: object) -> Complaint | None:
        """Call the driver; return what it complains of, if anything."""
        try:
            self._ask(name, *arguments)
        except DriverFault as fault:
            return _complaint(fault, 0.0)
        return None

    def hold(self, count: int, *calls: str) -> list[Reading | Complaint]:
        """Begin where the robot is, keep it there for some readings, then make calls, each with a reading after it."""
        found: list[Reading | Complaint] = []
        try:
            session = Session(self._known(), self._read().positions.copy())
            self._ask("begin", session.held / self._units)
            found += [self._cycle(session, session.held) for _ in range(count)]
            for call in calls:
                self._ask(call)
                found.append(self._read())
        except DriverFault as fault:
            found.append(_complaint(fault, 0.0))
        return found

    def readings(self, count: int) -> list[Reading | Complaint]:
        """Return readings in the driver's pace; a complaint is the last."""
        found: list[Reading | Complaint] = []
        try:
            for _ in range(count):
                found.append(self._read())
        except DriverFault as fault:
            found.append(_complaint(fault, 0.0))
        return found

    def complaint(self, path: str, seconds: float) -> Complaint | None:
        """Do something to the driver, then return what reading complains of within a time, or None."""
        self._read()
        found = self.told(path, seconds, words=False)
        return found if isinstance(found, Complaint) else None

    def told(self, path: str, seconds: float, words: bool = True) -> Reading | Complaint | None:
        """Do something to the driver; return the reading that has `words` of it, what is complained of, or None."""
        self.act(path)
        began = time.perf_counter()
        count = 0
        try:
            # A busy machine may make few readings in the time.
            while time.perf_counter() - began < seconds or count < READINGS:
                now, count = self._read(), count + 1
                if words and now.text:
                    return now
        except DriverFault as fault:
            return _complaint(fault, time.perf_counter() - began)
        return None

    def perform(self, script: Script) -> Session:
        """Connect, begin, hold, go, end; the robot is at rest and let go afterwards, whatever came."""
        about = self.connected()
        if isinstance(about, Complaint):
            raise _nonsense(f"connect complains: {about}")
        session = Session(about, np.zeros(about.joints))
        self._sent_at = None
        try:
            session.held = self._read().positions.copy()
            self._perform(script, session)
        except DriverFault as fault:
            session.complaint = _complaint(fault, 0.0)
        finally:
            self.let_go()
        return session

    def _perform(self, script: Script, session: Session) -> None:
        held, jobs = session.held, session.about.pace is Pace.JOBS
        self._ask("begin", held / self._units)
        ends = time.perf_counter() + script.settle_seconds
        while not session.running and time.perf_counter() < ends:
            session.running = self._cycle(session, held).mode is Mode.RUNNING
        session.holding = [self._cycle(session, held) for _ in range(READINGS)]
        start = held
        for i, way in enumerate(script.ways):
            cut = script.cut if i == len(script.ways) - 1 else 1.0
            go = self._job if jobs else self._way
            session.going.append(go(script, session, start, held + way, cut))
            start = held + way
        if ":" in script.ending:
            self.act(script.ending)
        else:
            self._ask(script.ending)
        if jobs:
            session.late = time.perf_counter() - self._read_at
        self._rest(script, session)

    def _way(self, script: Script, session: Session, start: Floats, goal: Floats, cut: float) -> list[Reading]:
        """Go along 3 s^2 - 2 s^3, which begins and ends at rest, and wait until the robot is there."""
        found = []
        steps = max(2, round(script.seconds * session.about.rate))
        for i in range(1, round(cut * steps) + 1):
            s = i / steps
            rate = 6.0 * s * (1.0 - s) / script.seconds
            found.append(self._cycle(session, start + (goal - start) * s * s * (3.0 - 2.0 * s), (goal - start) * rate))
        if cut == 1.0:
            found += self._until(
                script, lambda: self._cycle(session, goal), lambda now: _is_at(now, goal, script.tolerance)
            )
        return found

    def _job(self, script: Script, session: Session, start: Floats, goal: Floats, cut: float) -> list[Reading]:
        """Have the controller go there by itself, until it says so, or until a part of the way is made."""
        before = self._read().done
        began = time.perf_counter()
        self._ask("run", [goal / self._units], [SHARE], 0)
        session.took = max(session.took, time.perf_counter() - began)
        length = float(np.abs(goal - start).max())

        def done(now: Reading) -> bool:
            if cut < 1.0:
                return float(np.abs(now.positions - start).max()) >= cut * length
            return now.done > before

        return list(self._until(script, self._read, done))

    def _until(self, script: Script, read: Callable[[], Reading], done: Callable[[Reading], bool]) -> Iterator[Reading]:
        """Yield readings until something is so, at most as long as the robot may take."""
        ends = time.perf_counter() + script.settle_seconds
        while True:
            now = read()
            yield now
            if done(now) or time.perf_counter() >= ends:
                return

    def _rest(self, script: Script, session: Session) -> None:
        """Read until the robot does not move, and then as long again."""
        places: list[Floats] = []

        def rests(now: Reading) -> bool:
            places.append(now.positions)
            recent = np.array(places[-READINGS:])
            return len(recent) == READINGS and float(np.ptp(recent, axis=0).max()) <= script.tolerance

        session.after = [*self._until(script, self._read, rests), *(self._read() for _ in range(READINGS))]

    def _cycle(self, session: Session, positions: Floats, velocities: Floats | None = None) -> Reading:
        found = self._read()
        if session.about.pace is not Pace.JOBS:
            velocities = np.zeros_like(positions) if velocities is None else velocities
            self._ask("send", positions / self._units, velocities / self._units, 0)
            now = time.perf_counter()
            if self._sent_at is not None:
                session.late = max(session.late, now - self._sent_at)
            self._sent_at = now
        return found

    def _read(self) -> Reading:
        """Return a reading in rad and m; of a driver that does not wait for packets, a cycle after the last."""
        about = self._known()
        if about.pace is not Pace.CONTROLLER:
            time.sleep(max(0.0, self._due - time.perf_counter()))
            self._due = time.perf_counter() + 1.0 / about.rate
        self._read_at = time.perf_counter()
        found = self._ask("read")
        if wrong := wrong_reading(found) or finite(found, about.joints):
            raise _nonsense(f"read: {wrong}")
        if not 0 <= found.inputs < 2**about.inputs:
            raise _nonsense(f"read: inputs are {found.inputs:#b}; the controller has {about.inputs}")
        velocities = None if found.velocities is None else np.asarray(found.velocities) * self._units
        return dataclasses.replace(found, positions=np.asarray(found.positions) * self._units, velocities=velocities)

    def _known(self) -> About:
        if self._about is None:
            raise _nonsense("nothing is connected")
        return self._about

    def _ask(self, name: str, *arguments: object) -> Any:  # noqa: ANN401  an answer that nobody has looked at
        return self._watched(name, getattr(self._component, name), *arguments)

    def _contained(self, asked: str, function: Callable[..., Any], *arguments: object) -> Any:  # noqa: ANN401
        """Return what `function` returns; raise what a controller complains of as it is."""
        fault: DriverFault | None = None

        def told(*given: object) -> object:
            nonlocal fault
            try:
                return function(*given)
            except DriverFault as one:
                fault = one
                return None

        answer = super()._contained(asked, told, *arguments)
        if fault is not None:
            raise fault
        return answer


def _is_at(reading: Reading, place: Floats, tolerance: float) -> bool:
    return bool((np.abs(reading.positions - place) <= tolerance).all())


def _complaint(fault: DriverFault, seconds: float) -> Complaint:
    return Complaint(fault.text, fault.code, fault.clears, seconds)


def _nonsense(said: str) -> ComponentFault:
    return ComponentFault(FaultKind.NONSENSE, said)
