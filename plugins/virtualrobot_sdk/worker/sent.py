"""Encoding of questions to a worker: pickled, but each shape only once. From then on it is named by its key."""

from __future__ import annotations

import io
import pickle
from typing import Any

from virtualrobot_sdk.rays import Shape

MOST_UNUSED_BYTES = 64 << 20
"""Bytes that a worker keeps of shapes that the last question with shapes did not name; the longest unused go first."""


class Sent:
    """Packs the questions to one worker, and knows which shapes that one keeps."""

    def __init__(self) -> None:
        """Begin with a worker that keeps nothing."""
        self._kept: dict[str, int] = {}
        """The bytes of each shape by its key, the one unused for longest first."""
        self._to_forget: list[str] = []

    def pack(self, question: object) -> bytes:
        """Return what the worker's `Kept.unpack` makes the question of; raises what pickle raises."""
        content = io.BytesIO()
        pickle.dump(self._to_forget, content, protocol=5)
        pickler = _Pickler(content, self._kept)
        pickler.dump(question)
        self._to_forget = []
        if pickler.named:
            unused = {key: size for key, size in self._kept.items() if key not in pickler.named}
            self._kept = unused | pickler.named
            excess = sum(unused.values()) - MOST_UNUSED_BYTES
            for key, size in unused.items():
                if excess > 0:
                    self._forget(key)
                    excess -= size
        return content.getvalue()

    def doubt(self) -> None:
        """Send all shapes anew: the last question may not have been read to its end."""
        for key in list(self._kept):
            self._forget(key)

    def _forget(self, key: str) -> None:
        del self._kept[key]
        self._to_forget.append(key)


class _Pickler(pickle.Pickler):
    """Writes shapes by their key, those in full that are not among the `kept`."""

    def __init__(self, stream: io.BytesIO, kept: dict[str, int]) -> None:
        super().__init__(stream, protocol=5)
        self.kept = kept
        self.named: dict[str, int] = {}

    def persistent_id(self, one: Any, /) -> tuple[object, ...] | None:  # noqa: ANN401  it is asked of every object
        if type(one) is not Shape:
            return None
        is_there = one.key in self.kept or one.key in self.named
        self.named[one.key] = one.vertices.nbytes + one.triangles.nbytes
        return (one.key,) if is_there else (one.key, one.vertices, one.triangles, one.primitive)
