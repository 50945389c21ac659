"""The importer of `.dxf`, on ezdxf."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.importers import Translation

from virtualrobot_plugins.importers.dxf.drawing import Drawn, draw
from virtualrobot_plugins.importers.glb import placed, write_glb
from virtualrobot_plugins.importers.refusal import counted, described, library, listed, refusal, short_name

Document: TypeAlias = Any
"""One of ezdxf's documents: ezdxf is imported only when it is used."""

_BINARY = b"AutoCAD Binary DXF"
_END = re.compile(rb"^[ \t]*(ENDSEC|EOF)[ \t]*\r?$", re.MULTILINE)

UNITS = {
    1: ("inches", 0.0254),
    2: ("feet", 0.3048),
    3: ("miles", 1609.344),
    4: ("millimeters", 1e-3),
    5: ("centimeters", 1e-2),
    6: ("meters", 1.0),
    7: ("kilometers", 1e3),
    8: ("microinches", 0.0254e-6),
    9: ("mils", 0.0254e-3),
    10: ("yards", 0.9144),
    11: ("angstroms", 1e-10),
    12: ("nanometers", 1e-9),
    13: ("microns", 1e-6),
    14: ("decimeters", 0.1),
    15: ("decameters", 10.0),
    16: ("hectometers", 100.0),
    17: ("gigameters", 1e9),
    18: ("astronomical units", 149_597_870_700.0),
    19: ("light years", 9.4607304725808e15),
    20: ("parsecs", 3.0856775814913673e16),
    21: ("US survey feet", 1200.0 / 3937.0),
    22: ("US survey inches", 100.0 / 3937.0),
    23: ("US survey yards", 3600.0 / 3937.0),
    24: ("US survey miles", 6_336_000.0 / 3937.0),
}
"""Name and length in meters of each value of $INSUNITS (Autodesk, DXF reference, "HEADER Section Group Codes")."""

UNITLESS_METERS = 1e-3
"""Length of a drawing's unit (m) where it names none: millimeters, as mechanical drawings have them."""


@dataclass(frozen=True, slots=True)
class DxfSettings:
    """Settings of the DXF importer.

    Attributes:
        unit_meters: the length of the drawing's unit in meters, whatever the file says; 0: as the file says, and
            millimeters where it says nothing.
    """

    unit_meters: Annotated[float, Meta(description="Length of the drawing's unit; 0: as the file says.")] = 0.0


class DxfImporter:
    """Reads DXF drawings (all versions, text and binary): faces, meshes, extruded outlines, blocks, colours."""

    def __init__(self, settings: DxfSettings | None = None) -> None:
        """Take the unit from the settings, where they tell one."""
        self._unit = (settings or DxfSettings()).unit_meters

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], /) -> Translation:
        """Return the drawing's triangles as GLB, in meters and with the axes of the drawing (z up).

        Raises:
            ArgumentError: for a broken file, and for a drawing without anything that has a surface; the message says
                what the drawing holds.
        """
        library("ezdxf", ".dxf", "dxf")
        if not math.isfinite(self._unit) or self._unit < 0.0:
            raise refusal(uri, f"the setting unit_meters is {self._unit:g}; it is above 0, or 0 for the file's own")
        warnings: list[str] = []
        document = _load(data, uri)
        meters = self._meters(document, uri, warnings)
        try:
            with np.errstate(all="ignore"):  # numbers out of range are told by what they yield
                drawn = draw(document)
                to_meters = np.diag((meters, meters, meters, 1.0))
                pieces = [placed(piece, to_meters) for piece in drawn.pieces]
        except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
            # ezdxf checks little of what it loads, so broken values come to light where they are used.
            raise refusal(uri, f"broken DXF file ({described(error)})") from error
        if drawn.refused:
            raise refusal(uri, drawn.refused)
        if not any(len(piece.faces) for piece in pieces):
            raise refusal(uri, _nothing(drawn))
        warnings.extend(_left_out(drawn, uri))
        return Translation(".glb", write_glb(pieces, uri), tuple(warnings))

    def _meters(self, document: Document, uri: str, warnings: list[str]) -> float:
        if self._unit:
            return self._unit
        number = document.header.get("$INSUNITS", 0)
        if number in UNITS:
            return UNITS[number][1]
        told = "tells no unit ($INSUNITS)" if number == 0 else f"has the unknown unit $INSUNITS = {number}"
        warnings.append(f"{short_name(uri)}: the drawing {told}; its numbers are taken as millimeters")
        return UNITLESS_METERS


def _load(data: bytes, uri: str) -> Document:
    """Return ezdxf's document; what is broken but readable is mended."""
    from ezdxf import recover
    from ezdxf.document import Drawing
    from ezdxf.filemanagement import read
    from ezdxf.lldxf.tagger import binary_tags_loader

    if not data.strip():
        raise refusal(uri, "the file is empty")
    binary = data.startswith(_BINARY)
    if not (b"\0EOF\0" in data if binary else _END.search(data, data.rfind(b"ENTITIES"))):
        # ezdxf would give what comes before the cut, which is everything but what is drawn.
        raise refusal(uri, "not a DXF file, or cut off: it ends before its entities do")
    try:
        if binary:
            return Drawing.load(binary_tags_loader(data, errors="ignore"))
        try:
            return read(io.StringIO(data.decode("utf-8", "replace"), newline=None))
        except Exception:  # ezdxf raises whatever a broken file makes it run into
            document, _ = recover.read(io.BytesIO(data), errors="ignore")  # takes twice the time
    except Exception as error:  # ezdxf raises whatever a broken file makes it run into
        raise refusal(uri, f"broken or not a DXF file ({described(error)})") from error
    return document


def _nothing(drawn: Drawn) -> str:
    found = {**drawn.solids, **drawn.flat, **drawn.unknown}
    if not found:
        return "the drawing is empty: it holds no entity that is seen"
    hint = "ACIS bodies cannot be read: export them as meshes" if drawn.solids else "lines and text have no surface"
    return f"nothing in the drawing has a surface; it holds {counted(found)}; {hint}"


def _left_out(drawn: Drawn, uri: str) -> list[str]:
    name = short_name(uri)
    texts: list[str] = []
    if drawn.solids:
        texts.append(f"{name}: left out, since ACIS bodies cannot be read: {counted(drawn.solids)}")
    if drawn.flat or drawn.unknown:
        texts.append(f"{name}: left out, since they have no surface: {counted({**drawn.flat, **drawn.unknown})}")
    if drawn.hidden:
        texts.append(
            f"{name}: left out, since they are invisible or their layer is off or frozen: {drawn.hidden} entities"
        )
    if drawn.missing_blocks:
        texts.append(f"{name}: blocks that are not in the file: {listed(sorted(drawn.missing_blocks))}")
    return texts
