"""IDL types of the messages of ROS 2, its qualities of service, and listeners."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cyclonedds.core import Listener, Policy, Qos
from cyclonedds.idl import IdlStruct, make_idl_struct, types
from cyclonedds.util import duration

from virtualrobot_apps.bridges.ros.messages.types import ARRAY, BASE, MESSAGE, Description, fields, hash_of

_BLOCKING_MILLISECONDS = 100
_BASES: dict[str, Any] = {"bool": bool, "string": str, "wstring": str, "byte": types.byte, "char": types.uint8}
_BASES |= {
    name: getattr(types, name)
    for name in ("float32", "float64", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64")
}
_made: dict[tuple[str, bool, bool], Any] = {}


def idl_type(name: str, *, raw: bool = False, called: bool = False) -> Any:  # noqa: ANN401 made of a definition
    """Return the IDL type of a message, so that what discovery tells of it is true.

    A `raw` one is made from bytes and read as bytes: Cyclone's own coder, in Python, takes 50 ms for a picture.
    One that is `called`, a request or a response, begins with the header by which rmw_cyclonedds tells calls apart.
    """
    if (name, raw, called) not in _made:
        package, kind, base = name.split("/")
        members = {"guid": types.uint64, "seq": types.int64} if called else {}
        members |= {key: _member(one) for key, one in fields(name).items()}
        made = make_idl_struct(f"{base}_", f"{package}.{kind}.dds_.{base}_", members)
        if raw:
            _make_raw(made)
        _made[name, raw, called] = made
    return _made[name, raw, called]


def _make_raw(made: Any) -> None:  # noqa: ANN401
    def begin(self: IdlStruct, cdr: bytes) -> None:
        self.cdr = cdr  # pyright: ignore[reportAttributeAccessIssue]

    def message(kind: Any, data: bytes, *_: object, **__: object) -> Any:  # noqa: ANN401
        return kind(bytes(data))

    def end(kind: Any, *_: object, **__: object) -> Any:  # noqa: ANN401
        return kind(b"")  # the end of a writer tells a key alone, and is no message

    made.__init__ = begin
    made.serialize = lambda self, *_, **__: self.cdr
    made.deserialize, made.deserialize_key = classmethod(message), classmethod(end)


def _member(one: Description) -> Any:  # noqa: ANN401
    kind, detail = int(one[0]), one[1]
    if kind == BASE:
        return _BASES[detail[0]]
    if kind == MESSAGE:
        return idl_type(detail)
    inner = _member(detail[0])
    return types.array[inner, detail[1]] if kind == ARRAY else types.sequence[inner]


def quality(*, latched: bool, depth: int) -> Qos:
    """Return the quality of service of a topic: reliable, which all readers may read; latched: transient local."""
    durability = Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile
    reliability = Policy.Reliability.Reliable(duration(milliseconds=_BLOCKING_MILLISECONDS))
    return Qos(reliability, durability, Policy.History.KeepLast(depth))


def hashed(name: str) -> Qos:
    """Return the user data by which ROS 2 knows the hash of a type (REP 2016)."""
    return Qos(Policy.Userdata(f"typehash={hash_of(name)};".encode()))


class Matched(Listener):
    """Listener of a writer, called in a thread of Cyclone's with the count of readers."""

    def __init__(self, tell: Callable[[int], object]) -> None:
        """Tell what happens by `tell`."""
        super().__init__()
        self._tell = tell

    def on_publication_matched(self, writer: Any, status: Any) -> None:  # noqa: ANN401
        """Tell how many readers there are."""
        self._tell(status.current_count)


class Heard(Listener):
    """Listener of a reader, called in a thread of Cyclone's with the bytes of each message and its writer."""

    def __init__(self, tell: Callable[[bytes, int], object]) -> None:
        """Tell what happens by `tell`."""
        super().__init__()
        self._tell = tell

    def on_data_available(self, reader: Any) -> None:  # noqa: ANN401
        """Tell the messages that have come."""
        for one in reader.take(32):
            if cdr := getattr(one, "cdr", b""):
                self._tell(cdr, one.sample_info.publication_handle)
