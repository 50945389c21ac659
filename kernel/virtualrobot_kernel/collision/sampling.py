"""Random configurations: nodes of a robot that touch each other in them, and how often."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from virtualrobot_kernel.collision.allowed import Pair, ordered
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Joint, RobotIndex

FARTHEST = np.pi
"""Range in which joints without limits are moved, in radians or meters."""


@dataclass(frozen=True, slots=True, eq=False)
class Touched:
    """Counts of samples in which pairs of a robot's nodes (uids, the smaller first) touch that may not."""

    samples: int
    counts: dict[Pair, int]


def sample_touches(
    scene: CollisionScene,
    snapshot: Snapshot,
    robot: RobotIndex,
    samples: int,
    rng: np.random.Generator,
    go_on: Callable[[int], bool],
) -> Touched:
    """Return how often nodes of a robot and its grippers touch in random configurations within its joints' limits.

    Floating and planar joints stay as they are: they move nothing of a robot against the rest of it.

    Args:
        scene: is used for it.
        snapshot: the world.
        robot: the robot.
        samples: how many configurations.
        rng: what they are drawn from.
        go_on: is told how many are done and returns whether to go on; KernelError (WRONG_STATE) is raised where not.
    """
    single = [(joint, start) for joint, start in zip(robot.joints, robot.q_start, strict=True) if _single(joint)]
    q_index = np.array([start for _, start in single], np.int32)
    lower = np.array([max(joint.limits.lower, -FARTHEST) for joint, _ in single])
    upper = np.array([min(joint.limits.upper, FARTHEST) for joint, _ in single])
    scene.place(snapshot)
    robots = {robot.uid, *snapshot.structure.grippers_of(robot.uid)}
    counts = dict.fromkeys(_pairs(scene, robots), 0)
    for done in range(samples):
        scene.place(standing_at(snapshot, q_index, rng.uniform(lower, np.maximum(lower, upper))))
        for pair in scene.self_collisions(robots):
            counts[pair] += 1
        if not go_on(done + 1):
            raise KernelError("nobody waits for these pairs any more", reason=Reason.WRONG_STATE)
    return Touched(samples, counts)


def _single(joint: Joint) -> bool:
    return joint.type.coordinate_count == 1


def _pairs(scene: CollisionScene, robots: Collection[int]) -> list[Pair]:
    """Return the pairs of the robots' nodes that may not touch."""
    bodies = scene.bodies
    own = [uid for uid in bodies.elements if bodies.allowed.groups[uid] in robots]
    pairs = (ordered(one, other) for place, one in enumerate(own) for other in own[place + 1 :])
    return [pair for pair in pairs if bodies.allowed.why(*pair) is None]
