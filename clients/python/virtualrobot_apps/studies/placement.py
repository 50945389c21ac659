"""Placements of a robot's base: which targets it reaches from there, free of collisions and off its joints' limits.

For a study file: `function: virtualrobot_apps.studies.placement:place`,
`setup: virtualrobot_apps.studies.worlds:open_world`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from virtualrobot_apps.studies.parameters import Floats
from virtualrobot_apps.studies.work import Cell
from virtualrobot_apps.studies.worlds import Postures, World

OUT_OF_REACH = "out of reach"
"""Reason for a place that no posture reaches."""


def place(cell: Cell) -> dict[str, float | str | None]:
    """Return how well a robot reaches its targets from another place.

    Its parameters: `robot`, a name; `x` and `y`, where its base is then on its parent (m; without them it stays there),
    at the height that it has; `yaw`, by how much it is turned about the parent's z axis besides (rad; without it, 0);
    `targets`, names of nodes with commas between, at whose frames the tool centre point shall be.

    Its results: `reached`, the share of the targets that it reaches within limits; `free`, the share that it reaches
    and touches nothing; `margin`, how far the joints are from their limits in the best posture of the worst target, as
    a share of half their range, None where not all targets are free; `reason`, what is wrong with the first target
    that is not, or with the base.
    """
    return placed(cell.shared, cell.parameters)


def placed(world: World, parameters: Mapping[str, Any]) -> dict[str, float | str | None]:
    """Return what `place` does, of a world; without `x` or `y` the base stays there in that direction."""
    robot = parameters["robot"]
    targets = names_of(parameters["targets"])
    world.restore()
    poses = np.array([world.pose(name) for name in targets])
    world.place(robot, elsewhere(world.parent_pose(robot), parameters))
    found = world.postures(robot, poses)
    reached, free = set(found.target.tolist()), set(found.target[found.free].tolist())
    results = {"reached": len(reached) / len(targets), "free": len(free) / len(targets), "margin": None}
    if contacts := world.contacts(robot):
        return results | {"free": 0.0, "reason": touches(contacts[0])}
    for number, name in enumerate(targets):
        if number not in free:
            return results | {"reason": f"{name}: {_reason(found, number)}"}
    return results | {"margin": margin(found, world.joint_limits(robot), len(targets)), "reason": None}


def margin(found: Postures, limits: Floats, targets: int) -> float:
    """Return how far joints are from limits (k, 2), as a share of half their range: the worst of the best postures.

    Each of the targets, from 0, has a posture that is free. Joints without limits don't count.
    """
    each = margins(found, limits)
    return min(float(each[(found.target == one) & found.free].max()) for one in range(targets))


def margins(found: Postures, limits: Floats) -> Floats:
    """Return (m,) how far the joints of each posture are from limits (k, 2), as a share of half their range."""
    middle, half = limits.mean(axis=1), 0.5 * (limits[:, 1] - limits[:, 0])
    limited = np.isfinite(half)
    off = np.abs(found.positions - middle)[:, limited] / half[limited]
    return 1.0 - off.max(axis=1, initial=0.0)


def names_of(text: str) -> list[str]:
    """Return the names in a parameter that has several of them, with commas between."""
    return [name.strip() for name in text.split(",")]


def elsewhere(parent_t_node: Floats, parameters: Mapping[str, Any], axes: str = "xy") -> Floats:
    """Return where on its parent (4, 4) a node is with the parameters of a cell.

    `x`, `y` and so on, of these axes, are its place then (m; without one it stays there in that direction), and `yaw`
    by how much it is turned about the parent's z axis besides (rad; without it, 0).
    """
    found = turned(parameters.get("yaw", 0.0)) @ parent_t_node
    for name in axes:
        number = "xyz".index(name)
        found[number, 3] = parameters.get(name, parent_t_node[number, 3])
    return found


def touches(pair: tuple[str, str]) -> str:
    """Return in words that two nodes touch."""
    return f"{pair[0]} touches {pair[1]}"


def turned(yaw: float) -> Floats:
    """Return the pose (4, 4) of a frame that is turned about z (rad)."""
    result = np.eye(4)
    result[:2, :2] = [[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]]
    return result


def _reason(found: Postures, number: int) -> str:
    those = np.flatnonzero(found.target == number).tolist()
    if not those:
        return OUT_OF_REACH
    pair = next(found.touching[one] for one in those if found.touching[one])
    assert pair is not None
    return touches(pair)
