"""Charts of a report, in SVG: heat maps over two parameters, and fronts of two goals."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_apps.studies.parameters import Floats

_SCALE = np.array([[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]])
"""Colours from the least to the greatest value: five of the map `viridis` (Nathaniel Smith, Stefan van der Walt)."""
_NONE = "#dddddd"
_SIDE, _LEFT, _BELOW, _RIGHT = 360, 90, 40, 120
_FRONT, _DOMINATED, _CURVE = "#ee6677", "#bbbbbb", "#4477aa"
_MARGIN = 0.05


@dataclass(frozen=True)
class Axis:
    """Axis of a chart: what it is called, and its values or ends in order."""

    name: str
    values: Sequence[float]


class Chart(str):
    """SVG of a chart, which a notebook shows as a picture."""

    def _repr_html_(self) -> str:
        return str(self)


def heat_map(across: Axis, up: Axis, values: Floats, ends: tuple[float, float]) -> Chart:
    """Return the map of values (rows up, columns across), the first row at the bottom; NaN is grey.

    `ends` are the least and the greatest value that have a colour of their own, so that several maps share them.
    """
    rows, columns = values.shape
    width, height = _SIDE / columns, _SIDE / rows
    lines = [_begin(_LEFT + _SIDE + _RIGHT, _SIDE + _BELOW)]
    for row, column in np.ndindex(rows, columns):
        value = float(values[row, column])
        at = f"{across.name} {across.values[column]:.5g}, {up.name} {up.values[row]:.5g}"
        said = f"{html.escape(at)}: {'none' if np.isnan(value) else f'{value:.5g}'}"
        # A little wider, so that no line is left between two.
        lines.append(
            f'<rect x="{_LEFT + column * width:.2f}" y="{(rows - 1 - row) * height:.2f}" width="{width + 0.3:.2f}" '
            f'height="{height + 0.3:.2f}" style="fill:{color(value, ends)}"><title>{said}</title></rect>'
        )
    lines += _axes(across.name, (across.values[0], across.values[-1]), up.name, (up.values[0], up.values[-1]))
    return Chart("".join([*lines, *_legend(ends), "</svg>"]))


def color(value: float, ends: tuple[float, float]) -> str:
    """Return the colour of a value between two ends; that of none for NaN."""
    return _NONE if np.isnan(value) else "#" + colors([value], ends)[0].tobytes().hex()


def colors(values: Sequence[float], ends: tuple[float, float] | None = None) -> NDArray[np.uint8]:
    """Return the colours (n, 3), 0 to 255, of n values between two ends, by default the least and the greatest."""
    least, most = ends or (min(values), max(values))
    shares = (np.asarray(values) - least) / (most - least) if most > least else np.full(len(values), 0.5)
    places = np.clip(shares, 0.0, 1.0) * (len(_SCALE) - 1)
    parts = [np.interp(places, range(len(_SCALE)), _SCALE[:, one]) for one in range(3)]
    return np.stack(parts, axis=1).round().astype(np.uint8)


def is_on_front(costs: Floats) -> NDArray[np.bool_]:
    """Return (n,) which of some costs (n, d) no other one dominates: is less in one, and greater in none.

    Equal ones are on it together. In the order by the first cost none is dominated by a later one (H. T. Kung et al.,
    "On finding the maxima of a set of vectors", 1975).
    """
    order = np.lexsort(costs.T[::-1])
    kept = np.zeros(len(costs), np.bool_)
    front = np.empty((0, costs.shape[1]))
    for number in order.tolist():
        cost = costs[number]
        if not ((front <= cost).all(axis=1) & (front < cost).any(axis=1)).any():
            kept[number] = True
            front = np.concatenate([front, cost[None]])
    return kept


def front(across: Axis, up: Axis, is_best: NDArray[np.bool_], labels: Sequence[str]) -> str:
    """Return the chart of points by two goals, those of the front in red; each says on being pointed at what it is."""
    fills = [_FRONT if best else _DOMINATED for best in is_best.tolist()]
    # The front last, so that nothing covers it.
    return "".join([*_points(across, up, fills, np.argsort(is_best, kind="stable").tolist(), labels), "</svg>"])


def scatter(across: Axis, up: Axis, values: Floats, ends: tuple[float, float], labels: Sequence[str]) -> str:
    """Return the chart of points by two parameters, in the colours of their values (n,), as in `heat_map`."""
    fills = [color(value, ends) for value in values.tolist()]
    return "".join([*_points(across, up, fills, list(range(len(fills))), labels), *_legend(ends), "</svg>"])


def curve(across: Axis, up: Axis) -> str:
    """Return the chart of values over one parameter, NaN left out; each says on being pointed at what it is."""
    there = [one for one in zip(across.values, up.values, strict=True) if not np.isnan(one[1])]
    across, up = (Axis(one.name, values) for one, values in zip((across, up), zip(*there, strict=True), strict=True))
    labels = [f"{across.name} {x:.5g}: {value:.5g}" for x, value in there]
    return "".join([*_points(across, up, [_CURVE] * len(there), range(len(there)), labels, True), "</svg>"])


def _points(
    across: Axis, up: Axis, fills: Sequence[str], order: Sequence[int], labels: Sequence[str], is_joined: bool = False
) -> list[str]:
    """Return points with axes, those of the front larger; each says on being pointed at what it is."""
    x, y = np.asarray(across.values), np.asarray(up.values)
    ends = [_widened(values) for values in (x, y)]
    left = _LEFT + _SIDE * (x - ends[0][0]) / (ends[0][1] - ends[0][0])
    top = _SIDE * (1.0 - (y - ends[1][0]) / (ends[1][1] - ends[1][0]))
    lines = [_begin(_LEFT + _SIDE + _RIGHT, _SIDE + _BELOW)]
    lines.append(f'<path d="M{_LEFT} 0V{_SIDE}H{_LEFT + _SIDE}" style="fill:none;stroke:#888"/>')
    if is_joined:
        way = " ".join(f"{left[number]:.1f},{top[number]:.1f}" for number in order)
        lines.append(f'<polyline points="{way}" style="fill:none;stroke:{_CURVE}"/>')
    for number in order:
        radius = 5 if fills[number] == _FRONT else 3
        lines.append(
            f'<circle cx="{left[number]:.1f}" cy="{top[number]:.1f}" r="{radius}" style="fill:{fills[number]}">'
            f"<title>{html.escape(labels[number])}</title></circle>"
        )
    return [*lines, *_axes(across.name, ends[0], up.name, ends[1])]


def _legend(ends: tuple[float, float]) -> list[str]:
    """Return the colours from the least to the greatest value, beside the chart."""
    lines, steps = [], 20
    for step in range(steps):
        value = ends[0] + (ends[1] - ends[0]) * (step + 0.5) / steps
        top = _SIDE * (1.0 - (step + 1) / steps)
        lines.append(
            f'<rect x="{_LEFT + _SIDE + 20}" y="{top:.1f}" width="16" height="{_SIDE / steps + 0.3:.1f}" '
            f'style="fill:{color(value, ends)}"/>'
        )
    for value, top in ((ends[0], _SIDE), (ends[1], 12)):
        lines.append(f'<text x="{_LEFT + _SIDE + 42}" y="{top}">{value:.5g}</text>')
    return lines


def _widened(values: Floats) -> tuple[float, float]:
    least, most = float(values.min()), float(values.max())
    more = _MARGIN * (most - least) or 0.5 * abs(most) or 1.0
    return least - more, most + more


def _begin(width: int, height: int) -> str:
    return f'<svg viewBox="0 0 {width} {height}" width="{width}" role="img">'


def _axes(across: str, ends_across: tuple[float, float], up: str, ends_up: tuple[float, float]) -> list[str]:
    """Return the names of both axes and the numbers at their ends."""
    below, beside, middle = _SIDE + 16, _LEFT - 8, _SIDE // 2
    return [
        f'<text x="{_LEFT}" y="{below}">{ends_across[0]:.5g}</text>',
        f'<text x="{_LEFT + _SIDE}" y="{below}" text-anchor="end">{ends_across[1]:.5g}</text>',
        f'<text x="{_LEFT + _SIDE / 2:.0f}" y="{below + 14}" text-anchor="middle">{html.escape(across)}</text>',
        f'<text x="{beside}" y="{_SIDE}" text-anchor="end">{ends_up[0]:.5g}</text>',
        f'<text x="{beside}" y="12" text-anchor="end">{ends_up[1]:.5g}</text>',
        f'<text transform="translate({_LEFT - 30} {middle}) rotate(-90)" text-anchor="middle">{html.escape(up)}</text>',
    ]
