"""Scene of rays of a thread that sees, and what it saw last, so that only what changed is made anew."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.embree import TopScene, unavailable

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary, Appearances
from virtualrobot_kernel.sensing.coats import Shown, with_coats
from virtualrobot_kernel.sensing.elements import Elements, elements_of
from virtualrobot_kernel.sensing.lenses import Lens
from virtualrobot_kernel.sensing.lights import lights_of
from virtualrobot_kernel.sensing.picture import BACKGROUND, Color, Picture, Subject, render
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.sensing import ImageKind
from virtualrobot_kernel.world.state import Snapshot


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """Cache of what is made of a world's elements and of coats, until they change; `bare` are those without coats."""

    bare: Elements
    coats: Shown
    elements: Elements
    looks: Appearances


class RenderContext:
    """Takes pictures of snapshots; owned by one thread, which alone may call it, and which closes it."""

    def __init__(
        self,
        shapes: ShapeLibrary,
        looks: AppearanceLibrary,
        unseen: frozenset[int] = frozenset(),
        scene: TopScene | None = None,
    ) -> None:
        """See all elements but the figures of the nodes `unseen` (uids).

        A `scene` that is given is the caller's, who closes it. Raises KernelError where Embree can't be had.
        """
        reason = unavailable()
        if reason:
            raise KernelError(f"no pictures can be taken: {reason}", reason=Reason.WRONG_STATE, cause=reason)
        self._shapes, self._looks, self._unseen = shapes, looks, unseen
        self._scene, self._is_own = scene or TopScene(), scene is None
        self._seen: _Seen | None = None

    def close(self) -> None:
        """Free the scene."""
        if self._is_own:
            self._scene.close()

    @property
    def uids(self) -> tuple[int, ...]:
        """Return the nodes that the last picture's segmentation tells of, by place."""
        return self._seen.elements.nodes if self._seen else ()

    def see(
        self,
        snapshot: Snapshot,
        lens: Lens,
        world_t_camera: NDArray[np.float64],
        kinds: Collection[ImageKind],
        background: Color = BACKGROUND,
    ) -> Picture:
        """Return what a lens at `world_t_camera` (4, 4: z forward, x right, y down) sees; see `render`."""
        seen = self._look(snapshot)
        world_t_element = np.ascontiguousarray(seen.elements.world_t_element(snapshot.world_t_node))
        self._scene.place(seen.elements.shapes, world_t_element)
        subject = Subject(world_t_element, seen.elements.node_of, seen.looks, lights_of(snapshot), background)
        return render(self._scene, subject, lens, world_t_camera, kinds)

    def _look(self, snapshot: Snapshot) -> _Seen:
        before, coats = self._seen, self._looks.coats.get()
        bare = elements_of(snapshot, self._shapes, before.bare if before else None, self._unseen)
        if before is not None and before.bare is bare and before.coats is coats:
            return before
        elements = with_coats(bare, snapshot, coats, self._unseen)
        self._seen = seen = _Seen(bare, coats, elements, self._looks.of(elements))
        return seen
