"""Shortest ways in the plane of what turns on circles of a least radius: the words of Dubins, and of Reeds and Shepp.

A word is a row of arcs to the left (L), to the right (R) and straight lines (S). Going forward alone one of six words
is the shortest (L. E. Dubins, On curves of minimal length, American Journal of Mathematics 79, 1957); going back as
well one of 48 (J. A. Reeds, L. A. Shepp, Optimal paths for a car that goes both forwards and backwards, Pacific Journal
of Mathematics 145, 1990), which here come of nine of its formulas by going them backward in time, mirrored, and turned
round. Each candidate is driven, and counts only where it ends at the goal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

SAME = 1e-7
"""Largest error of the end of a word, in radii and rad."""

NONE = 1e-10
"""Parts of a word, in radii, that are none."""

TURNS = {"L": 1.0, "S": 0.0, "R": -1.0}


class Word(NamedTuple):
    """Word, and how far each part of it goes, by the radius (an arc's angle); below 0 it goes back."""

    letters: str
    lengths: tuple[float, ...]

    @property
    def length(self) -> float:
        """Return the length of the whole way, by the radius."""
        return sum(map(abs, self.lengths))

    @property
    def name(self) -> str:
        """Return the letters, each part that goes back with a minus: `LS-R`."""
        parts = zip(self.letters, self.lengths, strict=True)
        return "".join(letter + ("-" if length < 0.0 else "") for letter, length in parts)

    def end(self) -> tuple[float, float, float]:
        """Return where it ends, from the origin: x, y (by the radius) and heading (rad)."""
        x = y = heading = 0.0
        for letter, length in zip(self.letters, self.lengths, strict=True):
            side = TURNS[letter]
            if side:
                turned = heading + side * length
                x += side * (math.sin(turned) - math.sin(heading))
                y -= side * (math.cos(turned) - math.cos(heading))
                heading = turned
            else:
                x, y = x + length * math.cos(heading), y + length * math.sin(heading)
        return x, y, heading

    def leads_to(self, x: float, y: float, heading: float) -> bool:
        """Return whether it ends there."""
        there = self.end()
        off = math.remainder(there[2] - heading, math.tau)
        return math.hypot(there[0] - x, there[1] - y) <= SAME * (1.0 + math.hypot(x, y)) and abs(off) <= SAME


def shortest(x: float, y: float, heading: float, *, back: bool) -> Word:
    """Return the shortest way from the origin to x, y (by the radius) and a heading (rad); `back`: it may go back, too.

    Parts that are none are left out, so the word for the origin itself is empty.
    """
    found = _candidates_back(x, y, heading) if back else _candidates_forward(x, y, heading)
    best = min((word for word in found if word.leads_to(x, y, heading)), key=lambda word: word.length)
    parts = [(letter, length) for letter, length in zip(*best, strict=True) if abs(length) > NONE]
    return Word("".join(letter for letter, _ in parts), tuple(length for _, length in parts))


def best_of_all(goal_of: Callable[[float], tuple[float, float, float]], *, back: bool) -> Word:
    """Return the shortest way from the origin to any of some goals, given by an angle (rad) that comes round."""

    def word(angle: float) -> Word:
        return shortest(*goal_of(angle), back=back)

    def length(angle: float) -> float:
        return word(angle).length

    step = math.tau / 90.0
    first = min((step * place for place in range(90)), key=length)
    # Between two jumps of the length the best is where it is level, or at a jump: golden sections find either.
    low, high, ratio = first - step, first + step, (math.sqrt(5.0) - 1.0) / 2.0
    inner, outer = high - ratio * (high - low), low + ratio * (high - low)
    at_inner, at_outer = length(inner), length(outer)
    while high - low > 1e-9:
        if at_inner <= at_outer:
            high, outer, at_outer = outer, inner, at_inner
            inner = high - ratio * (high - low)
            at_inner = length(inner)
        else:
            low, inner, at_inner = inner, outer, at_outer
            outer = low + ratio * (high - low)
            at_outer = length(outer)
    return min(map(word, (first, inner, outer)), key=lambda word: word.length)


def _candidates_forward(x: float, y: float, heading: float) -> Iterator[Word]:
    """Yield what may be the way of Dubins, by the circles that touch begin and goal.

    A point of the circle about c, gone round to the side s, is c + s (sin, -cos) of the heading there.
    """
    for first in (1.0, -1.0):
        for last in (1.0, -1.0):
            across, up = x - last * math.sin(heading), y + last * math.cos(heading) - first
            far, angle = math.hypot(across, up), math.atan2(up, across)
            if first == last:
                straight, ahead = far, angle
            elif far >= 2.0:
                straight = math.sqrt(far * far - 4.0)
                ahead = angle + first * math.atan2(2.0, straight)
            else:
                continue
            turns = _around(first * ahead), _around(last * (heading - ahead))
            yield Word(_letter(first) + "S" + _letter(last), (turns[0], straight, turns[1]))
        across, up = x - first * math.sin(heading), y + first * math.cos(heading) - first
        far = math.hypot(across, up)
        if far > 4.0:
            continue
        # The middle circle touches both: its centre is two radii from theirs.
        high, angle = math.sqrt(4.0 - far * far / 4.0), math.atan2(up, across)
        for side in (1.0, -1.0):
            middle_x = across / 2.0 - side * high * math.sin(angle)
            middle_y = up / 2.0 + side * high * math.cos(angle)
            leaves = math.atan2(middle_y, middle_x) + first * math.pi / 2.0
            joins = math.atan2(middle_y - up, middle_x - across) + first * math.pi / 2.0
            lengths = _around(first * leaves), _around(first * (leaves - joins)), _around(first * (heading - joins))
            yield Word(_letter(first) + _letter(-first) + _letter(first), lengths)


def _candidates_back(x: float, y: float, heading: float) -> Iterator[Word]:
    """Yield the words of Reeds and Shepp."""
    for letters, forward, also_reversed in _FORMULAS:
        ends = [(x, y, letters, False)]
        if also_reversed:
            # The way from the goal back to the begin, gone the other way round.
            cosine, sine = math.cos(heading), math.sin(heading)
            ends.append((x * cosine + y * sine, x * sine - y * cosine, letters[::-1], True))
        for at_x, at_y, word, is_reversed in ends:
            for back in (1.0, -1.0):
                for mirror in (1.0, -1.0):
                    lengths = forward(back * at_x, mirror * at_y, back * mirror * heading)
                    if lengths is None:
                        continue
                    if is_reversed:
                        lengths = lengths[::-1]
                    named = word if mirror > 0.0 else word.translate(_MIRRORED)
                    yield Word(named, tuple(back * length for length in lengths))


_MIRRORED = str.maketrans("LR", "RL")

Lengths = tuple[float, ...] | None


def _letter(side: float) -> str:
    return "L" if side > 0.0 else "R"


def _wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)


def _around(angle: float) -> float:
    """Return an angle from 0 up to a whole turn, which itself is none."""
    turned = angle % math.tau
    return 0.0 if math.tau - turned < NONE else turned


def _lsl(x: float, y: float, heading: float) -> Lengths:
    """Formula 8.1."""
    across, up = x - math.sin(heading), y - 1.0 + math.cos(heading)
    turn = math.atan2(up, across)
    return turn, math.hypot(across, up), _wrapped(heading - turn)


def _lsr(x: float, y: float, heading: float) -> Lengths:
    """Formula 8.2."""
    across, up = x + math.sin(heading), y - 1.0 - math.cos(heading)
    far = across * across + up * up
    if far < 4.0:
        return None
    straight = math.sqrt(far - 4.0)
    turn = _wrapped(math.atan2(up, across) + math.atan2(2.0, straight))
    return turn, straight, _wrapped(turn - heading)


def _lrl(x: float, y: float, heading: float) -> Lengths:
    """Formulas 8.3 and 8.4: the middle arc goes back; the last one as it comes."""
    across, up = x - math.sin(heading), y - 1.0 + math.cos(heading)
    far = math.hypot(across, up)
    if far > 4.0:
        return None
    middle = -2.0 * math.asin(far / 4.0)
    turn = _wrapped(math.atan2(up, across) + middle / 2.0 + math.pi)
    return turn, middle, _wrapped(heading - turn + middle)


def _outer_turns(u: float, v: float, across: float, up: float, heading: float) -> tuple[float, float]:
    """Return the first and the last arc of four, of which the middle ones are u and v."""
    delta = _wrapped(u - v)
    a, b = math.sin(u) - math.sin(delta), math.cos(u) - math.cos(delta) - 1.0
    turn = math.atan2(up * a - across * b, across * a + up * b)
    if 2.0 * (math.cos(delta) - math.cos(v) - math.cos(u)) + 3.0 < 0.0:
        turn += math.pi
    turn = _wrapped(turn)
    return turn, _wrapped(turn - u + v - heading)


def _lrlr_there(x: float, y: float, heading: float) -> Lengths:
    """Formula 8.7: the middle arcs are equal, one forth and one back."""
    across, up = x + math.sin(heading), y - 1.0 - math.cos(heading)
    share = (2.0 + math.hypot(across, up)) / 4.0
    if share > 1.0:
        return None
    middle = math.acos(share)
    first, last = _outer_turns(middle, -middle, across, up, heading)
    return first, middle, -middle, last


def _lrlr_back(x: float, y: float, heading: float) -> Lengths:
    """Formula 8.8: the middle arcs are equal, and both go back."""
    across, up = x + math.sin(heading), y - 1.0 - math.cos(heading)
    share = (20.0 - across * across - up * up) / 16.0
    if not 0.0 <= share <= 1.0:
        return None
    middle = -math.acos(share)
    first, last = _outer_turns(middle, middle, across, up, heading)
    return first, middle, middle, last


def _lrsl(x: float, y: float, heading: float) -> Lengths:
    """Formula 8.9: the second arc is a quarter, back."""
    across, up = x - math.sin(heading), y - 1.0 + math.cos(heading)
    far = math.hypot(across, up)
    if far < 2.0:
        return None
    root = math.sqrt(far * far - 4.0)
    turn = _wrapped(math.atan2(up, across) + math.atan2(root, -2.0))
    return turn, -math.pi / 2.0, 2.0 - root, _wrapped(heading - math.pi / 2.0 - turn)


def _lrsr(x: float, y: float, heading: float) -> Lengths:
    """Formula 8.10: the second arc is a quarter, back."""
    across, up = x + math.sin(heading), y - 1.0 - math.cos(heading)
    far = math.hypot(across, up)
    if far < 2.0:
        return None
    turn = math.atan2(across, -up)
    return turn, -math.pi / 2.0, 2.0 - far, _wrapped(turn + math.pi / 2.0 - heading)


def _lrslr(x: float, y: float, heading: float) -> Lengths:
    """Formula 8.11: the second and the fourth part are quarters, back."""
    across, up = x + math.sin(heading), y - 1.0 - math.cos(heading)
    far = math.hypot(across, up)
    if far < 2.0:
        return None
    straight = 4.0 - math.sqrt(far * far - 4.0)
    turn = math.atan2((4.0 - straight) * across - 2.0 * up, -2.0 * across + (straight - 4.0) * up)
    return turn, -math.pi / 2.0, straight, -math.pi / 2.0, _wrapped(turn - heading)


_FORMULAS = (
    ("LSL", _lsl, False),
    ("LSR", _lsr, False),
    ("LRL", _lrl, True),
    ("LRLR", _lrlr_there, False),
    ("LRLR", _lrlr_back, False),
    ("LRSL", _lrsl, True),
    ("LRSR", _lrsr, True),
    ("LRSLR", _lrslr, False),
)
