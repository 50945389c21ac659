"""Steps of a program that runs, in words, around the one that it is at. Pure."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot_kernel.motion.program import Stage
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.tracking_motion import TrackingMotion
from virtualrobot_kernel.world.awaited_part import AwaitedPart
from virtualrobot_kernel.world.commands import AttachNode, PickPart, PlacePart, SelectTool, SetAllowedPairs
from virtualrobot_kernel.world.state import Motion
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_kernel.world.tolerances import AwaitedJoints

DOES: dict[type, str] = {
    PickPart: "pick",
    PlacePart: "place",
    AttachNode: "attach",
    SelectTool: "select tool",
    SetAllowedPairs: "let touch",
    AwaitedPart: "wait for a part",
    AwaitedJoints: "wait at the goal",
}
"""Word for what an order does."""


@dataclass(frozen=True, slots=True)
class Line:
    """Step of a program: what its text calls it, what it does in words, whether it is at it, or pauses before it."""

    path: str
    words: str
    now: bool
    pauses: bool


def program_lines(structure: Structure, motion: Motion, before: int, after: int) -> list[Line]:
    """Return the step that a motion is at with so many before and after it; none of what is no program."""
    run = motion.running.inner if isinstance(motion.running, TrackingMotion) else motion.running
    if not isinstance(run, ProgramRun) or not motion.step_count:
        return []
    steps = [
        (stage.paths[place] if stage.paths else str(number), stage, place)
        for stage in run.program.stages
        for place, (_, number) in enumerate(stage.steps)
    ]
    now = next((at for at, (path, _, _) in enumerate(steps) if path == motion.step_path), len(steps))
    return [
        Line(path, _words(structure, motion, stage), at == now, stage.pauses and not place)
        for at, (path, stage, place) in enumerate(steps)
        if -before <= at - now <= after
    ]


def _words(structure: Structure, motion: Motion, stage: Stage) -> str:
    """Return what a stage of a motion does, for people."""
    if stage.plan is not None:
        moved = dict.fromkeys(motion.joints[column][0] for column in stage.columns)
        names = ", ".join(structure.nodes[uid].name for uid in moved if uid in structure.nodes)
        return f"move {names}"
    if stage.orders:
        return ", ".join(DOES[type(order)] for order in stage.orders)
    if stage.wait is not None and stage.wait.condition is not None:
        return f"wait until {stage.wait.condition.signal} is {stage.wait.condition}"
    if stage.wait is not None:
        return f"dwell {stage.wait.seconds:g} s"
    return ", ".join(f"set {name} to {value}" for _, name, value in stage.marks) or "go on"
