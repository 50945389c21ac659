"""Readings of sensors as messages that Foxglove and PlotJuggler draw; what has none of these is told as it came."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.message import Message
from google.protobuf.timestamp_pb2 import Timestamp
from numpy.typing import NDArray

from virtualrobot._wire.messages import array_of
from virtualrobot._wire.showing import png
from virtualrobot.recording import topics
from virtualrobot.v1 import sensing_pb2, sensor_pb2

Told = Iterator[tuple[str, Message]]

_DISTORTIONS = {sensing_pb2.CAMERA_PROJECTION_PINHOLE: "rational_polynomial", 0: "rational_polynomial"}
_DISTORTIONS[sensing_pb2.CAMERA_PROJECTION_FISHEYE] = "equidistant"
_FEW_COEFFICIENTS = 5


class Readings:
    """Messages of readings; `patterns` are those of the range sensors by name."""

    def __init__(self, selection: topics.Selection, compressed: bool) -> None:
        """Tell topics of a selection; colours `compressed` as PNG, or else as they are."""
        self.patterns: Mapping[str, sensing_pb2.ScanPattern] = {}
        self._selection, self._compressed = selection, compressed

    def told(self, reading: sensor_pb2.SensorReading, time: Timestamp) -> Told:
        """Yield what a reading tells, by topic."""
        kind = reading.WhichOneof("reading")
        if kind == "range":
            messages = self._range(reading, time)
        elif kind == "camera":
            messages = self._camera(reading, time)
        else:
            messages = iter([("reading", reading)] if kind else ())
        for content, message in messages:
            topic = topics.sensor(reading.sensor, content)
            if topic in self._selection:
                yield topic, message

    def _range(self, reading: sensor_pb2.SensorReading, time: Timestamp) -> Told:
        angles = topics.scan_angles(self.patterns.get(reading.sensor, sensing_pb2.ScanPattern()))
        strengths = array_of(reading.range.intensities)
        if angles is None:
            yield "points", _cloud(reading.sensor, array_of(reading.range.points), strengths, time)
            return
        ranges = np.where(array_of(reading.range.valid) != 0, array_of(reading.range.distances), np.nan)
        scan = LaserScan(timestamp=time, frame_id=reading.sensor, start_angle=angles[0], end_angle=angles[1])
        scan.pose.orientation.w = 1.0
        scan.ranges.extend(ranges.ravel().tolist())
        scan.intensities.extend(strengths.ravel().tolist())
        yield "scan", scan

    def _camera(self, reading: sensor_pb2.SensorReading, time: Timestamp) -> Told:
        camera = reading.camera
        for image in camera.images:
            side = "right_" if image.right else ""
            pixels = array_of(image.pixels)
            raw = RawImage(timestamp=time, frame_id=reading.sensor, height=pixels.shape[0], width=pixels.shape[1])
            if image.kind == sensing_pb2.IMAGE_KIND_COLOR and self._compressed:
                yield (
                    f"{side}color",
                    CompressedImage(timestamp=time, frame_id=reading.sensor, format="png", data=png(pixels)),
                )
            elif image.kind == sensing_pb2.IMAGE_KIND_COLOR:
                yield f"{side}color", _filled(raw, "rgb8", pixels)
            elif image.kind == sensing_pb2.IMAGE_KIND_DEPTH:
                yield f"{side}depth", _filled(raw, "32FC1", pixels)
            elif image.kind == sensing_pb2.IMAGE_KIND_SEGMENTATION:
                yield f"{side}segmentation", _filled(raw, "16UC1", (pixels + 1).astype("<u2"))
                if not image.right:
                    yield "element_names", sensor_pb2.CameraReading(element_names=camera.element_names)
            else:
                yield f"{side}normals", image
        yield "camera_info", _calibration(reading.sensor, camera, time)


def _filled(image: RawImage, encoding: str, pixels: NDArray) -> RawImage:
    image.encoding, image.step, image.data = encoding, pixels.strides[0], pixels.tobytes()
    return image


def _cloud(frame: str, points: NDArray[np.float32], strengths: NDArray[np.float32], time: Timestamp) -> PointCloud:
    """Return the points that are valid; (r, c, 3) in the frame, and (r, c) how strong their echoes are."""
    rows = np.column_stack([points.reshape(-1, 3), strengths.reshape(-1)]).astype("<f4")
    rows = rows[np.isfinite(rows[:, :3]).all(axis=1)]
    cloud = PointCloud(timestamp=time, frame_id=frame, point_stride=16, data=rows.tobytes())
    cloud.pose.orientation.w = 1.0
    for place, name in enumerate(("x", "y", "z", "intensity")):
        cloud.fields.add(name=name, offset=4 * place, type=PackedElementField.FLOAT32)
    return cloud


def _calibration(frame: str, camera: sensor_pb2.CameraReading, time: Timestamp) -> CameraCalibration:
    one = camera.intrinsics
    made = CameraCalibration(timestamp=time, frame_id=frame, width=camera.width, height=camera.height)
    if camera.projection == sensing_pb2.CAMERA_PROJECTION_SPHERICAL:
        return made
    made.K.extend([one.fx, 0.0, one.cx, 0.0, one.fy, one.cy, 0.0, 0.0, 1.0])
    made.P.extend([one.fx, 0.0, one.cx, 0.0, 0.0, one.fy, one.cy, 0.0, 0.0, 0.0, 1.0, 0.0])
    made.R.extend([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    coefficients = list(camera.distortion)
    if coefficients:
        plain = camera.projection != sensing_pb2.CAMERA_PROJECTION_FISHEYE and len(coefficients) <= _FEW_COEFFICIENTS
        made.distortion_model = "plumb_bob" if plain else _DISTORTIONS[camera.projection]
        made.D.extend(coefficients + [0.0] * (_FEW_COEFFICIENTS - len(coefficients) if plain else 0))
    return made
