"""What is written comes back bit for bit, of every class that a command or a state consists of; damage is told."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, is_dataclass
from enum import Enum
from typing import Any

import msgspec
import numpy as np
import pytest
import virtualrobot_kernel.motion.limits
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.history.classes import MIGRATIONS, reached, world_codec
from virtualrobot_kernel.history.codec import Codec, same
from virtualrobot_kernel.history.documents import Parts, UnknownVersionError, UnreadableError
from virtualrobot_kernel.history.world_image import image_of
from virtualrobot_kernel.motion.running_motion import RunningMotion
from virtualrobot_kernel.world.commands import CreateNodes, SetSetpoint, SetSignal, StartMotion, UpdateNode
from virtualrobot_kernel.world.state import Signal
from virtualrobot_kernel.world.structure import JointLimits, Node

from tests.tiers import Draws
from tests.unit.history.random_values import RandomValues
from tests.unit.history.runs import random_run
from tests.unit.world.builders import after, arm, empty, part, shifted
from tools import freeze_classes

CODEC = world_codec()


@pytest.mark.parametrize("cls", reached(), ids=lambda cls: f"{cls.__module__.rpartition('.')[2]}.{cls.__name__}")
def test_random_values_of_each_class_come_back(cls: type, rng: np.random.Generator, draws: Draws) -> None:
    values = RandomValues(rng)
    for _ in range(draws(25)):
        value = values.of(cls)
        again = CODEC.decode(CODEC.encode(value))
        assert same(value, again) == ""
        assert type(again) is cls


def test_anything_comes_back_with_its_types(rng: np.random.Generator, draws: Draws) -> None:
    values = RandomValues(rng)
    for _ in range(draws(500)):
        value = values.anything(0)
        assert same(value, CODEC.decode(CODEC.encode(value))) == ""


def test_arrays_keep_order_and_whether_they_may_be_written_to() -> None:
    array = np.arange(12.0).reshape(3, 4)
    frozen = array.copy()
    frozen.setflags(write=False)
    for one in (array, array.T, frozen, array[:, 1:3], array[:0], np.float32(array)):
        again = CODEC.decode(CODEC.encode(one))
        assert same(one, again) == ""
        assert (again.flags.writeable, again.flags.aligned) == (one.flags.writeable, True)
        assert again.flags.f_contiguous == (one.flags.f_contiguous or not one.size)


def test_every_kind_of_running_motion_is_known() -> None:
    wanted = {name for name in vars(RunningMotion) if not name.startswith("_")}
    known = set(reached())
    for module in pkgutil.iter_modules(virtualrobot_kernel.motion.__path__, "virtualrobot_kernel.motion."):
        for cls in vars(importlib.import_module(module.name)).values():
            if inspect.isclass(cls) and is_dataclass(cls) and wanted <= {*dir(cls), *cls.__dataclass_fields__}:
                assert cls in known, f"add {cls.__name__} to RUNNING in history/classes.py"


def test_no_class_has_changed_since_it_was_written() -> None:
    """`tools/freeze_classes.py` adds what is new to the file; what it refuses is what this test tells."""
    assert freeze_classes.faults(freeze_classes.frozen(), CODEC.schema(), MIGRATIONS) == []
    known = {tag: version[str(max(map(int, version)))] for tag, version in freeze_classes.frozen().items()}
    assert {tag: fields for tag, (_, fields) in CODEC.schema().items()} == known, "run tools/freeze_classes.py"


@pytest.mark.parametrize(
    ("now", "told"),
    [
        ({"A": (1, ["x: int", "y: int"])}, "'A' has other fields than its version 1 had: give it version 2"),
        ({"A": (2, ["x: int", "y: int"])}, "nothing in MIGRATIONS makes version 2 of 'A' of version 1"),
        ({}, "'A' is gone"),
    ],
)
def test_a_change_without_a_version_is_told(now: Mapping[str, Any], told: str) -> None:
    (fault,) = freeze_classes.faults({"A": {"1": ["x: int"]}}, now, {})
    assert fault.startswith(told)
    assert freeze_classes.faults({"E": {"1": ["ON"]}}, {"E": (1, ["ON", "OFF"])}, {}) == []
    (fault,) = freeze_classes.faults({"E": {"1": ["ON", "OFF"]}}, {"E": (1, ["ON"])}, {})
    assert fault.startswith("'E' has lost OFF")


@dataclass(frozen=True)
class Wheel:
    radius: float


@dataclass(frozen=True)
class WheelOfTwo:
    radius: float
    width: float


class Gear(Enum):
    FIRST = 1


def test_the_version_before_is_read_and_what_is_newer_is_refused() -> None:
    old = Codec([Wheel], tags={Wheel: "Wheel"})
    widened: dict[tuple[str, int], Callable[[list[Any]], list[Any]]] = {("Wheel", 1): lambda fields: [*fields, 0.25]}
    new = Codec([WheelOfTwo], tags={WheelOfTwo: "Wheel"}, versions={WheelOfTwo: 2}, migrations=widened)
    assert new.decode(old.encode((Wheel(0.5),))) == (WheelOfTwo(0.5, 0.25),)
    with pytest.raises(UnknownVersionError, match="a 'Wheel' of version 2; this program knows 1"):
        old.decode(new.encode(WheelOfTwo(0.5, 0.1)))
    with pytest.raises(UnknownVersionError, match="a 'Wheel' of version 1, which this program doesn't know"):
        Codec([]).decode(old.encode(Wheel(0.5)))
    with pytest.raises(UnknownVersionError, match="format is number 2; this program knows 1"):
        old.decode(msgspec.msgpack.encode([2, [], [], None]))


def test_what_cannot_be_written_is_told_when_the_codec_is_made_or_asked() -> None:
    with pytest.raises(TypeError, match="two classes would be written as 'JointLimits'"):
        Codec([JointLimits, virtualrobot_kernel.motion.limits.JointLimits])

    class Called:
        __annotations__ = {"call": Callable[[], None]}

    with pytest.raises(TypeError, match=r"call is annotated with .*Callable.*, which can't be written"):
        Codec([dataclass(Called)])
    with pytest.raises(TypeError, match="Wheel compares by value, so that it can't be a part"):
        Codec([Wheel], parts=[Wheel])
    for value in (object(), Gear.FIRST, {1, 2}, 2**70, np.array(["a"])):
        with pytest.raises(KernelError, match="a value can't be written") as refused:
            CODEC.encode(value)
        assert refused.value.reason is Reason.INTERNAL


def test_damaged_bytes_are_told_or_give_another_value(rng: np.random.Generator, draws: Draws) -> None:
    """Whatever is flipped, cut or put in: an error of one kind, and never more memory than the bytes are worth."""
    values = RandomValues(rng)
    for _ in range(draws(100)):
        data = CODEC.encode((values.of(StartMotion), values.of(UpdateNode), values.of(Node)))
        for _ in range(20):
            damaged = bytearray(data)
            kind, place = rng.integers(3), int(rng.integers(len(data)))
            if kind == 0:
                damaged[place] ^= 1 << int(rng.integers(8))
            elif kind == 1:
                del damaged[place:]
            else:
                damaged[place:place] = rng.bytes(4)
            try:
                CODEC.decode(bytes(damaged))
            except UnreadableError as error:
                assert error.reason is Reason.MALFORMED_FILE


@pytest.mark.parametrize(
    "data",
    [
        *(b"", b"\xdd\xff\xff\xff\xff", b"\xc9\xff\xff\xff\xff\x01", b"\x91" * 100_000, b"\x94\x01\x90\x90"),
        msgspec.msgpack.encode([1, ["State", 1], [], [0, "one", 2]]),
        msgspec.msgpack.encode([1, ["SetSetpoint", 1], [], [0, 5, [1.0]]]),
        msgspec.msgpack.encode([1, [], [], msgspec.msgpack.Ext(3, b"\x07")]),
        msgspec.msgpack.encode([1, [], [], msgspec.msgpack.Ext(1, b"\x00\x00\x02\xff\xff\xff\xff\xff\xff\xff\xff")]),
        msgspec.msgpack.encode([1, [], [], msgspec.msgpack.Ext(9, b"")]),
        msgspec.msgpack.encode([1, [], [], msgspec.msgpack.Ext(4, b"part")]),
    ],
)
def test_bytes_of_nobody_are_unreadable(data: bytes) -> None:
    with pytest.raises(UnreadableError):
        CODEC.decode(data)


def test_values_have_the_types_that_annotations_say() -> None:
    wrong = msgspec.msgpack.encode([1, ["SetSetpoint", 1, "SetSignal", 1], [], [0, [1, "a", True], [1.0]]])
    with pytest.raises(UnreadableError, match="stands where str belongs"):
        CODEC.decode(wrong)
    right = msgspec.msgpack.encode([1, ["SetSetpoint", 1, "SetSignal", 1], [], [-1, [0, "a", [1.0]], [1, "b", True]]])
    assert CODEC.decode(right) == (SetSetpoint("a", (1.0,)), SetSignal("b", True))


def test_what_is_one_object_stays_one(rng: np.random.Generator) -> None:
    node = RandomValues(rng).of(Node)
    first, (second, third) = CODEC.decode(CODEC.encode((node, [node, Signal("on", True)])))
    assert first is second
    assert third == Signal("on", True)


def test_a_run_is_replayed_from_bytes_bit_for_bit(rng: np.random.Generator, draws: Draws) -> None:
    run = random_run(rng, draws(300))
    entries = [CODEC.encode(entry.commands) for entry in run.entries]
    assert len(entries) > 20
    assert same(image_of(*run.last), image_of(*run.replayed([CODEC.decode(one) for one in entries]))) == ""


def test_a_run_goes_on_from_a_checkpoint_bit_for_bit(rng: np.random.Generator, draws: Draws) -> None:
    """From a world out of bytes, with motions under way, it comes to the same end."""
    run = random_run(rng, draws(300))
    image = CODEC.decode(CODEC.encode(image_of(*run.worlds[len(run.worlds) // 2])))
    assert same(image_of(*run.last), image_of(*run.replayed(None, image))) == ""


def test_a_checkpoint_writes_again_only_what_is_new() -> None:
    row = CreateNodes(tuple(part(f"p{number}", shifted(x=0.2 * number)) for number in range(40)))
    change = after(empty(), arm(), row)
    parts = Parts()
    first = CODEC.encode_in_parts(image_of(change.structure, change.state), parts)
    assert len(first.parts) == len(first.fresh) == len(change.structure.nodes)
    again = CODEC.encode_in_parts(image_of(change.structure, change.state), parts)
    assert (again.parts, again.fresh, again.body) == (first.parts, {}, first.body)
    change = after(change, UpdateNode("p7", hidden=True))
    third = CODEC.encode_in_parts(image_of(change.structure, change.state), parts)
    assert len(third.fresh) == 1
    stored = {**first.fresh, **third.fresh}
    image = CODEC.decode(third.body, stored.__getitem__)
    assert same(image_of(change.structure, change.state), image) == ""
    assert [node.name for node in image.nodes if node.hidden] == ["p7"]
    with pytest.raises(UnreadableError, match=r"the part [0-9a-f]{32} is missing"):
        CODEC.decode(third.body)
    # Another process has other objects, and the same digests.
    assert CODEC.encode_in_parts(image, Parts()).parts == third.parts
