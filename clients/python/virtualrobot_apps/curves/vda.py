"""VDA-FS, the surface interface of the German car makers, version 2.0: its curves.

Sources: the example of a curve in DIN 66301, which OpenVDAFS has as `examples/CURVE_SP1.vda`, and its reader of the
format (MIT); COVISE's reader (`ReadVDAFS`, R. Beller, Stuttgart 1997), by which circles are in degrees. The standard
itself was not read.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.curves.curve import Curve, Floats, arc, polyline, polynomial

MILLIMETERS = 1e-3
"""Length (m) of the unit of VDA-FS."""
COLUMNS = 72
"""Columns of a line that are read; the others number it."""
MOST_ORDER = 26
"""Most coefficients of a polynomial."""
OTHERS = frozenset(("BEGINSET", "ENDSET", "CONS", "FACE", "GROUP", "POINT", "SURF", "TOP", "TMAT"))
"""Elements that hold no curve of their own."""

_ELEMENT = re.compile(r"\s*([A-Z]\w*)\s*=\s*([A-Z]+)\s*(?:/(.*))?", re.IGNORECASE)


@dataclass(slots=True)
class _Element:
    """Element: its line in the file, name, kind and what is written after the stroke."""

    line: int
    name: str
    kind: str
    text: str


def read(text: str, file: str) -> list[Curve]:
    """Return the curves of a file in VDA-FS, in meters and in its order: CURVE, CIRCLE, PSET and MDI.

    Raises InvalidArgumentError with the line of what is no VDA-FS, of an element that is not known, of a number that is
    none and of too many or few of them, and for a file that moves its elements by TLIST.
    """
    found: list[Curve] = []
    for element in _elements(text, file):
        try:
            if element.kind in _READERS:
                found.append(_READERS[element.kind](element.name, _Numbers(element.text)))
            elif element.kind == "TLIST":
                raise _Wrong("moves elements by matrices, which is not read; export the file with all in one frame")
            elif element.kind not in OTHERS:
                known = ", ".join(sorted((*_READERS, *OTHERS)))
                raise _Wrong(f"is no element of VDA-FS, which has {known}")
        except _Wrong as error:
            where = f"{file}:{element.line}: {element.name} = {element.kind}"
            raise InvalidArgumentError(f"{where} {error}") from None
    return found


class _Wrong(Exception):
    """Fault of an element."""


class _Numbers:
    """Numbers after the stroke, from the first to the last."""

    def __init__(self, text: str) -> None:
        fields = [one.strip() for one in text.rstrip().rstrip(",").split(",")]
        for place, field in enumerate(fields):
            if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([EeDd][+-]?\d+)?", field):
                raise _Wrong(f"has {field!r} as number {place + 1}, which is none")
        self._values = np.array([float(one.upper().replace("D", "E")) for one in fields])
        self._next = 0

    def take(self, count: int, what: str) -> Floats:
        """Return the next numbers."""
        values = self._values[self._next : self._next + count]
        if len(values) < count:
            raise _Wrong(f"ends in {what}: it has {len(self._values)} numbers, and needs {self._next + count}")
        if not np.isfinite(values).all():
            raise _Wrong(f"has a number in {what} that is too great")
        self._next += count
        return values

    def count(self, what: str, least: int, most: int) -> int:
        """Return the next number, a whole one."""
        (value,) = self.take(1, what)
        if value != int(value) or not least <= value <= most:
            raise _Wrong(f"has {value:g} {what}; there are {least} to {most}")
        return int(value)

    def end(self) -> None:
        """Raise _Wrong where more numbers follow."""
        if self._next < len(self._values):
            raise _Wrong(f"has {len(self._values)} numbers; it needs {self._next}")


def _elements(text: str, file: str) -> Iterator[_Element]:
    """Yield the elements of a file up to its END; one goes on until the line that begins the next."""
    lines = text.splitlines()
    current: _Element | None = None
    header, ended, at = False, False, 0
    while at < len(lines):
        line = lines[at][:COLUMNS]
        at += 1
        if not line.strip() or line.lstrip().startswith("$$"):
            continue
        match = _ELEMENT.fullmatch(line.rstrip())
        if line.strip().upper() == "END":
            ended = True
            break
        if match is None:
            if current is None:
                raise InvalidArgumentError(
                    f"{file}:{at}: {line.strip()[:40]!r} is no element of VDA-FS; one is as C1 = CURVE / 1, 0, 1, ..."
                )
            current.text += line
            continue
        if current is not None:
            yield current
            current = None
        name, kind, rest = match[1].upper(), match[2].upper(), match[3] or ""
        if kind == "HEADER":
            header = True
            count = rest.strip()
            if not count.isdigit():
                raise InvalidArgumentError(f"{file}:{at}: a header tells how many lines it has, not {count!r}")
            at += int(count)
        elif kind == "END":
            ended = True
            break
        else:
            current = _Element(at, name, kind, rest)
    if current is not None:
        yield current
    if not header:
        raise InvalidArgumentError(f"{file} is no VDA-FS: it has no header, as PART = HEADER / 20")
    if not ended:
        raise InvalidArgumentError(f"{file} is cut off: it does not end with an END, as PART = END")


def _curve(name: str, numbers: _Numbers) -> Curve:
    """Return a CURVE: n pieces, their n + 1 parameters, and of each the order and coefficients of x, y and z."""
    count = numbers.count("pieces", 1, 100_000)
    parameters = numbers.take(count + 1, "the parameters of its pieces")
    if (np.diff(parameters) <= 0.0).any():
        raise _Wrong(f"has parameters that do not grow: {parameters.tolist()}")
    pieces = []
    for number in range(1, count + 1):
        order = numbers.count(f"coefficients in piece {number}", 1, MOST_ORDER)
        rows = numbers.take(3 * order, f"the coefficients of piece {number}").reshape(3, order)
        pieces.append(polynomial(rows.T * MILLIMETERS))
    numbers.end()
    return Curve(name, tuple(pieces))


def _circle(name: str, numbers: _Numbers) -> Curve:
    """Return a CIRCLE: centre, radius, the vectors to 0 and 90 degrees, and the angles of both ends in degrees."""
    center, radius = numbers.take(3, "its centre") * MILLIMETERS, float(numbers.take(1, "its radius")[0]) * MILLIMETERS
    axes = numbers.take(6, "its axes").reshape(2, 3)
    begin, end = np.radians(numbers.take(2, "its angles"))
    numbers.end()
    if radius <= 0.0:
        raise _Wrong(f"has a radius of {radius / MILLIMETERS:g} mm; it must be above 0")
    if not np.allclose(axes @ axes.T, np.eye(2), atol=1e-3):
        raise _Wrong(f"has axes that are not of length 1 and at a right angle: {axes.tolist()}")
    if not 0.0 < abs(end - begin) <= 2.0 * np.pi + 1e-9:
        raise _Wrong(f"goes from {np.degrees(begin):g} to {np.degrees(end):g} degrees; that is at most one turn")
    return Curve(name, arc(center, radius * axes[0], radius * axes[1], float(begin), float(end)))


def _point_set(name: str, numbers: _Numbers) -> Curve:
    """Return a PSET: points that straight lines join."""
    count = numbers.count("points", 2, 1_000_000)
    points = numbers.take(3 * count, "its points").reshape(count, 3)
    numbers.end()
    return Curve(name, polyline(points * MILLIMETERS))


def _point_vector_set(name: str, numbers: _Numbers) -> Curve:
    """Return an MDI: points, each with the surface's normal there."""
    count = numbers.count("points", 2, 1_000_000)
    rows = numbers.take(6 * count, "its points and vectors").reshape(count, 6)
    numbers.end()
    sizes = np.linalg.norm(rows[:, 3:], axis=1)
    if not sizes.all():
        raise _Wrong(f"has a vector without length at point {int(sizes.argmin()) + 1}")
    return Curve(name, polyline(rows[:, :3] * MILLIMETERS), rows[:, 3:] / sizes[:, None])


_READERS = {"CURVE": _curve, "CIRCLE": _circle, "PSET": _point_set, "MDI": _point_vector_set}
