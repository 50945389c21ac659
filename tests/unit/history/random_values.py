"""Random values of any class that the codec writes, drawn by its annotations; bits as strange as floats have them."""

from __future__ import annotations

import dataclasses
import inspect
import struct
import types
import typing
from collections.abc import Mapping
from enum import Enum
from typing import Any

import numpy as np
from virtualrobot_kernel.history import classes
from virtualrobot_kernel.history.extensions import DTYPES
from virtualrobot_kernel.motion.limits import CartesianLimits, JointLimits
from virtualrobot_kernel.motion.planned import Plan, Track
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.program import Program, Stage
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.figures import Box

NAN = struct.unpack("<d", struct.pack("<Q", 0x7FF8_0000_DEAD_BEEF))[0]
FLOATS = (0.0, -0.0, 1.5, -1e308, 5e-324, float("inf"), float("-inf"), NAN)
WORDS = ("", "arm", "ä\u2028 'quoted'", "x" * 300, "\x00")
DEEPEST = 4


class RandomValues:
    """Values drawn from a generator; what is deep is drawn empty where it may be."""

    def __init__(self, rng: np.random.Generator) -> None:
        """Draw from a generator."""
        self._rng = rng

    def of(self, hint: Any, deep: int = 0) -> Any:  # noqa: ANN401
        """Return a value with an annotation."""
        rng = self._rng
        origin, args = typing.get_origin(hint), typing.get_args(hint)
        if hint is None or hint is type(None):
            return None
        if origin is np.ndarray:
            return self.array(np.dtype(typing.get_args(args[1])[0]))
        if origin in (types.UnionType, typing.Union):
            if deep > DEEPEST and type(None) in args:
                return None
            return self.of(args[rng.integers(len(args))], deep + 1)
        if origin in (tuple, list, frozenset) and (origin is not tuple or args[1:] == (...,)):
            return origin([self.of(args[0], deep + 1) for _ in range(self._count(deep))])
        if origin is tuple:
            return tuple(self.of(one, deep) for one in args)
        if origin is not None and issubclass(origin, Mapping):
            keys = [self.of(args[0], deep + 1) for _ in range(self._count(deep))]
            return {key: self.of(args[1], deep + 1) for key in keys}
        if hint is float:
            return FLOATS[rng.integers(len(FLOATS))] if rng.random() < 0.7 else np.float64(rng.normal())
        if hint is int:
            return int(rng.integers(-(2**63), 2**63 - 1)) >> int(rng.integers(63))
        if hint is bool:
            return bool(rng.integers(2))
        if hint is str:
            return WORDS[rng.integers(len(WORDS))]
        if hint is bytes:
            return rng.bytes(int(rng.integers(40)))
        if hint is types.EllipsisType:
            return ...
        if hint in (Any, object):
            return self.anything(deep)
        if getattr(hint, "_is_protocol", False):
            return self.of(classes.RUNNING[rng.integers(len(classes.RUNNING))], deep + 1)
        assert inspect.isclass(hint), hint
        if issubclass(hint, Enum):
            return [*hint][rng.integers(len(hint))]
        return self._made(hint, deep)

    def anything(self, deep: int) -> Any:  # noqa: ANN401
        """Return a value where nothing says what it is."""
        hints = (None, bool, int, float, str, bytes, Box, classes.AwaitedPart, DTYPES)
        inner = (tuple[Any, ...], list[Any], frozenset[str], Mapping[str, Any], types.EllipsisType, Command)
        several = hints if deep > DEEPEST else (*hints, *inner)
        hint = several[self._rng.integers(len(several))]
        if hint is DTYPES:
            dtype = DTYPES[self._rng.integers(len(DTYPES))]
            return self.array(dtype) if self._rng.integers(2) else np.frombuffer(bytes(dtype.itemsize), dtype)[0]
        return self.of(hint, deep + 1)

    def array(self, dtype: np.dtype[Any]) -> np.ndarray:
        """Return an array of any shape, order and content; a view of every other row, too."""
        rng = self._rng
        shape = tuple(int(rng.integers(4)) for _ in range(rng.integers(4)))
        count = int(np.prod(shape)) * dtype.itemsize
        content = bytes(count) if dtype.kind == "b" else rng.bytes(count)  # a bool is 0 or 1
        array = np.frombuffer(content, dtype).reshape(shape).copy("F" if rng.integers(2) else "C")
        if array.ndim and rng.integers(3) == 0:
            array = array[::2]
        array.setflags(write=bool(rng.integers(2)))
        return array

    def _count(self, deep: int) -> int:
        return 0 if deep > DEEPEST else int(self._rng.integers(3))

    def _made(self, cls: type, deep: int) -> Any:  # noqa: ANN401
        made = CHECKED.get(cls)
        if made is not None:
            return made(self, deep)
        hints = typing.get_type_hints(cls)
        if dataclasses.is_dataclass(cls):
            names = [field.name for field in dataclasses.fields(cls) if field.init]
        else:
            names = cls._fields  # pyright: ignore[reportAttributeAccessIssue]
        return cls(**{name: self.of(hints[name], deep + 1) for name in names})

    def _function(self, columns: int) -> PiecewisePolynomial:
        pieces = int(self._rng.integers(1, 4))
        coefficients = self._rng.normal(size=(pieces, 4, columns))
        return PiecewisePolynomial(np.linspace(0.0, 1.0, pieces + 1), coefficients)

    def _plan(self, _: int) -> Plan:
        count = int(self._rng.integers(1, 4))
        track = Track(self._function(count), self._function(1), None, self._function(count))
        names = tuple(f"joint{number}" for number in range(count))
        return Plan("ptp", names, (track,), *(self._rng.normal(size=count) for _ in range(5)))

    def _program(self, deep: int) -> Program:
        plan = self._plan(deep)
        stages = (Stage(plan, tuple(range(plan.q_count)), ((0.0, 0),)), self.of(Stage, DEEPEST))
        one = dataclasses.replace(stages[1], plan=None, columns=())
        return Program((stages[0], one, stages[0]), plan.start, 3, bool(self._rng.integers(2)), -0.0, (("arm", 0.5),))

    def _limits(self, _: int) -> JointLimits:
        low = np.array([-np.inf, -0.0])
        return JointLimits(("a", "b"), low, low + 1.0, *(np.ones(2) for _ in range(3)), sliding=frozenset({"a", "b"}))


CHECKED = {
    PiecewisePolynomial: lambda values, _: values._function(2),
    Plan: RandomValues._plan,
    Program: RandomValues._program,
    JointLimits: RandomValues._limits,
    CartesianLimits: lambda values, _: CartesianLimits(*values._rng.uniform(0.1, 5.0, 6).tolist()),
}
"""Classes that refuse what is impossible: their values are drawn so that it is not."""
