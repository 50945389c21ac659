"""The paper's closed form against its own Table 1, entry by entry: ten agree, o_y and p_y do not.

Exact: sines and cosines are random rational points of the circle and everything is a fraction. Both sides are rational
functions of low degree, so equality at one point drawn from 2^60 is equality everywhere, but for a chance of 1e-16
(J. T. Schwartz, Fast probabilistic algorithms for verification of polynomial identities, J. ACM 27, 1980).
"""

from __future__ import annotations

from fractions import Fraction
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.messages.dh import denavit_hartenberg
from virtualrobot_sdk.denavit_hartenberg import Table, frames

from .paper_arm import ENTRIES, TWIST_DEGREES, Lengths, closed_form, corrected, printed, product

WRONG = ("o_y", "p_y")
TWISTS = [{90: (1, 0), 0: (0, 1), -90: (-1, 0)}[degrees] for degrees in TWIST_DEGREES]
PAGE = Path(__file__).parents[3] / "docs" / "denavit-hartenberg.md"


class Exact:
    """Sines, cosines and lengths as fractions, and the entries of the three forms there."""

    def __init__(self, rng: np.random.Generator) -> None:
        """Draw six angles by the tangents of their halves, and five lengths."""
        halves = [self.drawn(rng) for _ in range(6)]
        self.sines = [2 * t / (1 + t * t) for t in halves]
        self.cosines = [(1 - t * t) / (1 + t * t) for t in halves]
        self.lengths = Lengths(*(self.drawn(rng) for _ in range(5)))
        self.product = product(self.sines, self.cosines, TWISTS, self.lengths)
        self.printed = printed(self.sines, self.cosines, self.lengths)
        self.corrected = corrected(self.sines, self.cosines, self.lengths)

    @staticmethod
    def drawn(rng: np.random.Generator) -> Fraction:
        return Fraction(int(rng.integers(1, 2**60)), 2**59) * int(rng.choice([-1, 1]))


@pytest.fixture
def exact(rng: np.random.Generator) -> Exact:
    return Exact(rng)


@pytest.mark.parametrize("entry", [entry for entry in ENTRIES if entry not in WRONG])
def test_the_printed_entry_is_that_of_the_table(exact: Exact, entry: str) -> None:
    assert exact.printed[entry] == exact.product[entry]


@pytest.mark.parametrize("entry", WRONG)
def test_the_corrected_entry_is_that_of_the_table(exact: Exact, entry: str) -> None:
    assert exact.corrected[entry] == exact.product[entry]
    assert exact.printed[entry] != exact.product[entry]


def shipped() -> tuple[Table, Lengths]:
    """Return the table of the model that comes with the kernel, and its lengths."""
    file = resources.files("virtualrobot_plugins") / "models" / "ar_manipulator.yaml"
    (model,) = scene_file.parse(file.read_text("utf-8")).models
    table, _ = denavit_hartenberg(model.denavit_hartenberg)
    rows = table.rows
    return table, Lengths(rows[0].a_meters, rows[1].a_meters, rows[0].d_meters, rows[3].d_meters, rows[5].d_meters)


def test_the_shipped_arm_is_the_paper_s(rng: np.random.Generator) -> None:
    table, lengths = shipped()
    assert table.convention == "standard"
    assert [(row.a_meters, row.d_meters) for row in table.rows] == lengths.rows()
    assert all(length > 0 for length in (lengths.a_1, lengths.a_2, lengths.d_1, lengths.d_4, lengths.d_6))
    np.testing.assert_allclose([row.alpha_radians for row in table.rows], np.radians(TWIST_DEGREES), atol=1e-15)
    assert [row.theta_radians for row in table.rows] == [0.0] * 6
    q = rng.uniform(-np.pi, np.pi, 6)
    np.testing.assert_allclose(frames(table, q)[-1], closed_form(q, lengths), atol=1e-14)


def test_the_docs_name_the_wrong_entries() -> None:
    text = PAGE.read_text("utf-8")
    assert [entry for entry in ENTRIES if f"| `{entry}` |" in text] == list(WRONG)
