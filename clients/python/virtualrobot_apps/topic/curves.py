"""Curves: numbers over time, from samples of streams or from a recorded file, chosen by names and subtracted."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError, UnknownNameError
from virtualrobot.streams.sample import Sample

Floats = NDArray[np.float64]

MINUS = " - "
"""Sign between two curves of which the difference is meant: spaces belong to it, since names may have hyphens."""

_PLACE = ("x", "y", "z")


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A number over time: times (n,) in s of simulation time, rising, and values (n,)."""

    name: str
    times: Floats
    values: Floats


def streams_of(wanted: Iterable[str]) -> list[str]:
    """Return the streams that curves are of, names or patterns, each once."""
    return list(dict.fromkeys(part.partition(":")[0].strip() for one in wanted for part in one.split(MINUS)))


def of_samples(samples: Iterable[Sample]) -> dict[str, Curve]:
    """Return the numbers of samples over time, as `STREAM:FIELD`; of streams with x and y the `speed` (m/s), too."""
    return of_numbers(
        ((f"{one.stream}:{field}", one.time, value) for one in samples for field, value in one.numbers().items()), ":"
    )


def of_numbers(numbers: Iterable[tuple[str, float, float]], sign: str) -> dict[str, Curve]:
    """Return curves of numbers (name, time, value) in order of time, with speeds.

    The last of a time counts; what is not finite, such as the distance of no echo, is left out.
    sign: what stands in names before `x`, `y`, `z` and `speed`.
    """
    rows: dict[str, tuple[list[float], list[float]]] = {}
    for name, time, value in numbers:
        if not math.isfinite(value):
            continue
        times, values = rows.setdefault(name, ([], []))
        if times and times[-1] == time:
            values[-1] = value  # a change between two ticks
        else:
            times.append(time)
            values.append(value)
    return _with_speeds({name: Curve(name, np.array(times), np.array(of)) for name, (times, of) in rows.items()}, sign)


def _with_speeds(curves: Mapping[str, Curve], sign: str) -> dict[str, Curve]:
    """Return curves and, where x and y of something are among them, its speed (m/s) from one sample to the next."""
    found = dict(curves)
    for name, x in curves.items():
        whole, _, field = name.rpartition(sign)
        parts = [curves.get(f"{whole}{sign}{axis}") for axis in _PLACE]
        places = [one.values for one in parts if one is not None and len(one.times) == len(x.times)]
        if field == "x" and len(places) > 1 and len(x.times) > 1:
            way = np.linalg.norm(np.diff(np.column_stack(places), axis=0), axis=1)
            speed = f"{whole}{sign}speed"
            found[speed] = Curve(speed, x.times[1:], way / np.diff(x.times))
    return found


def chosen(curves: Mapping[str, Curve], wanted: Iterable[str]) -> list[Curve]:
    """Return the curves that names or patterns choose; `A - B` is the difference, B as it is at the times of A.

    A stream's name alone means all of its numbers but its speed.

    Raises:
        UnknownNameError: for what chooses none.
        InvalidArgumentError: for a difference of two that are not one curve each, or never at the same time.
    """
    found: dict[str, Curve] = {}
    for pattern in wanted:
        first, minus, second = pattern.partition(MINUS)
        if minus:
            one = _difference(_matching(curves, first.strip()), _matching(curves, second.strip()), pattern)
            found[one.name] = one
        else:
            found |= {one.name: one for one in _matching(curves, pattern)}
    return list(found.values())


def _matching(curves: Mapping[str, Curve], pattern: str) -> list[Curve]:
    names = [name for name in curves if fnmatchcase(name, pattern)]
    if not names:
        names = [name for name in curves if fnmatchcase(name, f"{pattern}:*") and not name.endswith(":speed")]
    if not names:
        some = ", ".join(sorted(curves)[:8]) or "nothing"
        raise UnknownNameError(f"no number is called {pattern!r}; there is {some}{', ...' * (len(curves) > 8)}")
    return [curves[name] for name in names]


def _difference(first: list[Curve], second: list[Curve], name: str) -> Curve:
    if len(first) != 1 or len(second) != 1:
        raise InvalidArgumentError(
            f"{name!r} is to be the difference of two curves, not of {len(first)} and {len(second)}"
        )
    a, b = first[0], second[0]
    both = (a.times >= b.times[0]) & (a.times <= b.times[-1])
    if not both.any():
        raise InvalidArgumentError(f"the two curves of {name!r} are never at the same time")
    times = a.times[both]
    return Curve(name, times, a.values[both] - np.interp(times, b.times, b.values))


def trails(curves: Mapping[str, Curve], wanted: Sequence[str]) -> dict[str, Floats]:
    """Return the ways (n, 2) in x and y of all that patterns choose which has both, by its name.

    Raises UnknownNameError when nothing of it has.
    """
    found: dict[str, Floats] = {}
    for pattern in wanted:
        for name, x in curves.items():
            whole = re.sub(r"[:/]x$", "", name)
            y = curves.get(f"{name[:-1]}y") if whole != name else None
            if y is not None and fnmatchcase(whole, pattern) and len(x.times) == len(y.times):
                found[whole] = np.column_stack([x.values, y.values])
    if not found:
        raise UnknownNameError(f"nothing of {', '.join(wanted)} has x and y; poses of nodes, robots and crafts have")
    return found


def together(curves: Iterable[Curve]) -> tuple[Floats, Floats]:
    """Return all times of some curves from 0 (n,), and the values of each at them (n, k), held from before."""
    curves = list(curves)
    times = np.unique(np.concatenate([one.times for one in curves]))
    columns = []
    for one in curves:
        places = np.clip(np.searchsorted(one.times, times, side="right") - 1, 0, None)
        columns.append(one.values[places])
    return times - times[0], np.column_stack(columns)
