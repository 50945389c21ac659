"""Processes whose tool is led along ways: planned, and looked along before, to see where the tool gets to at all."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.processes.leading import Accompanying, Leading, Led, Process, at_line, lead, wanted
from virtualrobot_apps.processes.looking import look_along
from virtualrobot_apps.processes.process import Look, PlannedProcess
from virtualrobot_apps.processes.showing import Effect, Showing
from virtualrobot_apps.processes.together import Together

Work = TypeVar("Work", bound=Process)


@dataclass(frozen=True, slots=True, eq=False)
class AlongWays(Generic[Work]):
    """Process of one kind, as an entry point gives it: called, it plans what a file describes.

    Attributes:
        read: what a file says; raises MalformedFileError, with file and line, for what it says wrong.
        leading: how its tool is led.
        told: lines about its plan, beside those about each way.
        together: arms that go along, where there are any.
        effects: what it leaves on parts, each by its name, part, stretches and growth; by default nothing.
    """

    read: Callable[[Client, Item], Work]
    leading: Callable[[Work], Leading]
    told: Callable[[Client, Work, Led], Iterable[str]]
    together: Callable[[Work], Sequence[Together[Work]]] = lambda work: ()
    effects: Callable[[Client, Work, Led], Iterable[Effect]] | None = None

    def __call__(self, client: Client, item: Item) -> PlannedProcess:
        """Return the plan in the cell as it is; raises what `lead` raises."""
        work = self._read_here(client, item)
        leading = self.leading(work)
        led = lead(client, leading, work, self._partners(work))
        planned = led.with_measures(*self.told(client, work, led))
        effects = self.effects
        if effects is None:
            return planned

        def shown() -> Showing:
            passes = [(one.parts[0], one.frames, one.times) for one in led.stretches]
            return Showing(client, leading.robot, passes, list(effects(client, work, led)))

        return replace(planned, shown=shown)

    def look(self, client: Client, item: Item) -> tuple[Look, ...]:
        """Return where the tool gets to on each way, in the cell as it is; raises what `lead` raises for the ways."""
        work = self._read_here(client, item)
        every = [Accompanying(self.leading(work), work), *self._partners(work)]
        looks = [look_along(client, one.leading, list(wanted(client, one.leading, one.process))) for one in every]
        return tuple(look for one in looks for look in one)

    def _partners(self, work: Work) -> list[Accompanying]:
        return [Accompanying(self.leading(one.work), one.work, one.paced) for one in self.together(work)]

    def _read_here(self, client: Client, item: Item) -> Work:
        """Return what a file says; raise MalformedFileError, too, for a robot or signal that the cell lacks."""
        work = self.read(client, item)
        named = item.mapping()["robot"]
        try:
            client.robot(named.text())
        except VirtualRobotError as error:
            raise at_line(named, "robot", error) from None
        work.switch.check(client.signals)
        return work
