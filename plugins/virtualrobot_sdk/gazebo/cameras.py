"""Gazebo's cameras: they look along x of their frame, z up; a node's camera looks along z, y down."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from virtualrobot_sdk.gazebo.ranges import old_angle
from virtualrobot_sdk.gazebo.tags import (
    BadTagError,
    Element,
    Values,
    Warn,
    child,
    children,
    count,
    noise,
    not_negative,
    number,
    pose,
    said,
    text,
    vector,
)
from virtualrobot_sdk.kinematics import Floats

BODY_T_OPTICAL = np.array([[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""(4, 4) pose of the frame that looks along z in the one that looks along x (REP 103)."""

_COLOR, _DEPTH, _LABELS = "IMAGE_KIND_COLOR", "IMAGE_KIND_DEPTH", "IMAGE_KIND_SEGMENTATION"
IMAGES = {
    "camera": (),
    "multicamera": (),
    "wideanglecamera": (),
    "wide_angle_camera": (),
    "depth": (_COLOR, _DEPTH),
    "depth_camera": (_DEPTH,),
    "rgbd": (_COLOR, _DEPTH),
    "rgbd_camera": (_COLOR, _DEPTH),
    "segmentation": (_LABELS,),
    "segmentation_camera": (_LABELS,),
}
"""The types of cameras, and what each takes; nothing said means colour. Gazebo Classic's `depth` has both pictures."""
_WIDE = ("wideanglecamera", "wide_angle_camera")


def cameras(sensor: Element, kind: str, warn: Warn) -> Iterator[tuple[str, Floats, Values]]:
    """Yield for each <camera> its name where there are several, its pose in the sensor's frame and the camera."""
    found = list(children(sensor, "camera"))
    if not found:
        raise BadTagError(sensor, "it has no <camera>")
    for number_, camera in enumerate(found, 1):
        name = "" if len(found) == 1 else camera.get("name", "").strip() or str(number_)
        yield name, pose(camera) @ BODY_T_OPTICAL, _camera(camera, kind, warn)


def old_camera(sensor: Element) -> tuple[Floats, Values]:
    """Return the pose and the camera of a <sensor:camera> of Gazebo before 1.0."""
    size = vector(sensor, "imageSize")
    if size and (len(size) != 2 or min(size) < 1.0):
        raise BadTagError(child(sensor, "imageSize"), f"<imageSize> has {len(size)} numbers, expected width and height")
    width, height = (int(size[0]), int(size[1])) if size else (0, 0)
    values = said(
        width=width,
        height=height,
        horizontal_field_radians=_field(sensor, old_angle(sensor, "hfov"), math.pi),
        near_meters=not_negative(sensor, "nearClip"),
        far_meters=not_negative(sensor, "farClip"),
    )
    return BODY_T_OPTICAL, values


def _camera(camera: Element, kind: str, warn: Warn) -> Values:
    image, clip, lens = child(camera, "image"), child(camera, "clip"), child(camera, "lens")
    # In an <rgbd_camera> only the depth picture has a noise and a clip of its own; the first is used there.
    depth = child(camera, "depth_camera")
    if depth is not None and child(depth, "clip") is not None and clip is None:
        clip = child(depth, "clip")
    spread = noise(child(camera, "noise"), warn)
    if spread.mean or spread.bias_mean or spread.bias_deviation or spread.bias_walk:
        warn(child(camera, "noise"), "mean and bias of the noise are left out; cameras have none")
    only_depth = IMAGES[kind] == (_DEPTH,)
    fisheye = kind in _WIDE and _is_fisheye(lens, warn)
    intrinsics = _intrinsics(lens)
    field = number(camera, "horizontal_fov", default=1.047)
    values = said(
        width=count(image, "width", default=320),
        height=count(image, "height", default=240),
        projection="CAMERA_PROJECTION_FISHEYE" if fisheye else "",
        near_meters=not_negative(clip, "near"),
        far_meters=min(number(clip, "far"), 1e6),
        images=list(IMAGES[kind]),
        color_noise=0.0 if only_depth else spread.deviation,
        depth_noise_meters=spread.deviation if only_depth else 0.0,
        distortion=_distortion(camera, fisheye, warn),
    )
    if intrinsics:
        values["intrinsics"] = intrinsics
    else:
        values["horizontal_field_radians"] = _field(camera, field, 2.0 * math.pi if fisheye else math.pi)
    return values


def _field(named_by: Element, angle: float, widest: float) -> float:
    if not 0.0 <= angle < widest:
        raise BadTagError(named_by, f"the field of view of {angle:g} rad must be from 0 to below {widest:.4g}")
    return angle


def _distortion(camera: Element, fisheye: bool, warn: Warn) -> list[float]:
    """Return OpenCV's coefficients k1 k2 p1 p2 k3; empty without distortion."""
    tag = child(camera, "distortion")
    values = [number(tag, name) for name in ("k1", "k2", "p1", "p2", "k3")]
    if not any(values):
        return []
    if fisheye:
        warn(tag, "the distortion is left out: the lens is taken as equidistant")
        return []
    if any(round(one - 0.5, 6) for one in vector(tag, "center")):
        warn(tag, "the <center> of the distortion is left out: it is the picture's")
    return values if values[4] else values[:4]


def _intrinsics(lens: Element | None) -> Values:
    tag = child(lens, "intrinsics")
    if tag is None:
        return {}
    values = {name: number(tag, name) for name in ("fx", "fy", "cx", "cy")}
    if not (values["fx"] > 0.0 and values["fy"] > 0.0):
        raise BadTagError(tag, "<intrinsics> needs focal lengths above 0")
    return values


def _is_fisheye(lens: Element | None, warn: Warn) -> bool:
    """Return whether a wide angle is taken as equidistant; a <lens> of the type gnomonical is a pinhole."""
    kind = text(lens, "type")
    if kind == "gnomonical":
        return False
    if kind not in ("", "equidistant"):
        warn(lens, f"the lens {kind!r} is taken as equidistant")
    return True
