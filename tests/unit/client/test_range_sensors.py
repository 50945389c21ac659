"""What the makers of range sensors refuse before anything is sent."""

from __future__ import annotations

from typing import Any

import pytest
import virtualrobot
from virtualrobot.errors import InvalidArgumentError


def test_counts_seeds_and_patterns_that_no_message_holds() -> None:
    with pytest.raises(InvalidArgumentError, match=r"count is 2.5; it must be a whole number from 0 on"):
        virtualrobot.fan(2.5, 0.0, 1.0)  # pyright: ignore[reportArgumentType]
    with pytest.raises(InvalidArgumentError, match="rows is -1; it must be a whole number"):
        virtualrobot.raster(3, -1, 1.0, 1.0)
    with pytest.raises(InvalidArgumentError, match=r"a head's count of columns is .*, not 4294967296"):
        virtualrobot.spinning(2**32, [0.0])
    with pytest.raises(InvalidArgumentError, match="count is None; it must be a whole number"):
        virtualrobot.ring(None, 0.1, 0.0, 1.0)  # pyright: ignore[reportArgumentType]
    with pytest.raises(InvalidArgumentError, match="seed is -1; it must be a whole number"):
        virtualrobot.range_sensor(seed=-1)
    pattern: Any = "fan"
    with pytest.raises(
        InvalidArgumentError, match=r"pattern is 'fan'; it must be a pattern, as virtualrobot.fan, spinning"
    ):
        virtualrobot.range_sensor(pattern=pattern)
    with pytest.raises(InvalidArgumentError, match="seed is 18446744073709551616; it must be"):
        virtualrobot.imu(seed=2**64)
