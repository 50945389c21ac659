"""Statistics of a stream: how often it tells, how many bytes, and how late."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from virtualrobot.streams.sample import Sample


@dataclass(frozen=True, slots=True)
class Rate:
    """Rate of samples in simulation time.

    Attributes:
        count: how many came.
        lost: how many were lost.
        mean: samples a second, those that were lost included; NaN where fewer than two came.
        shortest: least time from one to the next (s).
        longest: greatest time (s).
        deviation: standard deviation of these times (s).
    """

    count: int
    lost: int
    mean: float
    shortest: float
    longest: float
    deviation: float


def rate(samples: Sequence[Sample]) -> Rate:
    """Return the rate of samples of one stream, in their order."""
    periods = [after.time - before.time for before, after in pairwise(samples)]
    lost = sum(one.lost for one in samples[1:])
    if not periods or not (span := sum(periods)) > 0.0:
        return Rate(len(samples), lost, math.nan, math.nan, math.nan, math.nan)
    mean = span / len(periods)
    deviation = math.sqrt(sum((one - mean) ** 2 for one in periods) / len(periods))
    return Rate(len(samples), lost, (len(periods) + lost) / span, min(periods), max(periods), deviation)


@dataclass(frozen=True, slots=True)
class Bandwidth:
    """Size of samples: how many came, bytes of all, and bytes a second of simulation time (NaN below two)."""

    count: int
    total: int
    mean: float


def bandwidth(samples: Sequence[Sample]) -> Bandwidth:
    """Return the bandwidth of samples of one stream, in their order."""
    span = samples[-1].time - samples[0].time if samples else 0.0
    total = sum(one.size for one in samples)
    later = sum(one.size for one in samples[1:])
    return Bandwidth(len(samples), total, later / span if span > 0.0 else math.nan)


@dataclass(frozen=True, slots=True)
class Delay:
    """Time (s of the wall clock) from the instant that samples tell to when they came; both clocks as they are."""

    count: int
    mean: float
    shortest: float
    longest: float


def delay(samples: Sequence[tuple[Sample, float]]) -> Delay:
    """Return the delay of samples, each with the wall time (s since 1970) at which it came."""
    times = [came - one.wall_time for one, came in samples]
    if not times:
        return Delay(0, math.nan, math.nan, math.nan)
    return Delay(len(times), sum(times) / len(times), min(times), max(times))
