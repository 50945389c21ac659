"""Random batches of edits, as two people give them, for tests of undo."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world import commands
from virtualrobot_kernel.world.about import About
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.figures import Box, Figure, Sphere
from virtualrobot_kernel.world.sensing import RangeSensor
from virtualrobot_kernel.world.state import Signal
from virtualrobot_kernel.world.structure import (
    JointGroup,
    Kind,
    LinkData,
    NodeSpec,
    PartData,
    RobotData,
    TargetData,
    ToolData,
    ViewpointData,
)

from tests.unit.world.builders import after, arm, empty, part, random_pose, shifted

Rng = np.random.Generator


def cell() -> Change:
    """Return a cell with two arms, their grippers, parts on a table, a sensor, a target and a signal."""
    things = (
        NodeSpec("table", Kind.OBJECT, figures=(Figure(Box((1.0, 1.0, 0.1))),), about=About("of oak", ("wood",))),
        *(part(f"part_{k}", shifted(x=0.1 * k), "table") for k in range(4)),
        NodeSpec("lidar", Kind.RANGE_SENSOR, data=RangeSensor(), running=True),
        NodeSpec("front", Kind.VIEWPOINT, "table", data=ViewpointData(2.0, 0.5)),
        NodeSpec("place", Kind.TARGET, "table", data=TargetData("left", "left_gripper", "tip", {"a": 0.1, "b": 0.2})),
    )
    return after(
        empty(),
        arm("left"),
        arm("right"),
        commands.CreateNodes(things),
        commands.CreateSignal(Signal("ready", False), "left"),
        commands.SetAllowedPairs(allow=(("part_1", "table", "stands there"),)),
        commands.SetJointPositions("left", {"a": 0.3, "b": -0.4, "f": 0.02}),
    )


def random_batch(rng: Rng, change: Change) -> tuple[Command, ...]:
    """Return one to three edits of a world that it takes all together."""
    while True:
        made, at = [], change
        for _ in range(rng.integers(1, 4)):
            edit = EDITS[rng.integers(len(EDITS))]
            try:
                command = edit(rng, at)
                at = after(at, command)
            except (KernelError, _Nothing):
                continue
            made.append(command)
        if made:
            return tuple(made)


class _Nothing(Exception):
    """There is nothing in the world that could be edited so."""


def _one(rng: Rng, names: Sequence[str]) -> str:
    if not names:
        raise _Nothing
    return names[int(rng.integers(len(names)))]


def _names(change: Change, *kinds: Kind) -> list[str]:
    return [node.name for node in change.structure.nodes.values() if not kinds or node.kind in kinds]


def _word(rng: Rng) -> str:
    return f"n{rng.integers(40)}"


def _create(rng: Rng, change: Change) -> Command:
    parent = _one(rng, _names(change))
    kind = (Kind.OBJECT, Kind.PART, Kind.ANNOTATION, Kind.TOOL, Kind.RANGE_SENSOR)[rng.integers(5)]
    data = {Kind.PART: PartData(rng.uniform()), Kind.TOOL: ToolData(), Kind.RANGE_SENSOR: RangeSensor()}.get(kind)
    return commands.CreateNodes((NodeSpec(_word(rng), kind, parent, random_pose(rng), data=data),))


def _create_arm(rng: Rng, change: Change) -> Command:
    if len(change.structure.robots) > 4:
        raise _Nothing
    return arm(f"arm{rng.integers(5)}")


def _rename(rng: Rng, change: Change) -> Command:
    return commands.UpdateNode(_one(rng, _names(change)), new_name=_word(rng))


def _move(rng: Rng, change: Change) -> Command:
    return commands.UpdateNode(_one(rng, _names(change)), parent_t_node=random_pose(rng))


def _hide(rng: Rng, change: Change) -> Command:
    return commands.UpdateNode(_one(rng, _names(change)), hidden=bool(rng.integers(2)))


def _figure(rng: Rng, change: Change) -> Command:
    return commands.UpdateNode(_one(rng, _names(change)), figures=(Figure(Sphere(rng.uniform(0.01, 0.1))),))


def _weigh(rng: Rng, change: Change) -> Command:
    return commands.UpdateNode(_one(rng, _names(change, Kind.PART)), data=PartData(rng.uniform()))


def _rejoint(rng: Rng, change: Change) -> Command:
    node = change.structure.node(_one(rng, _names(change, Kind.LINK)))
    assert isinstance(node.data, LinkData)
    joint = node.data.joint
    joint = replace(joint, name=_word(rng), limits=replace(joint.limits, velocity=rng.uniform(1, 2)))
    return commands.UpdateNode(node.name, data=replace(node.data, joint=joint))


def _remove(rng: Rng, change: Change) -> Command:
    return commands.RemoveNode(_one(rng, _names(change)))


def _attach(rng: Rng, change: Change) -> Command:
    pose = random_pose(rng) if rng.integers(2) else None
    return commands.AttachNode(_one(rng, _names(change)), _one(rng, _names(change)), pose)


def _pick(rng: Rng, change: Change) -> Command:
    return commands.PickPart(_one(rng, _names(change, Kind.ROBOT)), _one(rng, _names(change, Kind.PART)), 9.0)


def _place(rng: Rng, change: Change) -> Command:
    return commands.PlacePart(_one(rng, _names(change, Kind.ROBOT)))


def _select(rng: Rng, change: Change) -> Command:
    return commands.SelectTool(_one(rng, _names(change, Kind.ROBOT)), _one(rng, [*_names(change, Kind.TOOL), ""]))


def _mount(rng: Rng, change: Change) -> Command:
    return commands.MountTool(_one(rng, _names(change, Kind.ROBOT)), _one(rng, _names(change, Kind.TOOL)))


def _unmount(rng: Rng, change: Change) -> Command:
    return commands.UnmountTool(_one(rng, _names(change, Kind.ROBOT)))


def _postures(rng: Rng, change: Change) -> Command:
    name = _one(rng, _names(change, Kind.ROBOT))
    joints = change.structure.robot(name)[1].joint_names
    return commands.SetPostures(name, {_word(rng): dict.fromkeys(joints, 0.01)})


def _groups(rng: Rng, change: Change) -> Command:
    name = _one(rng, _names(change, Kind.ROBOT))
    return commands.SetGroups(name, (JointGroup(_word(rng), change.structure.robot(name)[1].joint_names[:1]),))


def _kinematics(rng: Rng, change: Change) -> Command:
    return commands.SetKinematics(_one(rng, _names(change, Kind.ROBOT)), _word(rng), {"tries": int(rng.integers(9))})


def _robot(rng: Rng, change: Change) -> Command:
    node = change.structure.node(_one(rng, _names(change, Kind.ROBOT)))
    assert isinstance(node.data, RobotData)
    return commands.UpdateNode(node.name, data=replace(node.data, source=_word(rng)))


def _components(rng: Rng, change: Change) -> Command:
    return commands.SetRangeComponents(_one(rng, _names(change, Kind.RANGE_SENSOR)), (_word(rng), {}))


def _create_signal(rng: Rng, change: Change) -> Command:
    value = (False, 3, -0.0, "word", (True, False))[rng.integers(5)]
    return commands.CreateSignal(Signal(_word(rng), value), _one(rng, _names(change)))


def _remove_signal(rng: Rng, change: Change) -> Command:
    return commands.RemoveSignal(_one(rng, list(change.state.signals)))


def _allow(rng: Rng, change: Change) -> Command:
    pair = _one(rng, _names(change)), _one(rng, _names(change)), _word(rng)
    return commands.SetAllowedPairs(built=(pair,)) if rng.integers(2) else commands.SetAllowedPairs(allow=(pair,))


def _forbid(rng: Rng, change: Change) -> Command:
    if not change.state.allowed_pairs:
        raise _Nothing
    first, second = list(change.state.allowed_pairs)[rng.integers(len(change.state.allowed_pairs))]
    nodes = change.structure.nodes
    return commands.SetAllowedPairs(forbid=((nodes[first].name, nodes[second].name),))


def _collisions(rng: Rng, change: Change) -> Command:
    modes = list(CollisionMode)
    mode = modes[rng.integers(4)] if rng.integers(2) else None
    own = (_one(rng, _names(change, Kind.ROBOT)), modes[rng.integers(4)] if rng.integers(2) else None)
    padding = _one(rng, _names(change)), float(rng.integers(3)) / 100
    return commands.SetCollisionSettings(mode, (own,), None, (padding,))


def _speed(rng: Rng, change: Change) -> Command:
    return commands.SetSpeedFactor(_one(rng, [*_names(change, Kind.ROBOT), ""]), rng.uniform(0.1, 1.0))


def _clear(rng: Rng, change: Change) -> Command:
    if rng.integers(6):
        raise _Nothing
    return commands.ClearWorld()


EDITS: tuple[Callable[[Rng, Change], Command], ...] = (
    *(
        _create,
        _create,
        _create,
        _create_arm,
        _rename,
        _move,
        _hide,
        _figure,
        _weigh,
        _rejoint,
        _remove,
        _attach,
        _pick,
    ),
    *(_place, _select, _mount, _unmount, _postures, _groups, _kinematics, _robot, _components, _create_signal),
    *(_remove_signal, _allow, _forbid, _collisions, _speed, _clear),
)
