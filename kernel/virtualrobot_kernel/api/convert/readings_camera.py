"""Camera readings as messages."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from virtualrobot.v1 import geometry_pb2, sensor_pb2

from virtualrobot_kernel.messages.sensing import INTRINSICS
from virtualrobot_kernel.messages.values import DTYPES
from virtualrobot_kernel.sensing.camera_reader import CameraContent
from virtualrobot_kernel.sensing.picture import Picture
from virtualrobot_kernel.world.sensing import ImageKind


def fill_camera(message: sensor_pb2.CameraReading, content: CameraContent, kinds: Collection[int]) -> None:
    """Fill a message in with what a camera saw: pictures of these kinds (numbers of the contract), none means all."""
    lens = content.lens
    message.width, message.height = lens.width, lens.height
    message.intrinsics.CopyFrom(INTRINSICS.write(lens.intrinsics))
    message.distortion.extend(lens.distortion)
    message.stereo_baseline_meters = content.baseline
    message.projection = lens.projection.value  # pyright: ignore[reportAttributeAccessIssue] the contract's number
    wanted = [kind for kind in content.kinds if not kinds or kind.value in kinds]
    if ImageKind.SEGMENTATION in wanted:
        message.element_names.extend(content.element_names)
    for right, picture in enumerate(content.pictures):
        for kind in wanted:
            _fill(message.images.add(right=bool(right)), kind, picture)


def _fill(image: sensor_pb2.Image, kind: ImageKind, picture: Picture) -> None:
    """Fill a message in with a picture of one kind, which was taken."""
    values, stored = {
        ImageKind.COLOR: (picture.color, geometry_pb2.NUMERIC_TYPE_UINT8),
        ImageKind.DEPTH: (picture.depth, geometry_pb2.NUMERIC_TYPE_FLOAT32),
        ImageKind.SEGMENTATION: (picture.segmentation, geometry_pb2.NUMERIC_TYPE_INT32),
        ImageKind.NORMALS: (picture.normals, geometry_pb2.NUMERIC_TYPE_FLOAT32),
    }[kind]
    assert values is not None  # it is of the kinds that were taken
    image.kind = kind.value  # pyright: ignore[reportAttributeAccessIssue] the contract's number
    image.pixels.type = stored
    image.pixels.shape.extend(values.shape)
    image.pixels.data = np.ascontiguousarray(values, DTYPES[stored]).tobytes()
