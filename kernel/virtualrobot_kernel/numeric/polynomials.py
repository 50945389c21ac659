"""Piecewise polynomials as `motion/polynomial.py` has them, in compiled code.

Their arrays are breaks (p + 1,) and terms (p, t, k): of p pieces and k components, ascending powers of the parameter
from the piece's break on; clamped outside.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from virtualrobot_sdk.compiled.cache import inlined

Floats = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.int64]]


@inlined
def write_all(values: Floats, found: Floats) -> None:
    """Write values (n,) to the begin of `found`: numba's own assignment to a slice takes seconds to compile."""
    for i in range(values.shape[0]):
        found[i] = values[i]


@inlined
def one_of(breaks: Floats, terms: Floats, shape: Integers) -> tuple[Floats, Floats]:
    """Return breaks and terms of one of many that are kept one after the other in (b,) and (c,).

    shape (5,): its first break, its first term, and the numbers of its pieces, terms and components.
    """
    pieces = shape[2]
    size = pieces * shape[3] * shape[4]
    own = terms[shape[1] : shape[1] + size].reshape((pieces, shape[3], shape[4]))
    return breaks[shape[0] : shape[0] + pieces + 1], own


@inlined
def piece_at(breaks: Floats, x: float) -> int:
    """Return the piece at x: of two that meet there the second one, beyond the ends the first or the last one."""
    low = 0
    high = breaks.shape[0] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if breaks[middle] <= x:
            low = middle
        else:
            high = middle
    return low


@inlined
def piece_near(breaks: Floats, x: float, piece: int) -> int:
    """Return the piece at x as `piece_at` does, looked for from a piece on, which is quick where it is near."""
    while piece > 0 and x < breaks[piece]:
        piece -= 1
    while piece < breaks.shape[0] - 2 and x >= breaks[piece + 1]:
        piece += 1
    return piece


@inlined
def jerk_state(breaks: Floats, terms: Floats, x: float, piece: int) -> tuple[float, float, float, float]:
    """Return the first component at x, in a piece, and its first three derivatives, which are 0 beyond the ends."""
    begin = breaks[0]
    end = breaks[breaks.shape[0] - 1]
    local = min(max(x, begin), end) - breaks[piece]
    value, first, second, third = 0.0, 0.0, 0.0, 0.0
    for power in range(terms.shape[1] - 1, -1, -1):
        third = third * local + second
        second = second * local + first
        first = first * local + value
        value = value * local + terms[piece, power, 0]
    if x < begin or x > end:
        return value, 0.0, 0.0, 0.0
    return value, first, 2.0 * second, 6.0 * third


@inlined
def write_derivatives(terms: Floats, piece: int, local: float, rows: Floats) -> None:
    """Write all components and their first two derivatives, `local` after a piece's break, into rows (3, k)."""
    for component in range(terms.shape[2]):
        rows[0, component], rows[1, component], rows[2, component] = 0.0, 0.0, 0.0
    for power in range(terms.shape[1] - 1, -1, -1):
        for component in range(terms.shape[2]):
            rows[2, component] = rows[2, component] * local + rows[1, component]
            rows[1, component] = rows[1, component] * local + rows[0, component]
            rows[0, component] = rows[0, component] * local + terms[piece, power, component]
    for component in range(terms.shape[2]):
        rows[2, component] *= 2.0


@inlined
def scalar_state(breaks: Floats, terms: Floats, x: float) -> tuple[float, float, float]:
    """Return the first component at x and its first two derivatives, which are 0 beyond the ends."""
    begin = breaks[0]
    end = breaks[breaks.shape[0] - 1]
    piece = piece_at(breaks, x)
    local = min(max(x, begin), end) - breaks[piece]
    value = 0.0
    first = 0.0
    second = 0.0
    for power in range(terms.shape[1] - 1, -1, -1):
        second = second * local + 2.0 * first
        first = first * local + value
        value = value * local + terms[piece, power, 0]
    if x < begin or x > end:
        return value, 0.0, 0.0
    return value, first, second


@inlined
def write_values(breaks: Floats, terms: Floats, x: float, row: Floats, column: int) -> None:
    """Write all components at x into a row from a column on."""
    piece = piece_at(breaks, x)
    local = min(max(x, breaks[0]), breaks[breaks.shape[0] - 1]) - breaks[piece]
    for component in range(terms.shape[2]):
        value = 0.0
        for power in range(terms.shape[1] - 1, -1, -1):
            value = value * local + terms[piece, power, component]
        row[column + component] = value


@inlined
def bends_of(breaks: Floats, terms: Floats, bends: Floats) -> None:
    """Write for each piece how great the second derivatives are at the most, and the jumps of the first at its begin.

    bends (p, 2, k).
    """
    for component in range(terms.shape[2]):
        slope = 0.0
        for piece in range(terms.shape[0]):
            length, power = breaks[piece + 1] - breaks[piece], 1.0
            bends[piece, 0, component], bends[piece, 1, component] = 0.0, 0.0
            if terms.shape[1] > 1:
                bends[piece, 1, component] = abs(terms[piece, 1, component] - slope) if piece > 0 else 0.0
                slope = terms[piece, 1, component]
            for n in range(2, terms.shape[1]):
                bends[piece, 0, component] += n * (n - 1) * abs(terms[piece, n, component]) * power
                power *= length
                slope += n * terms[piece, n, component] * power


@inlined
def strays(breaks: Floats, bends: Floats, ends: Floats, wobble: Floats, stray: Floats) -> None:
    """Write how far components (k,) are from going evenly between three places, `wobble` (k,) more than `bends` say.

    ends (3,): the places, in order. A chord of length h is apart from its curve by at most h²/8 of the greatest second
    derivative, and h/4 of each jump of the first (C. de Boor, A Practical Guide to Splines, 1978, III).
    """
    first, last = piece_at(breaks, ends[0]), piece_at(breaks, ends[2])
    half = max(ends[1] - ends[0], ends[2] - ends[1])
    for component in range(stray.shape[0]):
        bent, jumps = 0.0, 0.0
        for piece in range(first, last + 1):
            bent = max(bent, bends[piece, 0, component])
            if piece > first:
                jumps += bends[piece, 1, component]
        stray[component] = wobble[component] + 0.125 * half * half * bent + 0.25 * half * jumps
