"""Tasks of an emulated ABB controller: RAPID that is stopped and goes on, and whose data clients read and write."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from virtualrobot_apps.languages.rapid.cell import Cell
from virtualrobot_apps.languages.rapid.predefined import VARIABLES
from virtualrobot_apps.languages.rapid.support import copied
from virtualrobot_apps.languages.rapid.symbols import Datum
from virtualrobot_apps.languages.rapid.task import Loaded, RapidTask
from virtualrobot_apps.languages.rapid.tree import Data
from virtualrobot_apps.languages.rapid.types import Type
from virtualrobot_apps.languages.rapid.world import World

HOLD_SECONDS = 0.02
"""Time (s of the wall clock) from one look to the next at whether a stopped program goes on."""
PREDEFINED = "user"
"""Module in which data are that RAPID has before any program."""

Report = Callable[[str, float | None, Sequence[str]], None]
"""Takes a message of a program: error, warning or information, its number if it has one, and its lines."""


@dataclass(frozen=True, slots=True)
class Symbol:
    """A datum of a module, and the list that holds its value.

    Attributes:
        module: the module's name.
        name: its name, as it is declared.
        storage: var, pers or const.
        type: its type.
        scope: local, task or nothing.
        holder: the list whose first element is the value.
    """

    module: str
    name: str
    storage: str
    type: Type
    scope: str
    holder: list[Any]

    @property
    def key(self) -> tuple[str, str]:
        """Module and name in small letters."""
        return self.module.lower(), self.name.lower()


class ControlledTask(RapidTask):
    """One run of a program under a controller.

    Attributes:
        holds: whether the program shall stand; its robot brakes on its path then, and goes on when it is unset.
        held: whether it stands so, with its robot.
        over: whether the run has ended.
    """

    def __init__(
        self,
        program: Loaded,
        world: World,
        name: str,
        cell: Cell,
        files: Path,
        report: Report,
        write: Callable[[str], None],
        answers: Iterable[str],
        listen_at: str | None,
        egm: Mapping[str, tuple[str, int]] | None = None,
    ) -> None:
        """Set up the data; `report` gets messages of ErrWrite and ErrLog, the others are `RapidTask`'s."""
        super().__init__(program, world, write, listen_at, files=files, answers=answers, name=name, cell=cell, egm=egm)
        self.holds = self.held = self.over = self._serving = False
        self._report = report

    def report(self, kind: str, number: float | None, lines: Sequence[str]) -> None:
        """Write a message into the controller's log."""
        self._report(kind, number, lines)

    def run(self, name: str = "main", forever: bool = False) -> None:
        """Run a procedure, as `RapidTask.run`."""
        try:
            super().run(name, forever)
        finally:
            self.over = True

    def hold(self) -> None:
        """Have the program stand before its next statement; any thread may call it."""
        self.holds = True
        self.ask("hold")

    def go_on(self) -> None:
        """Let the program go on; any thread may call it."""
        self.holds = False

    @property
    def stands(self) -> bool:
        """True where it stands since it shall."""
        return self.holds and self.held

    def serve(self) -> None:
        """Stand as long as that is asked for, and do then what else is asked for."""
        if self._serving:
            return  # what is asked meanwhile waits
        if self.holds:
            self._serving = True
            queue = self.world.queue
            stopped = queue.stopped  # by the program's own StopMove
            try:
                queue.stop()
                self.held = True
                while self.holds:
                    self.pause(HOLD_SECONDS)
                queue.stopped = stopped
                if not stopped:
                    self.world.start()
            finally:
                self._serving = self.held = False
        super().serve()

    def symbols(self) -> Iterator[Symbol]:
        """Yield the data of all modules, and those that RAPID has before any program."""
        for scope in self.program.checked.modules:
            for one in scope.module.declarations:
                if isinstance(one, Data):
                    datum: Datum = one.symbol
                    holder = self._names[datum.python]
                    yield Symbol(scope.module.name, one.name, one.storage, datum.type, one.scope, holder)
        for name, (storage, kind, _) in VARIABLES.items():
            yield Symbol(PREDEFINED, name, storage, Type(kind), "", self._names[f"s_{name.lower()}"])

    def values(self) -> dict[tuple[str, str], tuple[Symbol, Any]]:
        """Return all data that can be kept, with their values, by module and name in small letters."""
        return {one.key: (one, copied(one.holder[0])) for one in self.symbols() if plain(one.holder[0])}

    def restore(self, values: dict[tuple[str, str], tuple[Symbol, Any]], storages: Sequence[str]) -> None:
        """Take values of data back, of those that are stored so and are of the same type and size as then."""
        for one in self.symbols():
            was, value = values.get(one.key, (None, None))
            if was is None or one.storage not in storages or (one.storage, one.type) != (was.storage, was.type):
                continue
            if alike(one.holder[0], value):
                one.holder[0] = copied(value)


def plain(value: Any) -> bool:  # noqa: ANN401 any value of RAPID
    """Return whether a value is made of numbers, strings and truths alone, and is no device."""
    return all(map(plain, value)) if isinstance(value, list) else isinstance(value, int | float | str)


def alike(one: Any, other: Any) -> bool:  # noqa: ANN401 any value of RAPID
    """Return whether two values have the same shape."""
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(alike, one, other))
    return not isinstance(one, list) and not isinstance(other, list)
