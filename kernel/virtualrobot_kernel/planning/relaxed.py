"""World without the limits that a motion violates: so that it can be planned, and its violation be looked at."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from virtualrobot_kernel.planning.robots import Arm, SolverOf, arm_of, locked_arm
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import LinkData, Node

BEYOND = 1e9
"""Limit that no motion meets; finite, since joints without limits are led to their goals the shorter way round."""


def relaxed(snapshot: Snapshot, robots: Collection[int], timed: Collection[tuple[int, str]]) -> Snapshot:
    """Return the world whose robots (uids) have joints without ends; those that are `timed` as fast as one likes.

    timed: (robot uid, joint) that move by given times alone, so that no planner asks how fast they may be.
    """
    structure = snapshot.structure
    nodes: dict[int, Node] = dict(structure.nodes)
    for robot in robots:
        index_of = structure.robots[robot]
        fast = {index_of.joint_of(name) for uid, name in timed if uid == robot}
        for uid in index_of.links:
            node = nodes[uid]
            assert isinstance(node.data, LinkData)
            joint = node.data.joint
            limits = replace(joint.limits, lower=-BEYOND, upper=BEYOND)
            if joint.name in fast:
                limits = replace(limits, velocity=BEYOND)
            nodes[uid] = replace(node, data=replace(node.data, joint=replace(joint, limits=limits)))
    return replace(snapshot, structure=index.build(nodes, structure.next_uid, structure.revision))


def solver_in(snapshot: Snapshot, solver_of: SolverOf) -> SolverOf:
    """Return the lookup that gives the arms of a relaxed world the components that they have in `snapshot`."""

    def solver(_: Snapshot, arm: Arm):  # noqa: ANN202 as `solver_of`
        whole = arm_of(snapshot, snapshot.structure.nodes[arm.robot.uid], arm.group)
        names = zip(whole.q_index.tolist(), whole.joint_names, strict=True)
        locked = {name: arm.locked[place] for place, name in names if place in arm.locked}
        return solver_of(snapshot, locked_arm(whole, locked))

    return solver
