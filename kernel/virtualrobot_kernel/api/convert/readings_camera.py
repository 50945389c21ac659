"""What cameras saw, as messages."""

from __future__ import annotations

from collections.abc import Iterator

from virtualrobot.v1 import geometry_pb2, sensing_pb2, sensor_pb2

from virtualrobot_kernel.api.convert.sensing import sensing_message
from virtualrobot_kernel.api.convert.values import array_message
from virtualrobot_kernel.sensing.camera_reader import CameraContent
from virtualrobot_kernel.sensing.picture import Picture
from virtualrobot_kernel.world.sensing import ImageKind

UINT8, FLOAT32, INT32 = (
    geometry_pb2.NUMERIC_TYPE_UINT8,
    geometry_pb2.NUMERIC_TYPE_FLOAT32,
    geometry_pb2.NUMERIC_TYPE_INT32,
)


def camera_message(content: CameraContent) -> sensor_pb2.CameraReading:
    """Return what a camera saw as a message."""
    lens = content.lens
    return sensor_pb2.CameraReading(
        images=[
            image for right, picture in enumerate(content.pictures) for image in _images(picture, content, bool(right))
        ],
        width=lens.width,
        height=lens.height,
        intrinsics=sensing_message(lens.intrinsics),
        distortion=lens.distortion,
        element_names=content.element_names if ImageKind.SEGMENTATION in content.kinds else (),
        stereo_baseline_meters=content.baseline,
        projection=sensing_pb2.CameraProjection.Name(lens.projection.value),
    )


def _images(picture: Picture, content: CameraContent, right: bool) -> Iterator[sensor_pb2.Image]:
    """Yield the pictures of one eye in the order of their kinds."""
    pixels = {
        ImageKind.COLOR: (picture.color, UINT8),
        ImageKind.DEPTH: (picture.depth, FLOAT32),
        ImageKind.SEGMENTATION: (picture.segmentation, INT32),
        ImageKind.NORMALS: (picture.normals, FLOAT32),
    }
    for kind in content.kinds:
        values, stored = pixels[kind]
        if values is not None:
            name = sensing_pb2.ImageKind.Name(kind.value)
            yield sensor_pb2.Image(kind=name, right=right, pixels=array_message(values, stored))
