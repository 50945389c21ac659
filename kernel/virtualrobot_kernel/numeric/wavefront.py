"""Wavefront OBJ files: from bytes to arrays in two passes, compiled.

The format is that of appendix B1 of the manual of Wavefront's "The Advanced Visualizer", as far as most files use it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int32, njit, uint8
from virtualrobot_sdk.compiled.cache import array_of, compiled, inlined

Bytes = np.ndarray[Any, np.dtype[np.uint8]]
Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int32]]
Places = np.ndarray[Any, np.dtype[np.int64]]

_TAB, _NEWLINE, _RETURN, _SPACE, _PLUS, _MINUS, _POINT, _SLASH, _ZERO = 9, 10, 13, 32, 43, 45, 46, 47, 48
_BACKSLASH, _LARGE_E, _E, _F, _N, _S, _T, _U, _V = 92, 69, 101, 102, 110, 115, 116, 117, 118

_in_place = njit(inline="always")
"""Puts a function's body in place of each call: to hand over text costs more than to look at a few letters of it."""

MOST_DIGITS = 10**17
"""Digits of a number that would make it greater than ten times this are told by its exponent alone."""

POWERS = 10.0 ** np.arange(23)
"""Powers of ten that are doubles."""

NONE = -1
"""Row of the texture coordinates or of the normal of a corner that has none."""


@_in_place
def _blank(text: Bytes, at: int) -> int:
    """Return where the spaces that begin at a place end."""
    while at < text.shape[0] and (text[at] == _SPACE or text[at] == _TAB):
        at += 1
    return at


@inlined
def _digits(text: Bytes, at: int, value: int, exponent: int, step: int) -> tuple[int, int, int]:
    """Return value and exponent with the digits that begin at a place, and where they end.

    Digits that have room move the exponent by `step`: 0 before the point, -1 behind it; others by one more.
    """
    while at < text.shape[0] and _ZERO <= text[at] < _ZERO + 10:
        if value < MOST_DIGITS:
            value = 10 * value + (text[at] - _ZERO)
            exponent += step
        else:
            exponent += step + 1
        at += 1
    return value, exponent, at


@_in_place
def _number(text: Bytes, at: int) -> tuple[float, int]:
    """Return the number behind spaces, and where it ends; -1 where there is none. Behind the text there is a zero."""
    letter = np.int64(text[at])
    while letter == _SPACE or letter == _TAB:
        at += 1
        letter = np.int64(text[at])
    negative = letter == _MINUS
    if negative or letter == _PLUS:
        at += 1
        letter = np.int64(text[at])
    value, exponent, point = 0, 0, 0
    begin = at
    while _ZERO <= letter < _ZERO + 10:
        if value < MOST_DIGITS:
            value = 10 * value + (letter - _ZERO)
        else:
            exponent += 1
        at += 1
        letter = np.int64(text[at])
    if letter == _POINT:
        point = 1
        at += 1
        letter = np.int64(text[at])
        while _ZERO <= letter < _ZERO + 10:
            if value < MOST_DIGITS:
                value = 10 * value + (letter - _ZERO)
                exponent -= 1
            at += 1
            letter = np.int64(text[at])
    end = at
    if at - begin == point:
        end = -1
    if letter == _E or letter == _LARGE_E:
        at += 1
        lower = text[at] == _MINUS
        if lower or text[at] == _PLUS:
            at += 1
        begin = at
        power, _, at = _digits(text, at, 0, 0, 0)
        if at == begin or at - begin > 3:
            end = -1
        exponent += -power if lower else power
        if end >= 0:
            end = at
        letter = np.int64(text[at])
    if letter > _SPACE:
        end = -1
    # Both are exact, and their quotient or product the nearest double, up to 15 digits and a power of 22.
    size = float(value)
    if -POWERS.shape[0] < exponent < POWERS.shape[0]:
        result = size / POWERS[-exponent] if exponent < 0 else size * POWERS[exponent]
    else:
        result = size / 10.0**-exponent if exponent < 0 else size * 10.0**exponent
    return -result if negative else result, end


@inlined
def _row(text: Bytes, at: int, row: Floats, least: int) -> int:
    """Read a row of numbers, at least so many of it, up to the end of the line; return where it ends, -1 for others."""
    for i in range(row.shape[0]):
        value, end = _number(text, at)
        if end < 0:
            return _blank(text, at) if i >= least else -1
        row[i], at = value, end
    return _blank(text, at)


@_in_place
def _index(text: Bytes, at: int, most: int) -> tuple[int, int]:
    """Return the row, from 0, that a number from 1 on names, and where it ends; -1 where there is none up to `most`."""
    value = 0
    digit = text[at] - _ZERO
    while 0 <= digit < 10 and value <= most:
        value = 10 * value + digit
        at += 1
        digit = text[at] - _ZERO
    if not 1 <= value <= most:
        return NONE, -1
    return value - 1, at


@_in_place
def _corner(text: Bytes, at: int, most: Places, corner: Integers) -> int:
    """Read rows of a corner's vertex, uv and normal (1, 1/1, 1//1 or 1/1/1); return where it ends, -1 for no corner."""
    corner[0], at = _index(text, at, most[0])
    corner[1], corner[2] = NONE, NONE
    if not 0 <= at < text.shape[0] or text[at] != _SLASH:
        return at
    at += 1
    if at < text.shape[0] and text[at] != _SLASH:
        corner[1], at = _index(text, at, most[1])
    if 0 <= at < text.shape[0] and text[at] == _SLASH:
        corner[2], at = _index(text, at + 1, most[2])
    return at


@inlined
def _line_end(text: Bytes, at: int) -> int:
    """Return where the next line begins."""
    while at < text.shape[0] and text[at] != _NEWLINE:
        at += 1
    return at + 1


@inlined
def _is(text: Bytes, at: int, first: int, second: int) -> bool:
    """Tell whether two bytes stand at a place."""
    return at + 1 < text.shape[0] and text[at] == first and text[at + 1] == second


@inlined
def _words(text: Bytes, at: int) -> tuple[int, int]:
    """Return how many words the rest of a line has, and where the next line begins."""
    count, inside = 0, False
    while at < text.shape[0] and text[at] != _NEWLINE:
        count += text[at] > _SPACE and not inside
        inside = text[at] > _SPACE
        at += 1
    return count, at + 1


@inlined
def _face(text: Bytes, at: int, most: Places, corners: Integers, first: int) -> tuple[int, int]:
    """Read a face as a fan of triangles, to corners[first] and on; return their end, and where the line ends or -1."""
    end = first
    at = _blank(text, at)
    while at < text.shape[0] and text[at] > _SPACE:
        if end - first >= 3:  # a triangle of the first corner, the last one, and this one
            for k in range(3):
                corners[end, k], corners[end + 1, k] = corners[first, k], corners[end - 1, k]
            end += 2
        at = _corner(text, at, most, corners[end])
        if at < 0 or (at < text.shape[0] and text[at] > _SPACE):
            return first, -1
        at = _blank(text, at)
        end += 1
    return end, at if end - first >= 3 else -1


@compiled(array_of(uint8, 1))
def read_faces(text: Bytes) -> tuple[bool, Floats, Floats, Floats, Integers, Places]:
    """Return what an OBJ file says, its polygons as fans of triangles.

    Args:
        text: (n,) the bytes of the file.

    Returns:
        whether the rest is all that it says, and not colours of vertices, continued lines, rows counted from the end,
        or what can't be read;
        vertices (v, 3), texture coordinates (t, 3) and normals (m, 3);
        corners (3 f, 3) of the triangles: rows of these three, NONE where a corner has none;
        uses of materials (k, 3): the first corner, and where the line begins and ends.
    """
    ended = np.zeros(text.shape[0] + 1, np.uint8)  # so that who reads digits need not ask where the text ends
    for place in range(text.shape[0]):
        ended[place] = text[place]
    text = ended[:-1]
    counts = np.zeros(5, np.int64)
    at = 0
    while at < text.shape[0]:
        if text[at] == _F:
            words, at = _words(text, at + 1)
            counts[3] += max(3 * (words - 2), 3)
            continue
        counts[0] += _is(text, at, _V, _SPACE)
        counts[1] += _is(text, at, _V, _T)
        counts[2] += _is(text, at, _V, _N)
        counts[4] += _is(text, at, _U, _S)
        at = _line_end(text, at)
    vertices, uvs, normals = np.zeros((counts[0], 3)), np.zeros((counts[1], 3)), np.zeros((counts[2], 3))
    corners = np.zeros((counts[3], 3), np.int32)
    uses = np.zeros((counts[4], 3), np.int64)
    read = np.zeros(5, np.int64)
    at = 0
    while at < text.shape[0]:
        if _is(text, at, _V, _SPACE):
            at = _row(text, at + 2, vertices[read[0]], 3)
            read[0] += 1
        elif _is(text, at, _V, _T):
            at = _row(text, at + 2, uvs[read[1]], 2)
            read[1] += 1
        elif _is(text, at, _V, _N):
            at = _row(text, at + 2, normals[read[2]], 3)
            read[2] += 1
        elif text[at] == _F:
            read[3], at = _face(text, at + 1, counts, corners, read[3])
        elif _is(text, at, _U, _S):
            begin = at
            while at < text.shape[0] and text[at] > _RETURN:
                at += 1
            uses[read[4], 0], uses[read[4], 1], uses[read[4], 2] = read[3], begin, at
            read[4] += 1
        elif text[at] == _SPACE or text[at] == _TAB:
            at = _blank(text, at)  # of a line that says nothing
        else:
            while at < text.shape[0] and text[at] > _RETURN and text[at] != _BACKSLASH:
                at += 1
        if 0 <= at < text.shape[0] and text[at] == _RETURN:
            at += 1
        if at < 0 or (at < text.shape[0] and text[at] != _NEWLINE):
            return False, vertices, uvs, normals, corners, uses
        at += 1
    return True, vertices, uvs, normals, corners[: read[3]].copy(), uses


@compiled(array_of(int32, 2))
def weld(corners: Integers) -> tuple[Integers, Integers]:
    """Return the different rows of (m, 3) corners, in the order in which they come first, and (m,) which each is."""
    size = 16
    while size < 2 * corners.shape[0]:
        size *= 2
    table = np.full(size, -1, np.int32)
    rows = np.empty((corners.shape[0], 3), np.int32)
    place = np.empty(corners.shape[0], np.int32)
    count = 0
    for i in range(corners.shape[0]):
        a, b, c = np.int64(corners[i, 0]), np.int64(corners[i, 1]), np.int64(corners[i, 2])
        at = (a * 73856093 ^ b * 19349663 ^ c * 83492791) & (size - 1)
        while True:
            known = table[at]
            if known < 0:
                table[at] = count
                rows[count, 0], rows[count, 1], rows[count, 2] = a, b, c
                place[i] = count
                count += 1
                break
            if rows[known, 0] == a and rows[known, 1] == b and rows[known, 2] == c:
                place[i] = known
                break
            at = (at + 1) & (size - 1)
    return rows[:count].copy(), place
