"""Labels: what a batch of commands has done, in words for people."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from virtualrobot_kernel.world import commands
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.records import Difference

LONGEST_LABEL = 200
"""Greatest number of characters of a label."""

MOST_PHRASES = 3
"""Greatest number of different things that a label tells."""


class Phrase(NamedTuple):
    """Phrase of what one command did: `verb`, to whom (empty: to nothing by name), and the rest of the sentence."""

    verb: str
    whom: str = ""
    rest: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Done:
    """Batch that was applied: the worlds before and after it, and their difference."""

    before: Change
    after: Change
    difference: Difference = field(default_factory=Difference)


def label(batch: Sequence[Command], done: Done) -> str:
    """Return what a batch did: "moved 'table' by 0.10 m", "created 'box_3' and 4 others"."""
    phrases = [phrase for command in batch for phrase in LABELS[type(command)](command, done)]
    groups: dict[str, list[Phrase]] = {}
    for phrase in phrases:
        groups.setdefault(phrase.verb, []).append(phrase)
    told = [_sentence(group) for group in groups.values()]
    more = len(told) - MOST_PHRASES
    text = ", ".join(told[:MOST_PHRASES]) + (f" and {more} more" if more > 0 else "")
    return text if len(text) <= LONGEST_LABEL else text[: LONGEST_LABEL - 1] + "…"


def _sentence(group: Sequence[Phrase]) -> str:
    whom = list(dict.fromkeys(phrase.whom for phrase in group))
    if len(whom) == 1:  # the last one says how it is now
        return f"{group[0].verb}{' ' if whom[0] else ''}{whom[0]}{group[-1].rest}"
    others = f"{len(whom) - 1} others" if len(whom) > 2 else whom[1]
    return f"{group[0].verb} {whom[0]} and {others}"


def distance(old: Pose, new: Pose) -> str:
    """Return how far apart two poses are: "by 0.10 m", or "by 12 degrees" where one is only turned."""
    metres = float(np.linalg.norm(new[:3, 3] - old[:3, 3]))
    if metres >= 0.005:
        return f" by {metres:.2f} m" if metres < 100 else f" by {metres:.0f} m"
    cosine = (float(np.trace(old[:3, :3].T @ new[:3, :3])) - 1.0) / 2.0
    degrees = math.degrees(math.acos(min(1.0, max(-1.0, cosine))))
    if degrees >= 0.1:
        return f" by {degrees:.3g} degrees"
    return f" by {metres * 1000.0:.2g} mm" if metres else ""


def _created(command: commands.CreateNodes, done: Done) -> Iterable[Phrase]:
    # What hangs on something new came with it.
    new = {spec.name for spec in command.specs}
    for spec in command.specs:
        if spec.parent not in new:
            yield Phrase("created", repr(spec.name))


def _updated(command: commands.UpdateNode, done: Done) -> Iterable[Phrase]:
    name = repr(command.name)
    if command.new_name is not None:
        yield Phrase("renamed", name, f" to {command.new_name!r}")
        name = repr(command.new_name)
    if command.parent_t_node is not None:
        uid = done.after.structure.uid_by_name.get(command.new_name or command.name)
        poses = (values.poses.get(uid) if uid else None for values in (done.difference.old, done.difference.new))
        old, new = poses
        yield Phrase("moved", name, "" if old is None or new is None else distance(old, new))
    if command.hidden is not None:
        yield Phrase("hid" if command.hidden else "showed", name)
    if command.figures is not None:
        yield Phrase("changed the figures of", name)
    if command.locked is not None:
        yield Phrase("locked" if command.locked else "unlocked", name)
    for said in ("description", "tags", "icon"):
        if getattr(command, said) is not None:
            yield Phrase(f"changed the {said} of", name)
    if command.data is not None:
        yield Phrase("changed the settings of", name)
    if command.running is not None:
        yield Phrase("started" if command.running else "stopped", name)


def _removed(command: commands.RemoveNode, done: Done) -> Iterable[Phrase]:
    yield Phrase("removed", repr(command.name))


def _cleared(command: commands.ClearWorld, done: Done) -> Iterable[Phrase]:
    yield Phrase("cleared the world")


def _attached(command: commands.AttachNode, done: Done) -> Iterable[Phrase]:
    yield Phrase("attached", repr(command.name), f" to {command.parent or 'world'!r}")


def _picked(command: commands.PickPart, done: Done) -> Iterable[Phrase]:
    nodes = done.after.structure.nodes
    parts = [command.part] if command.part else [nodes[uid].name for uid in done.after.picked if uid in nodes]
    yield Phrase("picked", ", ".join(map(repr, parts)), f" with {command.robot!r}")


def _placed(command: commands.PlacePart, done: Done) -> Iterable[Phrase]:
    where = f" on {command.parent!r}" if command.parent else ""
    yield Phrase("placed", repr(command.part) if command.part else "", f"{where} with {command.robot!r}")


def _put(command: commands.SetJointPositions, done: Done) -> Iterable[Phrase]:
    yield Phrase("put the joints of", repr(command.robot), " elsewhere")


def _solved(command: commands.SetKinematics, done: Done) -> Iterable[Phrase]:
    group = f" of the group {command.group!r}" if command.group else ""
    yield Phrase("set the kinematics of", repr(command.robot), f"{group} to {command.kinematics or 'automatic'!r}")


def _made_craft(command: commands.SetCraft, done: Done) -> Iterable[Phrase]:
    to = f" a craft ({command.craft.kinematics})" if command.craft else " no craft"
    yield Phrase("made", repr(command.robot), to)


def _ran(command: commands.RunSensors, done: Done) -> Iterable[Phrase]:
    verb = "started" if command.running else "stopped"
    yield from (Phrase(verb, repr(name)) for name in command.sensors)
    if not command.sensors:
        yield Phrase(f"{verb} all sensors")


def _cast(command: commands.SetRangeComponents, done: Done) -> Iterable[Phrase]:
    yield Phrase("set the components of", repr(command.sensor))


def _allowed(command: commands.SetAllowedPairs, done: Done) -> Iterable[Phrase]:
    for verb, pairs in (("let touch", (*command.allow, *command.built)), ("forbade to touch", command.forbid)):
        yield from (Phrase(verb, f"{pair[0]!r} with {pair[1]!r}") for pair in pairs)


def _collisions(command: commands.SetCollisionSettings, done: Done) -> Iterable[Phrase]:
    if command.mode is not None:
        yield Phrase("set collision handling", "", f" to {command.mode.value!r}")
    for robot, mode in command.modes:
        yield Phrase("set collision handling of", repr(robot), f" to {mode.value!r}" if mode else " to that of all")
    if command.look_ahead_seconds is not None:
        yield Phrase("set the look-ahead", "", f" to {command.look_ahead_seconds:g} s")
    for node, metres in command.paddings:
        yield Phrase("set the padding of", repr(node), f" to {metres:g} m")


def _grouped(command: commands.SetGroups, done: Done) -> Iterable[Phrase]:
    yield Phrase("changed the groups of", repr(command.robot))


def _postures(command: commands.SetPostures, done: Done) -> Iterable[Phrase]:
    for name in command.removed:
        if name not in command.postures:
            yield Phrase("removed the posture", repr(name), f" of {command.robot!r}")
    yield from (Phrase("set the posture", repr(name), f" of {command.robot!r}") for name in command.postures)


def _selected(command: commands.SelectTool, done: Done) -> Iterable[Phrase]:
    if not command.tool:
        yield Phrase("selected no tool for", repr(command.robot))
        return
    point = f", {command.tool_center_point!r}," if command.tool_center_point else ""
    yield Phrase("selected the tool", repr(command.tool), f"{point} for {command.robot!r}")


def _mounted(command: commands.MountTool, done: Done) -> Iterable[Phrase]:
    yield Phrase("mounted", repr(command.node), f" on {command.robot!r}")


def _unmounted(command: commands.UnmountTool, done: Done) -> Iterable[Phrase]:
    yield Phrase("took", repr(command.node) if command.node else "the tool", f" off {command.robot!r}")


def _tool_set(command: commands.SetToolState, done: Done) -> Iterable[Phrase]:
    yield Phrase("set the tool", repr(command.tool), f" to {command.state!r}")


def _signal_created(command: commands.CreateSignal, done: Done) -> Iterable[Phrase]:
    yield Phrase("created the signal", repr(command.signal.name))


def _signal_removed(command: commands.RemoveSignal, done: Done) -> Iterable[Phrase]:
    yield Phrase("removed the signal", repr(command.name))


def _signal_set(command: commands.SetSignal, done: Done) -> Iterable[Phrase]:
    yield Phrase("set the signal", repr(command.name), f" to {command.value!r:.40}")


def _slowed(command: commands.SetSpeedFactor, done: Done) -> Iterable[Phrase]:
    yield Phrase("set the speed factor of", repr(command.robot) if command.robot else "all", f" to {command.factor:g}")


def _limited(command: commands.SetTcpSpeedLimit, done: Done) -> Iterable[Phrase]:
    if command.limit:
        yield Phrase("limited the speed of", repr(command.robot), f" to {command.limit:g} m/s")
    else:
        yield Phrase("lifted the speed limit of", repr(command.robot))


def _started(command: commands.StartMotion, done: Done) -> Iterable[Phrase]:
    robots = list(dict.fromkeys(robot for robot, _ in command.joints))
    what = "program" if command.program.step_count else "motion"
    yield from (Phrase(f"started a {what} of", repr(robot)) for robot in robots)
    if not robots:
        yield Phrase(f"started a {what}")


def _restored(command: commands.RestoreRecords, done: Done) -> Iterable[Phrase]:
    yield Phrase("took back", "", f" step {command.undoes}")


def _went_back(command: commands.RestoreWorld, done: Done) -> Iterable[Phrase]:
    yield Phrase("went back to the checkpoint", repr(command.checkpoint))


def _measured(command: commands.SetMeasuredJoints, done: Done) -> Iterable[Phrase]:
    node = done.after.structure.nodes.get(command.robot)
    yield Phrase("measured the joints of", repr(node.name) if node else "a robot that is gone")


def _computed(command: commands.SetDynamics, done: Done) -> Iterable[Phrase]:
    yield Phrase("computed", "", f" {len(command.q_index)} coordinates")


def _exerts(command: commands.SetJointEfforts, done: Done) -> Iterable[Phrase]:
    yield Phrase("set the efforts of", repr(command.robot))


def _moved(command: commands.SetParts, done: Done) -> Iterable[Phrase]:
    yield Phrase("moved", "", f" {len(command.parts)} parts by forces")


def _touched(command: commands.SetContacts, done: Done) -> Iterable[Phrase]:
    yield Phrase("felt", "", f" {len(command.contacts.nodes)} contacts")


def _physics(command: commands.SetPhysics, done: Done) -> Iterable[Phrase]:
    if command.engine is not None:
        engine = command.engine
        yield Phrase("let", repr(engine), " move dynamic parts") if engine else Phrase("let forces move nothing")
    if command.gravity is not None:
        yield Phrase("set gravity to", f"{command.gravity} m/s^2")
    if command.substeps is not None:
        yield Phrase("set substeps to", str(command.substeps))
    if command.engine_settings is not None:
        yield Phrase("set the physics engine's settings")


def _stopped(command: commands.StopMotions, done: Done) -> Iterable[Phrase]:
    yield from (Phrase("stopped", repr(robot)) for robot in command.robots)
    if not command.robots:
        yield Phrase("stopped all robots")


def _halted(command: commands.StopRobots, done: Done) -> Iterable[Phrase]:
    nodes = done.after.structure.nodes
    names = [nodes[uid].name for uid in command.robots if uid in nodes]
    yield from (Phrase("stopped", repr(name), f": {command.cancellation.reason}") for name in names)
    if not names:
        yield Phrase("stopped no robot")


def _cell_stopped(command: commands.StopCell, done: Done) -> Iterable[Phrase]:
    yield Phrase("stopped the cell", "", f": {command.stop.reason}")


def _cell_released(command: commands.ReleaseCell, done: Done) -> Iterable[Phrase]:
    yield Phrase("released the cell")


def _played(command: commands.PlayedTicks, done: Done) -> Iterable[Phrase]:
    node = done.after.structure.nodes.get(command.robot)
    yield Phrase("played ticks of", repr(node.name) if node else "a robot that is gone")


def _follows(command: commands.StartSetpointMotion, done: Done) -> Iterable[Phrase]:
    yield Phrase("started setpoints of", repr(command.robot))


def _began_again(command: commands.RestartWorld, done: Done) -> Iterable[Phrase]:
    yield Phrase("started the kernel again")


def _of_motion(verb: str) -> Callable[[Any, Done], Iterable[Phrase]]:
    """Return the label of a command that names a motion."""
    return lambda command, done: (Phrase(verb, repr(command.id)),)


LABELS: dict[type, Callable[[Any, Done], Iterable[Phrase]]] = {
    commands.CreateNodes: _created,
    commands.UpdateNode: _updated,
    commands.RemoveNode: _removed,
    commands.ClearWorld: _cleared,
    commands.AttachNode: _attached,
    commands.PickPart: _picked,
    commands.PlacePart: _placed,
    commands.SetJointPositions: _put,
    commands.SetKinematics: _solved,
    commands.SetCraft: _made_craft,
    commands.RunSensors: _ran,
    commands.SetRangeComponents: _cast,
    commands.SetAllowedPairs: _allowed,
    commands.SetCollisionSettings: _collisions,
    commands.SetGroups: _grouped,
    commands.SetPostures: _postures,
    commands.SelectTool: _selected,
    commands.MountTool: _mounted,
    commands.UnmountTool: _unmounted,
    commands.SetToolState: _tool_set,
    commands.CreateSignal: _signal_created,
    commands.RemoveSignal: _signal_removed,
    commands.SetSignal: _signal_set,
    commands.SetSpeedFactor: _slowed,
    commands.SetTcpSpeedLimit: _limited,
    commands.StartMotion: _started,
    commands.AppendMotion: _of_motion("appended steps to"),
    commands.GoOn: _of_motion("went on with"),
    commands.StepMotion: _of_motion("stepped"),
    commands.StartSetpointMotion: _follows,
    commands.SetSetpoint: _of_motion("gave a setpoint to"),
    commands.EndSetpoints: _of_motion("ended the setpoints of"),
    commands.SetMeasuredJoints: _measured,
    commands.SetDynamics: _computed,
    commands.SetJointEfforts: _exerts,
    commands.SetParts: _moved,
    commands.SetContacts: _touched,
    commands.SetPhysics: _physics,
    commands.PauseMotion: _of_motion("paused"),
    commands.ResumeMotion: _of_motion("resumed"),
    commands.CancelMotion: _of_motion("cancelled"),
    commands.StopMotions: _stopped,
    commands.StopRobots: _halted,
    commands.StopCell: _cell_stopped,
    commands.ReleaseCell: _cell_released,
    commands.PlayedTicks: _played,
    commands.RestartWorld: _began_again,
    commands.RestoreRecords: _restored,
    commands.RestoreWorld: _went_back,
}
"""Function by command class that says what a command did; each new command needs an entry."""
