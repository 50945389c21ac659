"""Cycle times: how long a program takes, in ticks of a kernel's clock, and where it fails instead.

For a study file: `function: virtualrobot_apps.studies.cycle:run_program`,
`setup: virtualrobot_apps.studies.cycle:open_kernel`, `scene`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import virtualrobot
from virtualrobot.errors import InvalidArgumentError, VirtualRobotError
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.motions.program import Program
from virtualrobot.stepping import motion_ends

from virtualrobot_apps.studies.placement import elsewhere
from virtualrobot_apps.studies.work import Cell
from virtualrobot_apps.studies.worlds import NO_SCENE

PLANNING, RUNNING, DONE = "planning", "running", "done"
"""Stages of a program besides those of its check, which are called as the kinds of violations."""
_BEGIN = "begin of the study"
_USUAL_SECONDS = 600.0
_STEP_TICKS = 10_000
"""Number of ticks that a kernel takes in one call at most."""


@dataclass
class RunningKernel:
    """Kernel of a worker, whose time goes on by steps alone, with the world of a scene; it ends with the worker."""

    process: KernelProcess
    client: virtualrobot.Client
    scene: Path
    tick: float

    def restore(self) -> None:
        """Go back to the world as it was loaded."""
        way_back = self.client.history.restore(_BEGIN)
        self.client.history.remove_checkpoint(way_back.name)


def open_kernel(scene: Path | None) -> RunningKernel:
    """Start a kernel, and load a scene into it: for `setup` of a study file.

    Raises:
        InvalidArgumentError: when the study names no scene.
        VirtualRobotError: when no kernel starts, or for what is wrong in the scene.
    """
    if scene is None:
        raise InvalidArgumentError(NO_SCENE)
    process = KernelProcess(headless=True)
    try:
        client = virtualrobot.connect(process.address)
        tick = client.clock.set_stepped().tick_length
        client.scene.load_scene(scene)
        client.history.checkpoint(_BEGIN)
    except BaseException:
        process.close()
        raise
    return RunningKernel(process, client, scene, tick)


def run_program(cell: Cell) -> dict[str, float | str | None]:
    """Return how long a program takes from where a robot stands.

    Its parameters: `program`, a program file, from the scene's folder on; `robot`, with `x`, `y` and `yaw` as in
    `virtualrobot_apps.studies.placement:place`, where its base is meanwhile (without `robot`, all stays as in the
    scene); `most_seconds`, the simulated time (s) after which it is given up (without it, 600).

    Its results: `ticks` of the clock and `duration`, simulated time (s), None where it isn't done; `stage`, how far it
    has come: it is `done`, was ended while it was `running`, its check has found the first violation of a kind (such as
    `reach`, `singularity`, `joint_velocity`, `collision`), or `planning` has refused it; `reason`, in words and with
    the number of the step, None where it is done.
    """
    return run_from(cell.shared, cell.parameters)


def run_from(kernel: RunningKernel, parameters: Mapping[str, Any]) -> dict[str, float | str | None]:
    """Return what `run_program` does, of a kernel that goes back to its beginning first."""
    kernel.restore()
    if "robot" in parameters:
        node = kernel.client.scene.node(parameters["robot"])
        node.parent_t_node = elsewhere(node.parent_t_node, parameters)
    program = kernel.client.read_program(kernel.scene.parent / parameters["program"])
    return timed(kernel, program, parameters.get("most_seconds", _USUAL_SECONDS))


def timed(kernel: RunningKernel, program: Program, most_seconds: float) -> dict[str, float | str | None]:
    """Return how long a program takes, as `run_program`; raise ValueError when it may take less than a tick."""
    most = round(most_seconds / kernel.tick)
    if most < 1:
        raise ValueError(f"most_seconds is a tick of {kernel.tick:g} s or more, not {most_seconds:g}")
    try:
        if (violation := program.check().first_violation) is not None:
            reason = violation.message
            if not reason.startswith("step "):
                reason = f"step {violation.step_path}: {reason}"
            return _failed(violation.kind.name.lower(), reason)
        motion = program.start(wait=False)
    except VirtualRobotError as error:
        return _failed(PLANNING, str(error))
    ticks, is_ended = 0, False
    while not is_ended and ticks < most:
        observed = kernel.client.clock.step(min(most - ticks, _STEP_TICKS), until=[motion_ends(motion)])
        ticks, is_ended = ticks + observed.ticks, bool(observed.events)
    if not is_ended:
        motion.cancel("the study gives it up")
        return _failed(RUNNING, f"it is not done after {most_seconds:g} s")
    try:
        motion.state.raise_early_end()
    except VirtualRobotError as error:
        return _failed(RUNNING, str(error))
    return {"ticks": ticks, "duration": ticks * kernel.tick, "stage": DONE, "reason": None}


def _failed(stage: str, reason: str) -> dict[str, float | str | None]:
    return {"ticks": None, "duration": None, "stage": stage, "reason": reason}
