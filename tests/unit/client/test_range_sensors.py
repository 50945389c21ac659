"""What the makers of range sensors refuse before anything is sent."""

from __future__ import annotations

from typing import Any

import pytest
import virtualrobot
from virtualrobot.errors import InvalidArgumentError


def test_counts_seeds_and_patterns_that_no_message_holds() -> None:
    with pytest.raises(InvalidArgumentError, match=r"a fan's count of beams is a whole number from 0 .*, not 2.5"):
        virtualrobot.fan(2.5, 0.0, 1.0)  # pyright: ignore[reportArgumentType]
    with pytest.raises(InvalidArgumentError, match=r"a raster's count of rows is .*, not -1"):
        virtualrobot.raster(3, -1, 1.0, 1.0)
    with pytest.raises(InvalidArgumentError, match=r"a head's count of columns is .*, not 4294967296"):
        virtualrobot.spinning(2**32, [0.0])
    with pytest.raises(InvalidArgumentError, match=r"a ring's count of transducers is .*, not None"):
        virtualrobot.ring(None, 0.1, 0.0, 1.0)  # pyright: ignore[reportArgumentType]
    with pytest.raises(InvalidArgumentError, match=r"a seed is a whole number from 0 to 18446744073709551615, not -1"):
        virtualrobot.range_sensor(seed=-1)
    pattern: Any = "fan"
    with pytest.raises(InvalidArgumentError, match=r"'fan' is no pattern; make one by fan, spinning, raster, ring"):
        virtualrobot.range_sensor(pattern=pattern)
    with pytest.raises(InvalidArgumentError, match=r"a seed is .*, not 18446744073709551616"):
        virtualrobot.imu(seed=2**64)
