"""What a program sees of the client library: no message of the contract, and no unit in a name."""

from __future__ import annotations

import inspect
import re
import typing
from collections.abc import Iterator

import pytest
import virtualrobot
from virtualrobot import Client, Program, Robot, connection
from virtualrobot.scene.scene import Scene

UNITS = re.compile(r"_(seconds|meters|radians|hertz|kilograms|pixels|degrees)(_|$)")
DOORS = {"services"}
"""What leads to the contract itself, and says so."""
HIDDEN = {"virtualrobot._wire.services", "virtualrobot._wire.transport"}
MADE_BY_THE_LIBRARY = {"of"}
"""Constructors that the library calls with what the kernel has said."""


def reached() -> Iterator[object]:
    """Yield the classes and functions that can be reached from what `virtualrobot` exports, by types of signatures."""
    waiting = [getattr(virtualrobot, name) for name in dir(virtualrobot)]
    waiting += [one for one in vars(connection).values() if inspect.isclass(one)]  # what a client leads to
    seen: set[object] = set()
    while waiting:
        one = waiting.pop()
        module = getattr(one, "__module__", "")
        if one in seen or not module.startswith("virtualrobot") or module in HIDDEN:
            continue
        seen.add(one)
        yield one
        for _, annotation in signatures(one):
            waiting += [part for part in parts(annotation) if inspect.isclass(part)]


def signatures(one: object) -> Iterator[tuple[str, object]]:
    """Yield name and type of all that a class or function shows: parameters, answers, fields, properties."""
    if inspect.isfunction(one):
        yield from hints(one)
    if not inspect.isclass(one):
        return
    yield from ((name, kind) for name, kind in typed(one) if not name.startswith("_"))
    for name, member in inspect.getmembers(one):
        if name.startswith("_") or name in DOORS | MADE_BY_THE_LIBRARY:
            continue
        function = member.fget if isinstance(member, property) else member
        if inspect.isfunction(function):
            yield from ((f"{one.__name__}.{name}: {what}", kind) for what, kind in hints(function))


def typed(one: object) -> Iterator[tuple[str, object]]:
    """Yield the annotations of a class or function as types; names that only type checkers import are looked up."""
    yield from typing.get_type_hints(one, localns={"Robot": Robot, "Scene": Scene, "Program": Program}).items()


def hints(function: object) -> Iterator[tuple[str, object]]:
    for name, kind in typed(function):
        # **options are a TypedDict whose keys are parameters too.
        inner = typing.get_args(kind)[0] if typing.get_origin(kind) is typing.Unpack else None
        yield from typed(inner) if inner is not None else [(name, kind)]


def parts(annotation: object) -> Iterator[object]:
    """Yield a type and all that it is made of."""
    yield annotation
    for inner in typing.get_args(annotation):
        yield from parts(inner) if not isinstance(inner, list) else (part for one in inner for part in parts(one))


API = sorted(reached(), key=lambda one: (one.__module__, one.__qualname__))  # pyright: ignore[reportAttributeAccessIssue]


def test_everything_is_looked_at() -> None:
    names = {one.__name__ for one in API}  # pyright: ignore[reportAttributeAccessIssue]
    assert {"Robot", "Motion", "MotionState", "Move", "Program", "Scene", "NodeInfo", "ViewState", "Sensors"} <= names
    assert len(names) > 100


@pytest.mark.parametrize("one", API, ids=lambda one: one.__qualname__)
def test_no_message_of_the_contract_and_no_unit_is_seen(one: object) -> None:
    for name, annotation in signatures(one):
        messages = [part for part in parts(annotation) if "_pb2" in getattr(part, "__module__", "")]
        assert not messages, f"{name} shows {messages[0]}"
        assert not UNITS.search(name.rpartition(" ")[2]), f"{name} has a unit in its name; docs/conventions.md"


def test_the_door_to_the_contract_is_named() -> None:
    assert isinstance(inspect.getattr_static(Client, "services"), property)
