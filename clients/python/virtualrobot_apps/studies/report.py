"""Report of a study as one HTML file: tables, charts and what failed; it needs no other file and no script."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np
import pyarrow

from virtualrobot_apps.page import html_table, page_head
from virtualrobot_apps.studies import report_charts, summary
from virtualrobot_apps.studies.parameters import SENSITIVITY, Floats
from virtualrobot_apps.studies.parts import Counts, Parts
from virtualrobot_apps.studies.study_file import TEXT, Study
from virtualrobot_apps.studies.summary import Summary
from virtualrobot_apps.studies.work import OK

_MOST_POINTS = 500
_MOST_ERRORS = 20
_BEST = 10
_MOST_TEXTS = 50
_MOST_FRONT = 100
_MOST_OPEN = 12
"""Rows of a table of points that is shown at once; a longer one opens when it is clicked."""
_WIDTH, _HEIGHT, _BARS = 520, 160, 40
_FIGURES = (
    "cells",
    "mean",
    "95% interval",
    "deviation",
    "least",
    "median",
    "95% below",
    "95% interval of that",
    "most",
)


def report(study: Study, parts: Parts) -> str:
    """Return the report of the cells that are done.

    Raises:
        MalformedFileError: when a part is damaged.
    """
    return "\n".join(_lines(study, parts.table(), parts.counts(), parts.digest()))


def _lines(study: Study, table: pyarrow.Table, counts: Counts, digest: str) -> Iterator[str]:
    yield page_head(study.file.stem)
    cells = study.cells
    about = html_table(
        ("", ""),
        [
            ("function", study.function),
            ("scene", study.scene.name if study.scene else "none"),
            (
                "seed, sampling, draws",
                f"{cells.seed}, {cells.sampling if study.search is None else 'search'}, {cells.draws}",
            ),
            *((one.name, _value(one.values[0])) for one in cells.constant),
            ("cells", f"{counts.done} of {cells.count}, {counts.failed} failed, {counts.killed} killed"),
            ("SHA-256 of the results", digest),
        ],
    )
    yield f'<div class="about">{about}</div>'
    found = summary.numbers(study, table)
    figures = summary.summaries(study, found)
    names = [one.name for one in cells.parameters if one not in cells.constant]
    told = ["cell", *names, *(name for name, _ in study.results)]
    if study.search is not None and len(study.search.goals) == 1:
        yield "<h2>Best cells</h2>"
        goal = study.search.goals[0]
        order = [(goal.result, "ascending" if goal.sign > 0 else "descending")]
        best = table.sort_by(order).slice(0, _BEST).to_pylist()
        yield html_table(told, [tuple(_value(row[name]) for name in told) for row in best if row["status"] == OK])
    yield from _goals(study, table)
    has_draws = bool(cells.fixed) and 1 < cells.per_point < cells.count
    points = list(islice(summary.by_point(study, table), _MOST_POINTS)) if has_draws else []
    wide = [one.name for one in cells.fixed if one not in cells.constant]
    for result, of_all in figures.items():
        yield f"<h2>{html.escape(result)}</h2>"
        yield html_table(("", *_FIGURES), [("all cells", *_told(of_all))])
        for head, chart in report_charts.maps(study, table, result, found[result]):
            yield f"<figure><figcaption>{html.escape(head)}</figcaption>{chart}</figure>"
        values = found[result]
        yield f"<figure>{_histogram(values[~np.isnan(values)])}</figure>"
        yield from _sensitivities(study, table, found[result])
        rows = [
            (*(_value(at[name]) for name in wide), *_told(those[result])) for at, those in points if result in those
        ]
        yield from _points((*wide, *_FIGURES), rows)
    for result in (name for name, kind in study.results if kind == TEXT):
        counted = Counter(one for one in table.column(result).to_pylist() if one is not None)
        yield f"<h2>{html.escape(result)}</h2>"
        yield html_table(("", "cells"), [(text, str(count)) for text, count in counted.most_common(_MOST_TEXTS)])
    if not has_draws and study.search is None:
        yield "<h2>Cells</h2>"
        rows = [tuple(_value(row[name]) for name in told) for row in table.slice(0, _MOST_POINTS).to_pylist()]
        yield from _points(told, rows)
    yield from _failures(table)
    yield "</html>"


def _points(names: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield a table of points, which opens when it is clicked where it is long."""
    if len(rows) > _MOST_OPEN:
        yield f"<details><summary>{len(rows)} rows</summary>{html_table(names, rows)}</details>"
    elif rows:
        yield html_table(names, rows)


def _goals(study: Study, table: pyarrow.Table) -> Iterator[str]:
    """Yield the front of the study's goals, as far as there is one."""
    if (told := report_charts.goals(study, table)) is not None:
        names, rows, chart = told
        yield f"<h2>Goals</h2><p>{len(rows)} that no other one is better than in all of them:</p>"
        yield html_table(names, rows[:_MOST_FRONT])
        yield chart


def _sensitivities(study: Study, table: pyarrow.Table, values: Floats) -> Iterator[str]:
    """Yield a table of each point of the grid, where all cells are done and have the result."""
    if study.cells.sampling != SENSITIVITY or len(table) < study.cells.count:
        return
    for point in range(min(study.cells.count // study.cells.per_point, _MOST_POINTS)):
        if shares := summary.sensitivities(study, values, point):
            at = study.cells.point(point * study.cells.per_point)
            same = {one.name for one in study.cells.constant}
            head = ", ".join(f"{name} {_value(value)}" for name, value in at.items() if name not in same)
            rows = [(name, f"{one.first_order:.3f}", f"{one.total_order:.3f}") for name, one in shares.items()]
            yield html_table((head or "share of the variance", "alone", "with others"), rows)


def _failures(table: pyarrow.Table) -> Iterator[str]:
    rows = table.select(["cell", "status", "error"]).to_pylist()
    kinds: dict[str, list[dict[str, object]]] = {}
    for row in rows:
        if row["status"] != OK:
            kinds.setdefault(row["error"].strip().splitlines()[-1], []).append(row)
    if not kinds:
        return
    yield "<h2>Cells that failed</h2>"
    for said, those in sorted(kinds.items(), key=lambda kind: -len(kind[1]))[:_MOST_ERRORS]:
        first = those[0]
        about = f"{len(those)} {first['status']}, first cell {first['cell']}: {said}"
        trace = html.escape(str(first["error"]))
        yield f"<details><summary>{html.escape(about)}</summary><pre>{trace}</pre></details>"


def _told(one: Summary) -> tuple[str, ...]:
    before, after = (one.deviation, one.least, one.median, one.nearly_most), (one.most,)
    return (
        str(one.count),
        f"{one.mean:.5g}",
        _interval(one.interval),
        *(f"{value:.5g}" for value in before),
        _interval(one.nearly_most_interval),
        *(f"{value:.5g}" for value in after),
    )


def _interval(ends: tuple[float, float] | None) -> str:
    return "" if ends is None else f"{ends[0]:.5g} to {ends[1]:.5g}"


def _value(value: object) -> str:
    if isinstance(value, int | float):
        return f"{value:.6g}"
    return "" if value is None else str(value)


def _histogram(values: Floats) -> str:
    counts, edges = np.histogram(values, bins=_BARS)
    width, scale = _WIDTH / _BARS, (_HEIGHT - 20) / counts.max()
    bars = (
        f'<rect x="{number * width:.1f}" y="{_HEIGHT - 20 - count * scale:.1f}" width="{width - 1:.1f}" '
        f'height="{count * scale:.1f}"><title>{edges[number]:.5g} to {edges[number + 1]:.5g}: {count}</title></rect>'
        for number, count in enumerate(counts)
    )
    ends = (
        f'<text x="0" y="{_HEIGHT - 4}">{edges[0]:.5g}</text>'
        f'<text x="{_WIDTH}" y="{_HEIGHT - 4}" text-anchor="end">{edges[-1]:.5g}</text>'
    )
    return f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" width="{_WIDTH}" role="img">{"".join(bars)}{ends}</svg>'
