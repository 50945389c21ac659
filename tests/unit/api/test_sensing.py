"""Sensors and lights as messages and as data: both ways, and what is refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from google.protobuf.message import Message
from virtualrobot.v1 import sensing_pb2
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.sensing import SENSORS
from virtualrobot_kernel.messages.values import array_message

BEAMS = np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])


TABLES = {table.made.__name__: table for table in SENSORS.values()}


def told(message: Message) -> Any:  # noqa: ANN401 any dataclass
    """Return the settings that a message tells."""
    return TABLES[type(message).__name__].read(message, "it")


def lidar() -> sensing_pb2.RangeSensor:
    message = sensing_pb2.RangeSensor(preset="VLP-16", rate_hertz=10, min_range_meters=0.0, ray_caster="embree", seed=7)
    message.pattern.spinning.columns = 360
    message.pattern.spinning.elevations_radians.extend([-0.1, 0.0, 0.1])
    message.sensor_model_settings.update({"deviation": 0.01, "names": ["a", None], "deep": {"b": True}})
    return message


def free() -> sensing_pb2.RangeSensor:
    message = sensing_pb2.RangeSensor(max_range_meters=4.0, motion_distortion=True)
    message.pattern.free.directions.CopyFrom(array_message(BEAMS))
    message.pattern.free.origins.CopyFrom(array_message(np.zeros((2, 3))))
    return message


def camera() -> sensing_pb2.CameraSensor:
    return sensing_pb2.CameraSensor(
        width=320,
        projection=sensing_pb2.CAMERA_PROJECTION_FISHEYE,
        intrinsics=sensing_pb2.CameraIntrinsics(fx=200, fy=201, cx=-3, cy=120),
        distortion=[0.1, -0.2, 0.3, 0.0],
        images=[sensing_pb2.IMAGE_KIND_DEPTH, sensing_pb2.IMAGE_KIND_COLOR],
        stereo_baseline_meters=0.1,
    )


def imu() -> sensing_pb2.MotionSensor:
    message = sensing_pb2.MotionSensor(seed=3)
    message.imu.gyroscope.bias_walk = 0.1
    message.imu.magnetic_field.z = -4e-5
    return message


def light() -> sensing_pb2.Light:
    message = sensing_pb2.Light(kind=sensing_pb2.LIGHT_KIND_SPOT, cone_angle_radians=0.3, shadowless=True)
    message.color.red = 1.0
    return message


def touch() -> sensing_pb2.ContactSensor:
    message = sensing_pb2.ContactSensor(watched="arm", range_meters=0.2, ignored=["table"])
    message.region_size.x, message.region_size.y, message.region_size.z = 0.1, 0.2, 0.3
    return message


MESSAGES = (lidar, free, camera, imu, light, touch)


@pytest.mark.parametrize("make", MESSAGES)
def test_what_is_said_comes_back(make: Callable[[], Message]) -> None:
    message = make()
    assert TABLES[type(message).__name__].write(told(message)) == message


@pytest.mark.parametrize("name", ["RangeSensor", "CameraSensor", "ContactSensor", "Light"])
def test_what_is_not_said_stays_so(name: str) -> None:
    table = TABLES[name]
    data = told(getattr(sensing_pb2, name)())
    assert data == table.made() or vars_of(data) == vars_of(table.made())
    again = told(table.write(data))
    assert vars_of(again) == vars_of(data)


def vars_of(data: Any) -> dict[str, object]:  # noqa: ANN401 any dataclass
    return {field.name: getattr(data, field.name) for field in fields(data)}


def fan(**fields: float) -> sensing_pb2.RangeSensor:
    message = sensing_pb2.RangeSensor()
    for name, value in fields.items():
        setattr(message.pattern.fan, name, value)
    return message


def pointing(rows: np.ndarray) -> sensing_pb2.RangeSensor:
    message = sensing_pb2.RangeSensor()
    message.pattern.free.directions.CopyFrom(array_message(rows))
    return message


REFUSED = {
    "it.rate_hertz": sensing_pb2.RangeSensor(rate_hertz=math.nan),
    "it.rate_hertz must be 0 or above": sensing_pb2.CameraSensor(rate_hertz=-1),
    "it.rate_hertz must be 1e-06 to 10000": sensing_pb2.MotionSensor(rate_hertz=1e6, pose=sensing_pb2.PoseSensor()),
    "or 0, not 4.94066e-324": sensing_pb2.CameraSensor(rate_hertz=5e-324),
    "resolution must be at least": sensing_pb2.MotionSensor(imu={"gyroscope": {"resolution": 1e-320}}),
    "it.pose.orientation.bias_walk must be at most 1e+12": sensing_pb2.MotionSensor(
        pose={"orientation": {"bias_walk": 1e200}}
    ),
    "it.pattern.free.directions is missing": sensing_pb2.RangeSensor(pattern={"free": {}}),
    "row 0 is not": sensing_pb2.RangeSensor(
        pattern={"free": {"directions": array_message(BEAMS), "origins": array_message(1e13 * BEAMS)}}
    ),
    "above the least range 2": sensing_pb2.RangeSensor(min_range_meters=2, max_range_meters=1),
    "min_range_meters must be 0 or above": sensing_pb2.RangeSensor(min_range_meters=-1),
    "it does not say its kind; give one of imu": sensing_pb2.MotionSensor(),
    "give one of beam, fan": sensing_pb2.RangeSensor(pattern=sensing_pb2.ScanPattern()),
    "it.pattern.fan.count must be 1 to 2,000,000, not 0": fan(start_angle_radians=1.0),
    "not 1,000,000,000": fan(count=1_000_000_000),
    "a full turn is the most": fan(count=2, end_angle_radians=7.0),
    "row 1 is zero": pointing(np.array([[1.0, 0, 0], [0, 0, 0]])),
    "not finite": pointing(np.array([[1.0, math.inf, 0]])),
    "16,000,000": sensing_pb2.CameraSensor(width=100_000, height=1000),
    "give one": sensing_pb2.CameraSensor(
        intrinsics=sensing_pb2.CameraIntrinsics(fx=1, fy=1), horizontal_field_radians=1
    ),
    "must be between -pi/2 and pi/2, not 2": sensing_pb2.RangeSensor(
        pattern={"spinning": {"columns": 3, "elevations_radians": [0, 2]}}
    ),
    "less than half a turn high, not 1 x 4 rad": sensing_pb2.RangeSensor(
        pattern={"raster": {"columns": 3, "rows": 2, "horizontal_field_radians": 1, "vertical_field_radians": 4}}
    ),
    "focal lengths above 0": sensing_pb2.CameraSensor(intrinsics=sensing_pb2.CameraIntrinsics(fx=1)),
    "has 3 coefficients; 0 or 4 or 5 or 8": sensing_pb2.CameraSensor(distortion=[1, 2, 3]),
    "above near_meters": sensing_pb2.CameraSensor(near_meters=5, far_meters=1),
    "names a kind twice": sensing_pb2.CameraSensor(images=["IMAGE_KIND_COLOR", "IMAGE_KIND_COLOR"]),
    "it.images[0] is 9, which has no meaning; give one of IMAGE_KIND_COLOR": sensing_pb2.CameraSensor(images=[9]),  # pyright: ignore[reportArgumentType]
    "parts from 0 to 1": sensing_pb2.Light(color={"red": 2.0}),
    "it.region_size must have edges above 0": sensing_pb2.ContactSensor(region_size={"x": 1.0}),
    "at most pi/2": sensing_pb2.Light(cone_angle_radians=2.0),
}


@pytest.mark.parametrize("said", REFUSED, ids=str)
def test_nonsense_is_refused_by_the_field_that_is_wrong(said: str) -> None:
    with pytest.raises(KernelError) as refused:
        told(REFUSED[said])
    assert said in str(refused.value)
