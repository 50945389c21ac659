"""Overlay of a picture of the world: lines, points and words, hidden where a surface is in front of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from virtualrobot_kernel.drawing.viewpoint import Viewpoint
from virtualrobot_kernel.numeric.inlay import draw_inlay
from virtualrobot_kernel.numeric.strokes import BIAS, draw_discs, draw_lines

Rgb = tuple[int, int, int]

FONT_PIXELS = 15
PADDING = 4
PLATE = (255, 255, 255, 225)
BORDER = (170, 178, 186, 255)
TEXT: Rgb = (35, 40, 48)
SMALLEST_DISC = 0.8
"""The least radius of a point in pixels: it is seen from far away too."""


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Lines: ends (n, 2, 3) in meters in the world, colours (n, 4) of 0 to 255 and opacity, widths (n,) in pixels."""

    ends: NDArray[np.float64]
    colors: NDArray[np.float32]
    widths: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Dots:
    """Points: places (n, 3) in meters in the world, colours (n, 4) as in `Lines`, diameters (n,) in meters."""

    places: NDArray[np.float64]
    colors: NDArray[np.float32]
    diameters: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Words:
    """Words above a place (3,) in the world; surfaces do not hide them, as in the viewer."""

    text: str
    place: NDArray[np.float64]
    color: Rgb = TEXT


@dataclass(frozen=True, slots=True, eq=False)
class Inlay:
    """A picture that stands in the world.

    Attributes:
        world_t_frame: (4, 4) the frame that it stands in, x to its right, y down and z away from who looks at it.
        edges: (4,) its left, right, upper and lower edge on the plane z = 1.
        distance: it stands at this z, in meters, and so much larger.
        image: (r, c, 3) red, green, blue.
    """

    world_t_frame: NDArray[np.float64]
    edges: NDArray[np.float64]
    distance: float
    image: NDArray[np.uint8]


@dataclass(slots=True, eq=False)
class Overlay:
    """All that is drawn over one picture."""

    lines: list[Lines] = field(default_factory=list)
    dots: list[Dots] = field(default_factory=list)
    words: list[Words] = field(default_factory=list)
    inlays: list[Inlay] = field(default_factory=list)

    def add_lines(self, ends: NDArray[np.float64], color: Rgb, width: float) -> None:
        """Add lines (n, 2, 3) of one colour."""
        colors = np.tile(np.array([*color, 1.0], np.float32), (len(ends), 1))
        self.lines.append(Lines(ends, colors, np.full(len(ends), width)))

    def add_dots(self, places: NDArray[np.float64], colors: NDArray[np.uint8] | Rgb, diameter: float) -> None:
        """Add points (n, 3), of one colour or of one for each (n, 3)."""
        own = np.ones((len(places), 4), np.float32)
        own[:, :3] = colors
        self.dots.append(Dots(places, own, np.full(len(places), diameter)))


def draw_over(picture: NDArray[np.float32], depth: NDArray[np.float32], eye: Viewpoint, overlay: Overlay) -> None:
    """Draw pictures, points and lines on `picture` (h, w, 3), 0 to 255; `depth` (h, w) is of surfaces, in meters."""
    lens = eye.lens
    for inlay in overlay.inlays:
        frame_t_camera = np.linalg.inv(inlay.world_t_frame) @ eye.world_t_camera
        draw_inlay(
            *(picture, depth, lens.directions, lens.pixels, lens.slants, frame_t_camera),
            *(inlay.edges, inlay.distance, inlay.image, BIAS),
        )
    for dots in overlay.dots:
        places = eye.places(dots.places)
        seen = np.isfinite(places).all(axis=1)
        radii = np.maximum(0.5 * dots.diameters[seen] * eye.pixels_per_meter(places[seen, 2]), SMALLEST_DISC)
        draw_discs(picture, depth, np.ascontiguousarray(places[seen]), dots.colors[seen], radii, BIAS)
    for lines in overlay.lines:
        ends, rows = eye.lines(lines.ends)
        draw_lines(picture, depth, ends, lines.colors[rows], lines.widths[rows], BIAS)


def write_words(picture: NDArray[np.uint8], eye: Viewpoint, words: list[Words]) -> None:
    """Write words on plates above their places into a picture (h, w, 3), the nearest on top."""
    if not words:
        return
    places = eye.places(np.array([one.place for one in words]))
    height, width = picture.shape[:2]
    font = ImageFont.load_default(FONT_PIXELS)
    ruler = ImageDraw.Draw(Image.new("RGB", (1, 1)))
    for i in np.argsort(places[:, 2]).tolist():
        column, row, _ = places[i]
        if not (-width < column < 2 * width and -height < row < 2 * height):  # what is not in view is NaN
            continue
        box = ruler.multiline_textbbox((0, 0), words[i].text, font, align="center")
        wide, high = math.ceil(box[2] - box[0]) + 2 * PADDING, math.ceil(box[3] - box[1]) + 2 * PADDING
        left, top = round(column - 0.5 * wide), round(row - high - PADDING)
        rows = slice(max(top, 0), max(min(top + high + 1, height), 0))
        columns = slice(max(left, 0), max(min(left + wide + 1, width), 0))
        patch = picture[rows, columns]
        if not patch.size:
            continue
        image = Image.fromarray(patch)
        draw = ImageDraw.Draw(image, "RGBA")
        x, y = left - columns.start, top - rows.start
        draw.rounded_rectangle((x, y, x + wide, y + high), PADDING, PLATE, BORDER)
        start = (x + PADDING - box[0], y + PADDING - box[1])
        draw.multiline_text(start, words[i].text, words[i].color, font, align="center")
        patch[:] = np.asarray(image)
