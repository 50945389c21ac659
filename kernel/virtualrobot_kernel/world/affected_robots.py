"""Robots that a command moves or changes: what a lease of a robot keeps others from.

A robot is its joints, links, adapters, tools and grippers, its place, its settings and the parts that its tools hold.
What it stands on is not: a rail or a pedestal may be moved with all that it carries. Nor are parts that only lie on it,
such as those on a conveyor. Stopping affects nothing, since anyone may always stop.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from virtualrobot_kernel.world import commands
from virtualrobot_kernel.world.records import EVERYWHERE, Key, Presence
from virtualrobot_kernel.world.state import EndCause, Signal, SignalDirection, Snapshot, State
from virtualrobot_kernel.world.structure import Kind, Structure

SET_BY_OWNER = (SignalDirection.OUTPUT, SignalDirection.INTERNAL)
"""Directions of signals that only their owner sets; inputs are for others to set."""


def affected_robots(snapshot: Snapshot, batch: Sequence[commands.Command]) -> set[int]:
    """Return the uids of the robots that commands would move or change; unknown names affect nothing."""
    found = (uid for command in batch for uid in AFFECTED[type(command)](snapshot, command))
    return set(snapshot.structure.with_holders(found))


def named_nodes(structure: Structure, names: Iterable[str]) -> list[int]:
    """Return the uids of nodes by name; names that nothing has are left out."""
    return [uid for name in names if (uid := structure.uid_by_name.get(name)) is not None]


def _nothing(snapshot: Snapshot, command: Any) -> Iterable[int]:  # noqa: ANN401 any command
    return ()


def _everything(snapshot: Snapshot, command: Any) -> Iterable[int]:  # noqa: ANN401 any command
    return snapshot.structure.robots


def _robot(snapshot: Snapshot, command: Any) -> Iterable[int]:  # noqa: ANN401 any command that names a robot
    return named_nodes(snapshot.structure, [command.robot])


def _speed(snapshot: Snapshot, command: commands.SetSpeedFactor) -> Iterable[int]:
    return _robot(snapshot, command) if command.robot else snapshot.structure.robots


def _created(snapshot: Snapshot, command: commands.CreateNodes) -> Iterable[int]:
    for spec in command.specs:
        for parent in named_nodes(snapshot.structure, [spec.parent]):
            yield from owner_of(snapshot.structure, spec.kind, parent)


def _updated(snapshot: Snapshot, command: commands.UpdateNode) -> Iterable[int]:
    for uid in named_nodes(snapshot.structure, [command.name]):
        yield from owner_of(snapshot.structure, snapshot.structure.nodes[uid].kind, uid)


def _removed(snapshot: Snapshot, command: commands.RemoveNode) -> Iterable[int]:
    for uid in named_nodes(snapshot.structure, [command.name]):
        for node in snapshot.structure.below(uid):
            yield from owner_of(snapshot.structure, node.kind, node.uid)


def _attached(snapshot: Snapshot, command: commands.AttachNode) -> Iterable[int]:
    structure = snapshot.structure
    for uid in named_nodes(structure, [command.name]):
        kind = structure.nodes[uid].kind
        yield from owner_of(structure, kind, uid)
        for parent in named_nodes(structure, [command.parent]):
            yield from owner_of(structure, kind, parent)


def _mounted(snapshot: Snapshot, command: commands.MountTool | commands.UnmountTool) -> Iterable[int]:
    structure = snapshot.structure
    yield from _robot(snapshot, command)
    for uid in named_nodes(structure, [command.node, command.parent]):
        yield from owner_of(structure, structure.nodes[uid].kind, uid)
    for uid in named_nodes(structure, [command.robot]) if isinstance(command, commands.UnmountTool) else ():
        yield from structure.grippers_of(uid)


def _tool(snapshot: Snapshot, command: commands.SetToolState) -> Iterable[int]:
    for uid in named_nodes(snapshot.structure, [command.tool]):
        yield from owner_of(snapshot.structure, Kind.TOOL, uid)


def _placed(snapshot: Snapshot, command: commands.PlacePart) -> Iterable[int]:
    yield from _robot(snapshot, command)
    for parent in named_nodes(snapshot.structure, [command.parent]):
        yield from owner_of(snapshot.structure, Kind.PART, parent)


def _started(snapshot: Snapshot, command: commands.StartMotion) -> Iterable[int]:
    structure = snapshot.structure
    yield from named_nodes(structure, (robot for robot, _ in command.joints))
    for tool in named_nodes(structure, (tool for _, tool, _ in command.tool_states)):
        yield from owner_of(structure, Kind.TOOL, tool)
    stages = command.program.stages
    marks = {name for stage in stages for _, name, _ in stage.marks}
    yield from _signal_owners(snapshot, marks, SET_BY_OWNER)
    for order in (order for stage in stages for order in stage.orders):
        yield from AFFECTED.get(type(order), _nothing)(snapshot, order)


def _appended(snapshot: Snapshot, command: commands.AppendMotion) -> Iterable[int]:
    yield from _motion(snapshot, command)
    yield from _started(snapshot, command.more)


def _pairs(snapshot: Snapshot, command: commands.SetAllowedPairs) -> Iterable[int]:
    names = {name for pair in (*command.allow, *command.built, *command.forbid) for name in pair[:2]}
    for uid in named_nodes(snapshot.structure, names):
        yield from owner_of(snapshot.structure, snapshot.structure.nodes[uid].kind, uid)


def _collision_settings(snapshot: Snapshot, command: commands.SetCollisionSettings) -> Iterable[int]:
    if command.mode is not None:
        yield from snapshot.structure.robots.keys() - snapshot.state.collisions.modes.keys()
    if command.look_ahead_seconds is not None:
        yield from snapshot.structure.robots
    yield from named_nodes(snapshot.structure, (robot for robot, _ in command.modes))
    for uid in named_nodes(snapshot.structure, (node for node, _ in command.paddings)):
        yield from owner_of(snapshot.structure, snapshot.structure.nodes[uid].kind, uid)


def _signal_created(snapshot: Snapshot, command: commands.CreateSignal) -> Iterable[int]:
    for uid in named_nodes(snapshot.structure, [command.owner]):
        yield from owner_of(snapshot.structure, snapshot.structure.nodes[uid].kind, uid)


def _signal_removed(snapshot: Snapshot, command: commands.RemoveSignal) -> Iterable[int]:
    return _signal_owners(snapshot, [command.name], SignalDirection)


def _signal_set(snapshot: Snapshot, command: commands.SetSignal) -> Iterable[int]:
    return _signal_owners(snapshot, [command.name], SET_BY_OWNER)


def _signal_owners(snapshot: Snapshot, names: Iterable[str], directions: Iterable[SignalDirection]) -> Iterable[int]:
    """Yield the robots that own these signals, of those that go in one of the directions."""
    for name in names:
        signal = snapshot.state.signals.get(name)
        if signal and signal.owner and signal.direction in directions:
            yield from owner_of(snapshot.structure, snapshot.structure.nodes[signal.owner].kind, signal.owner)


def _motion(snapshot: Snapshot, command: Any) -> Iterable[int]:  # noqa: ANN401 any command that names a motion
    return next((motion.robots for motion in snapshot.state.motions if motion.id == command.id), ())


def _cancelled(snapshot: Snapshot, command: commands.CancelMotion) -> Iterable[int]:
    # Whoever preempts means to move the robot: a start that is refused in the end must not have stopped its owner.
    return _motion(snapshot, command) if command.cancellation.cause is EndCause.PREEMPTED else ()


def _restored(snapshot: Snapshot, command: commands.RestoreRecords) -> Iterable[int]:
    return robots_of_records(snapshot.structure, snapshot.state, command)


def robots_of_records(structure: Structure, state: State, command: commands.RestoreRecords) -> set[int]:
    """Return the robots (uids) that what a command of undo changes is of, hangs on, or will hang on."""
    found: set[int] = set()
    for table, key, restored in command.restored.items():
        found.update(_of_record(structure, state, table, key, restored))
    return found


def _of_record(structure: Structure, state: State, table: str, key: Key, restored: object) -> Iterable[int]:
    if key == EVERYWHERE:
        yield from structure.robots.keys() - (state.collisions.modes.keys() if table == "modes" else set())
        return
    uids = [uid for uid in (key if isinstance(key, tuple) else [key]) if isinstance(uid, int)]
    if table == "signals":
        uids += [one.owner for one in (state.signals.get(str(key)), restored) if isinstance(one, Signal)]
    for node in (structure.nodes[uid] for uid in uids if uid in structure.nodes):
        yield from owner_of(structure, node.kind, node.uid)
        if table == "parents" and isinstance(restored, int) and restored in structure.nodes:
            yield from owner_of(structure, node.kind, restored)
    if isinstance(restored, Presence) and restored.node.parent in structure.nodes:
        yield from owner_of(structure, restored.node.kind, restored.node.parent)


def owner_of(structure: Structure, kind: Kind, uid: int) -> Iterable[int]:
    """Yield the robot that a node of this kind belongs to when it is, or hangs on, the node `uid`."""
    if kind in (Kind.ANNOTATION, Kind.VIEWPOINT):
        return
    start = uid
    if kind is Kind.PART:
        start = next((node.uid for node in structure.ancestors(uid) if node.kind is Kind.TOOL), 0)
    robot = structure.robot_of(start) if start else None
    if robot is not None:
        yield robot.uid


AFFECTED: dict[type, Callable[[Snapshot, Any], Iterable[int]]] = {
    commands.CreateNodes: _created,
    commands.UpdateNode: _updated,
    commands.RemoveNode: _removed,
    commands.ClearWorld: _everything,
    commands.AttachNode: _attached,
    commands.PickPart: _robot,
    commands.PlacePart: _placed,
    commands.SetJointPositions: _robot,
    commands.SetKinematics: _robot,
    commands.SetCraft: _robot,
    commands.RunSensors: _nothing,
    commands.SetRangeComponents: _nothing,
    commands.SetAllowedPairs: _pairs,
    commands.SetCollisionSettings: _collision_settings,
    commands.SetGroups: _robot,
    commands.SetPostures: _robot,
    commands.SelectTool: _robot,
    commands.MountTool: _mounted,
    commands.UnmountTool: _mounted,
    commands.SetToolState: _tool,
    commands.CreateSignal: _signal_created,
    commands.RemoveSignal: _signal_removed,
    commands.SetSignal: _signal_set,
    commands.SetSpeedFactor: _speed,
    commands.SetTcpSpeedLimit: _robot,
    commands.StartMotion: _started,
    commands.AppendMotion: _appended,
    commands.GoOn: _motion,
    commands.StepMotion: _motion,
    commands.StartSetpointMotion: _robot,
    commands.SetSetpoint: _motion,
    commands.EndSetpoints: _motion,
    commands.SetMeasuredJoints: _nothing,
    commands.SetDynamics: _nothing,
    commands.SetJointEfforts: _robot,
    commands.SetParts: _nothing,
    commands.SetContacts: _nothing,
    commands.SetPhysics: _nothing,
    commands.PauseMotion: _nothing,
    commands.ResumeMotion: _motion,
    commands.CancelMotion: _cancelled,
    commands.StopMotions: _nothing,
    commands.StopRobots: _nothing,
    commands.StopCell: _nothing,
    commands.ReleaseCell: _nothing,
    commands.PlayedTicks: _nothing,
    commands.RestartWorld: _everything,
    commands.RestoreRecords: _restored,
    commands.RestoreWorld: _everything,
}
"""Function by command class that gives the robots (uids) which a command affects; each new command needs an entry."""
