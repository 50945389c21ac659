"""Files of displays: walls, observer and tracker, read with file, line and what would be right."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix, pose

from virtualrobot_apps.cell_io.yaml_file import Item, parse, read_text
from virtualrobot_apps.registration.touched import UP
from virtualrobot_apps.walls.display import STEREO, Display, Output, Tracker
from virtualrobot_apps.walls.frustum import Wall

FIELDS = ("schema_version", "display", "observer", "tracker")
DISPLAY_FIELDS = ("near", "far", "walls")
WALL_FIELDS = ("name", "lower_left", "lower_right", "upper_left", "pixels", "stereo")
OBSERVER_FIELDS = ("pose", "height", "speed", "eyes")
TRACKER_FIELDS = ("pose", "up", "body_t_head")

MOST_PIXELS = 16384
MOST_METERS = 1e6


def read_display(file: Path) -> Display:
    """Return what a file says; raise MissingFileError or MalformedFileError, which tells the line."""
    return display_of(parse(read_text(file), str(file)))


def display_of(root: Item) -> Display:
    """Return what a file says; raise MalformedFileError, which tells the line."""
    fields = root.fields(FIELDS, ("display",))
    display = fields["display"].fields(DISPLAY_FIELDS, ("walls",))
    near = display["near"].number(1e-3, MOST_METERS) if "near" in display else 0.05
    far = display["far"].number(1e-3, MOST_METERS) if "far" in display else 100.0
    if near >= far:
        raise display["far" if "far" in display else "near"].error(
            f"near is {near:g} m and far {far:g} m: far is farther"
        )
    outputs = tuple(_output(item) for item in display["walls"].items())
    if not outputs:
        raise display["walls"].error("a display has a wall at least")
    names = [one.wall.name for one in outputs]
    for item, name in zip(display["walls"].items(), names, strict=True):
        if names.count(name) > 1:
            raise item.error(f"the name {name!r} is that of several walls")
    observer = fields["observer"].fields(OBSERVER_FIELDS) if "observer" in fields else {}
    tracker = fields["tracker"].fields(TRACKER_FIELDS) if "tracker" in fields else {}
    up = tracker["up"].one_of(tuple(UP)) if "up" in tracker else "z"
    return Display(
        near,
        far,
        outputs,
        _pose(observer.get("pose")),
        observer["height"].number(0.0, 100.0) if "height" in observer else 1.7,
        observer["speed"].number(0.0, 100.0) if "speed" in observer else 1.0,
        observer["eyes"].number(0.0, 0.2) if "eyes" in observer else 0.064,
        Tracker(_pose(tracker.get("pose")) @ UP[up], _pose(tracker.get("body_t_head"))),
    )


def _output(item: Item) -> Output:
    needed = ("name", "lower_left", "lower_right", "upper_left", "pixels")
    fields = item.fields(WALL_FIELDS, needed)
    corners = [np.array(_numbers(fields[name], 3)) for name in needed[1:4]]
    try:
        wall = Wall(fields["name"].text(), *corners)
    except InvalidArgumentError as error:
        raise item.error(str(error)) from None
    sizes = fields["pixels"].items()
    if len(sizes) != 2:
        raise fields["pixels"].error(f"width and height belong here, not {len(sizes)} numbers")
    width, height = (one.whole(2, MOST_PIXELS) for one in sizes)
    return Output(wall, (width, height), fields["stereo"].one_of(tuple(STEREO)) if "stereo" in fields else "none")


def _pose(item: Item | None) -> Matrix:
    """Return the pose of x, y, z (m) and roll, pitch, yaw (rad)."""
    if item is None:
        return np.eye(4)
    try:
        return pose(*_numbers(item, 6))
    except InvalidArgumentError as error:
        raise item.error(str(error)) from None


def _numbers(item: Item, count: int) -> list[float]:
    numbers = [one.number(-MOST_METERS, MOST_METERS) for one in item.items()]
    if len(numbers) != count:
        raise item.error(f"{count} numbers belong here, not {len(numbers)}")
    return numbers
