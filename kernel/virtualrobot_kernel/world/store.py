"""World thread: one queue, one writer, snapshots for everybody else.

No lock is held while anything is computed. `snapshot` is a plain reference: reading it never waits.
"""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeVar, cast

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.lateness import Late, patiently
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.awaited_part import AwaitedPart
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.clock import CATCH_UP_SECONDS, Clock, Mode, Pacer
from virtualrobot_kernel.world.commands import CancelMotion, Command, GoOn
from virtualrobot_kernel.world.journal import Entry, Journal
from virtualrobot_kernel.world.listeners import Listeners
from virtualrobot_kernel.world.physics_commands import SetContacts, SetDynamics, SetParts
from virtualrobot_kernel.world.state import Cancellation, EndCause, Motion, Snapshot, State, empty_state
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_kernel.world.supervisor import Supervisor
from virtualrobot_kernel.world.tick import advance, told_more
from virtualrobot_kernel.world.tick_inputs import InputSource, taken
from virtualrobot_kernel.world.tolerances import AwaitedJoints

AWAITED = (AwaitedPart, AwaitedJoints)
"""Kinds of orders that are no commands: a motion waits until they are there."""

MAX_STEPS = 10_000
"""Greatest number of ticks in one Step: nothing else is served meanwhile."""

MOST_INTERVENTIONS = 100
"""Greatest number of times that supervisors may change the world before one tick."""

ASKED_AGAIN_SECONDS = 1.0
"""Time (s) after which supervisors are asked again for a tick whose answer has not come: it may never come."""

TOLD_FOR_TICK = (SetDynamics, SetParts, SetContacts)
"""Commands that change nothing before the next tick, in which what they tell becomes true."""

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class Applied:
    """Result of a batch: the world after it, the uids and motion ids that it created, the parts that it picked."""

    snapshot: Snapshot
    created: tuple[int | str, ...]
    picked: tuple[int, ...]


Permit = Callable[[Snapshot, Sequence[Command]], None]
"""Check of commands that may be applied to the world as it is, else KernelError; called in the world thread."""


@dataclass(slots=True, eq=False)
class _Batch:
    commands: tuple[Command, ...]
    author: str
    expected_revision: int | None
    permit: Permit | None
    done: Future[Applied] = field(default_factory=Future)


@dataclass(slots=True, eq=False)
class _Work:
    """Work of the world thread that is no batch: a step, another clock."""

    do: Callable[[], Snapshot]
    done: Future[Snapshot] = field(default_factory=Future)


Item = TypeVar("Item", _Batch, _Work)


def _closed() -> KernelError:
    return KernelError("the kernel is ending", reason=Reason.SHUTTING_DOWN)


def check_revision(structure: Structure, expected: int | None) -> None:
    """Raise KernelError (STALE_REVISION) when the structure has another revision than the expected one (None: any)."""
    if expected is not None and expected != structure.revision:
        raise KernelError(
            f"the structure has revision {structure.revision}, not {expected}; read it again and retry",
            reason=Reason.STALE_REVISION,
            revision=structure.revision,
            expected_structure_revision=expected,
        )


class World:
    """World and its thread. All methods may be called from any thread; results come as futures."""

    publishes_each_tick = False
    """True where each tick of a Step is published, though nobody supervises or listens."""

    def __init__(
        self,
        forward: Forward,
        journal: Journal,
        clock: Clock,
        structure: Structure | None = None,
        state: State | None = None,
        inputs: InputSource = tuple,
    ) -> None:
        """Begin with an empty world, or with `structure` and `state`; nothing runs before `start`.

        `inputs` gives what is to be applied as each tick begins.
        """
        self._forward = forward
        self._inputs = inputs
        self._journal = journal
        structure = structure or index.empty()
        self.snapshot = self._pictured(structure, state or empty_state(), clock, 0, None)
        self._pacer = Pacer(clock, time.monotonic())
        self._queue: queue.SimpleQueue[_Batch | _Work | None] = queue.SimpleQueue()
        self._listeners: Listeners[[]] = Listeners()
        self._tick_listeners: Listeners[[Snapshot]] = Listeners()
        self._supervisors: tuple[Supervisor, ...] = ()
        self._supervising = threading.Lock()
        self._clock_held = ""
        self._closing = self._ended = False
        self._thread = threading.Thread(target=self._run, name="world", daemon=True)

    @property
    def clock(self) -> Clock:
        """Return the clock as it is now."""
        return self._pacer.clock

    @property
    def journal(self) -> Journal:
        """Return the journal of applied batches."""
        return self._journal

    @property
    def due_nanoseconds(self) -> int:
        """Return when the newest tick was due, on the clock of `time.monotonic_ns`; for listeners to ticks."""
        return round(self._pacer.made * 1e9)

    def catch_up(self, seconds: float) -> None:
        """Have ticks that are late by no more than this made in quick succession, so that time falls behind by none."""
        self._pacer.catch_up_seconds = max(CATCH_UP_SECONDS, seconds)

    def hold_clock(self, reason: str) -> Future[Snapshot]:
        """Refuse from now on that mode and speed of the clock change, for a reason in words; empty: let them change."""

        def hold() -> Snapshot:
            self._clock_held = reason
            return self.snapshot

        return self._told(hold)

    def between_ticks(self, work: Callable[[], object] = lambda: None) -> Future[Snapshot]:
        """Have work done between two ticks, which must return at once and changes nothing of the world.

        A listener to ticks that has ended is called no more then.
        """

        def do() -> Snapshot:
            work()
            return self.snapshot

        return self._told(do)

    def start(self) -> None:
        """Start the world thread."""
        self._pacer.set(self.clock.mode, self.clock.speed_factor, time.monotonic())
        self._thread.start()

    def close(self) -> None:
        """End the world thread; what is still queued, and what is left of a Step, is refused as SHUTTING_DOWN."""
        self._closing = True
        self._queue.put(None)
        if self._thread.is_alive():
            self._thread.join(10.0)

    def listen(self, published: Callable[[], None]) -> Callable[[], None]:
        """Have `published` called in the world thread after each snapshot; it must return at once.

        Call what this returns to end that.
        """
        return self._listeners.add(published)

    def listen_ticks(self, ticked: Callable[[Snapshot], None]) -> Callable[[], None]:
        """Have `ticked` called in the world thread with the snapshot of every tick, none left out.

        Unlike `listen` it is told each tick of a Step too, as it happens: the step waits for the call. Where time
        follows the wall clock it must return at once. Call what this returns to end that.
        """
        return self._tick_listeners.add(ticked)

    def supervise(self, supervisor: Supervisor, first: bool = False) -> None:
        """Have a supervisor asked from now on, before all others or after; each tick of a Step is published then."""
        with self._supervising:
            others = self._supervisors
            self._supervisors = (supervisor, *others) if first else (*others, supervisor)

    def unsupervise(self, supervisor: Supervisor) -> None:
        """Ask a supervisor no more."""
        with self._supervising:
            self._supervisors = tuple(one for one in self._supervisors if one is not supervisor)

    def submit(
        self,
        commands: Sequence[Command],
        author: str = "",
        expected_revision: int | None = None,
        permit: Permit | None = None,
    ) -> Future[Applied]:
        """Queue a batch that is applied as a whole between two ticks, or refused as a whole.

        `permit` is asked right before, so that it judges by the same world that the commands meet.
        """
        return self._queued(_Batch(tuple(commands), author, expected_revision, permit)).done

    def step(self, ticks: int, until: Callable[[Snapshot], bool] | None = None) -> Future[Snapshot]:
        """Advance time by some ticks in STEPPED mode; the future gives the snapshot after the last one.

        With `until` it ends after the first tick whose snapshot that is true of; it is asked in the world thread.
        """
        return self._told(lambda: self._step(ticks, until))

    def check_step(self, ticks: int) -> None:
        """Raise KernelError for a step that is refused: time follows the wall clock, or there are too many ticks."""
        if self.clock.mode is not Mode.STEPPED:
            raise KernelError(
                "time follows the wall clock; set the clock to STEPPED before you step", reason=Reason.WRONG_STATE
            )
        if not 1 <= ticks <= MAX_STEPS:
            raise KernelError(f"a step takes 1 to {MAX_STEPS} ticks, not {ticks}", ticks=ticks)

    def set_clock(self, mode: Mode, speed_factor: float) -> Future[Snapshot]:
        """Change how time runs, between two ticks."""
        return self._told(lambda: self._set_clock(mode, speed_factor))

    def _told(self, work: Callable[[], Snapshot]) -> Future[Snapshot]:
        """Have work done in the world thread between two ticks."""
        return self._queued(_Work(work)).done

    def _queued(self, item: Item) -> Item:
        self._queue.put(item)
        if self._ended:
            self._refuse_rest()
        return item

    def _run(self) -> None:
        while True:
            wait = self._pacer.wait_seconds(time.monotonic())
            if wait == 0.0:
                self._pacer.ticked(time.monotonic())
                try:
                    self._tick()
                except Exception:  # without this thread nobody would be told anything ever again
                    log.exception("a tick failed inside the kernel; the world is as it was before")
                wait = 0.0
            try:
                item = self._queue.get(timeout=wait) if wait is None or wait > 0.0 else self._queue.get_nowait()
            except queue.Empty:
                continue
            if item is None:
                break
            self._serve(item)
        self._ended = True
        self._refuse_rest()

    def _serve(self, item: _Batch | _Work) -> None:
        if not item.done.set_running_or_notify_cancel():
            return
        try:
            if isinstance(item, _Batch):
                self._apply(item)
            else:
                item.done.set_result(item.do())
        except KernelError as error:
            item.done.set_exception(error)
        except Exception as error:
            log.exception("a command failed inside the kernel; the world is as it was before")
            item.done.set_exception(error)

    def _apply(self, batch: _Batch) -> None:
        """Apply a batch; the journal answers it once it is kept, with what supervisors did about it."""
        before = self.snapshot
        check_revision(before.structure, batch.expected_revision)
        if batch.permit is not None:
            batch.permit(before, batch.commands)
        change = self._applied(batch.commands, batch.author, self._supervisors)
        applied = Applied(self.snapshot, change.created, change.picked)
        self._supervise_change()

        def answer(failed: Exception | None) -> None:
            if failed is None:
                batch.done.set_result(applied)
            else:
                batch.done.set_exception(failed)

        self._journal.answer(answer)

    def _applied(self, commands: tuple[Command, ...], author: str, admitting: Sequence[Supervisor] = ()) -> Change:
        before = self.snapshot
        self._journal.admit(commands)
        change = apply(before.structure, before.state, commands, self._forward)
        after = self._later(change.structure, change.state)
        for supervisor in admitting:
            supervisor.admit(before, after, commands)
        entry = Entry(before.state.tick, author, commands, after.wall_time)
        self._journal.append(entry, Change(before.structure, before.state), change)
        if all(isinstance(command, TOLD_FOR_TICK) for command in commands):
            self.snapshot = after  # nothing is seen of it before the tick, and it is told with that
        else:
            self._publish(after)
        return change

    def _step(self, ticks: int, until: Callable[[Snapshot], bool] | None) -> Snapshot:
        self.check_step(ticks)
        state = self.snapshot.state
        last = state.tick + ticks
        publishes_each = self.publishes_each_tick or bool(self._supervisors) or until is not None
        for _ in range(ticks):
            if self._closing:
                raise _closed()
            if publishes_each:
                self._tick()
                if self._closing:
                    raise _closed()
                if until is not None and until(self.snapshot):
                    break
                continue
            state = self._with_inputs(state)
            before, state = state, self._ticked(state)
            self._journal.ticked(self.snapshot.structure, state)
            ordered = any(motion.running.orders for motion in state.motions)
            # Whoever watches signals is told every change, and whoever listens to ticks each of them.
            if ordered or state.tick == last or state.signals is not before.signals or self._tick_listeners:
                self._publish(self._later(self.snapshot.structure, state))
            if ordered:
                self._obey()
                state = self.snapshot.state
            if self._tick_listeners:
                self._tick_listeners.tell(self.snapshot)
        return self.snapshot

    def _tick(self) -> None:
        """Make a tick; while it waits for an answer that is late, batches are applied as between two ticks.

        The tick is begun anew then, in the world as it is. Makes none where the world is ending.
        """
        while not self._closing:
            try:
                self._made_tick()
                return
            except Late as late:
                self._serve_until(late.answer)

    def _serve_until(self, answer: Future[Any]) -> None:
        """Apply batches until an answer has come, or for a second; what else is queued comes after the tick."""
        again = time.monotonic() + ASKED_AGAIN_SECONDS
        put_off: list[_Batch | _Work | None] = []
        answer.add_done_callback(lambda _: self._told(lambda: self.snapshot))  # the queue wakes this thread
        while not (answer.done() or self._closing) and (left := again - time.monotonic()) > 0.0:
            try:
                item = self._queue.get(timeout=left)
            except queue.Empty:
                break
            if isinstance(item, _Batch):
                self._serve(item)
            else:
                put_off.append(item)
        for item in put_off:
            self._queue.put(item)

    def _made_tick(self) -> None:
        """Publish the world one tick later, with what has been put in for it, once no supervisor wants more done.

        Raises Late where a supervisor does; the world is in the same tick then.
        """
        state = self._with_inputs(self.snapshot.state)
        if state is not self.snapshot.state:
            self.snapshot = self._later(self.snapshot.structure, state)  # told with the tick
        before = self.snapshot.state
        later = self._later(self.snapshot.structure, self._ticked(before))
        for _ in range(MOST_INTERVENTIONS):
            enacted = self._first_enacted(later)
            if not enacted:
                break
            now, structure, ticked = self.snapshot.state, self.snapshot.structure, None
            if all(isinstance(command, TOLD_FOR_TICK) for command in enacted):
                ticked = told_more(structure, before, now, later.state)
            if ticked is None:
                before, ticked = now, self._ticked(now)
            later = self._later(structure, ticked)
        else:
            log.error("supervisors have changed the world %d times before one tick; it goes on", MOST_INTERVENTIONS)
        self._publish(later)
        self._journal.ticked(later.structure, later.state)
        self._supervise_change()
        self._obey()
        self._tick_listeners.tell(self.snapshot)

    def _obey(self) -> None:
        """Do what motions want done in the world, as commands of theirs; end those whose orders are refused."""
        for id in [motion.id for motion in self.snapshot.state.motions if motion.running.orders]:
            # As it is now: what another one has done may have ended it.
            motion = next((one for one in self.snapshot.state.motions if one.id == id), None)
            if motion is None or not (orders := motion.running.orders):
                continue
            try:
                self._do(motion, orders)
            except Exception as error:
                if not isinstance(error, KernelError):
                    log.exception("an order of %r failed inside the kernel", id)
                reason = Cancellation(EndCause.STEP_REFUSED, f"step {motion.step_path}: {error}")
                self._applied((CancelMotion(id, reason),), id)
                self._supervise_change()

    def _do(self, motion: Motion, orders: Sequence[object]) -> None:
        """Do the orders of a motion all or none, if what it waits for is there."""
        awaited = [one for one in orders if isinstance(one, AWAITED)]
        if all(one.is_there(self.snapshot) for one in awaited):
            commands = [one for one in orders if not isinstance(one, AWAITED)]
            self._applied((*cast("list[Command]", commands), GoOn(motion.id)), motion.id, self._supervisors)
            self._supervise_change()

    def _first_enacted(self, later: Snapshot) -> Sequence[Command]:
        """Do what the first supervisor wants done that wants anything before time goes on to `later`; return that."""
        for supervisor in self._supervisors:
            if commands := self._enacted(supervisor, partial(patiently, supervisor.before_tick), self.snapshot, later):
                return commands
        return ()

    def _supervise_change(self) -> None:
        for supervisor in self._supervisors:
            self._enacted(supervisor, supervisor.after_change, self.snapshot)

    def _enacted(
        self, supervisor: Supervisor, ask: Callable[..., Sequence[Command]], *about: Snapshot
    ) -> Sequence[Command]:
        """Do what a supervisor wants done, and return it."""
        try:
            commands = tuple(ask(*about))
            if commands:
                self._applied(commands, supervisor.author)
        except Exception:
            log.exception("%s failed inside the kernel", supervisor.author)
            return ()
        return commands

    def _with_inputs(self, state: State) -> State:
        """Return a state with the inputs of the tick that begins."""
        if inputs := self._inputs():
            later, entry = taken(self.snapshot, state, inputs, self._forward, self._journal.admit)
            if entry is not None:
                structure = self.snapshot.structure
                self._journal.append(entry, Change(structure, state), Change(structure, later))
            return later
        return state

    def _ticked(self, state: State) -> State:
        return advance(self.snapshot.structure, state, self.clock.tick_seconds, self._forward)

    def _set_clock(self, mode: Mode, speed_factor: float) -> Snapshot:
        if not 0.01 <= speed_factor <= 100.0:
            raise KernelError(
                f"a clock's speed factor must be 0.01 to 100, not {speed_factor:g}", speed_factor=speed_factor
            )
        if self._clock_held:
            raise KernelError(f"{self._clock_held}; time goes on as it does", reason=Reason.WRONG_STATE)
        self._pacer.set(mode, speed_factor, time.monotonic())
        self._publish(self._later(self.snapshot.structure, self.snapshot.state))
        self._supervise_change()
        return self.snapshot

    def _later(self, structure: Structure, state: State) -> Snapshot:
        """Return the snapshot that would follow the present one."""
        return self._pictured(structure, state, self.clock, self.snapshot.revision + 1, self.snapshot)

    def _publish(self, snapshot: Snapshot) -> None:
        self.snapshot = snapshot
        self._listeners.tell()

    def _pictured(
        self, structure: Structure, state: State, clock: Clock, revision: int, before: Snapshot | None
    ) -> Snapshot:
        still = (
            before is not None
            and structure.forest is before.structure.forest
            and state.q is before.state.q
            and state.parent_t_node is before.state.parent_t_node
        )
        world_t_node = before.world_t_node if still and before is not None else self._forward(structure, state)
        return Snapshot(structure, state, world_t_node, revision, time.time(), clock.tick_seconds)

    def _refuse_rest(self) -> None:
        while True:
            try:
                item = self._queue.get_nowait()
            except queue.Empty:
                return
            if item is not None and item.done.set_running_or_notify_cancel():
                item.done.set_exception(_closed())
