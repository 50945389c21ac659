"""The shapes that a worker keeps: each comes with the first question that names it (`sent` is the parent's side)."""

from __future__ import annotations

import io
import pickle
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from virtualrobot_sdk.rays import Shape


class Kept:
    """Reads the questions of the parent, and owns the shapes that came with them; their arrays are read-only."""

    def __init__(self) -> None:
        """Begin without any."""
        self._shapes: dict[str, Shape] = {}

    def unpack(self, content: bytes | bytearray) -> Any:  # noqa: ANN401  a question is anything
        """Return what `Sent.pack` was given; raises what pickle raises."""
        stream = io.BytesIO(content)
        for key in pickle.load(stream):
            self._shapes.pop(key, None)
        return _Unpickler(stream, self._shapes).load()


class _Unpickler(pickle.Unpickler):
    def __init__(self, stream: io.BytesIO, shapes: dict[str, Shape]) -> None:
        super().__init__(stream)
        self._shapes = shapes

    def persistent_load(self, pid: Any, /) -> Shape:  # noqa: ANN401  as pickle calls it
        key, *content = pid
        if content:
            # What not every worker needs is imported where it is needed: the process shall start quickly.
            from virtualrobot_sdk.rays import Shape

            vertices, triangles, primitive = content
            vertices.setflags(write=False)
            triangles.setflags(write=False)
            self._shapes[key] = Shape(vertices, triangles, key, primitive)
        return self._shapes[key]
