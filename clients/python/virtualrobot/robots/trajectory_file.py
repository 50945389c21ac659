"""Files of joint trajectories: CSV, as `virtualrobot plan --csv` and recordings write it, and JSON."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot.errors import InvalidArgumentError, MalformedFileError, MissingFileError

TIME = "time"
BESIDE = ("tick", "x", "y", "z", "tcp_speed")
"""Columns of our own files that are no joints; those of recordings with a slash are left out, too."""
FIELDS = ("joint_names", "times", "positions", "velocities", "accelerations", "interpolation")
RATES = ("velocities", "accelerations")
INTERPOLATIONS = ("smooth", "segments")

Rows = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Joints:
    """The robot that a file is read for.

    Attributes:
        robot: its name.
        names: the names of its coordinates.
        of_count: the names that so many values in order belong to; raises InvalidArgumentError where there are none.
    """

    robot: str
    names: Sequence[str]
    of_count: Callable[[int], Sequence[str]]


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Samples of a file.

    Attributes:
        joint_names: the joints, in the order of the columns.
        times: (n,), seconds from 0, strictly rising.
        positions: (n, k), radians or meters.
        velocities: (n, k), rad/s or m/s; None where the file tells none.
        accelerations: (n, k), rad/s^2 or m/s^2; None where the file tells none.
        interpolation: `smooth` or `segments`; None where the file tells none.
    """

    joint_names: Sequence[str]
    times: Rows
    positions: Rows
    velocities: Rows | None = None
    accelerations: Rows | None = None
    interpolation: str | None = None


def text_of(path: Path) -> str:
    """Return the text of a file; raise MissingFileError, or MalformedFileError for what is no UTF-8."""
    try:
        return path.read_text("utf-8-sig")
    except OSError as error:
        raise MissingFileError(f"{path} cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError as error:
        raise MalformedFileError(f"{path} is no text in UTF-8: {error.reason} at byte {error.start}") from None


def read(text: str, file: str, joints: Joints) -> Samples:
    """Return what a text says: JSON where it begins with a brace, else CSV.

    Raises MalformedFileError, with file, line and column, for what is no number, not finite, missing, no joint of the
    robot, or where times don't rise.
    """
    samples = (_Json(text, file) if text.lstrip().startswith("{") else _Csv(text, file)).samples(joints)
    if samples.interpolation != "segments":
        samples.times[:] -= samples.times[0]
    return samples


def _fault(file: str, line: int, column: int, what: str, words: str) -> MalformedFileError:
    place = f"{file}:{line}: column {column}{f' ({what})' if what else ''}"
    metadata = {"file": file, "line": str(line), "column": str(column), "path": what}
    return MalformedFileError(f"{place}: {words}", metadata=metadata)


def _unknown(name: str, joints: Joints) -> str:
    near = get_close_matches(name, joints.names, 1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    return f"{joints.robot!r} has no joint {name!r}{hint}; it has {', '.join(joints.names)}"


class _Csv:
    """A table: a column of times, and one for each joint; its first line names them, with units in brackets."""

    def __init__(self, text: str, file: str) -> None:
        """Read the cells; in tables with semicolons decimals may have a comma."""
        self._file = file
        first = text.lstrip().split("\n", 1)[0]
        self._mark = next((mark for mark in (";", "\t") if mark in first), ",")
        reader = csv.reader(io.StringIO(text, newline=""), delimiter=self._mark, skipinitialspace=True)
        try:
            self._lines = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
        except csv.Error as error:
            raise _fault(file, reader.line_num, 1, "", f"this is no CSV: {error}") from None

    def samples(self, joints: Joints) -> Samples:
        """Return what the table says."""
        if not self._lines:
            raise _fault(self._file, 1, 1, "", "the file is empty: a line of names belongs here, then the samples")
        line, head = self._lines[0]
        heads = [cell.strip() for cell in head]
        rows = self._lines
        if all(_is_number(cell) for cell in heads):
            names = self._unnamed(line, len(heads) - 1, joints)
            places, factors = list(range(1, len(heads))), [1.0] * len(names)
            heads, time = [TIME, *names], 0
        else:
            rows = rows[1:]
            time, names, places, factors = self._columns(line, heads, joints)
        if len(rows) < 2:
            raise _fault(self._file, line, 1, "", f"a trajectory has two samples or more, and here is {len(rows)}")
        table = np.array([[self._number(at, row, heads, place) for place in (time, *places)] for at, row in rows])
        for row in np.flatnonzero(np.diff(table[:, 0]) <= 0.0):
            (before, _), (at, _) = rows[row], rows[row + 1]
            words = f"{table[row + 1, 0]:g} s does not come after {table[row, 0]:g} s of line {before}; times rise"
            raise _fault(self._file, at, time + 1, heads[time], words)
        return Samples(names, table[:, 0], table[:, 1:] * factors)

    def _columns(self, line: int, heads: list[str], joints: Joints) -> tuple[int, list[str], list[int], list[float]]:
        """Return the place of the times, and the names, places and factors to SI of the joints."""
        time, found = -1, dict[str, tuple[int, float]]()
        for place, head in enumerate(heads):
            name, unit = re.fullmatch(r"(.*?)\s*(?:\[(.*)\])?", head, re.S).groups()  # pyright: ignore[reportOptionalMemberAccess] it matches all
            if name == TIME:
                time = place
                continue
            if name not in joints.names:
                name = name.removeprefix(f"{joints.robot}/").removesuffix("/position")
            if name not in joints.names:
                if name in BESIDE or "/" in name:
                    continue
                raise _fault(self._file, line, place + 1, head, _unknown(name, joints))
            if name in found:
                words = f"the joint {name!r} stands in column {found[name][0] + 1} already"
                raise _fault(self._file, line, place + 1, head, words)
            found[name] = place, self._factor(line, place, head, unit)
        if time < 0:
            raise _fault(self._file, line, 1, heads[0], f"no column is called {TIME!r}, the seconds of each sample")
        if not found:
            words = f"no column is a joint of {joints.robot!r}, which has {', '.join(joints.names)}"
            raise _fault(self._file, line, 1, heads[0], words)
        return time, list(found), [place for place, _ in found.values()], [factor for _, factor in found.values()]

    def _unnamed(self, line: int, count: int, joints: Joints) -> Sequence[str]:
        try:
            return joints.of_count(count)
        except InvalidArgumentError as error:
            words = f"no line names the columns, and these are a time and {count} joints: {error}"
            raise _fault(self._file, line, count + 1, "", words) from None

    def _factor(self, line: int, place: int, head: str, unit: str | None) -> float:
        factors = {None: 1.0, "": 1.0, "rad": 1.0, "m": 1.0, "deg": math.radians(1.0), "mm": 0.001}
        if unit not in factors:
            raise _fault(self._file, line, place + 1, head, f"the unit {unit!r} is none of rad, deg, m, mm")
        return factors[unit]

    def _number(self, line: int, row: list[str], heads: list[str], place: int) -> float:
        if len(row) != len(heads):
            words = f"here are {len(row)} columns, and the first line has {len(heads)}"
            raise _fault(self._file, line, min(len(row), len(heads)) + 1, "", words)
        cell = row[place].strip()
        if self._mark == ";":
            cell = cell.replace(",", ".")
        try:
            value = float(cell)
        except ValueError:
            words = f"{cell!r} is no number" if cell else "a number is missing"
            raise _fault(self._file, line, place + 1, heads[place], words) from None
        if not math.isfinite(value):
            raise _fault(self._file, line, place + 1, heads[place], f"{cell} is no finite number")
        return value


class _Json:
    """An object with `times` and `positions`, and perhaps other `FIELDS`, as the contract calls them."""

    def __init__(self, text: str, file: str) -> None:
        """Read it; raises MalformedFileError for what is no JSON."""
        self._text, self._file = text, file
        try:
            self._said: dict[str, Any] = json.loads(text)
        except json.JSONDecodeError as error:
            raise _fault(file, error.lineno, error.colno, "", f"this is no JSON: {error.msg}") from None
        except RecursionError:
            raise _fault(file, 1, 1, "", "this is no trajectory: lists stand too deep in each other") from None

    def samples(self, joints: Joints) -> Samples:
        """Return what the object says."""
        for name in self._said:
            if name not in FIELDS:
                near = get_close_matches(name, FIELDS, 1)
                hint = f"; did you mean {near[0]!r}?" if near else f"; fields are {', '.join(FIELDS)}"
                raise self._wrong(f"there is no field {name!r}{hint}", name)
        times = np.array([self._number(one, "times", row) for row, one in enumerate(self._list("times"))])
        interpolation = self._said.get("interpolation")
        if interpolation not in (None, *INTERPOLATIONS):
            names = " or ".join(map(repr, INTERPOLATIONS))
            raise self._wrong(f"{names} belongs here, not {interpolation!r:.40}", "interpolation")
        if len(times) < (fewest := 1 if interpolation == "segments" else 2):
            count = "a sample" if fewest == 1 else "two samples"
            raise self._wrong(f"a trajectory has {count} or more, and here is {len(times)}", "times")
        for row in np.flatnonzero(np.diff(times) <= 0.0):
            words = f"{times[row + 1]:g} s does not come after {times[row]:g} s; times rise"
            raise self._wrong(words, "times", int(row) + 1)
        names = self._names(joints)
        shape = len(times), len(names)
        velocities, accelerations = (self._table(one, *shape) if one in self._said else None for one in RATES)
        return Samples(names, times, self._table("positions", *shape), velocities, accelerations, interpolation)

    def _names(self, joints: Joints) -> Sequence[str]:
        if "joint_names" not in self._said:
            first = self._list("positions")[:1]
            count = len(first[0]) if first and isinstance(first[0], list) else 0
            try:
                return joints.of_count(count)
            except InvalidArgumentError as error:
                words = f"no 'joint_names' name the columns, and these are {count} joints: {error}"
                raise self._wrong(words, "positions") from None
        names = self._list("joint_names")
        for place, name in enumerate(names):
            if not isinstance(name, str) or name not in joints.names:
                raise self._wrong(_unknown(str(name), joints), "joint_names", place)
            if name in names[:place]:
                raise self._wrong(f"the joint {name!r} stands here twice", "joint_names", place)
        return names

    def _table(self, field: str, count: int, width: int) -> Rows:
        rows = self._list(field)
        if len(rows) != count:
            raise self._wrong(f"here are {len(rows)} rows, and there are {count} times", field)
        for row, values in enumerate(rows):
            if not isinstance(values, list) or len(values) != width:
                has = f"{len(values)} values" if isinstance(values, list) else f"{values!r:.40}"
                raise self._wrong(f"a row of {width} joints belongs here, not {has}", field, row)
        return np.array(
            [[self._number(one, field, row, at) for at, one in enumerate(rows[row])] for row in range(count)]
        )

    def _list(self, field: str) -> list[Any]:
        if field not in self._said:
            raise _fault(self._file, 1, 1, "", f"the field {field!r} is missing")
        value = self._said[field]
        if not isinstance(value, list):
            raise self._wrong(f"a list belongs here, not {value!r:.40}", field)
        return value

    def _number(self, value: object, *path: str | int) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._wrong(f"{value!r:.40} is no number", *path)
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self._wrong(f"{number} is no finite number", *path)
        return number

    def _wrong(self, words: str, *path: str | int) -> MalformedFileError:
        before = self._text[: _offset(self._text, path)]
        what = "".join(f"[{one}]" if isinstance(one, int) else one for one in path)
        return _fault(self._file, before.count("\n") + 1, len(before) - before.rfind("\n"), what, words)


def _offset(text: str, path: Sequence[str | int]) -> int:
    """Return where the value at a path of names and places begins in a text that is JSON."""
    decode, blank = json.JSONDecoder().raw_decode, re.compile(r"\s*")

    def after(at: int) -> int:
        found = blank.match(text, at)
        return found.end() if found else at

    at = after(0)
    for step in path:
        at = after(at + 1)
        for _ in range(step if isinstance(step, int) else len(text)):
            if isinstance(step, str):
                name, at = decode(text, at)
                at = after(after(at) + 1)
                if name == step:
                    break
            _, at = decode(text, at)
            at = after(after(at) + 1)
    return at


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True
