"""Parameters that `make test` leaves to `make test-all`."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import pytest

Draws = Callable[[int], int]
"""The fixture `draws`: how many of so many draws are made."""


def every_fifth(values: Iterable[object]) -> list[object]:
    """Return parameters of a test: the first of five is always tried, the others are long."""
    return [value if not i % 5 else pytest.param(value, marks=pytest.mark.long) for i, value in enumerate(values)]
