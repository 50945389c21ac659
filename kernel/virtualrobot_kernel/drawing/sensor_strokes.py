"""Sensor readings drawn over pictures: rays, points, frusta and their pictures, as the browser shows them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.overlay import Inlay, Lines, Overlay
from virtualrobot_kernel.drawing.palette import FRUSTUM_COLOR, FRUSTUM_WIDTH, RAY_WIDTH, SCAN_POINT_SIZE
from virtualrobot_kernel.sensing.overlays import (
    FRUSTUM_DEPTH,
    SensorOverlay,
    frustum_of,
    scan_points,
    scan_rays,
    seen_picture,
)
from virtualrobot_kernel.sensing.reading import Reading
from virtualrobot_kernel.world.sensing import CameraSensor, RangeSensor
from virtualrobot_kernel.world.state import Snapshot


def add_sensors(
    overlay: Overlay, snapshot: Snapshot, wanted: tuple[SensorOverlay, ...], readings: Mapping[int, Reading]
) -> None:
    """Add what is asked for of the latest readings; a sensor that is gone is passed over.

    Points and rays stand where the sensor was at its reading; a frustum goes with its camera.
    """
    for one in wanted:
        node, reading = snapshot.structure.nodes.get(one.uid), readings.get(one.uid)
        said = None if reading is None else reading.content
        if node is None:
            continue
        if isinstance(node.data, RangeSensor) and reading is not None and said is not None:
            pose = reading.world_t_sensor
            if one.rays:
                ends, colors = scan_rays(said, one.color_by)
                overlay.lines.append(Lines(_moved(pose, ends), _opaque(colors), np.full(len(ends), RAY_WIDTH)))
            if one.points:
                points, colors = scan_points(said, one.color_by)
                overlay.add_dots(_moved(pose, points), colors, SCAN_POINT_SIZE)
        elif isinstance(node.data, CameraSensor) and (one.frustum or one.image):
            pyramid = frustum_of(node.data)
            if pyramid is None:
                continue
            pose = snapshot.world_t(one.uid)
            if one.image and said is not None:
                edges = np.array([pyramid.left, pyramid.right, pyramid.top, pyramid.bottom])
                overlay.inlays.append(Inlay(pose, edges, FRUSTUM_DEPTH, seen_picture(said)))
            overlay.add_lines(_moved(pose, pyramid.lines()), FRUSTUM_COLOR, FRUSTUM_WIDTH)


def _moved(pose: NDArray[np.float64], points: NDArray[np.float32]) -> NDArray[np.float64]:
    return points @ pose[:3, :3].T + pose[:3, 3]


def _opaque(colors: NDArray[np.uint8]) -> NDArray[np.float32]:
    return np.concatenate([colors, np.ones((len(colors), 1))], axis=1).astype(np.float32)
