"""Mapping files of bridges: which signal is which node, address or topic. One format, one reader."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from virtualrobot_apps.bridges.words import RANGES, TYPES
from virtualrobot_apps.cell_io.yaml_file import Item, nearest, read_file

Value = bool | int | float | str | tuple[bool, ...]

FILE_FIELDS = ("schema_version", "signals", "connected", "cycle_seconds", "timeout_seconds", "modbus")
ENTRY_FIELDS = ("signal", "direction", "type", "scale", "offset", "deadband", "lost", "word_order")
MODBUS_FIELDS = ("unit", "baud_rate", "parity", "stop_bits")

PLACES = {"opcua": "node", "modbus": "address", "mqtt": "topic"}
"""Field that says where a signal is on the other side, by protocol."""

TABLES = ("coil", "discrete_input", "holding_register", "input_register")
READ_ONLY = ("discrete_input", "input_register")
PARITIES = {"none": "N", "even": "E", "odd": "O"}

KIND_NAMES = {bool: "boolean", int: "integer", float: "number", str: "text", tuple: "group"}


@dataclass(frozen=True, eq=False)
class Entry:
    """A signal and its place on the other side.

    Attributes:
        signal: name of the signal.
        incoming: True where the other side gives its value, False where the world does.
        type: how the other side holds it, one of `words.TYPES`.
        place: node, address or topic.
        scale: what a value of the other side is multiplied by.
        offset: what is then added; together they give the value of the signal.
        deadband: changes of a number that are not larger are not told.
        lost: value that the signal gets while the other side is gone; None leaves the last one.
        low_word_first: order of the words of what has several registers.
        item: where it stands.
    """

    signal: str
    incoming: bool
    type: str
    place: str
    scale: float
    offset: float
    deadband: float
    lost: bool | int | float | str | None
    low_word_first: bool
    item: Item

    @property
    def table(self) -> str:
        """Table of a Modbus address."""
        return self.place.split()[0]

    @property
    def number(self) -> int:
        """Number of a Modbus address within its table, from 0."""
        return int(self.place.split()[1])

    @property
    def words(self) -> int:
        """Registers, or one bit, that a Modbus address takes."""
        return 1 if self.type == "boolean" else RANGES[self.type].words


@dataclass(frozen=True, eq=False)
class BridgeMapping:
    """Content of a mapping file.

    Attributes:
        entries: the signals.
        connected: a boolean that is on while the other side answers; empty for none.
        cycle: time between two looks at the other side (s).
        timeout: time after which a silent other side is gone (s).
        unit: of Modbus.
        serial: settings of a serial line of Modbus: baud rate, parity, stop bits.
        root: the file.
    """

    entries: tuple[Entry, ...]
    connected: str
    cycle: float
    timeout: float
    unit: int
    serial: tuple[int, str, int]
    root: Item

    def check_signals(self, world: Mapping[str, Value]) -> None:
        """Check names and types of signals against those of a world.

        Raises:
            MalformedFileError: for the first fault, with its line.
        """
        for entry in self.entries:
            kind = _kind(world, entry.signal, entry.item)
            fits = {"boolean": (bool,), "text": (str,)}.get(entry.type, (bool, int, float))
            if kind not in fits:
                said = f"the signal {entry.signal!r} is {KIND_NAMES[kind]}, which {entry.type!r} does not hold"
                raise entry.item.error(said)
            lost = entry.lost
            if lost is not None and type(lost) is not kind and (type(lost), kind) != (int, float):
                raise entry.item.error(f"'lost' is {lost!r}, and the signal {entry.signal!r} is {KIND_NAMES[kind]}")
        if self.connected and _kind(world, self.connected, self.root) is not bool:
            raise self.root.error(f"'connected': the signal {self.connected!r} has to be a boolean")


def read_mapping(path: str | Path, protocol: str, serves: bool) -> BridgeMapping:
    """Return what a mapping file says for a protocol and a role.

    Raises:
        MissingFileError: when the file can't be read.
        MalformedFileError: for the first fault, with file and line.
    """
    return mapping_of(read_file(path), protocol, serves)


def mapping_of(root: Item, protocol: str, serves: bool) -> BridgeMapping:
    """Return what the root of a mapping file says, as `read_mapping` does."""
    fields = root.fields(FILE_FIELDS, ["signals"])
    entries = tuple(_entry(item, protocol, serves) for item in fields["signals"].items())
    if not entries:
        raise fields["signals"].error("it maps no signal")
    connected = fields["connected"].text() if "connected" in fields else ""
    _refuse_twice(entries, connected)
    settings = fields["modbus"].fields(MODBUS_FIELDS) if "modbus" in fields else {}
    if settings and protocol != "modbus":
        raise fields["modbus"].error(f"these are settings of Modbus, and this is a bridge to {protocol}")
    return BridgeMapping(
        entries,
        connected,
        fields["cycle_seconds"].number(0.001, 3600.0) if "cycle_seconds" in fields else 0.02,
        fields["timeout_seconds"].number(0.01, 3600.0) if "timeout_seconds" in fields else 1.0,
        settings["unit"].whole(0, 255) if "unit" in settings else 1,
        (
            settings["baud_rate"].whole(300, 4_000_000) if "baud_rate" in settings else 19200,
            PARITIES[settings["parity"].one_of(PARITIES)] if "parity" in settings else "E",
            settings["stop_bits"].whole(1, 2) if "stop_bits" in settings else 1,
        ),
        root,
    )


def _entry(item: Item, protocol: str, serves: bool) -> Entry:
    where = PLACES[protocol]
    fields = item.fields((*ENTRY_FIELDS, where), ["signal", "direction", where])
    incoming = fields["direction"].one_of(("in", "out")) == "in"
    place = fields[where].text()
    bits = False
    if protocol == "modbus":
        table, number = _address(fields[where])
        place, bits = f"{table} {number}", table in TABLES[:2]
        if table in READ_ONLY and incoming == serves:
            who = "no master writes it" if serves else "no master may write it"
            raise fields["direction"].error(f"{table} is read only: {who}, so that the direction is the other one")
    elif protocol == "mqtt" and any(sign in place for sign in "#+"):
        raise fields[where].error("a topic belongs here, not a pattern with # or +")
    kind = fields["type"].one_of(TYPES) if "type" in fields else "boolean"
    if protocol == "modbus" and (kind == "text" or bits != (kind == "boolean")):
        said = "a bit, whose type is boolean" if bits else "of 16 bits, so that its type is a number"
        raise fields.get("type", item).error(f"{place} is {said}")
    for name in ("scale", "offset", "deadband"):
        if name in fields and kind in ("boolean", "text"):
            raise fields[name].error(f"a {kind} has no {name}")
    if "word_order" in fields and (protocol != "modbus" or kind not in RANGES or RANGES[kind].words < 2):
        raise fields["word_order"].error("an order of words has only what takes several registers of Modbus")
    if "lost" in fields and not incoming:
        raise fields["lost"].error("only a signal that comes in can be lost")
    scale = fields["scale"].number() if "scale" in fields else 1.0
    if not scale:
        raise fields["scale"].error("a scale of 0 makes all values one")
    entry = Entry(
        fields["signal"].text(),
        incoming,
        kind,
        place,
        scale,
        fields["offset"].number() if "offset" in fields else 0.0,
        fields["deadband"].number(0.0) if "deadband" in fields else 0.0,
        fields["lost"].scalar() if "lost" in fields else None,
        "word_order" in fields and fields["word_order"].one_of(("big", "little")) == "little",
        item,
    )
    if protocol == "modbus" and entry.number + entry.words > 65536:
        raise fields[where].error(f"{kind} takes {entry.words} registers, and the last one is 65535")
    if isinstance(entry.lost, float) and not math.isfinite(entry.lost):
        raise fields["lost"].error("a finite number belongs here")
    return entry


def _address(item: Item) -> tuple[str, int]:
    table, _, number = item.text().partition(" ")
    if table not in TABLES:
        raise item.error(f"there is no table {table!r}{nearest(table, TABLES)} known: {', '.join(TABLES)}")
    if not number.strip().isdecimal() or int(number) > 65535:
        raise item.error(f"after {table} comes its number from 0 to 65535, not {number!r}")
    return table, int(number)


def _refuse_twice(entries: tuple[Entry, ...], connected: str) -> None:
    signals: dict[str, Entry] = {}
    places: dict[str, Entry] = {}
    for entry in entries:
        if entry.signal in signals:
            line = signals[entry.signal].item.line
            raise entry.item.error(f"the signal {entry.signal!r} is mapped in line {line} already")
        if entry.signal == connected:
            raise entry.item.error(f"the signal {entry.signal!r} tells whether the other side answers")
        signals[entry.signal] = entry
        for place in _cells(entry):
            if place in places:
                first = places[place]
                raise entry.item.error(f"{place!r} is mapped to {first.signal!r} in line {first.item.line} already")
            places[place] = entry


def _cells(entry: Entry) -> list[str]:
    if not entry.place.startswith(TABLES) or " " not in entry.place or entry.type == "text":
        return [entry.place]
    return [f"{entry.table} {entry.number + word}" for word in range(entry.words)]


def _kind(world: Mapping[str, Value], name: str, item: Item) -> type:
    if name not in world:
        make: Callable[[str], str] = "virtualrobot signal '{}' --create".format
        raise item.error(f"there is no signal {name!r}{nearest(name, world)} {make(name)!r} makes one")
    return type(world[name])
