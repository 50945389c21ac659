"""Questions about arrays."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_sdk.arrays import is_finite


@pytest.mark.parametrize("shape", [(0,), (1,), (5,), (3, 4), (0, 3), (2, 2, 2)])
def test_all_must_be_finite(shape: tuple[int, ...]) -> None:
    assert is_finite(np.zeros(shape))
    # Larger than the root of the greatest number: their squares are not finite, and they are.
    assert is_finite(np.full(shape, 1e300))
    assert is_finite(np.full(shape, -1e308))
    for wrong in (np.nan, np.inf, -np.inf):
        for values in (np.zeros(shape), np.full(shape, 1e300)):
            if values.size:
                values.flat[-1] = wrong
                assert not is_finite(values)


def test_infinities_do_not_cancel_out() -> None:
    assert not is_finite(np.array([np.inf, -np.inf]))
