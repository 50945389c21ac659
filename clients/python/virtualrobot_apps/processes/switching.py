"""Signal of a tool along a way: an arc, a valve, a spindle, with the time that the tool stands at the ends for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from virtualrobot import Program, ToolPath

from virtualrobot_apps.cell_io.yaml_file import Item, nearest

LONGEST = 60.0
"""Longest time (s) that a tool stands at an end."""


@dataclass(frozen=True, slots=True)
class Switch:
    """Signal that is true, or has a value, along a way.

    Attributes:
        signal: its name; None without.
        value: what it has along the way: true, or a number; before and after it is false, or 0.
        start_seconds: how long the tool stands at the beginning with it on.
        end_seconds: how long it does so at the end.
        others: switches of arms that go along; all stand as long as the one that needs longest.
        item: where a file says so.
    """

    signal: str | None = None
    value: bool | float = True
    start_seconds: float = 0.0
    end_seconds: float = 0.0
    others: tuple[Switch, ...] = ()
    item: Item | None = field(default=None, compare=False, repr=False)

    def check(self, signals: Mapping[str, object]) -> None:
        """Raise MalformedFileError, with its line, where a cell's signals have none of this name that takes the value.

        signals: their values, by name.
        """
        for one in self.others:
            one.check(signals)
        if self.signal is None or self.item is None:
            return
        if self.signal not in signals:
            known = ", ".join(sorted(signals)) or "none"
            raise self.item.error(
                f"there is no signal {self.signal!r}{nearest(self.signal, signals)} the cell has {known}; "
                f"`virtualrobot signal --create {self.signal}` makes one"
            )
        has, is_switched = signals[self.signal], self.value is True
        if isinstance(has, bool) != is_switched or not isinstance(has, bool | int | float):
            kind = {bool: "true or false", int: "a number", float: "a number"}.get(type(has), "something else")
            right = "say its `value` on the way" if is_switched else "leave `value` out"
            wanted = "true or false" if is_switched else "a number"
            raise self.item.error(f"the signal {self.signal!r} is {kind}, and would be given {wanted}: {right}")

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add a tool path to a program, with the signal, and return how long that is on (s)."""
        working = self.on_along(program, path, name)
        self.off(program)
        return working

    def on_along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add a tool path to a program, with the signal, which stays on; return how long that takes (s)."""
        self.on(program)
        program.call(path.program, name)
        self.stand(program, self.longest("end_seconds"))
        return path.duration + self.longest("start_seconds") + self.longest("end_seconds")

    def on(self, program: Program) -> None:
        """Add to a program that the signal is on from here on, and that the tool stands for its beginning."""
        for one in (self, *self.others):
            if one.signal is not None:
                program.set(one.signal, one.value)
        self.stand(program, self.longest("start_seconds"))

    def stand(self, program: Program, seconds: float) -> None:
        """Add to a program that it stands for a time, where that is above 0."""
        if seconds:
            program.dwell(seconds)

    def off(self, program: Program) -> None:
        """Add to a program that the signal is off from here on."""
        for one in (self, *self.others):
            if one.signal is not None:
                program.set(one.signal, False if one.value is True else 0.0)

    def longest(self, name: str) -> float:
        """Return the longest `start_seconds` or `end_seconds` of this and the others."""
        return max(getattr(one, name) for one in (self, *self.others))


def read_switch(item: Item | None) -> Switch:
    """Return what a file says: a signal's name, or a mapping; raises MalformedFileError for what it says wrong."""
    if item is None:
        return Switch()
    if not item.is_mapping:
        return Switch(item.text(), item=item)
    fields = item.fields(("signal", "value", "start_seconds", "end_seconds"), ("signal",))
    value = fields["value"].number() if "value" in fields else True
    start, end = (
        fields[name].number(0.0, LONGEST) if name in fields else 0.0 for name in ("start_seconds", "end_seconds")
    )
    return Switch(fields["signal"].text(), value, start, end, item=fields["signal"])
