"""Arguments of public functions: looked at by their annotations before anything is done."""

from __future__ import annotations

import importlib
import inspect
import operator
import os
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import is_dataclass
from difflib import get_close_matches
from functools import cache, wraps
from pathlib import Path
from types import FunctionType, NoneType, UnionType
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeVar, Union

import numpy as np

from virtualrobot.errors import InvalidArgumentError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
else:

    class ArrayLike:
        """Numbers that NumPy makes an array of; NumPy's own type falls apart in a union, and takes words too."""


Text = Annotated[str, "a text"]
"""Words that may be empty. Any other `str` of a public function is a name or a choice, and an empty one is refused."""

Count = Annotated[int, "a whole number, at least 1"]
"""Number of things of which there is at least one."""

PoseLike = Annotated[ArrayLike, "a 4x4 array, as virtualrobot.pose() makes it"]
"""A pose; as of every annotated type, the words are those of the error."""

One = TypeVar("One", bound=Callable[..., Any])

_ITEMS = ("__getitem__", "__setitem__", "__delitem__")
_MOST_SHOWN = 80
"""Longest part of a wrong value in an error."""


def checked(one: One) -> One:
    """Return a function that looks at its arguments first, or a class whose public functions and setters do.

    An argument that is not what its annotation says is refused by InvalidArgumentError with its name, its value and
    what would be right. None stands for the default of an option and of a parameter that is given by name only.
    The objects of such a class, which handle what the kernel has, take no attribute that would change nothing there.
    """
    if not inspect.isclass(one):
        return _checking(one)  # pyright: ignore[reportArgumentType, reportReturnType] a function of the same signature
    if not is_dataclass(one):
        one.__setattr__ = _set_known  # pyright: ignore[reportAttributeAccessIssue]
    for name, member in list(vars(one).items()):
        if isinstance(member, property) and member.fset is not None:
            setattr(one, name, property(member.fget, _checking(member.fset, name), member.fdel, member.__doc__))  # pyright: ignore[reportArgumentType]
        elif isinstance(member, FunctionType) and (
            not name.startswith("_") or name in _ITEMS or (name == "__init__" and is_dataclass(one))
        ):
            setattr(one, name, _checking(member))
    return one  # pyright: ignore[reportReturnType] it was narrowed by the look whether it is a dataclass


def _set_known(self: object, name: str, value: object) -> None:
    """Set an attribute that is private, has a setter, or is set by a function of the object itself."""
    known = getattr(type(self), name, None)
    if not (name.startswith("_") or (isinstance(known, property) and known.fset is not None)):
        caller = inspect.currentframe()
        caller = caller.f_back if caller is not None else None
        if caller is None or caller.f_locals.get("self") is not self:
            raise AttributeError(_refusal(type(self), name), name=name, obj=self)
    object.__setattr__(self, name, value)


def _refusal(one: type, name: str) -> str:
    """Return that an attribute cannot be set, and the call that the writer may have meant."""
    settable = [own for own, member in inspect.getmembers(one) if isinstance(member, property) and member.fset]
    setter = getattr(one, "set", None)
    near = [own for own in settable if own.startswith(name)] or get_close_matches(name, settable, n=1)
    if setter is not None and name in _signature(inspect.unwrap(setter), "").named:
        right = f"; call set({name}=...)"
    elif hasattr(one, f"set_{name}"):
        right = f"; call set_{name}(...)"
    elif near:
        right = f"; set {near[0]!r}"
    elif hasattr(one, "__setitem__"):
        right = f"; set the entry [{name!r}]"
    elif settable:
        right = f"; those that can are {', '.join(settable)}"
    else:
        right = ""
    return f"the attribute {name!r} of {one.__name__} cannot be set{right}"


class _Signature(NamedTuple):
    """Kinds of arguments: of those in order, of the rest of these, and by name; and for which None is the default."""

    order: tuple[tuple[str, Any], ...]
    rest: tuple[str, Any] | None
    named: Mapping[str, Any]
    defaulted: frozenset[str]


def _checking(function: FunctionType, setter: str = "") -> FunctionType:
    """Return `function` with the look before it; a `setter` is told by the name of its property."""
    read = cache(lambda: _signature(function, setter))

    @wraps(function)
    def call(*given: Any, **named: Any) -> Any:  # noqa: ANN401 those of the function
        signature = read()
        for value, (name, kind) in zip(given, signature.order, strict=False):
            _check(value, kind, name)
        if signature.rest is not None:
            for value in given[len(signature.order) :]:
                _check(value, signature.rest[1], signature.rest[0])
        for name, value in list(named.items()):
            if value is None and name in signature.defaulted:
                del named[name]
            elif name in signature.named:
                _check(value, signature.named[name], name)
        return function(*given, **named)

    return typing.cast(FunctionType, call)


def _signature(function: FunctionType, setter: str) -> _Signature:
    kinds = _hints(function)
    order: list[tuple[str, Any]] = []
    rest, named, defaulted = None, {}, set()
    for parameter in inspect.signature(function).parameters.values():
        name, kind = parameter.name, kinds.get(parameter.name, Any)
        if parameter.default in ("", None) and parameter.default is not parameter.empty:
            kind = Union[kind, Text] if parameter.default == "" else Union[kind, None]  # noqa: UP007 at run time
        if parameter.kind is parameter.VAR_POSITIONAL:
            rest = name, kind
        elif parameter.kind is parameter.VAR_KEYWORD:
            if typing.get_origin(kind) is typing.Unpack:
                options = _hints(typing.get_args(kind)[0])
                named |= options
                defaulted |= options.keys()
        else:
            named[name] = kind
            if parameter.kind is parameter.KEYWORD_ONLY:
                if parameter.default is not parameter.empty:
                    defaulted.add(name)
            else:
                order.append((setter if setter and order else name, kind))
    return _Signature(tuple(order), rest, named, frozenset(defaulted))


def _hints(one: object) -> dict[str, Any]:
    """Return annotations as types; names that only type checkers import are those of the library, or anything."""
    known: dict[str, Any] = {}
    while True:
        try:
            return typing.get_type_hints(one, localns=known, include_extras=True)
        except NameError as error:
            name = error.name or ""
            known[name] = getattr(importlib.import_module("virtualrobot"), name, Any)


class _Fault(NamedTuple):
    """Wrong part of an argument: its place, its value, and what would be right."""

    place: str
    value: object
    right: str


def _check(value: object, kind: Any, name: str) -> None:  # noqa: ANN401 any annotation
    fault = _fault(value, kind, name)
    if fault is not None:
        shown = " ".join(repr(fault.value).split())
        shown = shown if len(shown) <= _MOST_SHOWN else f"{shown[:_MOST_SHOWN]}..."
        raise InvalidArgumentError(
            f"{fault.place} is {shown}; it must be {fault.right}", metadata={"field": name, "value": shown}
        )


def _fault(value: object, kind: Any, place: str) -> _Fault | None:  # noqa: ANN401
    """Return what of a value is not of a kind; None where all of it is, and of kinds that nothing is known of."""
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if origin is Annotated and kind not in _TESTS:
        return _Fault(place, value, inner[1]) if _fault(value, inner[0], place) else None
    if origin in (Union, UnionType):
        return _fault_of_any(value, inner, place)
    if origin is not None and inspect.isclass(origin) and issubclass(origin, Mapping):
        if not isinstance(value, Mapping):
            return _Fault(place, value, _words(kind))
        for name, one in value.items():
            if wrong := _fault(name, inner[0], f"a name in {place}") or _fault(one, inner[1], f"{place}[{name!r}]"):
                return wrong
        return None
    if origin is not None and inspect.isclass(origin) and issubclass(origin, Iterable):
        return _fault_in_row(value, kind, place)
    test = _TESTS.get(kind)
    if test is None and inspect.isclass(kind) and kind not in (Any, object):
        right = isinstance(value, kind)
    else:
        right = callable(value) if origin is Callable else test is None or test(value)
    return None if right else _Fault(place, value, _words(kind))


def _fault_of_any(value: object, kinds: Sequence[Any], place: str) -> _Fault | None:
    """Return what is wrong with a value that may be of several kinds: of the one that it is most like."""
    faults = []
    for kind in kinds:
        fault = _fault(value, kind, place)
        if fault is None:
            return None
        faults.append(fault)
    deepest = max(faults, key=lambda fault: len(fault.place))
    if deepest.place != place:
        return [fault for fault in faults if fault.place == deepest.place][-1]
    return _Fault(place, value, _words(Union[tuple(kinds)]))  # noqa: UP007 made at run time


def _fault_in_row(value: object, kind: Any, place: str) -> _Fault | None:  # noqa: ANN401
    inner = typing.get_args(kind)
    fixed = typing.get_origin(kind) is tuple and Ellipsis not in inner
    if isinstance(value, str | bytes) or not hasattr(value, "__iter__"):
        return _Fault(place, value, _words(kind))
    if fixed:
        right = isinstance(value, tuple | list) and len(value) == len(inner)
        return None if right else _Fault(place, value, _words(kind))
    # What can be read only once is left to who reads it.
    for number, one in enumerate(value if isinstance(value, list | tuple) else ()):
        if fault := _fault(one, inner[0], f"{place}[{number}]"):
            return fault
    return None


def _is_number(value: object) -> bool:
    if type(value) is float:
        return True
    if isinstance(value, bool | np.bool_ | str | bytes) or np.ndim(value) != 0:  # pyright: ignore[reportArgumentType]
        return False
    try:
        float(value)  # pyright: ignore[reportArgumentType] what is no number raises TypeError
    except (TypeError, ValueError, OverflowError):
        return False
    return True


def _is_count(value: object) -> bool:
    try:
        return not isinstance(value, bool) and 0 <= operator.index(value) < 2**64  # pyright: ignore[reportArgumentType]
    except TypeError:
        return False


def _is_text(value: object) -> bool:
    # A lone half of a surrogate pair, as of a file's name that is not in UTF-8, fits in no message.
    return isinstance(value, str) and not any("\ud800" <= letter <= "\udfff" for letter in value)


def _is_array(value: object) -> bool:
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "biuf"
    if value is None or isinstance(value, str | bytes | Mapping | set | frozenset):
        return False
    try:
        np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        return False
    return True


_TESTS: dict[Any, Callable[[Any], bool]] = {
    bool: lambda value: isinstance(value, bool | np.bool_),
    int: _is_count,
    Count: lambda value: _is_count(value) and operator.index(value) >= 1,
    float: _is_number,
    str: lambda value: _is_text(value) and value != "",
    Text: _is_text,
    Path: lambda value: isinstance(value, os.PathLike),
    ArrayLike: _is_array,
    NoneType: lambda value: value is None,
}
_WORDS: dict[Any, str] = {
    bool: "True or False",
    int: "a whole number from 0 on",
    Count: "a whole number, at least 1",
    float: "a number",
    str: "a text that is not empty",
    Path: "a path",
    ArrayLike: "an array of numbers",
    NoneType: "None",
}


def _words(kind: Any) -> str:  # noqa: ANN401
    """Return what a kind of values is called."""
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if kind in _WORDS:
        return _WORDS[kind]
    if origin in (Union, UnionType):
        words = list(dict.fromkeys(_words(one) for one in inner if one is not NoneType))
        some = words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"
        return f"{some}, or None" if NoneType in inner else some
    if origin is Annotated:
        return inner[1]
    if origin is Callable:
        return "a function"
    if origin is tuple and Ellipsis not in inner:
        return f"a tuple ({', '.join(map(_words, inner))})"
    if inspect.isclass(origin) and issubclass(origin, Mapping):
        return f"a dictionary by name (each {_words(inner[1])})"
    if inspect.isclass(origin) and issubclass(origin, Iterable):
        return f"a list (each {_words(inner[0])})"
    return getattr(kind, "_called", "") or f"a {getattr(kind, '__name__', kind)}"
