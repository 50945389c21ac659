"""Charts as PNG pictures, by Pillow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from virtualrobot_apps.chart import COLORS, ticks
from virtualrobot_apps.topic.curves import Floats

_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _GAP, _BOTTOM = 1140, 240, 96, 230, 24, 30, 48
_SQUARE = 560


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """Box of lines by name, each x (n,) and y (n,), all finite. equal: x and y have the same scale, as on a plan."""

    label: str
    lines: Mapping[str, tuple[Floats, Floats]]
    equal: bool = False


def write(path: Path, boxes: Sequence[Box]) -> None:
    """Write boxes, one below the other, as a PNG."""
    heights = [_SQUARE if box.equal else _HEIGHT for box in boxes]
    image = Image.new("RGB", (_WIDTH, _TOP + sum(heights) + _GAP * (len(boxes) - 1) + _BOTTOM), "white")
    draw = ImageDraw.Draw(image)
    top = _TOP
    for place, (box, height) in enumerate(zip(boxes, heights, strict=True)):
        _draw(draw, box, top, height, place == len(boxes) - 1)
        top += height + _GAP
    image.save(path)


def _draw(draw: ImageDraw.ImageDraw, box: Box, top: int, height: int, last: bool) -> None:
    xs = np.concatenate([x for x, _ in box.lines.values()])
    ys = np.concatenate([y for _, y in box.lines.values()])
    across, up = ticks(float(xs.min()), float(xs.max()), 8), ticks(float(ys.min()), float(ys.max()), height // 40)
    left, low = (across[0], up[0]) if box.equal else (float(xs.min()), up[0])
    width = _WIDTH - _LEFT - _RIGHT
    x_scale = width / max((across[-1] if box.equal else float(xs.max())) - left, 1e-9)
    y_scale = height / max(up[-1] - low, 1e-9)
    if box.equal:
        x_scale = y_scale = min(x_scale, y_scale)

    def x_of(value: float) -> float:
        return _LEFT + x_scale * (value - left)

    def y_of(value: float) -> float:
        return top + height - y_scale * (value - low)

    for value in up:
        draw.line([(_LEFT, y_of(value)), (_LEFT + width, y_of(value))], fill="#dddddd")
        draw.text((_LEFT - 8, y_of(value)), f"{value:g}", fill="black", anchor="rm")
    for value in across:
        if _LEFT <= x_of(value) <= _LEFT + width and (last or box.equal):
            draw.text((x_of(value), top + height + 6), f"{value:g}", fill="black", anchor="ma")
    draw.text((8, top), box.label, fill="black")
    if last:
        words = "x in m" if box.equal else "time in s"
        draw.text((_LEFT + width / 2, top + height + 28), words, fill="black", anchor="ma")
    for place, (name, (x, y)) in enumerate(box.lines.items()):
        color = COLORS[place % len(COLORS)]
        points = [(x_of(float(one)), y_of(float(other))) for one, other in zip(x, y, strict=True)]
        if len(points) > 1:
            draw.line(points, fill=color, width=2)
        line = top + 10 + 18 * place
        draw.line([(_WIDTH - _RIGHT + 12, line), (_WIDTH - _RIGHT + 32, line)], fill=color, width=3)
        draw.text((_WIDTH - _RIGHT + 38, line), name, fill="black", anchor="lm")
