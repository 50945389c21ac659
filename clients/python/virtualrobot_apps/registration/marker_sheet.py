"""Sheets with a marker to be printed: its squares in mm, as SVG, PDF or PNG."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray
from virtualrobot._wire.showing import png
from virtualrobot.errors import InvalidArgumentError

Bits = NDArray[np.bool_]

PAPERS = {"a4": (210.0, 297.0), "a3": (297.0, 420.0), "letter": (215.9, 279.4)}
"""Width and height of papers, mm."""

RULER = 100.0
"""Length (mm) of the line by which people see whether it was printed in its true size."""

DOTS = 300
"""Dots of a PNG per inch."""

_POINTS = 72.0 / 25.4
_TEXT = 4.0


@dataclass(frozen=True, slots=True)
class Sheet:
    """Paper with black rectangles and words; all in mm, x to the right and y down from the upper left corner.

    Attributes:
        width: of the paper.
        height: of it.
        rectangles: x, y, width, height of each.
        words: x, y of the baseline's beginning, and the text, 4 mm high.
    """

    width: float
    height: float
    rectangles: tuple[tuple[float, float, float, float], ...]
    words: tuple[tuple[float, float, str], ...]


def sheet(bits: Bits, edge: float, number: int, paper: str = "a4") -> Sheet:
    """Return the sheet of a marker in the middle of a paper.

    Args:
        bits: (k, k) its squares with their border, row by row from above; True is white.
        edge: of the black square, m.
        number: of the marker, for the words.
        paper: `a4`, `a3` or `letter`.

    Raises:
        InvalidArgumentError: for a paper that isn't known, and for a marker that leaves no white edge of one of its
            squares on it.
    """
    if paper not in PAPERS:
        raise InvalidArgumentError(f"there is no paper {paper!r}; there are {', '.join(PAPERS)}")
    width, height = PAPERS[paper]
    size, count = 1e3 * edge, len(bits)
    most = width * count / (count + 2)
    if not 0.0 < size <= most:
        raise InvalidArgumentError(
            f"an edge of {size:g} mm doesn't go on {paper}: it is above 0 and at most {math.floor(most)} mm, since one "
            "square of white belongs around a marker"
        )
    square, left, top = size / count, (width - size) / 2.0, (height - size) / 2.0
    squares = [
        (left + square * begin, top + square * row, square * (end - begin), square)
        for row in range(count)
        for begin, end in _runs(~bits[row])
    ]
    below = (height + size) / 2.0 + square
    ruler = [(left, below + 6.0, RULER, 0.5), *((left + at, below + 3.0, 0.5, 6.5) for at in (0.0, RULER - 0.5))]
    words = (
        (left, below + 16.0, f"marker {number}, {size:g} mm from black edge to black edge; the line is {RULER:g} mm"),
        (left, below + 22.0, "print it in its true size (100%), measure both, and keep it flat"),
        (left, below + 28.0, "its frame: middle of the marker, x to the right, y up, z out of the paper"),
    )
    return Sheet(width, height, (*squares, *ruler), words)


def _runs(black: Bits) -> list[tuple[int, int]]:
    """Return where runs of True begin and end in a row."""
    steps = np.flatnonzero(np.diff(np.concatenate([[False], black, [False]]).astype(np.int8)))
    return list(zip(steps[::2].tolist(), steps[1::2].tolist(), strict=True))


def as_svg(page: Sheet) -> bytes:
    """Return a sheet as SVG of its true size."""
    squares = "".join(
        f'<rect x="{x:.4f}" y="{y:.4f}" width="{w:.4f}" height="{h:.4f}"/>' for x, y, w, h in page.rectangles
    )
    words = "".join(f'<text x="{x:.4f}" y="{y:.4f}">{escape(text)}</text>' for x, y, text in page.words)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{page.width:g}mm" height="{page.height:g}mm" '
        f'viewBox="0 0 {page.width:g} {page.height:g}">'
        '<rect width="100%" height="100%" fill="white"/>'
        f'<g shape-rendering="crispEdges">{squares}</g>'
        f'<g font-family="sans-serif" font-size="{_TEXT:g}">{words}</g></svg>\n'
    ).encode()


def as_pdf(page: Sheet) -> bytes:
    """Return a sheet as a PDF of one page (ISO 32000-1), without a font in it: each reader has Helvetica."""

    def points(*values: float) -> str:
        return " ".join(f"{_POINTS * value:.4f}" for value in values)

    squares = [f"{points(x, page.height - y - h, w, h)} re" for x, y, w, h in page.rectangles]
    words = [
        f"BT /F1 {points(_TEXT)} Tf {points(x, page.height - y)} Td ({_pdf_text(text)}) Tj ET"
        for x, y, text in page.words
    ]
    drawn = "\n".join([*squares, "f", *words]).encode("latin-1")
    things = (
        b"<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {points(page.width, page.height)}] /Contents 4 0 R "
        "/Resources << /Font << /F1 5 0 R >> >> >>".encode(),
        b"<< /Length %d >>\nstream\n%s\nendstream" % (len(drawn), drawn),
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
    )
    file, places = bytearray(b"%PDF-1.6\n"), list[int]()
    for number, thing in enumerate(things, 1):
        places.append(len(file))
        file += b"%d 0 obj\n%s\nendobj\n" % (number, thing)
    table = "".join(f"{place:010d} 00000 n \n" for place in places)
    end = len(file)
    file += f"xref\n0 {len(things) + 1}\n0000000000 65535 f \n{table}".encode()
    file += f"trailer\n<< /Size {len(things) + 1} /Root 1 0 R >>\nstartxref\n{end}\n%%EOF\n".encode()
    return bytes(file)


def _pdf_text(text: str) -> str:
    return text.replace("\\", r"\\").replace("(", r"\(").replace(")", r"\)")


def as_png(page: Sheet) -> bytes:
    """Return a sheet as PNG of 300 dots per inch, black on white, without its words."""
    scale = DOTS / 25.4
    is_white = np.ones((round(page.height * scale), round(page.width * scale)), dtype=np.bool_)
    for x, y, w, h in page.rectangles:
        is_white[round(y * scale) : round((y + h) * scale), round(x * scale) : round((x + w) * scale)] = False
    return png(is_white, round(DOTS / 0.0254))


WRITERS: dict[str, Callable[[Sheet], bytes]] = {".pdf": as_pdf, ".png": as_png, ".svg": as_svg}
"""Writers of sheets by the ending of a file's name."""
