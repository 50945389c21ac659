"""Robots of the catalogue in the place of one: which of them reaches its targets, free of collisions.

For a study file: `function: virtualrobot_apps.studies.robots:choose`,
`setup: virtualrobot_apps.studies.worlds:open_worlds`.
"""

from __future__ import annotations

from virtualrobot_apps.studies.placement import placed
from virtualrobot_apps.studies.work import Cell
from virtualrobot_apps.studies.worlds import Worlds


def choose(cell: Cell) -> dict[str, float | str | None]:
    """Return how well another model would do in the place of a robot.

    Its parameters: `robot`, the name of one of the scene's models; `model`, what it is made of then, such as
    `model://ur10e`; and those of `virtualrobot_apps.studies.placement:place`, whose results it has. Worlds take seconds
    to open: `model` comes before all others in the study file, so that neighbouring cells have the same.
    """
    worlds: Worlds = cell.shared
    return placed(worlds.of(cell.parameters["robot"], cell.parameters["model"]), cell.parameters)
