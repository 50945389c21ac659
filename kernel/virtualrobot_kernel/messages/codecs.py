"""Codecs of fields: what a message has to what a value has, and back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Generic, Protocol, TypeVar

from google.protobuf.message import Message

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.structs import settings, settings_message
from virtualrobot_kernel.messages.values import (
    array,
    array_message,
    by_name,
    color,
    color_message,
    finite,
    not_negative,
    pose,
    pose_message,
    positive,
    vector,
    vector_message,
)

E = TypeVar("E", bound=Enum)


class Codec(Protocol):
    """Conversion of a field, or of each entry of a repeated one; tables of fields and of enums are codecs, too."""

    def read(self, given: Any, what: str, /) -> Any:  # noqa: ANN401  what a message has, and what a value has
        """Return a value; raise KernelError, which names the field `what`, where it is none."""
        ...

    def write(self, value: Any, /) -> Any:  # noqa: ANN401
        """Return what the message has for a value."""
        ...


@dataclass(frozen=True, slots=True)
class Pair:
    """Codec of two functions; `whole` takes a repeated field as one instead of each of its entries."""

    read: Callable[[Any, str], Any]
    write: Callable[[Any], Any]
    whole: bool = False


@dataclass(frozen=True, slots=True)
class OrDefault:
    """Codec of a number whose 0 stands for the default of the value's class."""

    codec: Codec


def same(value: Any) -> Any:  # noqa: ANN401
    """Return a value as it is."""
    return value


PLAIN = Pair(lambda given, what: given, same)
FINITE = Pair(finite, same)
POSITIVE = Pair(positive, same)
NOT_NEGATIVE = Pair(not_negative, same)
VECTOR = Pair(vector, vector_message)
POSE = Pair(pose, pose_message)
COLOR = Pair(color, color_message)
SETTINGS = Pair(settings, settings_message)
BY_NAME = Pair(by_name, same, whole=True)
NUMBERS = Pair(lambda given, what: tuple(given), lambda values: values.tolist(), whole=True)
"""Codec of a repeated number that is an array (n,)."""


def rows(*shape: int | None) -> Pair:
    """Return the codec of a float64 array of this shape."""
    return Pair(lambda given, what: array(given, shape, what), array_message)


def named(message: type[Message], value: str, codec: Codec = FINITE, key: str = "name") -> Pair:
    """Return the codec of a list of messages that is a mapping: from the field `key` to the field `value`.

    Names must differ, and none may be empty.
    """

    def read(given: Sequence[Any], what: str) -> dict[str, Any]:
        _check_names([getattr(one, key) for one in given], what)
        return {
            getattr(one, key): codec.read(getattr(one, value), f"{what}[{place}].{value}")
            for place, one in enumerate(given)
        }

    def write(values: Mapping[str, Any]) -> list[Message]:
        return [message(**{key: name, value: codec.write(one)}) for name, one in values.items()]

    return Pair(read, write, whole=True)


def distinct(codec: Codec) -> Pair:
    """Return the codec of a list of messages whose names must differ, and none may be empty."""

    def read(given: Sequence[Any], what: str) -> tuple:
        _check_names([one.name for one in given], what)
        return tuple(codec.read(one, f"{what}[{place}]") for place, one in enumerate(given))

    return Pair(read, lambda values: [codec.write(one) for one in values], whole=True)


def _check_names(names: Sequence[str], what: str) -> None:
    for place, name in enumerate(names):
        if not name:
            raise KernelError(f"{what}[{place}] has no name; give one", field=f"{what}[{place}]")
        if name in names[:place]:
            raise KernelError(f"{what}[{place}] names {name!r} again", field=f"{what}[{place}]", name=name)


class EnumTable(Generic[E]):
    """Members of an enum and the contract's numbers for them, by their names."""

    def __init__(self, members: type[E], contract: Any, unspecified: E | None = None) -> None:  # noqa: ANN401 a wrapper
        """Match `members` with the enum `contract`; its UNSPECIFIED stands for the member `unspecified`."""
        prefix = contract.Name(0).removesuffix("UNSPECIFIED")
        self._numbers = {member: contract.Value(prefix + member.name) for member in members}
        self._members = {number: member for member, number in self._numbers.items()}
        self._valid = ", ".join(contract.Name(number) for number in sorted(self._members))
        if unspecified is not None:
            self._members[0] = unspecified

    def read(self, given: int, what: str) -> E:
        """Return a member; raise KernelError, which names the field `what`, for a number that has no meaning."""
        member = self._members.get(given)
        if member is None:
            raise KernelError(
                f"{what} is {given}, which has no meaning; give one of {self._valid}", field=what, value=given
            )
        return member

    def write(self, value: E) -> Any:  # noqa: ANN401  the number, of the contract's own type
        """Return the number of a member."""
        return self._numbers[value]
