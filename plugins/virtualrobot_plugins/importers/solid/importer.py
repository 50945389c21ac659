"""The importer of `.solid`: bodies that a text describes, made of each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import yaml
from virtualrobot_sdk.importers import Translation

from virtualrobot_plugins.importers.glb import Color, Piece, write_glb
from virtualrobot_plugins.importers.refusal import library, refusal
from virtualrobot_plugins.importers.solid import grammar

if TYPE_CHECKING:
    from manifold3d import Manifold

MAX_BYTES = 2**20
SHARP_DEGREES = 40.0
"""Edges whose faces turn more than that are seen as edges, others as parts of a round surface."""


class SolidImporter:
    """Reads `.solid` files: boxes, extrusions, turned profiles, what joins and cuts them, rows, rings and mirrors."""

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], /) -> Translation:
        """Return the bodies as GLB, in meters.

        Raises:
            ArgumentError: for what makes no body; the message names the place, such as `solid.difference[1].cylinder`.
        """
        if len(data) > MAX_BYTES:
            raise refusal(uri, f"the file has {len(data)} bytes; at most {MAX_BYTES} are read")
        library("manifold3d", ".solid", "modeller")
        from virtualrobot_plugins.importers.solid.building import Builder, Wrong, taken

        try:
            tree = yaml.load(data.decode(), yaml.CSafeLoader)
        except UnicodeDecodeError as error:
            raise refusal(uri, "the file is no text in UTF-8") from error
        except yaml.MarkedYAMLError as error:
            line = None if error.problem_mark is None else error.problem_mark.line + 1
            raise refusal(uri, f"no YAML: {error.problem}", line) from error
        except (yaml.YAMLError, RecursionError, ValueError) as error:
            raise refusal(uri, f"no YAML: {error}") from error
        try:
            file = taken(tree, grammar.File, "")
            parts = [grammar.Part(file.solid)] if file.solid is not None else []
            if bool(parts) == bool(file.parts):
                raise Wrong("", "the file has either `solid`, one body, or `parts`, bodies with colours")
            builder = Builder(file.solids, file.tolerance)
            pieces = []
            for number, part in enumerate(parts or file.parts):
                place = "solid" if parts else f"parts[{number}].solid"
                body = builder.solid(part.solid, place)
                if body.is_empty():
                    raise Wrong(place, "nothing is left of it")
                pieces.append(_piece(body, _color(part.color, f"parts[{number}].color")))
        except Wrong as error:
            raise refusal(uri, str(error)) from None
        return Translation(".glb", write_glb(pieces, uri))


def _color(color: str | list[float] | None, place: str) -> Color | None:
    from PIL import ImageColor

    from virtualrobot_plugins.importers.solid.building import Wrong

    if color is None:
        return None
    if isinstance(color, str):
        try:
            values = [value / 255.0 for value in ImageColor.getrgb(color)]
        except ValueError:
            raise Wrong(place, f"{color!r} is no colour: `orange`, `#ff8800`, or numbers from 0 to 1") from None
    else:
        values = color
    if not all(0.0 <= value <= 1.0 for value in values):
        raise Wrong(place, f"the numbers of a colour are from 0 to 1, not {values}")
    red, green, blue, opacity = (*values, 1.0)[:4]
    return red, green, blue, opacity


def _piece(body: Manifold, color: Color | None) -> Piece:
    """Return the triangles of a body, with normals that are smooth where it is round."""
    mesh = body.calculate_normals(0, SHARP_DEGREES).to_mesh()
    values = np.asarray(mesh.vert_properties, float)
    return Piece(values[:, :3], np.asarray(mesh.tri_verts), color, values[:, 3:6])
