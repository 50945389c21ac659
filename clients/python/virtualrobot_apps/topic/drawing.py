"""Drawings of curves and trails: SVG by the chart of all applications, PNG by Pillow, and letters of a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from virtualrobot.errors import InvalidArgumentError, WrongStateError

from virtualrobot_apps.chart import COLORS, Panel, chart, plan, ticks
from virtualrobot_apps.topic.curves import MINUS, Curve, Floats, together

MOST_POINTS = 2000
"""Greatest number of points of a drawn curve: more are not seen."""

ENDINGS = (".svg", ".png")
_MARKS = "ox+*#@%&"


def svg(curves: Sequence[Curve]) -> str:
    """Return an SVG of curves over time: one panel for those of the same last word, such as `position`."""
    times, table = together(curves)
    kept = _thinned(len(times))
    panels = []
    for label, places in _panels(curves).items():
        names = [curves[place].name for place in places]
        panels.append(Panel(label, [_short(name) for name in names], table[kept][:, places]))
    return chart(times[kept], panels)


def check(path: Path) -> None:
    """Raise InvalidArgumentError for a picture that ends with neither .svg nor .png, or is in no folder."""
    if path.suffix.lower() not in ENDINGS:
        raise InvalidArgumentError(f"a picture ends with {' or '.join(ENDINGS)}, not {path.suffix or path.name!r}")
    if not path.parent.is_dir():
        raise InvalidArgumentError(f"there is no folder {path.parent} for the picture")


def write(path: Path, curves: Sequence[Curve] = (), ways: Mapping[str, Floats] | None = None) -> None:
    """Write curves over time, or trails from above, to a picture.

    Raises:
        InvalidArgumentError: as `check` does.
        WrongStateError: when Pillow is missing that writes a .png.
    """
    check(path)
    if path.suffix.lower() == ".svg":
        path.write_text(svg(curves) if ways is None else plan(ways), "utf-8")
        return
    try:
        from virtualrobot_apps.topic import raster
    except ImportError as error:
        raise WrongStateError("a .png needs Pillow: pip install 'virtualrobot[kernel]', or write an .svg") from error
    if ways is not None:
        raster.write(path, [raster.Box("y in m", {name: (way[:, 0], way[:, 1]) for name, way in ways.items()}, True)])
        return
    begin = min(float(one.times[0]) for one in curves)
    boxes = []
    for label, places in _panels(curves).items():
        lines = {}
        for place in places:
            kept = _thinned(len(curves[place].times))
            lines[_short(curves[place].name)] = curves[place].times[kept] - begin, curves[place].values[kept]
        boxes.append(raster.Box(label, lines))
    raster.write(path, boxes)


def letters(curves: Sequence[Curve], width: int = 78, height: int = 16) -> str:
    """Return curves over time as lines of letters, one letter for each curve, with a legend."""
    times, table = together(curves)
    scale = ticks(float(table.min()), float(table.max()), 4)
    low, high = scale[0], scale[-1]
    field = [[" "] * width for _ in range(height)]
    span = max(float(times[-1]), 1e-9)
    for place, column in enumerate(table.T):
        for time, value in zip(times, column, strict=True):
            x = min(int(width * time / span), width - 1)
            y = min(int(height * (high - value) / (high - low)), height - 1)
            field[y][x] = _MARKS[place % len(_MARKS)]
    edge = max(len(f"{high:g}"), len(f"{low:g}"))
    lines = []
    for row, cells in enumerate(field):
        label = f"{high:g}" if row == 0 else f"{low:g}" if row == height - 1 else ""
        lines.append(f"{label.rjust(edge)} |{''.join(cells).rstrip()}")
    lines.append(f"{' ' * edge} +{'-' * width}")
    lines.append(f"{' ' * edge}  0{f'{span:.3g} s'.rjust(width - 1)}")
    lines += [f"  {_MARKS[place % len(_MARKS)]} {one.name}" for place, one in enumerate(curves)]
    return "\n".join(lines)


def _panels(curves: Sequence[Curve]) -> dict[str, list[int]]:
    """Return the places of curves that are drawn together: those with the same last word, at most seven."""
    found: dict[str, list[int]] = {}
    for place, one in enumerate(curves):
        word = one.name.replace(":", "/").rpartition("/")[2]
        if MINUS in one.name:
            word = "difference"
        count = sum(len(places) for label, places in found.items() if label.split(" (")[0] == word)
        part = count // len(COLORS)
        found.setdefault(word if not part else f"{word} ({part + 1})", []).append(place)
    return found


def _short(name: str) -> str:
    """Return as much of a name as a legend has room for."""
    words = name.replace(":", "/").split("/")
    return name if MINUS not in name and len(name) < 20 else "/".join(words[-2:])[-20:]


def _thinned(count: int) -> np.ndarray:
    return np.unique(np.linspace(0, count - 1, min(count, MOST_POINTS)).astype(int))
