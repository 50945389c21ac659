"""Words of Dubins, and of Reeds and Shepp, against published formulas and against ways drawn at random."""

from __future__ import annotations

import math

import numpy as np
import pytest
from virtualrobot_kernel.crafts.words import Word, best_of_all, shortest

from tests.tiers import Draws

DUBINS = ("LSL", "RSR", "LSR", "RSL", "RLR", "LRL")
"""The six words that may be the shortest going forward."""

REEDS_SHEPP = (
    *("L+S+L+", "L+S+R+", "L+R-L+", "L+R-L-", "L+R+L-", "L+R+L-R-", "L+R-L-R+"),
    *("L+R-S-L-", "L+R-S-R-", "L+S+R+L-", "L+S+L+R-", "L+R-S-L-R+"),
)
"""The words that may be the shortest going back as well, but for the mirrored ones and those the other way round.

The table of J. A. Reeds, L. A. Shepp, Optimal paths for a car that goes both forwards and backwards (1990), as given by
P. Souères, J.-P. Laumond (1996).
"""


def shkel_lumelsky(x: float, y: float, heading: float) -> float:
    """Return the length of the shortest way going forward.

    A. M. Shkel, V. Lumelsky, Classification of the Dubins set, Robotics and Autonomous Systems 34, 2001: the goal is at
    distance d along the x axis, and headings are alpha and beta from it.
    """
    d, theta = math.hypot(x, y), math.atan2(y, x)
    alpha, beta = -theta % math.tau, (heading - theta) % math.tau
    sa, ca, sb, cb, cab = math.sin(alpha), math.cos(alpha), math.sin(beta), math.cos(beta), math.cos(alpha - beta)
    around = math.tau
    found = []
    if (square := 2 + d * d - 2 * cab + 2 * d * (sa - sb)) >= 0.0:
        turn = math.atan2(cb - ca, d + sa - sb)
        found.append(((turn - alpha) % around) + math.sqrt(square) + ((beta - turn) % around))
    if (square := 2 + d * d - 2 * cab + 2 * d * (sb - sa)) >= 0.0:
        turn = math.atan2(ca - cb, d - sa + sb)
        found.append(((alpha - turn) % around) + math.sqrt(square) + ((turn - beta) % around))
    if (square := -2 + d * d + 2 * cab + 2 * d * (sa + sb)) >= 0.0:
        p = math.sqrt(square)
        turn = math.atan2(-ca - cb, d + sa + sb) - math.atan2(-2.0, p)
        found.append(((turn - alpha) % around) + p + ((turn - beta) % around))
    if (square := -2 + d * d + 2 * cab - 2 * d * (sa + sb)) >= 0.0:
        p = math.sqrt(square)
        turn = math.atan2(ca + cb, d - sa - sb) - math.atan2(2.0, p)
        found.append(((alpha - turn) % around) + p + ((beta - turn) % around))
    if abs(cosine := (6 - d * d + 2 * cab + 2 * d * (sa - sb)) / 8) <= 1.0:
        p = (around - math.acos(cosine)) % around
        t = (alpha - math.atan2(ca - cb, d - sa + sb) + p / 2) % around
        found.append(t + p + ((alpha - beta - t + p) % around))
    if abs(cosine := (6 - d * d + 2 * cab + 2 * d * (sb - sa)) / 8) <= 1.0:
        p = (around - math.acos(cosine)) % around
        t = (-alpha - math.atan2(ca - cb, d + sa - sb) + p / 2) % around
        found.append(t + p + ((beta - alpha - t + p) % around))
    return min(found)


def goals(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return goals (n, 3), near and far."""
    near = np.column_stack([rng.uniform(-3.0, 3.0, (count, 2)), rng.uniform(-np.pi, np.pi, count)])
    return np.concatenate([near, near * (5.0, 5.0, 1.0)])


def test_going_forward_they_are_as_long_as_published_formulas_say(rng: np.random.Generator, draws: Draws) -> None:
    for x, y, heading in goals(rng, draws(1000)).tolist():
        word = shortest(x, y, heading, back=False)
        assert word.leads_to(x, y, heading)
        assert min(word.lengths) > 0.0
        assert word.length == pytest.approx(shkel_lumelsky(x, y, heading), abs=1e-7)


@pytest.mark.parametrize("letters", DUBINS)
def test_no_way_going_forward_is_shorter(letters: str, rng: np.random.Generator, draws: Draws) -> None:
    for _ in range(draws(200)):
        drawn = Word(letters, tuple(rng.uniform(0.0, (3.0 if letter == "S" else 6.0)) for letter in letters))
        assert shortest(*drawn.end(), back=False).length <= drawn.length + 1e-7


@pytest.mark.parametrize("pattern", REEDS_SHEPP)
def test_no_way_forth_and_back_is_shorter(pattern: str, rng: np.random.Generator, draws: Draws) -> None:
    """Of each word that may be the shortest, with any lengths, mirrored, backward, and from the goal to the begin."""
    letters, signs = pattern[::2], [1.0 if sign == "+" else -1.0 for sign in pattern[1::2]]
    for _ in range(draws(150)):
        sizes = [rng.uniform(0.0, 3.0 if letter == "S" else math.pi / 2.0) for letter in letters]
        if len(letters) == 4 and "S" not in letters:
            sizes[2] = sizes[1]
        if "R-S" in pattern:
            sizes[1] = math.pi / 2.0
        if pattern.endswith("S-L-R+"):
            sizes[3] = math.pi / 2.0
        lengths = [size * sign for size, sign in zip(sizes, signs, strict=True)]
        mirrored = letters.translate(str.maketrans("LR", "RL"))
        for word in (letters, mirrored):
            for turned in (lengths, [-length for length in lengths], lengths[::-1]):
                named = word[::-1] if turned == lengths[::-1] else word
                drawn = Word(named, tuple(turned))
                found = shortest(*(end := drawn.end()), back=True)
                assert found.leads_to(*end)
                assert found.length <= drawn.length + 1e-7, drawn


def test_no_way_of_many_parts_is_shorter(rng: np.random.Generator, draws: Draws) -> None:
    """Any controls: up to eight parts of any kind, drawn at random."""
    for _ in range(draws(1000)):
        count = int(rng.integers(1, 9))
        letters = "".join(rng.choice(list("LSR"), count))
        drawn = Word(letters, tuple(rng.uniform(-2.0, 2.0, count)))
        assert shortest(*drawn.end(), back=True).length <= drawn.length + 1e-7


def test_going_back_is_never_longer_and_the_way_home_is_as_long(rng: np.random.Generator, draws: Draws) -> None:
    for x, y, heading in goals(rng, draws(500)).tolist():
        there = shortest(x, y, heading, back=True)
        assert there.length <= shortest(x, y, heading, back=False).length + 1e-9
        home = (-x * math.cos(heading) - y * math.sin(heading), x * math.sin(heading) - y * math.cos(heading), -heading)
        assert shortest(*home, back=True).length == pytest.approx(there.length, abs=1e-7)


def test_ways_that_anybody_can_tell() -> None:
    for far, back in ((3.0, False), (-2.0, True)):
        straight = shortest(far, 0.0, 0.0, back=back)
        assert (straight.letters, straight.lengths) == ("S", (pytest.approx(far),))
    assert shortest(0.0, 0.0, 0.0, back=False) == Word("", ())
    quarter = shortest(1.0, 1.0, math.pi / 2.0, back=False)
    assert (quarter.letters, quarter.length) == ("L", pytest.approx(math.pi / 2.0))
    # Turning round where one stands takes three arcs of 60 degrees, one of them back.
    turned = shortest(0.0, 0.0, math.pi, back=True)
    assert turned.length == pytest.approx(math.pi)
    assert [abs(length) for length in turned.lengths] == pytest.approx([math.pi / 3.0] * 3)


def test_a_place_alone_is_reached_by_an_arc_and_its_tangent(rng: np.random.Generator, draws: Draws) -> None:
    """From outside the circle about (0, 1) the straight line is the tangent, of length sqrt(l^2 - 1)."""
    for _ in range(draws(20)):
        x, y = rng.uniform(-4.0, 4.0), rng.uniform(2.5, 6.0)
        found = best_of_all(lambda heading, x=x, y=y: (x, y, heading), back=False)
        far = math.hypot(x, y - 1.0)
        straight = math.sqrt(far * far - 1.0)
        turn = (math.atan2(y - 1.0, x) + math.atan2(1.0, straight)) % math.tau
        assert found.length == pytest.approx(straight + turn, abs=1e-6)
