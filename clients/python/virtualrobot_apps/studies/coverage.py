"""Places of cameras and range sensors: how much of an area they see, and how much of it two of them do.

For a study file: `function: virtualrobot_apps.studies.coverage:cover`,
`setup: virtualrobot_apps.studies.worlds:open_world`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from virtualrobot_apps.studies.parameters import Floats
from virtualrobot_apps.studies.placement import elsewhere, names_of
from virtualrobot_apps.studies.work import Cell
from virtualrobot_apps.studies.worlds import World

_MOST_POINTS = 1_000_000


def cover(cell: Cell) -> dict[str, float | str | None]:
    """Return how much of an area sensors see, some of them from other places.

    Its parameters: `sensors`, names of pinhole cameras and range sensors with commas between; `moved`, those of them
    that are elsewhere (without it, none is): the first one by `x`, `y` and `z`, its place on its parent then (m;
    without them it stays there), and `yaw`, by how much it is turned about the parent's z axis besides (rad; without
    it, 0), the second one by `x2`, `y2`, `z2` and `yaw2`, and so on; `area`, the name of a node in the middle of the
    area, which is `length` along the node's x axis, `width` along y and `height` along z (m; without `height` it is
    flat); `spacing`, between the points of it that are asked for at most (m). A range sensor sees a point that one of
    its beams passes within half of that.

    Its results: `seen`, the share of the area that one sensor or more see, each point with nothing before it; `twice`,
    the share that two or more see, from which places can be measured; `least`, the share that the worst one of the
    sensors sees, and `worst`, its name.
    """
    world: World = cell.shared
    world.restore()
    parameters = cell.parameters
    sensors = names_of(parameters["sensors"])
    moved = names_of(parameters["moved"]) if "moved" in parameters else []
    for number, name in enumerate(moved, 1):
        if name not in sensors or name in moved[: number - 1]:
            raise ValueError(f"moved is some of {', '.join(sensors)}, each once, not {', '.join(moved)}")
        world.place(name, elsewhere(world.parent_pose(name), _of_number(parameters, number), "xyz"))
    points = area_points(world.pose(parameters["area"]), parameters)
    within = 0.5 * parameters["spacing"]
    views = np.array([world.seen(name, points, within) for name in sensors])
    count, shares = views.sum(axis=0), views.mean(axis=1)
    worst = int(np.argmin(shares))
    return {
        "seen": float((count >= 1).mean()),
        "twice": float((count >= 2).mean()),
        "least": float(shares[worst]),
        "worst": sensors[worst],
    }


def _of_number(parameters: Mapping[str, Any], number: int) -> dict[str, Any]:
    """Return the place of a sensor: `x2` and so on of the second, `x` of the first."""
    ending = "" if number == 1 else str(number)
    return {name: parameters[name + ending] for name in ("x", "y", "z", "yaw") if name + ending in parameters}


def area_points(world_t_area: Floats, parameters: Mapping[str, Any]) -> Floats:
    """Return points (n, 3), m in the world: the middles of equal pieces of the area, none longer than `spacing`.

    Raises:
        ValueError: for sizes that are none, and for more than a million of points.
    """
    sizes = [parameters["length"], parameters["width"], parameters.get("height", 0.0)]
    spacing = parameters["spacing"]
    if min(*sizes[:2], spacing) <= 0.0 or sizes[2] < 0.0:
        raise ValueError("length, width and spacing are above 0, and height is 0 or more")
    counts = [max(1, int(np.ceil(size / spacing - 1e-9))) for size in sizes]
    if np.prod(counts, dtype=float) > _MOST_POINTS:
        raise ValueError(f"{' x '.join(map(str, counts))} points are more than {_MOST_POINTS}: spacing is too small")
    axes = [size * ((np.arange(count) + 0.5) / count - 0.5) for size, count in zip(sizes, counts, strict=True)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return places @ world_t_area[:3, :3].T + world_t_area[:3, 3]
