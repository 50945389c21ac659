"""Registrations that pages and headsets ask the console for: by points that they touched, and by pictures they send.

As `virtualrobot register` does it. What is kept in the world is kept with the token of who asks.
"""

from __future__ import annotations

import base64
import binascii
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, MalformedFileError

from virtualrobot_apps.cell_io.yaml_file import SCHEMA_VERSION, parse
from virtualrobot_apps.console.numbers import numbers
from virtualrobot_apps.registration.marker_pose import EDGE, picture_of
from virtualrobot_apps.registration.placing import AWAY, camera_in, keep_frame, move_robot, seen_in, touched_in
from virtualrobot_apps.registration.touched import LEAST_APART
from virtualrobot_apps.registration.touched_file import FIELDS, touched_of

MOST_PICTURES = 10

OF_TOUCHES = (*FIELDS[1:], "tools", "least_apart", "frame", "robot")
OF_PICTURES = ("pictures", "marker", "number", "field", "matrix", "distortion", "edge", "up", "tools", "frame")


def by_touches(client: Client, said: Mapping[str, Any]) -> dict[str, object]:
    """Return where a device is that touched points, and keep it where `frame` or `robot` says so.

    The fields are those of a file of touched points, and `tools`, `least_apart` (m), `frame` and `robot` as the
    command's options.
    """
    _known(said, OF_TOUCHES)
    text = json.dumps({"schema_version": SCHEMA_VERSION, **{name: said[name] for name in FIELDS[1:] if name in said}})
    try:
        read = touched_of(parse(text, "points"))
    except MalformedFileError as error:
        # It has no lines that anybody has seen.
        raise InvalidArgumentError(str(error).partition(": ")[2]) from None
    tools = _tools(said)
    frame, robot = _text(said, "frame"), _text(said, "robot")
    if frame and robot:
        raise InvalidArgumentError("'frame' keeps a device and 'robot' moves a robot; give one of them")
    (least_apart,) = numbers([said.get("least_apart", LEAST_APART)], "least_apart", 1)
    found, errors = touched_in(client, read, tools, least_apart)
    if frame:
        keep_frame(client, frame, found.model_t_device, read.relative_to)
    if robot:
        move_robot(client, robot, found)
    return {
        "world_t_device": found.model_t_device.ravel().tolist(),
        "residuals": found.residuals.tolist(),
        "noise": found.noise,
        "error_away": found.error(found.center + np.array([AWAY, 0.0, 0.0])),
        "errors": errors,
    }


def by_pictures(client: Client, said: Mapping[str, Any]) -> dict[str, object]:
    """Return where a camera is that took pictures of a marker, and keep it where `frame` says so.

    `pictures` are files (PNG, JPEG) in base64, `marker` the node of the sheet, `field` the horizontal field of view
    (rad) or `matrix` fx, fy, cx, cy; `number`, `distortion`, `edge` (m), `up`, `tools` and `frame` as the command's
    options.
    """
    _known(said, OF_PICTURES)
    given = said.get("pictures")
    if not isinstance(given, list) or not 1 <= len(given) <= MOST_PICTURES:
        raise InvalidArgumentError(f"'pictures' are 1 to {MOST_PICTURES} files in base64, not {given!r:.40}")
    pictures = {f"picture {place}": picture_of(_bytes(one), f"picture {place}") for place, one in enumerate(given, 1)}
    number = said.get("number")
    if number is not None and (not isinstance(number, int) or isinstance(number, bool)):
        raise InvalidArgumentError(f"'number' is a whole number, not {number!r:.40}")
    seen = seen_in(
        pictures,
        field=numbers([said["field"]], "field", 1)[0] if "field" in said else None,
        matrix=numbers(said["matrix"], "matrix", 4) if "matrix" in said else None,
        distortion=numbers(said.get("distortion", []), "distortion", 0, 4, 5, 8),
        edge=numbers([said.get("edge", EDGE)], "edge", 1)[0],
        number=number,
    )
    sheet, frame = _text(said, "marker"), _text(said, "frame")
    up = numbers(said["up"], "up", 3) if "up" in said else None
    seen, world_t_camera, errors = camera_in(client, seen, sheet, _tools(said), up)
    if frame:
        keep_frame(client, frame, world_t_camera, sheet)
    return {
        "number": seen.number,
        "corners": seen.corners.tolist(),
        "deviation": seen.deviation,
        "camera_t_marker": seen.camera_t_marker.ravel().tolist(),
        "world_t_camera": world_t_camera.ravel().tolist(),
        "error_away": seen.error([AWAY, 0.0, 0.0]),
        "errors": errors,
    }


def _known(said: Mapping[str, Any], known: tuple[str, ...]) -> None:
    for name in said:
        if name not in known:
            raise InvalidArgumentError(f"there is no field {name!r:.60}; known: {', '.join(known)}")


def _text(said: Mapping[str, Any], field: str) -> str:
    value = said.get(field, "")
    if not isinstance(value, str):
        raise InvalidArgumentError(f"{field!r} is a text, not {value!r:.60}")
    return value


def _tools(said: Mapping[str, Any]) -> list[str]:
    tools = said.get("tools", [])
    if not isinstance(tools, list) or not all(isinstance(one, str) for one in tools):
        raise InvalidArgumentError(f"'tools' are names of nodes, not {tools!r:.80}")
    return tools


def _bytes(said: object) -> bytes:
    try:
        return base64.b64decode(said if isinstance(said, str) else "", validate=True)
    except (binascii.Error, ValueError):
        raise InvalidArgumentError("a picture is a file in base64") from None
