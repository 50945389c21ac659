"""Measured distances in the browser: a line between the two points, and its length in the middle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import viser
from numpy.typing import NDArray

from virtualrobot_kernel.collision.clearances import Clearance, Measured
from virtualrobot_kernel.drawing.palette import (
    CLEARANCE_COLOR,
    MEASURE_COLOR,
    MEASURE_WIDTH,
    clearance_words,
    measured_words,
)
from virtualrobot_kernel.sensing.measuring import Measurement, ends, is_there
from virtualrobot_kernel.world.state import Snapshot


@dataclass(slots=True, eq=False)
class _Drawn:
    line: viser.LineSegmentsHandle
    label: viser.LabelHandle
    points: NDArray[np.float64]
    text: str


class MeasurementLayer:
    """Owns the lines and labels of the measurements and clearances of one viser server."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Draw on `server`."""
        self._server = server
        self._drawn: dict[Measurement | Clearance, _Drawn] = {}
        self._count = 0

    def draw(self, snapshot: Snapshot, wanted: tuple[Measurement, ...], clearances: Measured) -> None:
        """Show these measurements as they are now, and clearances as they were measured last, and no others.

        A measurement whose node is gone is passed over.
        """
        shown: dict[Measurement | Clearance, tuple[NDArray[np.float64], str]] = {}
        for one in wanted:
            if is_there(snapshot, one):
                points = ends(snapshot, one.first, one.second)
                shown[one] = points, measured_words(one, points)
        for clearance, nearest in clearances.items():
            shown[clearance] = nearest.points, clearance_words(clearance, nearest)
        for gone in [one for one in self._drawn if one not in shown]:
            drawn = self._drawn.pop(gone)
            drawn.line.remove()
            drawn.label.remove()
        for one, (points, text) in shown.items():
            drawn = self._drawn.get(one)
            if drawn is None:
                color = CLEARANCE_COLOR if isinstance(one, Clearance) else MEASURE_COLOR
                self._drawn[one] = self._added(points, text, color)
            elif drawn.text != text or not np.array_equal(points, drawn.points):
                drawn.line.points = points[None].astype(np.float32)
                drawn.label.text = text
                drawn.label.position = points.mean(axis=0)
                drawn.points, drawn.text = points, text

    def _added(self, points: NDArray[np.float64], text: str, color: tuple[int, int, int]) -> _Drawn:
        self._count += 1
        name, scene = f"/measurement/{self._count}", self._server.scene
        line = scene.add_line_segments(
            f"{name}/line",
            points[None].astype(np.float32),
            color,
            thickness=MEASURE_WIDTH,
            thickness_units="screen",
        )
        middle = points.mean(axis=0)
        label = scene.add_label(
            f"{name}/label",
            text,
            position=middle,
            anchor="bottom-center",
            depth_test=False,
        )
        return _Drawn(line, label, points, text)
