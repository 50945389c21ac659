"""Charts of a study's report: what belongs on which of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np
import pyarrow
from numpy.typing import NDArray

from virtualrobot_apps.studies.charts import Axis, curve, front, heat_map, is_on_front, scatter
from virtualrobot_apps.studies.parameters import Floats, Law, Values
from virtualrobot_apps.studies.study_file import Goal, Study
from virtualrobot_apps.studies.work import OK

_MOST_MAPS = 12
_LEAST_DRAWN, _MOST_FIELDS = 3, 10_000
_MOST_SHOWN = 5000

Row = dict[str, object]


def maps(study: Study, table: pyarrow.Table, name: str, values: Floats) -> Iterator[tuple[str, str]]:
    """Yield charts of the means of a result over the grid (cells that are done,), each with what it is for.

    A heat map has across the last parameter of the file that has several numbers, and up the one before it; of all
    others each combination has a map of its own, the first dozen of them. Yields nothing where a map would have too
    many fields. Where only one parameter has several numbers, three or more, it is across, and the mean up. Of a
    search the cells are points, by its last two ranges.
    """
    cells = study.cells
    if study.search is not None:
        yield from _searched(study, table, values)
        return
    wide = [one for one in cells.fixed if len(one.values) > 1 and not one.is_text]
    if not wide or np.isnan(values).all():
        return
    drawn = wide[-2:]
    if not _LEAST_DRAWN <= math.prod(len(one.values) for one in drawn) <= _MOST_FIELDS:
        return
    means = _means(study, table, values).reshape([len(one.values) for one in cells.fixed])
    ends = float(np.nanmin(means)), float(np.nanmax(means))
    others = [one for one in cells.fixed if all(one is not other for other in drawn)]
    for places in list(product(*(range(len(one.values)) for one in others)))[:_MOST_MAPS]:
        at = {one.name: place for one, place in zip(others, places, strict=True)}
        field = means[tuple(at.get(one.name, slice(None)) for one in cells.fixed)]
        head = ", ".join(f"{one.name} {_said(one.values[at[one.name]])}" for one in others if len(one.values) > 1)
        axes = [_axis(one, count) for one, count in zip(drawn, field.shape, strict=True)]
        if len(axes) == 2:
            yield head, heat_map(axes[1], axes[0], field, ends)
        elif not np.isnan(field).all():
            yield head, curve(axes[0], Axis(name, field.tolist()))


def _searched(study: Study, table: pyarrow.Table, values: Floats) -> Iterator[tuple[str, str]]:
    laws = [one for one in study.cells.laws if isinstance(one, Law)][-2:]
    there = np.flatnonzero(~np.isnan(values))
    there = there[:: max(1, math.ceil(len(there) / _MOST_SHOWN))]
    if len(laws) < 2 or not len(there):
        return
    up, across = (Axis(one.name, table.column(one.name).to_numpy()[there].tolist()) for one in laws)
    labels = [
        f"cell {cell}, {across.name} {x:.5g}, {up.name} {y:.5g}: {value:.5g}"
        for cell, x, y, value in zip(
            table.column("cell").to_numpy()[there].tolist(), across.values, up.values, values[there], strict=True
        )
    ]
    ends = float(values[there].min()), float(values[there].max())
    yield "", scatter(across, up, values[there], ends, labels)


def goals(study: Study, table: pyarrow.Table) -> tuple[list[str], list[list[str]], str] | None:
    """Return the front of a study's goals: names and rows of a table, and its chart; None where nothing has all goals.

    Points of the grid count by the means of their cells; where there are no draws, or a search, each cell counts.
    """
    cells, wanted = study.cells, study.goals
    if not wanted or not len(table):
        return None
    if cells.fixed and cells.per_point > 1:
        names = [one.name for one in cells.fixed if len(one.values) > 1]
        found = np.stack([_means(study, table, _column(table, goal)) for goal in wanted], axis=1)
        rows: list[Row] = [dict(cells.point(point * cells.per_point)) for point in range(len(found))]
    else:
        names = ["cell", *(one.name for one in cells.parameters if one not in cells.constant)]
        found = np.stack([_column(table, goal) for goal in wanted], axis=1)
        found[np.array(table.column("status").to_pylist()) != OK] = np.nan
        rows = table.select(["cell", *(one.name for one in cells.parameters)]).to_pylist()
    there = np.flatnonzero(~np.isnan(found).any(axis=1))
    if not len(there):
        return None
    found, rows = found[there], [rows[one] for one in there.tolist()]
    best = is_on_front(found * [goal.sign for goal in wanted])
    order = [one for one in np.argsort(found[:, 0], kind="stable").tolist() if best[one]]
    shown = [
        [*(_said(rows[one][name]) for name in names), *(f"{value:.6g}" for value in found[one])]
        for one in order[:_MOST_SHOWN]
    ]
    kept = _thinned(best)
    labels = [", ".join(f"{name} {_said(rows[one][name])}" for name in names) for one in kept.tolist()]
    axes = [Axis(goal.said, found[kept, number].tolist()) for number, goal in enumerate(wanted)]
    return [*names, *(goal.said for goal in wanted)], shown, front(axes[0], axes[1], best[kept], labels)


def _thinned(best: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return which points a chart shows: all of the front, and of the others as many as it may hold."""
    others = np.flatnonzero(~best)
    step = max(1, math.ceil(len(others) / _MOST_SHOWN))
    return np.sort(np.concatenate([np.flatnonzero(best), others[::step]]))


def _column(table: pyarrow.Table, goal: Goal) -> Floats:
    return np.array(table.column(goal.result).to_numpy(), dtype=np.float64)


def _means(study: Study, table: pyarrow.Table, values: Floats) -> Floats:
    """Return the mean of a result at each point of the grid; NaN where no cell has it."""
    points = table.column("cell").to_numpy() // study.cells.per_point
    count = study.cells.count // study.cells.per_point
    there = ~np.isnan(values)
    sums = np.bincount(points[there], values[there], count)
    found = np.bincount(points[there], minlength=count)
    return np.where(found > 0, sums / np.maximum(found, 1), np.nan)


def _axis(parameter: Values, count: int) -> Axis:
    assert count == len(parameter.values)
    return Axis(parameter.name, [float(value) for value in parameter.values])


def _said(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, int | float) else str(value)
