"""Batched meshes in the browser: one handle for each shape and colour, however many nodes show it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import viser
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.inventory import Batch, BatchKey, Inventory
from virtualrobot_kernel.drawing.library import ShapeLibrary

LEVELS_OF_DETAIL = ((4.0, 0.5), (10.0, 0.2))
"""From how many meters off which part of a mesh's triangles is drawn; viser's own choice shows facets close by."""

NO_ROWS = np.zeros(0, np.int64)
NO_POSES = np.zeros((0, 4, 4))


@dataclass(slots=True, eq=False)
class _Drawn:
    """The handles of one batch (several where a shape needs several GLB files), and what they show."""

    handles: tuple[viser.BatchedGlbHandle, ...]
    positions: NDArray[np.float32]
    wxyzs: NDArray[np.float32]
    scale: NDArray[np.float32]
    visible: bool


class BatchLayer:
    """Owns the batch handles of one viser server. Call `arrange` when the inventory is new, then `pose`."""

    def __init__(self, server: viser.ViserServer, library: ShapeLibrary, name: str = "batch") -> None:
        """Draw on `server` what `library` makes, all under `name`, which is this layer's alone."""
        self._name = name
        self._server = server
        self._library = library
        self._drawn: dict[BatchKey, _Drawn] = {}
        self._batches: Mapping[BatchKey, Batch] = {}
        self._rows = NO_ROWS
        self._node_t_shape = NO_POSES
        self._count = 0

    def arrange(self, inventory: Inventory) -> None:
        """Take over which instances there are, and forget batches that no node uses any more.

        A batch that is only hidden now stays in the browser, so that showing it again costs nothing.
        """
        for key in [key for key in self._drawn if key not in inventory.used]:
            for handle in self._drawn.pop(key).handles:
                handle.remove()
        self._batches = inventory.batches
        batches = tuple(inventory.batches.values())
        self._rows = np.concatenate([NO_ROWS, *(batch.rows for batch in batches)])
        self._node_t_shape = np.concatenate([NO_POSES, *(batch.node_t_shape for batch in batches)])
        for key, drawn in self._drawn.items():
            if key not in inventory.batches and drawn.visible:
                drawn.visible = False
                for handle in drawn.handles:
                    handle.visible = False

    def pose(self, world_t_node: NDArray[np.float64]) -> None:
        """Put every instance where its node is; `world_t_node` is (N, 4, 4). What has not moved is not sent."""
        world_t_shape = world_t_node[self._rows] @ self._node_t_shape
        positions = world_t_shape[:, :3, 3].astype(np.float32)
        wxyzs = wxyz_of(world_t_shape[:, :3, :3]).astype(np.float32)
        start = 0
        for key, batch in self._batches.items():
            part = slice(start, start := start + len(batch.rows))
            drawn = self._drawn.get(key)
            if drawn is None:
                self._drawn[key] = self._added(key, positions[part], wxyzs[part], batch.scale)
            else:
                _update(drawn, positions[part], wxyzs[part], batch.scale)

    def _added(
        self, key: BatchKey, positions: NDArray[np.float32], wxyzs: NDArray[np.float32], scale: NDArray[np.float32]
    ) -> _Drawn:
        handles = []
        for data in self._library.files(*key):
            self._count += 1
            handles.append(
                self._server.scene.add_batched_glb(
                    f"/{self._name}/{self._count}",
                    data,
                    batched_wxyzs=wxyzs,
                    batched_positions=positions,
                    batched_scales=scale,
                    lod="off" if isinstance(key[0], str) else LEVELS_OF_DETAIL,
                )
            )
        return _Drawn(tuple(handles), positions, wxyzs, scale, True)


def _update(
    drawn: _Drawn, positions: NDArray[np.float32], wxyzs: NDArray[np.float32], scale: NDArray[np.float32]
) -> None:
    moved = not np.array_equal(positions, drawn.positions)
    turned = not np.array_equal(wxyzs, drawn.wxyzs)
    scaled = not np.array_equal(scale, drawn.scale)
    for handle in drawn.handles:
        if moved:
            handle.batched_positions = positions
        if turned:
            handle.batched_wxyzs = wxyzs
        if scaled:
            handle.batched_scales = scale
        if not drawn.visible:
            handle.visible = True
    drawn.positions, drawn.wxyzs, drawn.scale, drawn.visible = positions, wxyzs, scale, True


def wxyz_of(rotations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return unit quaternions (n, 4) as w, x, y, z of rotation matrices (n, 3, 3).

    Each is built about its largest component, so that none is divided by a small number (S. W. Shepperd, Quaternion
    from Rotation Matrix, Journal of Guidance and Control 1(3), 1978).
    """
    m00, m11, m22 = rotations[:, 0, 0], rotations[:, 1, 1], rotations[:, 2, 2]
    # Row k holds 4 q_k (w, x, y, z); every row is the quaternion up to a factor.
    table = np.empty((len(rotations), 4, 4))
    table[:, 0, 0] = 1.0 + m00 + m11 + m22
    table[:, 1, 1] = 1.0 + m00 - m11 - m22
    table[:, 2, 2] = 1.0 - m00 + m11 - m22
    table[:, 3, 3] = 1.0 - m00 - m11 + m22
    table[:, 0, 1] = table[:, 1, 0] = rotations[:, 2, 1] - rotations[:, 1, 2]
    table[:, 0, 2] = table[:, 2, 0] = rotations[:, 0, 2] - rotations[:, 2, 0]
    table[:, 0, 3] = table[:, 3, 0] = rotations[:, 1, 0] - rotations[:, 0, 1]
    table[:, 1, 2] = table[:, 2, 1] = rotations[:, 0, 1] + rotations[:, 1, 0]
    table[:, 1, 3] = table[:, 3, 1] = rotations[:, 0, 2] + rotations[:, 2, 0]
    table[:, 2, 3] = table[:, 3, 2] = rotations[:, 1, 2] + rotations[:, 2, 1]
    best = np.argmax(np.einsum("nii->ni", table), axis=1)
    chosen = table[np.arange(len(rotations)), best]
    return chosen / np.linalg.norm(chosen, axis=1, keepdims=True)
