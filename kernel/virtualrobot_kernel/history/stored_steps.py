"""Steps in the store of the history, as those who list, watch and undo them ask for them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from virtualrobot_kernel.history.codec import Codec
from virtualrobot_kernel.history.database import RARE_STEPS
from virtualrobot_kernel.history.rows import StepRow
from virtualrobot_kernel.history.step import Step, StepKind
from virtualrobot_kernel.history.steps import Wanted
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.world.records import Difference

FREQUENT = frozenset({StepKind.SIGNAL, StepKind.MOTION, StepKind.OTHER})
"""Kinds that come as often as calls: `RARE_STEPS` are those of all others."""

MOST_RECENT = 50
"""Greatest number of the newest steps, and of the nodes that they are about, that stay in memory."""


class StoredSteps:
    """Steps of a store; one thread at a time adds them, any may read.

    They wait in memory until they are written, with the entries that they were made of. The newest ones stay there: who
    undoes wants these.
    """

    def __init__(self, store: Store, codec: Codec) -> None:
        """Keep steps in `store`, their differences as `codec` writes them."""
        self._store = store
        self._codec = codec
        self._recent: dict[int, Step] = {}
        self._waiting: dict[int, tuple[Step, int]] = {}

    def append(self, step: Step, replaced: Step | None) -> None:
        """Keep a step after all others, in place of one that it has drawn out (None: of none)."""
        gone = replaced.number if replaced else 0
        self._recent.pop(gone, None)
        self._recent[step.number] = step
        if gone in self._waiting:
            gone = self._waiting.pop(gone)[1]
        self._waiting[step.number] = step, gone

    def waiting(self) -> list[tuple[StepRow, int]]:
        """Return the steps that are to be written, each with the number of the one whose place it takes (0: none)."""
        return [(self._row(step), replaced) for step, replaced in self._waiting.values()]

    def written(self) -> None:
        """Note that all that waited is in the store."""
        self._waiting = {}
        recent, size = list[Step](), 0
        for step in reversed(self._recent.values()):
            size += 1 + len(step.touched)
            if size > MOST_RECENT:
                break
            recent.append(step)
        if len(recent) < len(self._recent):
            self._recent = {step.number: step for step in reversed(recent)}

    def get(self, number: int) -> Step | None:
        """Return the step of an entry, None when it is not kept."""
        for step in [*self._recent.values()]:
            if number in (step.first_number, step.number):
                return step
        row = self._store.step(number)
        return self._step(row) if row else None

    def find(self, wanted: Wanted, before: int | None = None, whole: bool = True) -> Iterator[Step]:
        """Yield steps that are wanted, newest first, with smaller numbers than `before`; `whole` with differences."""
        recent, replaced = [*self._recent.values()], {number for _, number in [*self._waiting.values()]}
        for step in reversed(recent):
            if (before is None or step.number < before) and wanted.has(step):
                yield step
        first = recent[0].number if recent else before
        before = first if before is None or first is None else min(before, first)
        for step in self._written(wanted, before, whole):
            if step.number not in replaced:
                yield step

    def _written(self, wanted: Wanted, before: int | None, whole: bool) -> Iterator[Step]:
        conditions, values = ["1"], list[object]()
        if wanted.kinds:
            conditions.append(f"kind IN ({','.join('?' * len(wanted.kinds))})")
            values += [kind.value for kind in wanted.kinds]
            if wanted.kinds.isdisjoint(FREQUENT):
                conditions.append(RARE_STEPS)
        if wanted.since is not None:
            conditions.append("time >= ?")
            values.append(wanted.since)
        if wanted.until is not None:
            conditions.append("time < ?")
            values.append(wanted.until)
        if wanted.node:
            uids = ",".join(map(str, wanted.uids))
            conditions.append(f"(number IN (SELECT number FROM touched WHERE uid IN ({uids})) OR instr(names, ?))")
            values.append(wanted.node)
        if wanted.about:
            uids = ",".join(map(str, wanted.about))
            conditions.append(f"(number IN (SELECT number FROM touched WHERE uid IN ({uids})) OR kind = 'restore')")
        rows = self._store.steps(" AND ".join(conditions), values, before)
        # What it changed is most of a step, and no filter asks for it.
        return (self._step(row) if whole else step for row in rows if wanted.has(step := _listed(row)))

    @property
    def last(self) -> int:
        """Number of the newest step that was ever kept; 0: none was."""
        return next((step.number for step in self.find(Wanted(), whole=False)), self._store.forgotten)

    @property
    def forgotten(self) -> int:
        """Number of the newest step that may not be kept any more; 0: all are."""
        return self._store.forgotten

    def _row(self, step: Step) -> StepRow:
        changed = step.difference
        return StepRow(
            step.number,
            step.first_number,
            step.tick,
            step.wall_time,
            step.author,
            step.kind.value,
            step.label,
            step.names,
            step.undoes,
            self._codec.encode((changed.old, changed.new)) if changed else b"",
            tuple(sorted(step.touched)),
        )

    def _step(self, row: StepRow) -> Step:
        old, new = self._codec.decode(row.difference) if row.difference else (None, None)
        return replace(_listed(row), difference=Difference(old, new) if old and new else Difference())


def _listed(row: StepRow) -> Step:
    """Return a step without its difference."""
    return Step(
        number=row.number,
        first_number=row.first,
        tick=row.tick,
        wall_time=row.time,
        author=row.author,
        kind=StepKind(row.kind),
        label=row.label,
        difference=Difference(),
        touched=frozenset(row.touched),
        names=row.names,
        undoes=row.undoes,
    )
