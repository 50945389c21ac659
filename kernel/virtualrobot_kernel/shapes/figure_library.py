"""Library of what is made of figures: triangles for rays, solids for collisions, files for the browser."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Collection
from typing import Generic, TypeVar

from virtualrobot_kernel.shapes.submesh import Meshes

Key = TypeVar("Key")
Made = TypeVar("Made")


class FigureLibrary(ABC, Generic[Key, Made]):
    """Library of what is made of figures, each once, when first asked for; any thread may ask.

    Nothing is made under the lock: two threads that ask for the same new one at once both make it, and keep one.
    """

    def __init__(self, meshes: Meshes) -> None:
        """Take the triangles of meshes from `meshes`."""
        self.meshes = meshes
        self._kept: dict[Key, Made] = {}
        self._lock = threading.Lock()

    def get(self, key: Key) -> Made:
        """Return what is made of a figure."""
        kept = self._kept.get(key)
        if kept is not None:
            return kept
        made = self._made(key)
        if made is None:
            return made
        with self._lock:
            return self._kept.setdefault(key, made)

    def __len__(self) -> int:
        """Return of how many figures something is kept."""
        return len(self._kept)

    def keep(self, keys: Collection[Key]) -> None:
        """Forget what was made of all figures but these; who uses it meanwhile has it still."""
        with self._lock:
            self._kept = {key: made for key, made in self._kept.items() if key in keys}

    @abstractmethod
    def _made(self, key: Key) -> Made:
        """Return what is made of a figure; None is not kept."""
