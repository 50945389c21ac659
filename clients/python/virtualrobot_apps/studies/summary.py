"""Figures of a study's results: of all cells, and at each point of the grid."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pyarrow

from virtualrobot_apps.studies.parameters import RANDOM, SENSITIVITY, Floats, Value
from virtualrobot_apps.studies.study_file import NUMBER, Study

CONFIDENCE = 0.95
MOST = 0.95
"""Share of the values that a tolerance is to hold for."""


@dataclass(frozen=True)
class Summary:
    """Figures of one result over some cells.

    Attributes:
        count: cells that have it.
        mean, deviation: of these; the deviation is that of a sample.
        interval: of the mean, with 95% confidence; None where there are fewer than two, or draws aren't independent.
        least, median, most: of these.
        nearly_most: 95% of the values are not above it.
        nearly_most_interval: of that, with 95% confidence; None where there are too few values, or draws aren't
            independent.
    """

    count: int
    mean: float
    deviation: float
    interval: tuple[float, float] | None
    least: float
    median: float
    most: float
    nearly_most: float
    nearly_most_interval: tuple[float, float] | None


def summarize(values: Floats, independent: bool = True) -> Summary:
    """Return the figures of one or more values (n,).

    The interval of what is always 0 or 1 is Wilson's (Edwin Wilson, "Probable inference, the law of succession, and
    statistical inference", 1927), that of others Student's.
    """
    from scipy import stats

    count, mean = len(values), float(values.mean())
    deviation = float(values.std(ddof=1)) if count > 1 else 0.0
    interval = None
    if independent and count > 1:
        if np.isin(values, (0.0, 1.0)).all():
            interval = wilson(float(values.sum()), count)
        else:
            off = float(stats.t.ppf(0.5 + CONFIDENCE / 2.0, count - 1)) * deviation / math.sqrt(count)
            interval = mean - off, mean + off
    return Summary(
        count,
        mean,
        deviation,
        interval,
        float(values.min()),
        float(np.median(values)),
        float(values.max()),
        float(np.quantile(values, MOST)),
        quantile_interval(values, MOST) if independent else None,
    )


def quantile_interval(values: Floats, share: float) -> tuple[float, float] | None:
    """Return the 95% interval of what `share` of all values are below; None where these (n,) are too few to tell.

    It lies between two of them, by the binomial law of how many are below it, whatever law they follow themselves
    (William Conover, "Practical nonparametric statistics", 1999, section 3.2).
    """
    from scipy import stats

    low, high = stats.binom.ppf([0.5 - CONFIDENCE / 2.0, 0.5 + CONFIDENCE / 2.0], len(values), share).astype(int)
    if low < 1 or high >= len(values):
        return None
    ordered = np.sort(values)
    return float(ordered[low - 1]), float(ordered[high])


def wilson(successes: float, count: int) -> tuple[float, float]:
    """Return the 95% interval of a share of which `successes` of `count` were seen."""
    from scipy import stats

    z = float(stats.norm.ppf(0.5 + CONFIDENCE / 2.0))
    share = successes / count
    middle = (share + z * z / (2.0 * count)) / (1.0 + z * z / count)
    off = z / (1.0 + z * z / count) * math.sqrt(share * (1.0 - share) / count + z * z / (4.0 * count * count))
    return max(0.0, middle - off), min(1.0, middle + off)


def numbers(study: Study, table: pyarrow.Table) -> dict[str, Floats]:
    """Return the results that are numbers, by name, a row for each cell that is done; NaN where there is none."""
    names = [name for name, kind in study.results if kind == NUMBER]
    return {name: np.asarray(table.column(name).to_numpy(), dtype=np.float64) for name in names}


def by_point(study: Study, table: pyarrow.Table) -> Iterator[tuple[dict[str, Value], dict[str, Summary]]]:
    """Yield each point of the grid of which cells are done, with the figures of the results that any of these has."""
    found = numbers(study, table)
    points = table.column("cell").to_numpy() // study.cells.per_point
    starts = np.flatnonzero(np.diff(points, prepend=-1))
    for start, end in zip(starts, [*starts[1:], len(points)], strict=True):
        yield (
            study.cells.point(int(points[start]) * study.cells.per_point),
            summaries(study, {name: values[start:end] for name, values in found.items()}),
        )


def summaries(study: Study, found: dict[str, Floats]) -> dict[str, Summary]:
    """Return the figures of each result that any cell has, by name."""
    there = {name: values[~np.isnan(values)] for name, values in found.items()}
    independent = study.cells.sampling == RANDOM and study.search is None
    return {name: summarize(values, independent) for name, values in there.items() if len(values)}


@dataclass(frozen=True)
class Sensitivity:
    """Shares of a result's variance that a parameter has: alone, and with all that it acts together with."""

    first_order: float
    total_order: float


def sensitivities(study: Study, values: Floats, point: int = 0) -> dict[str, Sensitivity] | None:
    """Return Sobol' indices of a result (cells,) at a point of the grid, by parameter; None where a cell hasn't got it.

    Andrea Saltelli et al., "Variance based sensitivity analysis of model output", 2010, table 2 (b) and (f).
    """
    from scipy import stats

    cells = study.cells
    here = values[point * cells.per_point : (point + 1) * cells.per_point]
    if cells.sampling != SENSITIVITY or len(here) < cells.per_point or np.isnan(here).any():
        return None
    matrices = here.reshape(len(cells.laws) + 2, 1, cells.draws)
    found = stats.sobol_indices(func={"f_A": matrices[0], "f_B": matrices[1], "f_AB": matrices[2:]}, n=cells.draws)
    pairs = zip(cells.laws, found.first_order, found.total_order, strict=True)
    return {law.name: Sensitivity(float(first), float(total)) for law, first, total in pairs}
