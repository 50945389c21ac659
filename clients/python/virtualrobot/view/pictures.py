"""Pictures that the kernel takes without a browser, one or many, and what is under their pixels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import value_or_default, vector_of
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import png, shown
from virtualrobot._wire.transport import Stream
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import view_pb2
from virtualrobot.view.state import camera_message

Camera = str | tuple[ArrayLike, ArrayLike] | tuple[ArrayLike, ArrayLike, float]
"""Camera of a picture: the name of a camera or a viewpoint of the scene; or eye and target, meters in the world's
frame, and where wanted the vertical field of view in radians."""

Size = tuple[int, int]
"""Width and height in pixels."""

FORMATS = {
    "png": view_pb2.IMAGE_FORMAT_PNG,
    "jpeg": view_pb2.IMAGE_FORMAT_JPEG,
    "jpg": view_pb2.IMAGE_FORMAT_JPEG,
    "raw": view_pb2.IMAGE_FORMAT_RAW,
}


@shown
@checked
@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A picture of the world.

    Attributes:
        image: the bytes of a file, or of the pixels where the format is `raw`.
        format: `png`, `jpeg` or `raw`.
        width: in pixels.
        height: in pixels.
        simulation_time: the simulation time of the world in the picture, in seconds.
        number: counts the pictures of a film, from 0.
        behind: of a film, the number of pictures of what has happened already that are still to be drawn.
    """

    image: bytes
    format: str
    width: int
    height: int
    simulation_time: float
    number: int = 0
    behind: int = 0

    @property
    def pixels(self) -> NDArray[np.uint8]:
        """Red, green, blue of each pixel, shape (height, width, 3), read-only; of a picture whose format is `raw`."""
        if self.format != "raw":
            raise InvalidArgumentError(
                f"the picture is packed as {self.format}; take it with format='raw' for its pixels"
            )
        return np.frombuffer(self.image, np.uint8).reshape(self.height, self.width, 3)

    def _repr_png_(self) -> bytes | None:
        """Return the picture for notebooks."""
        if self.format == "raw":
            return png(self.pixels)
        return self.image if self.format == "png" else None

    def _repr_jpeg_(self) -> bytes | None:
        """Return the picture for notebooks."""
        return self.image if self.format == "jpeg" else None

    def save(self, path: str | Path) -> None:
        """Write the file; its name ends as the format is called."""
        ending = format_of(path)
        if ending != self.format:
            raise InvalidArgumentError(f"the picture is packed as {self.format}, not as the file {path} says")
        Path(path).write_bytes(self.image)


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Picked:
    """Surface point under a pixel.

    Attributes:
        node: the node's name; empty where there is nothing, and then the rest is NaN, and inf for the distance.
        point: (3,) the point, meters in the world's frame.
        node_point: (3,) the point, meters in the node's frame: it stays there as the node moves.
        normal: (3,) unit normal of the surface in the world's frame, towards the eye.
        distance: from the eye, in meters.
        color: (3,) of the surface without light, red, green, blue from 0 to 1.
    """

    node: str
    point: NDArray[np.float64]
    node_point: NDArray[np.float64]
    normal: NDArray[np.float64]
    distance: float
    color: NDArray[np.float64]


class Recording:
    """Pictures of a film as they are drawn; it ends with its time, or when it is cancelled."""

    def __init__(self, stream: Stream[view_pb2.RecordFilmResponse], shot: view_pb2.Shot, format: str) -> None:
        """Read the pictures of `shot`, which says how large they are."""
        self._stream, self._shot, self._format = stream, shot, format

    def __iter__(self) -> Iterator[Picture]:
        """Return itself."""
        return self

    def __next__(self) -> Picture:
        """Wait for the next picture."""
        frame = next(self._stream)
        return Picture(
            frame.image,
            self._format,
            self._shot.width,
            self._shot.height,
            frame.stamp.simulation_time_seconds,
            frame.frame,
            frame.behind,
        )

    def cancel(self) -> None:
        """End it; pictures that are not drawn yet are not drawn."""
        self._stream.cancel()

    def __enter__(self) -> Recording:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """End it."""
        self.cancel()

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Recording of {self._shot.width} x {self._shot.height} pixels, {self._format}>"


def capture(services: Services, camera: Camera | None, size: Size | None, format: str, plain: bool) -> Picture:
    """Return a picture of the world as it is now."""
    request = view_pb2.CaptureImageRequest(shot=shot_message(camera, size, format, plain))
    answer = services.view.CaptureImage(request, timeout=LONG_TIMEOUT_SECONDS)
    name = "jpeg" if format == "jpg" else format
    return Picture(answer.image, name, answer.width, answer.height, answer.stamp.simulation_time_seconds)


def capture_model(services: Services, name: str) -> Picture:
    """Return a small picture of a known model."""
    request = view_pb2.CaptureModelRequest(name=name)
    answer = services.view.CaptureModel(request, timeout=LONG_TIMEOUT_SECONDS)
    return Picture(answer.image, "png", answer.width, answer.height, 0.0)


def record(
    services: Services,
    camera: Camera | None,
    size: Size | None,
    format: str,
    plain: bool,
    rate: float,
    duration: float | None,
) -> Recording:
    """Return pictures at equal steps of simulation time, none left out."""
    shot = shot_message(camera, size, format, plain)
    if not (shot.width and shot.height):
        # The pictures of a film do not say how large they are; a small one that is taken before does.
        shot.width, shot.height = _own_size(services, shot)
    length = value_or_default(duration, "duration")
    request = view_pb2.RecordFilmRequest(shot=shot, frames_per_second=rate, duration_seconds=length)
    return Recording(services.view.RecordFilm(request), shot, "jpeg" if format == "jpg" else format)


def pick(services: Services, column: float, row: float, camera: Camera | None, size: Size | None) -> Picked:
    """Return what is under a pixel."""
    shot = shot_message(camera, size, "raw", False)
    request = view_pb2.PickPixelRequest(column=column, row=row, width=shot.width, height=shot.height)
    if shot.WhichOneof("from") == "camera":
        request.camera.CopyFrom(shot.camera)
    elif shot.WhichOneof("from") == "camera_sensor":
        request.camera_sensor = shot.camera_sensor
    found = services.view.PickPixel(request)
    nowhere = np.full(3, np.nan)
    if not found.node:
        return Picked("", nowhere, nowhere, nowhere, np.inf, nowhere)
    return Picked(
        found.node,
        vector_of(found.world_point),
        vector_of(found.node_point),
        vector_of(found.normal),
        found.distance_meters,
        np.array([found.color.red, found.color.green, found.color.blue]),
    )


def shot_message(camera: Camera | None, size: Size | None, format: str, plain: bool) -> view_pb2.Shot:
    """Return from where and how a picture is taken as a message."""
    if format not in FORMATS:
        raise InvalidArgumentError(f"{format!r} is no format of pictures; use one of {', '.join(FORMATS)}")
    try:
        width, height = (0, 0) if size is None else (int(value) for value in size)
        if size is not None and not (width and height):
            width = -1
    except (TypeError, ValueError):
        width, height = -1, -1
    if not (0 <= width <= 2**31 and 0 <= height <= 2**31):
        raise InvalidArgumentError(f"a picture's size is its width and height in pixels, not {size!r}")
    shot = view_pb2.Shot(width=width, height=height, format=FORMATS[format], plain=plain)
    if isinstance(camera, str):
        shot.camera_sensor = camera
    elif camera is not None:
        if not isinstance(camera, tuple) or len(camera) not in (2, 3):
            raise InvalidArgumentError(f"{camera!r} is no camera; give its name, or (eye, target), each 3 numbers")
        shot.camera.CopyFrom(camera_message(camera[0], camera[1], camera[2] if len(camera) == 3 else None))
    return shot


def format_of(path: str | Path) -> str:
    """Return the format that a file's name ends with."""
    ending = Path(path).suffix.lower().removeprefix(".")
    if ending not in FORMATS:
        raise InvalidArgumentError(f"{path} is no picture that the kernel takes; let it end with .png or .jpg")
    return "jpeg" if ending == "jpg" else ending


def _own_size(services: Services, shot: view_pb2.Shot) -> tuple[int, int]:
    small = view_pb2.Shot()
    small.CopyFrom(shot)
    small.format, small.plain = view_pb2.IMAGE_FORMAT_JPEG, True
    answer = services.view.CaptureImage(view_pb2.CaptureImageRequest(shot=small), timeout=LONG_TIMEOUT_SECONDS)
    return answer.width, answer.height
