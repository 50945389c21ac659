"""Which nodes may touch by rule: what hangs together rigidly, joints, mounts, held parts, files."""

from __future__ import annotations

from virtualrobot_kernel.collision.allowed import AllowedPairs, Cause, allowed_pairs
from virtualrobot_kernel.world.commands import CreateNodes, UpdateNode
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, LinkData, LinkPair, NodeSpec, RobotData

from tests.unit.collision.worlds import after, world
from tests.unit.world.builders import LIMITS, Z, part, shifted

CUBE = (Figure(Box((0.1, 0.1, 0.1))),)


def chain(*figured: bool, fixed: tuple[int, ...] = ()) -> Snapshot:
    """Return a robot of links one after the other, some with figures; joints are revolute but for the fixed ones."""
    specs = [NodeSpec("robot", Kind.ROBOT, data=RobotData())]
    for place, has in enumerate(figured):
        kind = JointType.FIXED if place in fixed else JointType.REVOLUTE
        data = LinkData(Joint(f"j{place}", kind, Z, LIMITS))
        specs.append(
            NodeSpec(f"robot.l{place}", Kind.LINK, specs[-1].name, shifted(), False, CUBE if has else (), data)
        )
    return world(CreateNodes(tuple(specs)))


def found(snapshot: Snapshot) -> AllowedPairs:
    return allowed_pairs(snapshot.structure, snapshot.state.allowed_pairs)


def why(snapshot: Snapshot, one: str, other: str) -> Cause | None:
    """Return the cause of a pair by names, the same in both orders."""
    allowed, uids = found(snapshot), snapshot.structure.uid_by_name
    answers = {allowed.why(uids[one], uids[other]), allowed.why(uids[other], uids[one])}
    (answer,) = answers
    return answer[0] if answer else None


def test_links_on_both_sides_of_a_joint_are_adjacent() -> None:
    snapshot = chain(True, True, True)
    assert why(snapshot, "robot.l0", "robot.l1") is Cause.ADJACENT
    assert why(snapshot, "robot.l1", "robot.l2") is Cause.ADJACENT
    assert why(snapshot, "robot.l0", "robot.l2") is None
    assert why(snapshot, "robot.l1", "robot.l1") is Cause.RIGID


def test_a_fixed_joint_makes_one_body_and_links_without_figures_do_not_count() -> None:
    rigid = chain(True, True, True, fixed=(2,))
    assert why(rigid, "robot.l1", "robot.l2") is Cause.RIGID
    assert why(rigid, "robot.l0", "robot.l2") is None  # the link between them has figures
    over = chain(True, False, True, fixed=(2,))
    assert why(over, "robot.l0", "robot.l2") is Cause.ADJACENT
    above = chain(True, False, True, fixed=(1,))
    assert why(above, "robot.l0", "robot.l2") is Cause.ADJACENT
    twice = chain(True, False, True)
    assert why(twice, "robot.l0", "robot.l2") is None


def test_a_robot_may_touch_what_it_stands_on_and_nothing_else_of_the_world() -> None:
    table = NodeSpec("table", Kind.OBJECT, figures=CUBE)
    wall = NodeSpec("wall", Kind.OBJECT, figures=CUBE)
    snapshot = after(chain(True, True, fixed=(0,)), CreateNodes((table, wall)))
    assert why(snapshot, "robot.l0", "table") is None
    from virtualrobot_kernel.world.commands import AttachNode

    standing = after(snapshot, AttachNode("robot", "table"))
    assert why(standing, "robot.l0", "table") is Cause.MOUNTED
    assert why(standing, "robot", "table") is Cause.MOUNTED
    assert why(standing, "robot.l1", "table") is None
    assert why(standing, "robot.l0", "wall") is None


def test_a_robot_on_a_robot_may_touch_the_link_that_carries_it() -> None:
    base = LinkData(Joint("base"))
    upper = (
        NodeSpec("upper", Kind.ROBOT, "robot.l1", data=RobotData()),
        NodeSpec("upper.foot", Kind.LINK, "upper", shifted(), False, CUBE, base),
    )
    snapshot = after(chain(True, True), CreateNodes(upper))
    assert why(snapshot, "upper.foot", "robot.l1") is Cause.MOUNTED
    assert why(snapshot, "upper.foot", "robot.l0") is None
    assert (
        found(snapshot).groups[snapshot.structure.uid_by_name["upper.foot"]]
        != found(snapshot).groups[snapshot.structure.uid_by_name["robot.l1"]]
    )


def test_parts_that_lie_on_a_link_lie_on_it_rigidly() -> None:
    snapshot = after(
        chain(True, True), CreateNodes((part("a", shifted(), "robot.l1"), part("b", shifted(), "robot.l1")))
    )
    assert why(snapshot, "a", "robot.l1") is Cause.RIGID
    assert why(snapshot, "a", "b") is Cause.RIGID
    assert why(snapshot, "a", "robot.l0") is None


def test_files_name_pairs() -> None:
    snapshot = chain(True, True, True)
    data = RobotData(allowed_collisions=(LinkPair("l2", "l0", "Never"),))
    snapshot = after(snapshot, UpdateNode("robot", data=data))
    uids = snapshot.structure.uid_by_name
    assert found(snapshot).why(uids["robot.l0"], uids["robot.l2"]) == (Cause.FILE, "Never")
