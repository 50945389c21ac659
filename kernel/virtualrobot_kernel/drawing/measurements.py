"""Measured distances in the browser: a line between the two points, and its length in the middle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import viser
from numpy.typing import NDArray

from virtualrobot_kernel.drawing.inks import MEASURE_COLOR, MEASURE_WIDTH, measured_words
from virtualrobot_kernel.sensing.measuring import Measurement, ends, is_there
from virtualrobot_kernel.world.state import Snapshot


@dataclass(slots=True, eq=False)
class _Drawn:
    line: viser.LineSegmentsHandle
    label: viser.LabelHandle
    points: NDArray[np.float64]


class MeasurementLayer:
    """Owns the lines and labels of the measurements of one viser server."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Draw on `server`."""
        self._server = server
        self._drawn: dict[Measurement, _Drawn] = {}
        self._count = 0

    def draw(self, snapshot: Snapshot, wanted: tuple[Measurement, ...]) -> None:
        """Show these measurements as they are now, and no others; one whose node is gone is passed over."""
        shown = {one: ends(snapshot, one.first, one.second) for one in wanted if is_there(snapshot, one)}
        for gone in [one for one in self._drawn if one not in shown]:
            drawn = self._drawn.pop(gone)
            drawn.line.remove()
            drawn.label.remove()
        for measurement, points in shown.items():
            drawn = self._drawn.get(measurement)
            if drawn is None:
                self._drawn[measurement] = self._added(measurement, points)
            elif not np.array_equal(points, drawn.points):
                drawn.line.points = points[None].astype(np.float32)
                drawn.label.text = measured_words(measurement, points)
                drawn.label.position = points.mean(axis=0)
                drawn.points = points

    def _added(self, measurement: Measurement, points: NDArray[np.float64]) -> _Drawn:
        self._count += 1
        name, scene = f"/measurement/{self._count}", self._server.scene
        line = scene.add_line_segments(
            f"{name}/line",
            points[None].astype(np.float32),
            MEASURE_COLOR,
            thickness=MEASURE_WIDTH,
            thickness_units="screen",
        )
        middle = points.mean(axis=0)
        label = scene.add_label(
            f"{name}/label",
            measured_words(measurement, points),
            position=middle,
            anchor="bottom-center",
            depth_test=False,
        )
        return _Drawn(line, label, points)
