"""Arrays that are given: points and masks of the right shape and with finite numbers, or words about what is wrong."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from virtualrobot.errors import InvalidArgumentError

Floats = NDArray[np.float64]


def finite(values: ArrayLike, columns: int, called: str) -> Floats:
    """Return rows (n, columns) of finite numbers; raise InvalidArgumentError, which calls them so, for others."""
    try:
        rows = np.asarray(values, np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidArgumentError(f"{called} are numbers (n, {columns}), not {type(values).__name__}") from error
    if rows.ndim != 2 or rows.shape[1] != columns:
        raise InvalidArgumentError(f"{called} have the shape (n, {columns}), not {rows.shape}")
    bad = ~np.isfinite(rows).all(axis=1)
    if bad.any():
        raise InvalidArgumentError(
            f"{bad.sum()} of {len(rows)} {called} are not finite, the first is number {bad.argmax()}: leave out what "
            "isn't valid"
        )
    return rows


def mask(values: ArrayLike, count: int, called: str) -> NDArray[np.bool_]:
    """Return a mask (count,); raise InvalidArgumentError, which calls it so, for another length or other values."""
    given = np.asarray(values)
    if given.dtype != bool or given.shape != (count,):
        raise InvalidArgumentError(f"{called} is a mask of {count} booleans, not {given.dtype} {given.shape}")
    return given
