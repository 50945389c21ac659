"""Coats in the browser: a dot at each corner, since viser has meshes of one colour only, or sent anew as a whole."""

from __future__ import annotations

import time
from dataclasses import dataclass
from html import escape

import numpy as np
import viser
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.batches import wxyz_of
from virtualrobot_kernel.sensing.coats import Coat, Legend, Shown
from virtualrobot_kernel.sensing.color_maps import palette
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.visibility import inherited_visibility

AT_ONCE = 4096
"""Corners of a handle: where none of them has another value, none is sent."""
PERIOD = 0.1
"""Shortest time (s) between two sendings of values."""
COVER = 1.3
"""Diameter of a dot, in parts of the mean edge of the triangles: dots beside each other leave no gaps."""
OUT = 0.4
"""Height of a dot over its corner, in diameters: dots face the eye, and must not dive into the surface below."""
STOPS = 12
"""As many of a map's colours as a legend has."""
HIDDEN = (0.0, 0.0, -1e4)
"""Position of a dot where there is nothing: handles have as many dots as corners."""


@dataclass(slots=True, eq=False)
class _Drawn:
    coat: Coat
    frame: viser.FrameHandle
    handles: list[viser.PointCloudHandle]
    size: float
    legend: viser.GuiHtmlHandle
    world_t_node: NDArray[np.float64] | None = None


class CoatLayer:
    """Owns the handles of coats of one viser server."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Draw on `server`."""
        self._server = server
        self._drawn: dict[str, _Drawn] = {}
        self._shown: Shown = {}
        self._snapshot: Snapshot | None = None
        self._count = 0
        self._sent = -PERIOD

    def draw(self, snapshot: Snapshot, coats: Shown) -> None:
        """Show these coats where their nodes are, and no others."""
        if not coats and not self._drawn:
            return
        now = time.monotonic()
        if coats is not self._shown and now - self._sent >= PERIOD:
            self._arrange(coats)
            self._shown, self._sent, self._snapshot = coats, now, None
        if snapshot is self._snapshot:
            return
        self._snapshot, structure = snapshot, snapshot.structure
        hidden, _ = inherited_visibility(structure, snapshot.state.tool_states)
        for drawn in self._drawn.values():
            uid, frame = drawn.coat.uid, drawn.frame
            there = uid in structure.nodes and not hidden[uid]
            if frame.visible != there:
                frame.visible = there
            pose = snapshot.world_t(uid) if there else None
            if pose is not None and (drawn.world_t_node is None or not np.array_equal(pose, drawn.world_t_node)):
                frame.position, frame.wxyz = pose[:3, 3], wxyz_of(pose[None, :3, :3])[0]
                drawn.world_t_node = pose

    def _arrange(self, coats: Shown) -> None:
        for name in [name for name in self._drawn if name not in coats]:
            _remove(self._drawn.pop(name))
        for name, coat in coats.items():
            drawn = self._drawn.get(name)
            if drawn is not None and coat.is_repainted(drawn.coat):
                _repaint(drawn, coat)
            else:
                if drawn is not None:
                    _remove(drawn)
                self._drawn[name] = self._added(coat)

    def _added(self, coat: Coat) -> _Drawn:
        self._count += 1
        root = f"/coat/{self._count}"
        frame = self._server.scene.add_frame(root, show_axes=False)
        size = COVER * _edge(coat)
        handles = [
            self._server.scene.add_point_cloud(
                f"{root}/{first}",
                *_dots(coat, slice(first, first + AT_ONCE), size),
                point_size=size,
                point_shape="circle",
                precision="float32",
            )
            for first in range(0, len(coat.values), AT_ONCE)
        ]
        return _Drawn(coat, frame, handles, size, self._server.gui.add_html(legend_html(coat.legend)))


def legend_html(legend: Legend) -> str:
    """Return a legend as the page shows it beside the view."""
    table = palette(legend.color_map)[np.linspace(1, 255, STOPS).astype(int)].tolist()
    stops = ", ".join(f"rgb({red}, {green}, {blue})" for red, green, blue in table)
    return (
        f'<div style="margin: 0.6em 1em; font-size: 0.85em"><b>{escape(legend.title)}</b> {escape(legend.unit)}'
        f'<div style="height: 0.8em; background: linear-gradient(to right, {stops})"></div>'
        f'<div style="display: flex; justify-content: space-between"><span>{legend.low:.3g}</span>'
        f"<span>{legend.high:.3g}</span></div></div>"
    )


def _remove(drawn: _Drawn) -> None:
    drawn.frame.remove()
    drawn.legend.remove()


def _repaint(drawn: _Drawn, coat: Coat) -> None:
    """Send what has changed."""
    before = drawn.coat.values
    for place, handle in enumerate(drawn.handles):
        part = slice(place * AT_ONCE, (place + 1) * AT_ONCE)
        old, new = before[part], coat.values[part]
        if np.array_equal(old, new):
            continue
        points, colors = _dots(coat, part, drawn.size)
        if not np.array_equal(old > 0, new > 0):
            handle.points = points
        handle.colors = colors
    drawn.coat = coat


def _dots(coat: Coat, part: slice, size: float) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    values, skin = coat.values[part], coat.skin
    places = skin.vertices[part] + OUT * size * skin.normals[part]
    points = np.where(values[:, None] > 0, places, HIDDEN).astype(np.float32)
    return points, coat.colors[part]


def _edge(coat: Coat) -> float:
    corners = coat.skin.vertices[coat.skin.faces]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())
