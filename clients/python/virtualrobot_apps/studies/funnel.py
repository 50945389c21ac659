"""Funnel of placements: what is quick to ask sorts out most places of a base, and only the rest run a program.

For a study file: `function: virtualrobot_apps.studies.funnel:sift`,
`setup: virtualrobot_apps.studies.funnel:open_both`, `scene`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from virtualrobot_apps.studies.cycle import DONE, RUNNING, RunningKernel, open_kernel, run_from
from virtualrobot_apps.studies.placement import names_of, placed
from virtualrobot_apps.studies.work import Cell
from virtualrobot_apps.studies.worlds import World, open_world

REACH, COLLISION = "reach", "collision"
"""Stages at which a place fails before a program is planned; the others are those of its planning and its run."""


@dataclass
class Both:
    """World of a scene in a worker's memory, and a kernel with the same scene, which starts when it is first needed.

    Attributes:
        world: for postures and collisions.
        open_kernel: starts the kernel.
    """

    world: World
    open_kernel: Callable[[], RunningKernel]

    @cached_property
    def kernel(self) -> RunningKernel:
        """Return the kernel."""
        return self.open_kernel()


def open_both(scene: Path | None) -> Both:
    """Open a scene in this process's memory, and prepare a kernel of it: for `setup` of a study file.

    Raises:
        InvalidArgumentError: when the study names no scene.
        Exception: what is wrong in the scene, in words.
    """
    return Both(open_world(scene), lambda: open_kernel(scene))


def sift(cell: Cell) -> dict[str, float | str | None]:
    """Return how far a place of a robot's base gets: by inverse kinematics, collisions, planning and simulation.

    Each is asked only where the ones before it have gone well. Its parameters: `robot`, `x`, `y`, `yaw` and `targets`
    as in `virtualrobot_apps.studies.placement:place`; `program` and `most_seconds` as in
    `virtualrobot_apps.studies.cycle:run_program`.

    Its results: `kinematics`, 1 where all targets are within reach, `collision`, 1 where they are free besides,
    `planning`, 1 where the program's check has found nothing, `simulation`, 1 where it has run to its end, each else
    0, so that a mean is the share of the places that have come through; `margin` as of `place`, None before it is
    known; `ticks` and `duration` (s) of the run; `stage` and `reason`, where it failed and why: `reach` with the
    number of targets that are not, `collision`, or as of `run_program`, at last `done` and None.
    """
    both: Both = cell.shared
    at = placed(both.world, cell.parameters)
    found: dict[str, float | str | None] = dict.fromkeys(("kinematics", "collision", "planning", "simulation"), 0)
    found |= {"margin": at["margin"], "ticks": None, "duration": None, "reason": at["reason"]}
    if (reached := at["reached"]) != 1.0:
        count = len(names_of(cell.parameters["targets"]))
        return found | {"stage": REACH, "reason": f"{round((1.0 - float(reached or 0.0)) * count)} of {count} targets"}
    found["kinematics"] = 1
    if at["reason"] is not None:
        return found | {"stage": COLLISION}
    found["collision"] = 1
    found |= run_from(both.kernel, cell.parameters)
    found["planning"] = found["stage"] in (RUNNING, DONE)
    found["simulation"] = found["stage"] == DONE
    return found
