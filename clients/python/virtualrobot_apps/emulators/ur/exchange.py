"""Real-Time Data Exchange (RTDE), protocol 2: what one client is told and sets.

A packet is its length (two bytes, with the three of its head), its kind, and a body
(Universal Robots, "Real-Time Data Exchange (RTDE) Guide").
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import isfinite

from virtualrobot_apps.emulators.ur import values

_HEAD = struct.Struct(">HB")
VERSION, CONTROLLER_VERSION, TEXT = ord("V"), ord("v"), ord("M")
DATA, OUTPUTS, INPUTS, START, PAUSE = ord("U"), ord("O"), ord("I"), ord("S"), ord("P")


class NotFinite(ValueError):
    """A number that is none, or infinite."""


@dataclass(frozen=True, slots=True)
class Recipe:
    """Variables that come together."""

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    form: struct.Struct

    def read(self, data: bytes) -> dict[str, object]:
        """Return values by name: the first that are whole, since ur-rtde sends more than its recipe for one command.

        Raises NotFinite, but for registers: a script's are its own to judge.
        """
        if len(data) == self.form.size:
            found = values.unpack(self.names, self.kinds, self.form, data)
        else:
            count, form = 0, values.layout(())
            while count < len(self.kinds) and (longer := values.layout(self.kinds[: count + 1])).size <= len(data):
                count, form = count + 1, longer
            found = values.unpack(self.names[:count], self.kinds[:count], form, data[: form.size])
        for name, value in found.items():
            if name.startswith("input_double_register_"):
                continue
            for one in value if isinstance(value, tuple) else (value,):
                if isinstance(one, float) and not isfinite(one):
                    raise NotFinite(f"{name} is a finite number, not {one}")
        return found


def packet(kind: int, body: bytes) -> bytes:
    """Return the bytes of a packet."""
    return _HEAD.pack(_HEAD.size + len(body), kind) + body


def packets(data: bytearray) -> Iterator[tuple[int, bytes]]:
    """Take whole packets off the front of `data`; raises ValueError where it is no packet."""
    while len(data) >= _HEAD.size:
        size, kind = _HEAD.unpack_from(data)
        if size < _HEAD.size:
            raise ValueError(f"a packet of {size} bytes")
        if len(data) < size:
            return
        body = bytes(data[_HEAD.size : size])
        del data[:size]
        yield kind, body


class Session:
    """One client: its recipes, and at how many cycles it is told."""

    def __init__(self, rate: float, version: tuple[int, int, int, int], taken: set[str]) -> None:
        """Know the controller's rate (Hz) and version; `taken` are inputs that have an owner, of all clients."""
        self._rate, self._version, self._taken = rate, version, taken
        self._own: set[str] = set()
        self._outputs: Recipe | None = None
        self._inputs: dict[int, Recipe] = {}
        self._every, self._cycle, self.started = 1, 0, False
        self.set: dict[str, object] = {}
        """Inputs that the client has set since they were last taken."""

    def take(self, kind: int, body: bytes) -> bytes:
        """Return the answer to a packet, empty where it has none."""
        if kind == VERSION:
            return packet(kind, bytes((int(body == b"\0\2"),)))
        if kind == CONTROLLER_VERSION:
            return packet(kind, struct.pack(">4I", *self._version))
        if kind == OUTPUTS:
            frequency = struct.unpack_from(">d", body)[0]
            self._every = max(1, round(self._rate / min(max(frequency, 1.0), self._rate)))
            recipe, kinds = self._recipe(body[8:], inputs=False)
            self._outputs = recipe
            return packet(kind, bytes((recipe is not None,)) + kinds)
        if kind == INPUTS:
            recipe, kinds = self._recipe(body, inputs=True)
            number = len(self._inputs) + 1 if recipe is not None else 0
            if recipe is not None:
                self._inputs[number] = recipe
                self._own.update(recipe.names)
                self._taken.update(recipe.names)
            return packet(kind, bytes((number,)) + kinds)
        if kind == START:
            self.started = self._outputs is not None
            return packet(kind, bytes((self.started,)))
        if kind == PAUSE:
            self.started = False
            return packet(kind, b"\1")
        if kind == DATA and body and body[0] in self._inputs:
            recipe = self._inputs[body[0]]
            self.set.update(recipe.read(body[1:]))
        return b""

    def _recipe(self, text: bytes, inputs: bool) -> tuple[Recipe | None, bytes]:
        names = tuple(name for name in text.decode(errors="replace").split(",") if name)
        kinds = [values.type_of(name, inputs) for name in names]
        if inputs:
            kinds = [
                "IN_USE" if name in self._taken - self._own else kind for name, kind in zip(names, kinds, strict=True)
            ]
        said = ",".join(kinds).encode()
        if not names or not set(kinds).isdisjoint({"NOT_FOUND", "IN_USE"}):
            return None, said
        return Recipe(names, tuple(kinds), values.layout(kinds)), said

    def due(self) -> bool:
        """Return whether the client is told something in this cycle; called once in each."""
        self._cycle += 1
        return self.started and self._cycle % self._every == 0

    def tell(self, told: Mapping[str, object]) -> bytes:
        """Return the packet of what is told."""
        recipe = self._outputs
        assert recipe is not None
        return packet(DATA, b"\1" + values.pack(recipe.names, recipe.kinds, recipe.form, told))

    def close(self) -> None:
        """Give inputs back."""
        self._taken -= self._own
