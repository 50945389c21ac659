"""Curves over time, or something else, as a small SVG: one panel below the other, with one legend."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

WIDTH, PANEL, LEFT, RIGHT, TOP, GAP, BOTTOM = 760, 150, 64, 150, 20, 22, 42
"""Pixels; the last five are the margins around the panels and the gap between two of them."""

COLORS = ("#1f5fa8", "#c0392b", "#2e8b57", "#8e5bb0", "#d2841f", "#5d6770", "#20a5b5")


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """Curves (n, k) with their names; `label` says what they are, with the unit. height: in pixels."""

    label: str
    names: Sequence[str]
    curves: NDArray[np.float64]
    height: int = PANEL


def chart(
    times: NDArray[np.float64], panels: Sequence[Panel], marks: Sequence[float] = (), along: str = "time in s"
) -> str:
    """Return an SVG of panels over times (n,), or what `along` says, from 0; `marks` are those with a dashed line."""
    height = TOP + sum(panel.height for panel in panels) + GAP * (len(panels) - 1) + BOTTOM
    end = float(times[-1])

    def x(seconds: float) -> float:
        return round(LEFT + (WIDTH - LEFT - RIGHT) * seconds / end, 1)

    parts = _head(height)
    top = float(TOP)
    for panel in panels:
        parts += _panel(panel, top, [x(float(time)) for time in times])
        for mark in marks:
            parts.append(f'<path d="M{x(mark)} {top:g}v{panel.height}" stroke="#888" stroke-dasharray="4 3"/>')
        top += panel.height + GAP
    bottom = top - GAP
    for seconds in (tick for tick in ticks(0.0, end, 8) if tick <= end):
        parts.append(f'<path d="M{x(seconds)} {bottom:g}v4" stroke="#888"/>')
        parts.append(f'<text x="{x(seconds)}" y="{bottom + 18:g}" text-anchor="middle">{seconds:g}</text>')
    parts.append(f'<text x="{x(end / 2)}" y="{height - 8}" text-anchor="middle">{along}</text>')
    return "\n".join([*parts, "</svg>\n"])


def plan(ways: Mapping[str, NDArray[np.float64]], size: int = 400, areas: Sequence[NDArray[np.float64]] = ()) -> str:
    """Return an SVG of ways (n, 2) from above, by name: x (m) to the right, and y up, at the same scale.

    `areas` are polygons (m, 2) below them, such as walls.
    """
    points = np.vstack([*ways.values(), *areas])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = size / max(float((high - low).max()), 1e-6)
    parts = _head(TOP + size + BOTTOM)

    def x(value: float) -> float:
        return round(LEFT + scale * (value - float(low[0])), 1)

    def y(value: float) -> float:
        return round(TOP + scale * (float(high[1]) - value), 1)

    for value in (tick for tick in ticks(float(low[0]), float(high[0]), 6) if low[0] <= tick <= high[0]):
        parts.append(f'<text x="{x(value)}" y="{y(float(low[1])) + 20:g}" text-anchor="middle">{value:g}</text>')
    for value in (tick for tick in ticks(float(low[1]), float(high[1]), 6) if low[1] <= tick <= high[1]):
        parts.append(f'<text x="{LEFT - 12}" y="{y(value) + 4:g}" text-anchor="end">{value:g}</text>')
    for area in areas:
        corners = " ".join(f"{x(float(east)):g},{y(float(north)):g}" for east, north in area)
        parts.append(f'<polygon points="{corners}" fill="#ddd5c8"/>')
    for place, (name, way) in enumerate(ways.items()):
        drawn = " ".join(f"{x(float(east)):g},{y(float(north)):g}" for east, north in way)
        parts += _curve(drawn, place, name, LEFT + size + 40, TOP)
    parts.append(
        f'<text x="{LEFT + size / 2:g}" y="{TOP + size + BOTTOM - 4}" text-anchor="middle">x and y in m</text>'
    )
    return "\n".join([*parts, "</svg>\n"])


def stacked(*pictures: str) -> str:
    """Return an SVG of pictures of this module, one below the other."""
    parts, top = [], 0
    for picture in pictures:
        found = re.search(r'viewBox="0 0 \d+ (\d+)"', picture)
        assert found is not None
        parts.append(picture.replace("<svg ", f'<svg y="{top}" width="{WIDTH}" height="{found[1]}" ', 1))
        top += int(found[1])
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {top}">\n{"".join(parts)}</svg>\n'


def _head(height: int) -> list[str]:
    """Return the first lines of an SVG that is so high."""
    return [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" '
        'font-size="13">',
        f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
    ]


def _curve(points: str, place: int, name: str, left: float, top: float) -> list[str]:
    """Return a curve in the colour of its place, and its name in the legend there."""
    color, line = COLORS[place % len(COLORS)], top + 10 + 18 * place
    return [
        f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="1.8"/>',
        f'<path d="M{left} {line:g}h20" stroke="{color}" stroke-width="1.8"/>',
        f'<text x="{left + 26}" y="{line + 4:g}">{name}</text>',
    ]


def _panel(panel: Panel, top: float, places: Sequence[float]) -> list[str]:
    """Return the lines of a panel whose samples are at these x."""
    steps = ticks(float(min(panel.curves.min(), 0.0)), float(max(panel.curves.max(), 0.0)), panel.height // 30)
    low, high = steps[0], steps[-1]

    def y(value: float) -> float:
        return round(top + panel.height * (high - value) / (high - low), 1)

    parts = []
    for value in steps:
        color = "#888" if value == 0.0 else "#ddd"
        parts.append(f'<path d="M{LEFT} {y(value)}H{WIDTH - RIGHT}" stroke="{color}"/>')
        parts.append(f'<text x="{LEFT - 8}" y="{y(value) + 4:g}" text-anchor="end">{value:g}</text>')
    turned = f'transform="translate(18 {top + panel.height / 2:g}) rotate(-90)"'
    parts.append(f'<text {turned} text-anchor="middle">{panel.label}</text>')
    for place, (name, curve) in enumerate(zip(panel.names, panel.curves.T, strict=True)):
        points = " ".join(f"{at:g},{y(float(value)):g}" for at, value in zip(places, curve, strict=True))
        parts += _curve(points, place, name, WIDTH - RIGHT + 12, top)
    return parts


def ticks(low: float, high: float, most: int) -> list[float]:
    """Return at most about `most` round numbers that enclose the range from low to high."""
    span = max(high - low, 1e-9)
    unit = 10.0 ** np.floor(np.log10(span / most))
    step = next(unit * factor for factor in (1.0, 2.0, 5.0, 10.0) if span / (unit * factor) <= most)
    first, last = np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9)
    return [float(f"{number * step:.12g}") for number in np.arange(first, max(last, first + 1) + 1)]
