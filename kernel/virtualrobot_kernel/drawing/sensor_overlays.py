"""Sensor readings in the browser: rays, points, frusta and pictures. A scan is one node, however many its points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.annotations import add_dots
from virtualrobot_kernel.drawing.batches import wxyz_of
from virtualrobot_kernel.drawing.palette import FRUSTUM_COLOR, FRUSTUM_WIDTH, RAY_WIDTH, SCAN_POINT_SIZE
from virtualrobot_kernel.sensing.overlays import (
    FRUSTUM_DEPTH,
    Bytes,
    Frustum,
    Pictures,
    SensorOverlay,
    Singles,
    frustum_of,
    scan_points,
    scan_rays,
    seen_picture,
)
from virtualrobot_kernel.sensing.reading import Reading
from virtualrobot_kernel.world.sensing import CameraSensor, RangeSensor
from virtualrobot_kernel.world.state import Snapshot, unchanged

MOST_PIXELS = 320
"""The greatest side of a picture that is sent to browsers."""
JPEG_QUALITY = 75

Shown = tuple[int, str]
"""A sensor's uid, and which of its overlays."""


@dataclass(slots=True, eq=False)
class _Drawn:
    handle: Any  # viser's handles share no public base type with a pose
    made_of: tuple[object, object]

    def is_of(self, made_of: tuple[object, object]) -> bool:
        """Return whether it shows just these objects."""
        return unchanged(self.made_of, made_of)


class SensorLayer:
    """Owns what is shown of sensors on one viser server."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Draw on `server`."""
        self._scene = server.scene
        self._drawn: dict[Shown, _Drawn] = {}

    def draw(self, snapshot: Snapshot, overlays: tuple[SensorOverlay, ...], readings: Mapping[int, Reading]) -> None:
        """Show these overlays with the latest readings, and no others; a sensor that is gone is passed over.

        Points and rays stand where the sensor was at its reading; a frustum goes with its camera.
        """
        wanted: set[Shown] = set()
        for overlay in overlays:
            node = snapshot.structure.nodes.get(overlay.uid)
            reading = readings.get(overlay.uid)
            said = None if reading is None else reading.content
            if node is None:
                continue
            if isinstance(node.data, RangeSensor) and reading is not None and said is not None:
                for part in ("points",) * overlay.points + ("rays",) * overlay.rays:
                    wanted.add(self._scan(part, overlay, reading))
            elif isinstance(node.data, CameraSensor) and (overlay.frustum or overlay.image):
                pyramid = frustum_of(node.data)
                if pyramid is not None:
                    shown = self._frustum(overlay.uid, node.data, pyramid, said if overlay.image else None)
                    _place(self._drawn[shown].handle, snapshot.world_t(overlay.uid))
                    wanted.add(shown)
        for gone in [shown for shown in self._drawn if shown not in wanted]:
            self._drawn.pop(gone).handle.remove()

    def _scan(self, part: str, overlay: SensorOverlay, reading: Reading) -> Shown:
        """Show the points or the rays of a scan."""
        shown, made_of = (overlay.uid, part), (reading, overlay.color_by)
        drawn = self._drawn.get(shown)
        if drawn is not None and drawn.is_of(made_of):
            return shown
        scan: Any = reading.content  # what a reader of range sensors makes
        points, colors = (scan_points if part == "points" else scan_rays)(scan, overlay.color_by)
        if part == "rays":
            colors = np.repeat(colors[:, None], 2, axis=1)
        if drawn is None:
            drawn = self._drawn[shown] = _Drawn(self._added(shown, points, colors), made_of)
        else:
            drawn.handle.points, drawn.handle.colors, drawn.made_of = points, colors, made_of
        _place(drawn.handle, reading.world_t_sensor)
        return shown

    def _added(self, shown: Shown, points: Singles, colors: Bytes) -> Any:  # noqa: ANN401 see _Drawn
        if shown[1] == "rays":
            return self._scene.add_line_segments(
                _name(shown), points, colors, thickness=RAY_WIDTH, thickness_units="screen"
            )
        return add_dots(self._scene, _name(shown), points, colors, SCAN_POINT_SIZE)

    def _frustum(self, uid: int, camera: CameraSensor, pyramid: Frustum, pictures: Pictures | None) -> Shown:
        """Show a camera's pyramid, with the first of its pictures in it or without."""
        shown, made_of = (uid, "frustum"), (camera, pictures)
        drawn = self._drawn.get(shown)
        if drawn is not None and drawn.is_of(made_of):
            return shown
        picture = None
        if pictures is not None:
            picture = seen_picture(pictures, MOST_PIXELS)
        if drawn is not None and drawn.made_of[0] is camera and picture is not None and drawn.handle.image is not None:
            drawn.handle.image, drawn.made_of = picture, made_of
            return shown
        handle = self._scene.add_camera_frustum(
            _name(shown),
            pyramid.vertical_field,
            pyramid.aspect,
            thickness=FRUSTUM_WIDTH,
            thickness_units="screen",
            color=FRUSTUM_COLOR,
            image=picture,
            format="jpeg",
            jpeg_quality=JPEG_QUALITY,
            cast_shadow=False,
            receive_shadow=False,
        )
        handle.scale = FRUSTUM_DEPTH / handle.compute_canonical_frustum_size()[2]
        self._drawn[shown] = _Drawn(handle, made_of)
        return shown


def _name(shown: Shown) -> str:
    return f"/sensor/{shown[0]}/{shown[1]}"


def _place(handle: Any, pose: NDArray[np.float64]) -> None:  # noqa: ANN401 see _Drawn
    handle.position = pose[:3, 3]
    handle.wxyz = wxyz_of(pose[None, :3, :3])[0]
