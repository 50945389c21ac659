"""Files of touched points: where each is in the model, and where a device says that it is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from virtualrobot_apps.cell_io.yaml_file import Item, parse, read_text
from virtualrobot_apps.registration.touched import MOST_TILT, NOISE, UP

FIELDS = ("schema_version", "relative_to", "up", "noise", "tilt", "points")

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class TouchedFile:
    """Touched points of a file.

    Attributes:
        relative_to: the node in whose frame the model's points are given.
        up: the axis of the device's frame that is up, `z` or `y`.
        noise: standard deviation of each coordinate of a touch, m.
        tilt: that of what the device takes for up, rad.
        model: where each point is in the model: x, y, z (m) in the frame of that node, or a node, whose origin it is.
        touched: where the device says that it is, m.
    """

    relative_to: str
    up: str
    noise: float
    tilt: float
    model: tuple[Vector | str, ...]
    touched: tuple[Vector, ...]


def read_touched(file: Path) -> TouchedFile:
    """Return what a file says; raise MissingFileError or MalformedFileError, which tells the line."""
    return touched_of(parse(read_text(file), str(file)))


def touched_of(root: Item) -> TouchedFile:
    """Return what a file says; raise MalformedFileError, which tells the line."""
    fields = root.fields(FIELDS, ("points",))
    pairs = [item.fields(("model", "touched"), ("model", "touched")) for item in fields["points"].items()]
    return TouchedFile(
        fields["relative_to"].text() if "relative_to" in fields else "world",
        fields["up"].one_of(tuple(UP)) if "up" in fields else "z",
        fields["noise"].number(1e-6, 0.1) if "noise" in fields else NOISE,
        fields["tilt"].number(0.0, MOST_TILT) if "tilt" in fields else 0.0,
        tuple(_vector(pair["model"]) if pair["model"].is_list else pair["model"].text() for pair in pairs),
        tuple(_vector(pair["touched"]) for pair in pairs),
    )


def _vector(item: Item) -> Vector:
    numbers = [one.number() for one in item.items()]
    if len(numbers) != 3:
        raise item.error(f"three numbers (m) belong here, not {len(numbers)}")
    return numbers[0], numbers[1], numbers[2]
