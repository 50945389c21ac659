"""Messages of ABB's Externally Guided Motion: Protocol Buffers (proto2), of which this driver needs few fields.

Numbers of fields as in ABB's `egm.proto` (RobotWare 6 and 7; Application manual Externally Guided Motion, 3HAC073318).
Fields that aren't named here are passed over, as Protocol Buffers have it
(https://protobuf.dev/programming-guides/encoding/).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import IntEnum

MSGTYPE_CORRECTION = 3
"""Type of a setpoint in its header."""


class Motors(IntEnum):
    """EgmMotorState."""

    UNDEFINED = 0
    ON = 1
    OFF = 2


class Mci(IntEnum):
    """EgmMCIState: what guided motion itself does."""

    UNDEFINED = 0
    ERROR = 1
    STOPPED = 2
    RUNNING = 3


class Rapid(IntEnum):
    """EgmRapidCtrlExecState: whether the robot's program runs."""

    UNDEFINED = 0
    STOPPED = 1
    RUNNING = 2


class MessageError(ValueError):
    """Bytes that are no such message."""


@dataclass(slots=True)
class FromRobot:
    """Fields of an EgmRobot that this driver reads.

    Attributes:
        sequence: number of the packet; it grows by one.
        milliseconds: the controller's time as it sent this (header.tm), 0 where it doesn't tell.
        seconds: the controller's time of the joints (feedBack.time), 0 where it doesn't tell.
        joints, external: measured positions, degrees, and mm of external axes that slide.
        motors, mci, rapid: what it does.
        utilization: how much of its speed guided motion asks for (%), above 100 it can't follow.
        digital: the bit that the robot's program sends.
        collision: whether its motion supervision has seen one.
    """

    sequence: int = -1
    milliseconds: int = 0
    seconds: float = 0.0
    joints: list[float] = field(default_factory=list)
    external: list[float] = field(default_factory=list)
    motors: Motors = Motors.UNDEFINED
    mci: Mci = Mci.UNDEFINED
    rapid: Rapid = Rapid.UNDEFINED
    utilization: float = 0.0
    digital: bool = False
    collision: bool = False


def read_robot(data: bytes) -> FromRobot:
    """Return an EgmRobot; raises MessageError where the bytes are none, or have neither header nor feedback."""
    said = FromRobot()
    try:
        for number, value in _fields(data):
            if number == 1:
                for inner, header in _fields(_bytes(value)):
                    if inner == 1:
                        said.sequence = _whole(header)
                    elif inner == 2:
                        said.milliseconds = _whole(header)
            elif number == 2:
                _read_feedback(said, _bytes(value))
            elif number in (4, 5, 8, 12):
                state = next((_whole(one) for inner, one in _fields(_bytes(value)) if inner == 1), 0)
                if number == 4:
                    said.motors = Motors(state)
                elif number == 5:
                    said.mci = Mci(state)
                elif number == 8:
                    said.rapid = Rapid(state)
                else:
                    said.collision = bool(state)
            elif number == 10:
                said.utilization = _double(value)
            elif number == 13:
                said.digital = any(_whole(one) for inner, one in _fields(_bytes(value)) if inner == 1)
    except (IndexError, struct.error, ValueError) as error:
        raise MessageError(f"no EgmRobot: {error}") from error
    if said.sequence < 0 or not said.joints:
        raise MessageError("no EgmRobot: it has no sequence number, or no measured joints")
    return said


def _read_feedback(said: FromRobot, data: bytes) -> None:
    for number, value in _fields(data):
        if number in (1, 3):
            joints = said.joints if number == 1 else said.external
            for inner, one in _fields(_bytes(value)):
                if inner == 1 and isinstance(one, bytes) and len(one) != 8:  # packed
                    joints.extend(struct.unpack(f"<{len(one) // 8}d", one))
                elif inner == 1:
                    joints.append(_double(one))
        elif number == 4:
            parts = {inner: _whole(one) for inner, one in _fields(_bytes(value)) if inner in (1, 2)}
            said.seconds = parts.get(1, 0) + 1e-6 * parts.get(2, 0)


def write_sensor(
    sequence: int, milliseconds: int, joints: Sequence[float], external: Sequence[float], digital: bool
) -> bytes:
    """Return an EgmSensor that asks for these positions (degrees; mm of external axes that slide)."""
    header = b"\x08" + _varint(sequence) + b"\x10" + _varint(milliseconds) + bytes((0x18, MSGTYPE_CORRECTION))
    planned = _part(1, _doubles(joints)) + (_part(3, _doubles(external)) if external else b"")
    return _part(1, header) + _part(2, planned) + _part(4, bytes((0x08, digital)))


def _part(number: int, data: bytes) -> bytes:
    return bytes((number << 3 | 2,)) + _varint(len(data)) + data


def _doubles(values: Sequence[float]) -> bytes:
    return b"".join(b"\x09" + struct.pack("<d", value) for value in values)


def _varint(value: int) -> bytes:
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes((*out, value))


def _fields(data: bytes) -> Iterator[tuple[int, int | bytes]]:
    """Yield number and value of each field: whole numbers as such, all others as their bytes."""
    at = 0
    while at < len(data):
        key, at = _read_varint(data, at)
        kind = key & 7
        if kind == 0:
            value, at = _read_varint(data, at)
        else:
            if kind == 2:
                length, at = _read_varint(data, at)
            elif kind in (1, 5):
                length = 8 if kind == 1 else 4
            else:
                raise MessageError(f"a field has the kind {kind}")
            value, at = data[at : at + length], at + length
            if at > len(data):
                raise MessageError("it is cut off")
        yield key >> 3, value


def _read_varint(data: bytes, at: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value & 0xFFFFFFFFFFFFFFFF, at
        shift += 7
        if shift > 63:
            raise MessageError("a number has more than ten bytes")


def _bytes(value: int | bytes) -> bytes:
    if isinstance(value, int):
        raise MessageError("a number stands in place of a message")
    return value


def _whole(value: int | bytes) -> int:
    if isinstance(value, bytes):
        raise MessageError("bytes stand in place of a number")
    return value


def _double(value: int | bytes) -> float:
    return struct.unpack("<d", _bytes(value))[0]
