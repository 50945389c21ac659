"""Curves over time, or something else, as a small SVG: one panel below the other, with one legend."""

from __future__ import annotations

from collections.abc import Sequence
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

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" '
        'font-size="13">',
        f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
    ]
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
        color = COLORS[place % len(COLORS)]
        points = " ".join(f"{at:g},{y(float(value)):g}" for at, value in zip(places, curve, strict=True))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="1.8"/>')
        line = top + 10 + 18 * place
        parts.append(f'<path d="M{WIDTH - RIGHT + 12} {line:g}h20" stroke="{color}" stroke-width="1.8"/>')
        parts.append(f'<text x="{WIDTH - RIGHT + 38}" y="{line + 4:g}">{name}</text>')
    return parts


def ticks(low: float, high: float, most: int) -> list[float]:
    """Return at most about `most` round numbers that enclose the range from low to high."""
    span = max(high - low, 1e-9)
    unit = 10.0 ** np.floor(np.log10(span / most))
    step = next(unit * factor for factor in (1.0, 2.0, 5.0, 10.0) if span / (unit * factor) <= most)
    first, last = np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9)
    return [float(f"{number * step:.12g}") for number in np.arange(first, max(last, first + 1) + 1)]
