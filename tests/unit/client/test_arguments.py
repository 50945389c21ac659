"""Wrong arguments: each public function refuses them by name before it does anything."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import is_dataclass
from typing import Any

import numpy as np
import pytest
import virtualrobot
from virtualrobot._wire.arguments import _ITEMS, _signature, checked
from virtualrobot.clock import Clock
from virtualrobot.collisions.collisions import Collisions
from virtualrobot.signals import Signals
from virtualrobot.v1 import motion_pb2, signal_pb2

from tests.unit.client.test_public_api import API

NOTHING = object()
"""Value that no argument can have."""
UNCHECKED = {
    "FilmFile", "FilmThread", "KernelInfo", "Recording", "RobotTrajectory", "MotionPlan", "Wrapped", "Stamp",
}  # fmt: skip
"""Classes that the library makes, whose functions take nothing of a program's own."""


def functions() -> Iterator[tuple[str, Callable[..., Any], int]]:
    """Yield each public function of the library with its name and how many arguments come before a program's own."""
    for one in API:
        if inspect.isfunction(one):
            yield one.__name__, one, 0
        elif inspect.isclass(one) and not issubclass(one, BaseException):
            for name, member in vars(one).items():
                if isinstance(member, property) and member.fset is not None:
                    yield f"{one.__name__}.{name}", member.fset, 1
                elif inspect.isfunction(member) and (not name.startswith("_") or name in _ITEMS):
                    yield f"{one.__name__}.{name}", member, 1


ALL = [(name, function, own) for name, function, own in functions() if name.partition(".")[0] not in UNCHECKED]
TAKING = [one for one in ALL if len(inspect.signature(one[1]).parameters) > one[2]]


@pytest.mark.parametrize(("name", "function", "own"), TAKING, ids=[name for name, *_ in TAKING])
def test_what_is_of_no_kind_is_refused_by_its_name(name: str, function: Callable[..., Any], own: int) -> None:
    """None of these calls gets as far as the function: it has no robot, no scene and no kernel."""
    setter = name.rpartition(".")[2] if not function.__name__.startswith("__") else ""
    signature = _signature(inspect.unwrap(function), "")  # pyright: ignore[reportArgumentType]
    for place, (argument, kind) in enumerate(signature.order):
        if place < own or kind in (Any, object):
            continue
        with pytest.raises(virtualrobot.InvalidArgumentError, match=rf"^{argument}|^{setter}") as refused:
            function(*[None] * own, *[NOTHING] * (place - own + 1))
        assert "must be" in str(refused.value)
        break  # those after it are told when it is right
    for argument, kind in signature.named.items():
        if kind in (Any, object) or argument in [name for name, _ in signature.order]:
            continue
        with pytest.raises(virtualrobot.InvalidArgumentError, match=rf"^{argument} is <object.*; it must be"):
            function(*[None] * own, **{argument: NOTHING})


@checked
def sample(
    name: str = "a",
    *,
    count: int = 1,
    speed: float | None = None,
    values: dict[str, float] | None = None,
    names: list[str] | None = None,
    on: bool = False,
) -> tuple[object, ...]:
    """Return what comes through."""
    return name, count, speed, values, names, on


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"name": ""}, "name is ''; it must be a text that is not empty"),
        ({"name": None}, "name is None; it must be a text"),
        ({"name": "\ud800"}, "it must be a text"),
        ({"count": -1}, "count is -1; it must be a whole number from 0 on"),
        ({"count": 1.5}, "count is 1.5"),
        ({"count": True}, "count is True"),
        ({"count": 2**64}, "a whole number"),
        ({"speed": "fast"}, "speed is 'fast'; it must be a number, or None"),
        ({"speed": [1.0]}, r"speed is \[1.0\]"),
        ({"speed": True}, "speed is True"),
        ({"speed": 10**400}, "it must be a number"),
        ({"values": {"base": "abc"}}, r"values\['base'\] is 'abc'; it must be a number"),
        ({"values": {1: 0.0}}, "a name in values is 1; it must be a text"),
        ({"values": 5}, r"a dictionary by name \(each a number\), or None"),
        ({"names": "abc"}, "names is 'abc'; it must be a list"),
        ({"names": ["a", 1]}, r"names\[1\] is 1; it must be a text"),
        ({"on": "no"}, "on is 'no'; it must be True or False"),
        ({"on": 1}, "on is 1; it must be True or False"),
    ],
    ids=str,
)
def test_each_kind_says_what_would_be_right(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match=words) as refused:
        sample(**wrong)
    assert refused.value.metadata["field"] in wrong


def test_what_is_right_comes_through() -> None:
    assert sample() == ("a", 1, None, None, None, False)
    given = {"count": np.uint8(3), "speed": np.float32(0.5), "values": {"a": 1}, "names": ["b"], "on": np.bool_(True)}
    assert sample("c", **given) == ("c", 3, 0.5, {"a": 1}, ["b"], True)
    assert sample(count=None, on=None) == ("a", 1, None, None, None, False)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    with pytest.raises(TypeError, match="unexpected keyword argument 'speeed'"):
        sample(speeed=1)  # type: ignore[call-arg]  # pyright: ignore[reportCallIssue]


@pytest.mark.parametrize(
    ("value", "kind"),
    [
        (np.float64(0.5), "number"),
        (np.float32(0.5), "number"),
        (np.int64(3), "integer"),
        (np.uint8(3), "integer"),
        (np.bool_(True), "boolean"),
        (np.str_("on"), "text"),
        (np.array([True, False]), "group"),
        ([np.bool_(True), False], "group"),
    ],
    ids=repr,
)
def test_numbers_of_numpy_are_values_of_signals(value: Any, kind: str) -> None:  # noqa: ANN401 that is the point
    program = virtualrobot.Program(None).set("signal", value)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    (step,) = program._spec.steps
    assert step.set_signal.value.WhichOneof("kind") == kind


def test_moves_of_a_file_are_a_first_step() -> None:
    spec = motion_pb2.MotionSpec(moves=[motion_pb2.Move(robot="arm")])
    program = virtualrobot.Program(None, spec)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    assert (len(program), repr(program)) == (1, "<Program of 1 step>")
    assert len(spec.moves) == 1  # as it was read
    program.set("on").dwell(0.1)
    assert len(program) == 3
    assert [step.WhichOneof("step") for step in program._spec.steps] == ["move", "set_signal", "dwell"]
    assert program._spec.steps[0].move.moves[0].robot == "arm"
    assert not program._spec.moves
    assert program._spec.steps[1].set_signal.value == signal_pb2.SignalValue(boolean=True)


@pytest.mark.parametrize("wrong", [-1, 0, 1.5, True])
def test_what_there_is_one_of_at_least_is_told_so(wrong: int) -> None:
    program = virtualrobot.Program.__new__(virtualrobot.Program)
    with pytest.raises(virtualrobot.InvalidArgumentError, match=rf"count is {wrong}; .* a whole number, at least 1$"):
        program.repeat(wrong, program)
    with pytest.raises(virtualrobot.InvalidArgumentError, match=rf"ticks is {wrong}; .* a whole number, at least 1$"):
        object.__new__(Clock).step(wrong)


def test_a_program_that_calls_itself_is_told_so() -> None:
    program = virtualrobot.Program.__new__(virtualrobot.Program)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="the program calls itself"):
        program.call(program)


def test_an_empty_name_of_a_tool_is_told_so() -> None:
    with pytest.raises(
        virtualrobot.InvalidArgumentError, match=r"what is ''; it must be a node, its name \(not empty\)"
    ):
        object.__new__(virtualrobot.Robot).mount("")


HANDLES = [
    one
    for one in API
    if inspect.isclass(one)
    and one.__name__ not in UNCHECKED
    and not is_dataclass(one)
    and any(name.startswith(f"{one.__name__}.") for name, *_ in TAKING)
]
"""Classes whose objects handle what the kernel has."""


@pytest.mark.parametrize("one", HANDLES, ids=[one.__name__ for one in HANDLES])
def test_handles_take_no_attribute_that_changes_nothing(one: type) -> None:
    handle = object.__new__(one)
    for name in ("no_such_attribute", "state", "name"):
        with pytest.raises(AttributeError, match=rf"the attribute '{name}' of {one.__name__} cannot be set"):
            setattr(handle, name, 1)
    handle._own = 1  # pyright: ignore[reportAttributeAccessIssue]
    assert handle._own == 1  # pyright: ignore[reportAttributeAccessIssue]


@pytest.mark.parametrize(
    ("one", "name", "right"),
    [
        (Collisions, "mode", r"call set\(mode=\.\.\.\)"),
        (Collisions, "look_ahead", r"call set\(look_ahead=\.\.\.\)"),
        (virtualrobot.Robot, "speed", "set 'speed_factor'"),
        (virtualrobot.Robot, "positions", r"call set_positions\(\.\.\.\)"),
        (Clock, "speed", "set 'speed_factor'"),
        (Signals, "foo", r"set the entry \['foo'\]"),
    ],
)
def test_a_refused_attribute_tells_the_right_call(one: type, name: str, right: str) -> None:
    with pytest.raises(AttributeError, match=f"the attribute '{name}' of {one.__name__} cannot be set; {right}$"):
        setattr(object.__new__(one), name, 1)
