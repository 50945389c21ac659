"""Collision scenes for calls: each is used by one thread at a time and kept for the next call."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager

from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.scene import CollisionScene

KEPT = 4
"""Number of scenes that are kept: as many as calls have threads at once."""


class ScenePool:
    """Scenes that are free; any thread may take one.

    Attributes:
        shapes: what they are made of.
    """

    def __init__(self, shapes: CollisionShapes) -> None:
        """Make scenes of these shapes, each when it is needed."""
        self.shapes = shapes
        self._free: deque[CollisionScene] = deque(maxlen=KEPT)

    @contextmanager
    def scene(self) -> Iterator[CollisionScene]:
        """Lend a scene to this thread; one whose use raised is not kept."""
        try:
            scene = self._free.pop()  # the last used: most of it stands where it must
        except IndexError:
            scene = CollisionScene(self.shapes)
        yield scene
        self._free.append(scene)
