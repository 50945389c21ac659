"""Recovery: the world as a store and its last tick tell it, from the newest checkpoint on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.history.codec import Codec
from virtualrobot_kernel.history.journal import Told
from virtualrobot_kernel.history.rows import CheckpointRow, Row
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.upkeep import Moment
from virtualrobot_kernel.history.world_image import WorldImage
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.journal import Entry, waited
from virtualrobot_kernel.world.state import empty_state

MOST_WARNINGS = 5
"""Number of entries that can't be repeated and are told one by one."""


def empty_world() -> Moment:
    """Return the moment before the first entry."""
    return Moment(0, index.empty(), empty_state())


def image(store: Store, codec: Codec, id: int) -> WorldImage:
    """Return the world of a checkpoint; raise KernelError when there is none with this id, or it is damaged."""
    found = store.checkpoint(id)
    if found is None:
        raise KernelError(f"there is no checkpoint {id}", reason=Reason.UNKNOWN_NAME, checkpoint=id)
    bodies = dict(zip(found.parts, store.parts(found.parts), strict=True))
    return codec.decode(found.body, bodies.__getitem__)


def moment_of(store: Store, codec: Codec, head: CheckpointRow) -> Moment:
    """Return the moment of a checkpoint; raise KernelError when it is damaged."""
    world = image(store, codec, head.id)
    return Moment(head.seq, world.structure, world.state)


def entry(row: Row, codec: Codec) -> Entry:
    """Return the entry of a row; raise KernelError when it was written by a newer program, or is damaged."""
    try:
        return Entry(row.tick, row.author, codec.decode(row.commands), row.time)
    except KernelError as error:
        raise error.at(f"entry {row.seq}") from error


def recovered(
    store: Store,
    codec: Codec,
    last_tick: int,
    tick_seconds: float,
    forward: Forward,
    tail: Sequence[Row] = (),
    left: Callable[[Told], object] = lambda told: None,
) -> tuple[Moment, list[str]]:
    """Return the last moment of which there is anything, and in words what is not as it should be.

    Args:
        store: the journal.
        codec: how it is written.
        last_tick: how far time had come, as far as that is known from elsewhere.
        tick_seconds: the length of a tick.
        forward: the forward pass.
        tail: the entries that come after those of the store.
        left: is told each entry of these, as the world told it when it was new.

    Raises KernelError, which names the row, when what is needed for it is damaged.
    """
    moment, warnings = _begin(store, codec)
    number, change = moment.number, Change(moment.structure, moment.state)
    refused = 0
    last_kept = store.last_seq
    for told, error in repeated(moment, chain(store.rows(moment.number), tail), codec, tick_seconds, forward):
        number, change = told.number, told.after
        if error is not None:
            refused += 1
            if refused <= MOST_WARNINGS:
                author = told.entry.author or "nobody"
                warnings.append(f"entry {number} by {author} is left out, it can't be repeated: {error}")
        if number > last_kept:
            left(told)
    if refused > MOST_WARNINGS:
        warnings.append(f"{refused - MOST_WARNINGS} entries more are left out")
    change = waited(change, max(last_tick, store.last_tick), tick_seconds, forward)
    return Moment(number, change.structure, change.state), warnings


def repeated(
    moment: Moment, rows: Iterable[Row], codec: Codec, tick_seconds: float, forward: Forward
) -> Iterator[tuple[Told, KernelError | None]]:
    """Yield the entries that come after a moment as the world told them, and why one can't be repeated (None: it can).

    Raises KernelError for a row that was written by a newer program, or is damaged.
    """
    change = Change(moment.structure, moment.state)
    for row in rows:
        one, failed = entry(row, codec), None
        before = change
        try:
            before = change = waited(change, one.tick, tick_seconds, forward)
            change = apply(before.structure, before.state, one.commands, forward)
        except KernelError as error:
            failed = error
        yield Told(row.seq, one, before, change, row.commands), failed


def _begin(store: Store, codec: Codec) -> tuple[Moment, list[str]]:
    """Return the newest checkpoint that can be read, else the empty world, if the first entry is there."""
    warnings: list[str] = []
    for head in reversed(store.checkpoints()):
        if head.seq < store.forgotten:
            break  # what came right after it is not kept any more
        try:
            return moment_of(store, codec, head), warnings
        except KernelError as error:
            warnings.append(f"the checkpoint {head.id} can't be read, and the one before it is taken: {error}")
    if store.forgotten:
        raise store.damaged(f"no checkpoint can be read, and the entries up to {store.forgotten} were thinned out")
    return empty_world(), warnings
