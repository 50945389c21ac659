"""Mapping files and values of bridges, without a kernel and without a socket."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest
from virtualrobot.errors import MalformedFileError
from virtualrobot_apps.bridges.mapping import BridgeMapping, mapping_of
from virtualrobot_apps.bridges.modbus import blocks
from virtualrobot_apps.bridges.opcua import OpcUaClient, OpcUaServer
from virtualrobot_apps.bridges.words import RANGES, BadValueError, from_registers, to_raw, to_registers, to_signal
from virtualrobot_apps.cell_io.yaml_file import parse

WORLD = {"start": False, "speed": 0.0, "count": 0, "name": "", "bus": (True, False), "there": False}


def mapping(entries: str, protocol: str = "modbus", serves: bool = False, more: str = "") -> BridgeMapping:
    """Return the mapping of these lines below `signals`, checked against a world."""
    lines = "".join(f"- {line}\n" for line in entries.strip().splitlines())
    read = mapping_of(parse(f"schema_version: 1\n{more}signals:\n{lines}", "plc.yaml"), protocol, serves)
    read.check_signals(WORLD)
    return read


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        (
            "{signal: strat, direction: in, address: coil 1}",
            "plc.yaml:3: signals[0]: there is no signal 'strat'; did you",
        ),
        ("{signal: start, direction: in, adress: coil 1}", "there is no field 'adress'; did you mean 'address'?"),
        (
            "{signal: start, direction: inn, address: coil 1}",
            "'inn' is not known; did you mean 'in'? it is one of in, out",
        ),
        ("{signal: start, direction: in}", "the field 'address' is missing"),
        ("{signal: start, direction: in, address: coils 1}", "there is no table 'coils'; did you mean 'coil'?"),
        ("{signal: start, direction: in, address: coil 70000}", "after coil comes its number from 0 to 65535"),
        ("{signal: start, direction: out, address: discrete_input 1}", "discrete_input is read only: no master may"),
        ("{signal: speed, direction: in, address: holding_register 1}", "its type is a number"),
        ("{signal: start, direction: in, address: coil 1, type: int16}", "a bit, whose type is boolean"),
        (
            "{signal: name, direction: in, address: input_register 1, type: int16}",
            "is text, which 'int16' does not hold",
        ),
        ("{signal: bus, direction: in, address: coil 1}", "is group, which 'boolean' does not hold"),
        ("{signal: speed, direction: in, address: input_register 1, type: float32, scale: 0}", "a scale of 0"),
        ("{signal: start, direction: in, address: coil 1, scale: 2}", "a boolean has no scale"),
        (
            "{signal: speed, direction: in, address: input_register 1, type: int16, word_order: big}",
            "an order of words",
        ),
        ("{signal: speed, direction: in, address: input_register 65535, type: float32}", "takes 2 registers"),
        ("{signal: start, direction: out, address: coil 1, lost: false}", "only a signal that comes in can be lost"),
        ("{signal: start, direction: in, address: coil 1, lost: 3}", "'lost' is 3, and the signal 'start' is boolean"),
        (
            "{signal: start, direction: in, address: coil 1}\n{signal: start, direction: in, address: coil 2}",
            "plc.yaml:4: signals[1]: the signal 'start' is mapped in line 3 already",
        ),
        (
            "{signal: speed, direction: in, address: input_register 1, type: float32}\n"
            "{signal: count, direction: in, address: input_register 2, type: int16}",
            "'input_register 2' is mapped to 'speed' in line 3 already",
        ),
    ],
)
def test_a_fault_is_told_with_its_line(entries: str, said: str) -> None:
    with pytest.raises(MalformedFileError) as refused:
        mapping(entries)
    assert said in str(refused.value)
    assert str(refused.value).startswith("plc.yaml:")


def test_a_slave_cannot_be_told_by_what_masters_only_read() -> None:
    with pytest.raises(MalformedFileError, match="read only: no master writes it"):
        mapping("{signal: start, direction: in, address: discrete_input 1}", serves=True)
    with pytest.raises(MalformedFileError, match="these are settings of Modbus"):
        mapping("{signal: start, direction: in, topic: a/b}", "mqtt", more="modbus: {unit: 3}\n")
    with pytest.raises(MalformedFileError, match="a topic belongs here"):
        mapping("{signal: start, direction: in, topic: a/#}", "mqtt")
    with pytest.raises(MalformedFileError, match="tells whether the other side answers"):
        mapping("{signal: start, direction: in, topic: a}", "mqtt", more="connected: start\n")


@pytest.mark.parametrize(
    ("protocol", "serves", "one", "other"),
    [
        ("opcua", False, "node: ns=2;s=a", "node: ns=2;s=b"),
        ("opcua", True, "node: ns=2;s=a", "node: ns=2;s=b"),
        ("modbus", False, "address: coil 1", "address: coil 2"),
        ("modbus", True, "address: coil 1", "address: coil 2"),
        ("mqtt", False, "topic: cell/a", "topic: cell/b"),
    ],
)
def test_what_is_mapped_twice_is_refused_by_every_bridge(protocol: str, serves: bool, one: str, other: str) -> None:
    """A signal with two places would have two masters, a place with two signals two values."""
    way = "in" if protocol == "modbus" and serves else "out"
    first = f"{{signal: start, direction: {way}, {one}}}"
    with pytest.raises(MalformedFileError) as refused:
        mapping(f"{first}\n{{signal: start, direction: in, {other}}}", protocol, serves)
    assert str(refused.value) == "plc.yaml:4: signals[1]: the signal 'start' is mapped in line 3 already"
    with pytest.raises(MalformedFileError) as refused:
        mapping(f"{first}\n{{signal: there, direction: in, {one}}}", protocol, serves)
    place = one.partition(": ")[2]
    assert str(refused.value) == f"plc.yaml:4: signals[1]: {place!r} is mapped to 'start' in line 3 already"
    assert len(mapping(f"{first}\n{{signal: there, direction: in, {other}}}", protocol, serves).entries) == 2


@pytest.mark.parametrize("peer", [OpcUaClient, OpcUaServer])
def test_one_node_that_is_written_in_two_ways_is_mapped_twice(peer: type[OpcUaClient | OpcUaServer]) -> None:
    read = mapping(
        "{signal: start, direction: out, node: ns=2;i=1001}\n{signal: there, direction: in, node: ns=2;i=01001}",
        "opcua",
    )
    with pytest.raises(MalformedFileError, match=r"plc\.yaml:4: .*'ns=2;i=01001' is mapped in line 3 already"):
        peer(read, "opc.tcp://127.0.0.1:4840")


@pytest.mark.parametrize("kind", RANGES)
@pytest.mark.parametrize("order", ["big", "little"])
def test_registers_are_those_of_struct(kind: str, order: str, rng: np.random.Generator) -> None:
    """Big-endian within a register; the order of registers is the file's."""
    words = f", word_order: {order}" if RANGES[kind].words > 1 else ""
    (entry,) = mapping(f"{{signal: speed, direction: in, address: input_register 1, type: {kind}{words}}}").entries
    for value in (0, 1, *map(int, rng.integers(0, 30000, 20))):
        raw = to_raw(entry, value)
        registers = to_registers(entry, raw)
        assert from_registers(entry, registers) == value
        ordered = registers if order == "big" or not words else registers[::-1]
        assert struct.pack(f">{len(ordered)}H", *ordered) == struct.pack(f">{RANGES[kind].code}", value)


def test_scales_and_ranges() -> None:
    (entry,) = mapping(
        "{signal: speed, direction: in, address: input_register 1, type: int16, scale: 0.1, offset: -5}"
    ).entries
    assert to_signal(entry, 123, float) == pytest.approx(7.3)
    assert to_raw(entry, 7.3) == 123
    for value, words in ((1e9, "int16 goes from -32768 to 32767"), (math.inf, "inf"), (math.nan, "nan")):
        with pytest.raises(BadValueError, match=words):
            to_raw(entry, value)
    for raw in (math.nan, math.inf, 1.5, 40000, "12", True, None, [1]):
        with pytest.raises(BadValueError):
            to_signal(entry, raw, float)


def test_one_request_reaches_what_is_adjacent() -> None:
    read = mapping(
        "{signal: speed, direction: in, address: input_register 4, type: float32}\n"
        "{signal: count, direction: in, address: input_register 6, type: int16}\n"
        "{signal: start, direction: in, address: coil 6}\n"
        "{signal: there, direction: in, address: coil 8}"
    )
    grouped = [[entry.signal for entry in block] for block in blocks(read.entries)]
    assert grouped == [["start"], ["there"], ["speed", "count"]]
