"""Link of one robot of the world and the real one: its mode, its state, and what came back last."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from math import isfinite
from threading import Lock

from virtualrobot_sdk.drivers import About, Safety, Words
from virtualrobot_sdk.drivers import Mode as ControllerMode
from virtualrobot_sdk.drivers.shared import NEVER, CellBlock, Report, State, TickRing

from virtualrobot_kernel.drivers.far_side import Process
from virtualrobot_kernel.drivers.played import Played
from virtualrobot_kernel.drivers.twin import Asked, Columns, Floats, Twin, columns
from virtualrobot_kernel.world.state import Signal, Snapshot
from virtualrobot_kernel.world.structure import Structure

SILENT_CYCLES = 3
SILENT_SECONDS = 0.1
"""A host is silent after so many cycles without a report, and not before so much time (s), nor before its lead is over:
who leads by more says that the machine may be busy."""

ROUNDING_NS = 1000
"""Time (ns) within which ticks are as far apart as ticks are: when they were due is rounded."""

LOOK_SECONDS = 0.02
"""Longest time (s) between two looks that counts as one of silence."""

UNTOLD = Words("the driver has met a fault")
"""Words that stand in for those of a host which has not told them in time; they are asked for again."""

WORDS_SECONDS = 0.02
"""Time (s) that the words of a fault are waited for before the twin is stopped: the robot brakes already."""

STOPPED = (Safety.PROTECTIVE_STOP, Safety.SAFEGUARD_STOP, Safety.EMERGENCY_STOP, Safety.FAULT)
"""Verdicts with which the controller has stopped the robot."""

DEAF = (ControllerMode.OFF, ControllerMode.HAND_GUIDED, ControllerMode.LOCAL)
"""Modes in which a controller does not follow."""


class LinkMode(Enum):
    """Mode of a link; the names equal those of `DriverMode` in the contract."""

    SIMULATED = "simulated"
    MONITOR = "monitor"
    EXECUTE = "execute"


PLAYED = (State.BEGINNING, State.ACTIVE, State.STOPPING)
"""States in which the robot does, or is about to do, what its twin does: the twin may not be put elsewhere."""


@dataclass(slots=True, eq=False)
class Link:
    """Link of one robot. Its fields are single references: threads read them, one at a time changes them (`Links`)."""

    twin: Twin
    asked: Asked
    process: Process
    ring: TickRing
    about: About
    signals: tuple[str, ...] = ()
    """Signals of the controller that were made for this link, and go with it."""
    mode: LinkMode = LinkMode.SIMULATED
    state: State = State.INACTIVE
    words: Words = field(default_factory=Words)
    halted: bool = False
    """True while motions of the twin are refused: the connection failed, or the robot follows no more unasked; until a
    mode is chosen."""
    outputs: int = 0
    played: Played | None = None
    """Record of what went out since the robot was let follow last; None before."""
    follows_badly: bool = False
    report: Report | None = None
    is_silent: bool = False
    is_unread: bool = False
    """True where the newest report could not be read: the host was writing it."""
    told: Words | None = None
    """Words of the host, once they were asked for after it met a fault."""
    settling: Lock = field(default_factory=Lock)
    lead_ns: int = field(init=False)
    """Time (ns) by which the robot is later than its twin."""
    inputs_known: tuple[int, Mapping[str, Signal] | None] = (-1, None)
    """Digital inputs, and the signals of the world that agree with them."""
    _places: tuple[Structure, Columns, Columns] | None = None
    _stood: _Rest | None = None
    _fine: int = -1
    """News of reports in which there was no fault; -1 while there is none."""
    _cycles: int = -1
    _silence: float = 0.0
    _asked_ns: int = 0
    _error_ns: int = 0

    @property
    def is_played(self) -> bool:
        """True while the robot does, or is about to do, what its twin does."""
        return self.state in PLAYED

    @property
    def is_monitored(self) -> bool:
        """True while the robot's readings are its twin's joints."""
        return self.mode is LinkMode.MONITOR and self.state is State.INACTIVE

    @property
    def awaits_words(self) -> bool:
        """True while the host has met a fault whose words are not here yet, or is silent, and where is not known."""
        return self._error_ns > 0 and self.state is not State.ERROR

    def __post_init__(self) -> None:
        """Count the lead as times are counted."""
        self.lead_ns = round(self.asked.lead * 1e9)

    def places(self, structure: Structure) -> tuple[Columns, Columns]:
        """Return where its joints are in q and v; they are looked up once for each structure."""
        if self._places is None or self._places[0] is not structure:
            self._places = (structure, *columns(structure, self.twin))
        return self._places[1], self._places[2]

    def write_rest(self, now: Snapshot, due_ns: int) -> bool:
        """Put a tick that was due at a time (ns) into the ring, while nothing moves.

        One that is as the one before is there already: then it returns True, as for those that come, if they are so.
        """
        state, rest = now.state, self._stood
        if rest is None or rest.q is not state.q or rest.v is not state.v or rest.structure is not now.structure:
            at_q, at_v = self.places(now.structure)
            q = state.q[at_q]
            joints = self.ring.joints_of(q, state.v[at_v], q[None])
            rest = self._stood = _Rest(now.structure, state.q, state.v, joints)
        off = due_ns - rest.due_ns - (state.tick - rest.tick) * rest.period_ns
        if -ROUNDING_NS < off < ROUNDING_NS and rest.outputs == self.outputs:
            if rest.lasts:
                return True
            play_ns = due_ns + self.lead_ns
            if self.ring.rest(state.tick, play_ns, self.outputs, rest.joints, rest.period_ns):
                rest.lasts = True
                return True
        else:
            rest.tick, rest.due_ns, rest.outputs, rest.lasts = state.tick, due_ns, self.outputs, False
            rest.period_ns = round(now.tick_seconds * 1e9)
        self.ring.put_joints(state.tick, due_ns + self.lead_ns, self.outputs, rest.joints)
        return False

    def halt(self, words: Words, state: State) -> None:
        """Follow no more though nobody chose so, for the reason that the words tell."""
        self.words, self.state = words, state
        self.halted = True  # last: `take_orders`, in another thread, looks at the state after it has taken this back

    def take_orders(self) -> None:
        """Let the twin be moved again, as somebody has chosen; a fault that has come meanwhile stays."""
        self.halted = False
        if self.state is State.ERROR:
            self.halted = True

    def begin_anew(self, tick: int) -> None:
        """Forget what was played before."""
        self.forget_faults()
        self.halted = False
        self.played = Played(self.twin.uid, tick)
        self.follows_badly = False
        self.ring.clear()
        self._stood = None  # last: the world thread may write a rest meanwhile, which is forgotten with it

    def forget_faults(self) -> None:
        """Forget which fault was met, as another connection begins."""
        self.words, self.told, self.is_silent, self.is_unread = Words(), None, False, False
        self._fine = self._cycles = -1
        self._silence, self._error_ns = 0.0, 0

    def newest(self) -> Report | None:
        """Return the newest report that can be read: the host may be writing one just now."""
        return self.ring.reported() or self.report

    def fault(self, now_ns: int, block: CellBlock) -> Words | None:
        """Return why the robot cannot go on being played; None: it can. It is asked before each tick.

        `block`: the cell's; that it is stopped is no fault of the robot's.
        """
        cycles, news, error = self.ring.pulse()
        # Where all was well, and nothing is new but that time goes on, no more is looked at: each tick costs that.
        fine = news == self._fine and error <= self.asked.following_warning and self.mode is not LinkMode.MONITOR
        if not fine or self.is_silent or self.process.fault is not None:
            self._fine = -1
            report = self.ring.reported()
            self.is_unread, self.report = report is None, report or self.report
            if (fault := self._met(self.report, now_ns)) is not None:
                return fault
            if self.is_silent:
                return None  # where it hangs is asked for
            if self.report is None:
                cycles = self._cycles
            elif has_fault(self.report):
                return None  # its words are on their way
            elif self.is_unread:
                pass  # the one before may be of a time before it was played
            elif self.state is State.ACTIVE and cycles != self._cycles and block.stop_ns == NEVER:
                if self.report.state is not State.ACTIVE:
                    return Words("the driver has ended what it played")
                if (fault := self._astray(self.report)) is not None:
                    return fault
                self._fine = news
        # Only time in which the world goes on counts: a kernel that was late has not looked.
        since, self._asked_ns = min(now_ns - self._asked_ns, LOOK_SECONDS * 1e9), now_ns
        if cycles != self._cycles:
            self._cycles, self._silence = cycles, 0.0
            return None
        self._silence += since * 1e-9
        if self._silence > SILENT_SECONDS and self._silence > max(self.asked.lead, SILENT_CYCLES / self.about.rate):
            self.is_silent, self._error_ns = True, self._error_ns or now_ns
        return None

    def _met(self, report: Report | None, now_ns: int) -> Words | None:
        """Return the fault that the process, the host or the controller has; the host's once its words are here."""
        if (fault := self.process.fault) is not None:
            return fault.words
        if self.is_silent:
            if self.told is None and now_ns - self._error_ns < WORDS_SECONDS * 1e9:
                return None
            silent = f"the driver has been silent for {self._silence:.2f} s"
            return Words(f"{silent}: {self.told.text}" if self.told is not None else silent)
        if report is None:
            return None
        if has_fault(report):
            self._error_ns = self._error_ns or now_ns
            if self.told is None and now_ns - self._error_ns < WORDS_SECONDS * 1e9:
                return None
            return self.told or UNTOLD
        if report.safety in STOPPED and self.is_played:
            return Words(f"the controller has stopped the robot: {report.safety.value}")
        return None

    def _astray(self, report: Report) -> Words | None:
        """Return why a robot that is played is not where it should be."""
        if report.mode in DEAF:
            return Words(f"the controller does not follow any more: it is {report.mode.value}")
        if not isfinite(sum(report.q)):
            return Words(f"the controller says that its joints are at {list(map(float, report.q))}")
        sizes = list(map(abs, report.error))
        most = max(sizes)
        self.follows_badly = most > self.asked.following_warning
        if most > self.asked.following_limit:
            worst = sizes.index(most)
            return Words(
                f"the joint {self.twin.names[worst]!r} is {report.error[worst]:+.4f} from where it should be; "
                f"{self.asked.following_limit:g} is allowed"
            )
        return None


@dataclass(slots=True, eq=False)
class _Rest:
    """World in which nothing moves, and what its ticks say of a robot's joints.

    tick, due_ns, period_ns, outputs: the first tick of a series that is told alike, when it was due (ns), the time
    between two, and the outputs. lasts: whether the ring tells those that come, too.
    """

    structure: Structure
    q: Floats
    v: Floats
    joints: bytes
    tick: int = 0
    due_ns: int = NEVER
    period_ns: int = 0
    outputs: int = -1
    lasts: bool = False


def has_fault(report: Report) -> bool:
    """Return whether a host has met a fault, though it may still brake."""
    return report.state is State.ERROR or report.is_faulty


@dataclass(frozen=True, slots=True, eq=False)
class Status:
    """Picture of a link for those who ask: the link, by the robot's present name, and its newest report."""

    robot: str
    link: Link
    report: Report | None
