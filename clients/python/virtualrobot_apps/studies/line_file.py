"""Line files: stations in a row, where parts come from, and what all of it costs, in YAML.

Wherever a number belongs, the name of a parameter of the study may stand: the cell says it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from virtualrobot._wire.names import nearest
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.cell_io.yaml_file import Item, read_file
from virtualrobot_apps.studies.economy import Money
from virtualrobot_apps.studies.flow import SOURCE, Failures, Station, Time
from virtualrobot_apps.studies.parameters import Law, Value, check_law

_STATION = ("name", "cycle", "buffer", "machines", "failures", "scrap", "price")
_MONEY = ("hours", "running", "material", "revenue", "interest", "years")
_UNLIMITED = "unlimited"
_MOST = 1e15


@dataclass(frozen=True)
class Line:
    """Line of a file, with the parameters of a cell; `prices` are those of a machine of each station."""

    stations: tuple[Station, ...]
    prices: tuple[float, ...]
    source: Time | None
    money: Money | None


class LineFile:
    """Line file that was read; each cell has its own line of it."""

    def __init__(self, file: Path) -> None:
        """Read it; raise MissingFileError, or MalformedFileError for what is no YAML."""
        self._fields = read_file(file).fields(("schema_version", "source", "stations", "money"), needed=("stations",))

    def line(self, parameters: Mapping[str, Value]) -> Line:
        """Return the line with these parameters.

        Raises:
            MalformedFileError: with file, line and what would be right.
        """
        reader, fields = _Reader(parameters), self._fields
        items = fields["stations"].items()
        if not items:
            raise fields["stations"].error("one or more stations belong here")
        stations, prices = zip(*(reader.station(item) for item in items), strict=True)
        names = [one.name for one in stations]
        for item, name in zip(items, names, strict=True):
            if names.count(name) > 1 or name == SOURCE:
                raise item.error(f"{name!r} is the name of {'parts come from' if name == SOURCE else 'two stations'}")
        source = reader.time(fields["source"]) if "source" in fields else None
        investment = sum(price * one.machines for price, one in zip(prices, stations, strict=True))
        return Line(stations, prices, source, reader.money(fields["money"], investment) if "money" in fields else None)


def open_line(scene: Path | None) -> LineFile:
    """Return the line of a file: for `setup` of a study file, whose `scene` it is.

    Raises:
        InvalidArgumentError: when the study names none.
        MissingFileError, MalformedFileError: when it can't be read, or is no YAML.
    """
    if scene is None:
        raise InvalidArgumentError("this study needs a line: `scene: LINE.yaml` in the study file")
    return LineFile(scene)


class _Reader:
    def __init__(self, parameters: Mapping[str, Value]) -> None:
        self._parameters = parameters

    def station(self, item: Item) -> tuple[Station, float]:
        """Return a station, and the price of one of its machines."""
        fields = item.fields(_STATION, needed=("name", "cycle"))
        failures = None
        if "failures" in fields:
            found = fields["failures"].fields(("between", "repair"), needed=("between", "repair"))
            failures = Failures(self.time(found["between"]), self.time(found["repair"], 0.0))
        station = Station(
            name=fields["name"].text(),
            cycle=self.time(fields["cycle"]),
            buffer=self._buffer(fields["buffer"]) if "buffer" in fields else 0,
            machines=int(self._whole(fields["machines"], 1)) if "machines" in fields else 1,
            failures=failures,
            scrap=self._number(fields["scrap"], 0.0, 1.0) if "scrap" in fields else 0.0,
        )
        return station, self._number(fields["price"], 0.0, _MOST) if "price" in fields else 0.0

    def money(self, item: Item, investment: float) -> Money:
        """Return what the line costs and brings."""
        fields = item.fields(_MONEY, needed=("hours", "revenue", "years"))

        def amount(name: str, default: float = 0.0, least: float = 0.0, most: float = _MOST) -> float:
            return self._number(fields[name], least, most) if name in fields else default

        return Money(
            investment=investment,
            hours=amount("hours", least=1e-3, most=8784.0),
            running=amount("running"),
            material=amount("material"),
            revenue=amount("revenue"),
            interest=amount("interest", most=10.0),
            years=amount("years", least=0.1, most=1000.0),
        )

    def time(self, item: Item, least: float = 1e-6) -> Time:
        """Return a time (s), at least so many where it is always the same."""
        if not item.is_mapping:
            return self._number(item, least, _MOST)
        fields = item.mapping("settings")
        if "law" not in fields:
            raise item.error("a time (s) belongs here, or a law, such as {law: expon, scale: 60}")
        law = fields["law"].text()
        settings = {name: self._number(one, -_MOST, _MOST) for name, one in fields.items() if name != "law"}
        try:
            check_law(law, settings)
        except ValueError as error:
            raise item.error(str(error)) from error
        return Law("", law, tuple(settings.items()))

    def _buffer(self, item: Item) -> float:
        return math.inf if item.scalar() == _UNLIMITED else self._whole(item, 0)

    def _whole(self, item: Item, least: int) -> float:
        value = self._number(item, least, 1e6)
        if value != int(value):
            raise item.error(f"a whole number belongs here, not {value:g}")
        return value

    def _number(self, item: Item, least: float, most: float) -> float:
        name = item.scalar()
        if not isinstance(name, str):
            return item.number(least, most)
        if name not in self._parameters:
            raise item.error(f"the study has no parameter {name!r}; {nearest(name, self._parameters)}")
        value = self._parameters[name]
        if isinstance(value, str) or not least <= value <= most:
            raise item.error(
                f"a number from {least:g} to {most:g} belongs here, not {value!r} of the parameter {name!r}"
            )
        return float(value)
