"""Points, lines, labels and bounding boxes in the browser: a handle for each, since they have no batched form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.batches import wxyz_of
from virtualrobot_kernel.drawing.inventory import Inventory, node_bounds
from virtualrobot_kernel.drawing.library import ShapeLibrary
from virtualrobot_kernel.drawing.palette import BOX_COLOR, BOX_WIDTH, CONTACT_COLOR, CONTACT_SIZE, box_edges, ink
from virtualrobot_kernel.world.figures import Figure, Label, Lines, Points
from virtualrobot_kernel.world.structure import Structure


@dataclass(slots=True, eq=False)
class _Drawn:
    handle: Any  # viser's handles of points, lines and labels share no public base type with a pose
    row: int
    node_t_figure: NDArray[np.float64]
    world_t_figure: NDArray[np.float64] | None = None


class AnnotationLayer:
    """Owns the handles of points, lines and labels of one viser server. Call `arrange`, then `pose`."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Draw on `server`."""
        self._server = server
        self._drawn: dict[tuple[int, Figure], _Drawn] = {}
        self._count = 0

    def arrange(self, structure: Structure, inventory: Inventory) -> None:
        """Take over which figures there are; one that is still the same object keeps its handle."""
        wanted = dict.fromkeys(inventory.annotations)
        for key in [key for key in self._drawn if key not in wanted]:
            self._drawn.pop(key).handle.remove()
        for uid, figure in wanted:
            drawn = self._drawn.get((uid, figure))
            if drawn is None:
                self._count += 1
                handle = _added(self._server, f"/annotation/{self._count}", figure)
                if handle is None:
                    continue
                drawn = self._drawn[uid, figure] = _Drawn(handle, 0, figure.node_t_figure)
            drawn.row = structure.rows[uid]

    def pose(self, world_t_node: NDArray[np.float64]) -> None:
        """Put every figure where its node is; `world_t_node` is (N, 4, 4)."""
        for drawn in self._drawn.values():
            pose = world_t_node[drawn.row] @ drawn.node_t_figure
            if drawn.world_t_figure is None or not np.array_equal(pose, drawn.world_t_figure):
                _place(drawn.handle, pose)
                drawn.world_t_figure = pose


class BoxLayer:
    """Owns the line boxes of one viser server: one around each chosen node and all below it, in the node's frame."""

    def __init__(self, server: viser.ViserServer, library: ShapeLibrary) -> None:
        """Draw on `server` around the shapes of `library`."""
        self._server = server
        self._library = library
        self._handles: dict[int, viser.LineSegmentsHandle] = {}

    def draw(
        self, structure: Structure, inventory: Inventory, world_t_node: NDArray[np.float64], chosen: tuple[int, ...]
    ) -> None:
        """Show the boxes of the chosen nodes (uids) as they are now, and no others."""
        boxes = {
            uid: box
            for uid in chosen
            if uid in structure.nodes
            and (box := node_bounds(structure, inventory, world_t_node, self._library, uid)) is not None
        }
        for uid in [uid for uid in self._handles if uid not in boxes]:
            self._handles.pop(uid).remove()
        for uid, box in boxes.items():
            segments = box_edges(box).astype(np.float32)
            handle = self._handles.get(uid)
            if handle is None:
                handle = self._handles[uid] = self._server.scene.add_line_segments(
                    f"/box/{uid}", segments, BOX_COLOR, thickness=BOX_WIDTH, thickness_units="screen"
                )
            handle.points = segments
            _place(handle, world_t_node[structure.rows[uid]])


class ContactLayer:
    """Owns the dots where things touch that may not, on one viser server."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Draw on `server`."""
        self._server = server
        self._handle: viser.PointCloudHandle | None = None

    def draw(self, points: NDArray[np.float64]) -> None:
        """Show dots at these points (n, 3), meters in the world's frame, and no others."""
        if self._handle is not None:
            self._handle.remove()
            self._handle = None
        if len(points):
            self._handle = add_dots(self._server.scene, "/contacts", points, CONTACT_COLOR, CONTACT_SIZE)


def add_dots(
    scene: viser.SceneApi, name: str, points: NDArray, colors: tuple[int, int, int] | NDArray[np.uint8], size: float
) -> viser.PointCloudHandle:
    """Return the handle of round dots at points (n, 3), `size` meters wide; colours are (n, 3) or one for all."""
    return scene.add_point_cloud(
        name,
        points,
        colors,
        point_size=0.5 * size,  # viser draws points twice as wide as this says
        point_shape="circle",
        point_shading="flat",
        precision="float32",
    )


def _added(server: viser.ViserServer, name: str, figure: Figure) -> Any:  # noqa: ANN401  see _Drawn
    """Return the handle of a figure, or None when there is nothing in it to draw."""
    color = ink(figure)
    match figure.geometry:
        case Points(positions, colors, size) if positions:
            points = np.frombuffer(positions, np.float64).reshape(-1, 3)
            own = np.frombuffer(colors, np.uint8).reshape(-1, 3) if colors else color
            return add_dots(server.scene, name, points, own, size)
        case Lines(segments, width) if segments:
            points = np.frombuffer(segments, np.float64).reshape(-1, 2, 3)
            return server.scene.add_line_segments(name, points, color, thickness=width, thickness_units="screen")
        case Label(text) if text:
            return server.scene.add_label(name, text, anchor="bottom-center")
    return None


def _place(handle: Any, pose: NDArray[np.float64]) -> None:  # noqa: ANN401  see _Drawn
    handle.position = pose[:3, 3]
    handle.wxyz = wxyz_of(pose[None, :3, :3])[0]
