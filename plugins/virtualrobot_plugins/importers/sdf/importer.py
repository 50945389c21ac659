"""The importer of `.sdf` and `.world`.

No library does it: the research of this project found bindings without their native part and readers that refuse real
files.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np
from virtualrobot_sdk.errors import FilesNeeded
from virtualrobot_sdk.importers import Translation

from virtualrobot_plugins.importers.refusal import refusal
from virtualrobot_plugins.importers.sdf.elements import Notes
from virtualrobot_plugins.importers.sdf.nodes import model_nodes
from virtualrobot_plugins.importers.sdf.reader import Reader


class SdfImporter:
    """Reads SDFormat 1.0 to 1.12, models and worlds: robots, parts and objects with shapes, colours and masses."""

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], /) -> Translation:
        """Return the models as a scene file; meshes are named, not read.

        Raises:
            FilesNeeded: for included models.
            ArgumentError: `file:line: element: ...` for a broken file, and for a model with a kinematic loop.
        """
        notes = Notes()
        reader = Reader(uri, files, notes)
        world = reader.document(data)
        if reader.needed:
            raise FilesNeeded(list(reader.needed))
        nodes = []
        with np.errstate(all="ignore"):  # numbers out of range are told by what they yield
            for name, model in world.nested.items():
                nodes += model_nodes(model, name, world.scope_t(name, model.element), uri, notes)
        if not nodes:
            raise refusal(uri, "the file holds no model with a link")
        try:
            text = json.dumps({"schema_version": 1, "nodes": nodes}, indent=1, allow_nan=False)
        except ValueError as error:
            raise refusal(uri, "the file holds numbers that are too large") from error
        return Translation(".yaml", text.encode(), notes.all())
