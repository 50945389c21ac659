"""Sensors and lights: messages to frozen settings and back, field by field, since both have the same names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, fields
from enum import Enum
from typing import Any

import numpy as np
from google.protobuf.message import Message
from google.protobuf.struct_pb2 import Struct
from virtualrobot.v1 import sensing_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.fields import Field, is_repeated
from virtualrobot_kernel.messages.figures import color, color_message
from virtualrobot_kernel.messages.robots import settings, settings_message
from virtualrobot_kernel.messages.sensing_limits import CHECKS
from virtualrobot_kernel.messages.values import (
    GREATEST,
    array,
    array_message,
    check_enum,
    finite,
    not_negative,
    vector,
    vector_message,
)
from virtualrobot_kernel.world import sensing

SIGNED = frozenset({"start_angle_radians", "end_angle_radians", "elevations_radians", "cx", "cy", "distortion"})
"""Numbers that may be below 0; no others may."""

CLASSES: dict[str, type] = {
    "RangeSensor": sensing.RangeSensor,
    "SingleBeam": sensing.SingleBeam,
    "Fan": sensing.Fan,
    "Spinning": sensing.Spinning,
    "Raster": sensing.Raster,
    "Ring": sensing.Ring,
    "FreeBeams": sensing.FreeBeams,
    "CameraSensor": sensing.CameraSensor,
    "CameraIntrinsics": sensing.Intrinsics,
    "ContactSensor": sensing.ContactSensor,
    "MotionSensor": sensing.MotionSensor,
    "NoiseModel": sensing.NoiseModel,
    "Imu": sensing.Imu,
    "Encoders": sensing.Encoders,
    "PoseSensor": sensing.PoseSensor,
    "ForceTorqueSensor": sensing.ForceTorqueSensor,
    "Light": sensing.Light,
}
"""The world's class of each message."""
MESSAGES = {made: name for name, made in CLASSES.items()}
ENUMS: dict[str, type[Enum]] = {
    "CameraProjection": sensing.Projection,
    "ImageKind": sensing.ImageKind,
    "LightKind": sensing.LightKind,
}


def sensing_data(message: Message, what: str) -> Any:  # noqa: ANN401 the class of the message
    """Return what a message says of the sensor, light or part of one called `what`; what is not said is left out.

    Raises KernelError that names the field that is wrong.
    """
    made = CLASSES[message.DESCRIPTOR.name]
    values = {}
    for name in (field.name for field in fields(made)):
        if name in message.DESCRIPTOR.oneofs_by_name:
            value = _chosen(message, name, what)
        else:
            value = _value(message, message.DESCRIPTOR.fields_by_name[name], f"{what}.{name}")
        if value is not None:
            values[name] = value
    unsaid = next((field.name for field in fields(made) if field.default is MISSING and field.name not in values), "")
    if unsaid:
        raise KernelError(f"{what}.{unsaid} is not said; give it", field=f"{what}.{unsaid}")
    data = made(**values)
    if made in CHECKS:
        CHECKS[made](data, what)
    return data


def sensing_message(data: Any) -> Any:  # noqa: ANN401 the message of the data's class
    """Return the message of a sensor, a light or a part of one."""
    message = getattr(sensing_pb2, MESSAGES[type(data)])()
    for field in fields(data):
        value = getattr(data, field.name)
        if value is None or (isinstance(value, tuple | bytes) and not value):
            continue
        if field.name in message.DESCRIPTOR.oneofs_by_name:
            _choose(message, field.name, value)
        else:
            _fill(message, message.DESCRIPTOR.fields_by_name[field.name], value)
    return message


def _chosen(message: Message, oneof: str, what: str) -> Any:  # noqa: ANN401 one of the oneof's classes
    chosen = message.WhichOneof(oneof)
    if chosen is None:
        names = ", ".join(field.name for field in message.DESCRIPTOR.oneofs_by_name[oneof].fields)
        raise KernelError(f"{what} does not say its {oneof}; give one of {names}", field=what)
    return sensing_data(getattr(message, chosen), f"{what}.{chosen}")


def _choose(message: Any, oneof: str, value: object) -> None:  # noqa: ANN401 any message
    name = MESSAGES[type(value)]
    chosen = next(
        field.name for field in message.DESCRIPTOR.oneofs_by_name[oneof].fields if field.message_type.name == name
    )
    getattr(message, chosen).CopyFrom(sensing_message(value))


def _value(message: Message, field: Field, what: str) -> Any:  # noqa: ANN401 what the field holds
    """Return a field's value; None where it is not said."""
    value = getattr(message, field.name)
    if is_repeated(field):
        return tuple(_scalar(field, item, what) for item in value)
    if field.has_presence and not message.HasField(field.name):
        return None
    if field.message_type is not None:
        return _READERS.get(field.message_type.name, sensing_data)(value, what)
    if field.enum_type is not None:
        check_enum(message, field.name)
        return ENUMS[field.enum_type.name](value) if value else None
    return _scalar(field, value, what)


def _scalar(field: Field, value: Any, what: str) -> Any:  # noqa: ANN401
    if field.enum_type is not None:
        if value not in (one.value for one in ENUMS[field.enum_type.name]):
            names = ", ".join(one.name for one in field.enum_type.values[1:])
            raise KernelError(f"{what} holds {value}; give some of {names}", field=what, value=value)
        return ENUMS[field.enum_type.name](value)
    if not isinstance(value, float):
        return value
    if field.name not in SIGNED:
        not_negative(value, what)
    if not abs(finite(value, what)) <= GREATEST:
        raise KernelError(f"{what} must be at most {GREATEST:g} in size, not {value:g}", field=what, value=value)
    return value


def _fill(message: Any, field: Field, value: Any) -> None:  # noqa: ANN401
    if is_repeated(field):
        getattr(message, field.name).extend(one.value if isinstance(one, Enum) else one for one in value)
    elif field.message_type is not None:
        made = _WRITERS.get(field.message_type.name, sensing_message)(value)
        if field.has_presence and (made.ByteSize() or field.message_type.name != "NoiseModel"):
            getattr(message, field.name).CopyFrom(made)
    else:
        setattr(message, field.name, value.value if isinstance(value, Enum) else value)


def _pattern(message: sensing_pb2.ScanPattern, what: str) -> sensing.Pattern:
    return _chosen(message, "pattern", what)


def _pattern_message(pattern: sensing.Pattern) -> sensing_pb2.ScanPattern:
    message = sensing_pb2.ScanPattern()
    _choose(message, "pattern", pattern)
    return message


_READERS: dict[str, Callable[[Any, str], Any]] = {
    "ScanPattern": _pattern,
    "Struct": settings,
    "Vector3": vector,
    "Color": color,
    "NumericArray": lambda message, what: np.asarray(array(message, (None, 3), what), np.float64),
}
_WRITERS: dict[str, Callable[[Any], Any]] = {
    "ScanPattern": _pattern_message,
    # No settings are said too: those of the preset do not count then.
    "Struct": lambda value: settings_message(value) or Struct(),
    "Vector3": vector_message,
    "Color": color_message,
    "NumericArray": array_message,
}
