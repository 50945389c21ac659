"""Layout of a scene: where what forces move is in the arrays of the world, and where in those of an engine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.physics import BodyJoint, MotorMode, Motors, jointed, places, sizes
from virtualrobot_sdk.poses import from_quaternion, inverse, quaternion

from virtualrobot_kernel.physics.bodies import Scene
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world import motors as kinds
from virtualrobot_kernel.world.motored import motor_of
from virtualrobot_kernel.world.state import JointValues, Snapshot, State
from virtualrobot_kernel.world.structure import Joint, LinkData, Node, Structure

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

FOLLOWING_SECONDS = 0.02
"""Time constant (s) with which a motor without a stiffness of its own comes to the position that is commanded."""

_MODES = {
    kinds.MotorMode.FREE: MotorMode.OFF,
    kinds.MotorMode.VELOCITY: MotorMode.VELOCITY,
    kinds.MotorMode.POSITION: MotorMode.POSITION,
    kinds.MotorMode.EFFORT: MotorMode.EFFORT,
}


@dataclass(frozen=True, slots=True, eq=False)
class Bases:
    """The b floating bases of robots: their places, and where their joints are in the world."""

    rows: Integers
    """(b,) rows of their links in the world."""
    q: Integers
    """(b, 7) places in the world's q."""
    v: Integers
    """(b, 6) places in the world's v."""
    engine_q: Integers
    engine_v: Integers
    turns: Floats
    """(b, 3, 3) rotation of their joints' frames in the world."""
    quaternions: Floats
    """(b, 4) the inverse of that, as x, y, z, w."""
    origins: Floats
    """(b, 3) origin of these frames in the world."""


@dataclass(frozen=True, slots=True, eq=False)
class Joints:
    """The m joints of robots that turn or slide: their places, and their motors."""

    q: Integers
    v: Integers
    engine_q: Integers
    engine_v: Integers
    names: tuple[tuple[int, str], ...]
    """Their robots (uids) and names."""
    modes: Integers
    """(m,) values of the engine's MotorMode."""
    follows: NDArray[np.bool_]
    """(m,) motors that the engine has hold a velocity, by which they come to the position that is commanded."""
    stiffness: Floats
    damping: Floats
    max_effort: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """Places of parts, bases and joints; make it by `layout_of`."""

    part_rows: Integers
    """(k,) rows of the free parts in the world."""
    part_uids: NDArray[np.int64]
    part_q: Integers
    """(k, 7) places in the engine's q."""
    part_v: Integers
    parents: Floats
    """(k, 4, 4) parent_t_world of the parents of these parts, which stand."""
    driven_rows: Integers
    robots: tuple[int, ...]
    """Robots (uids) that forces move."""
    bases: Bases
    joints: Joints
    q: Integers
    """(n,) all places in the world's q of what forces move of robots, rising."""
    v: Integers
    counts: tuple[int, int]
    """Numbers of the engine's coordinates and velocities."""

    def engine_state(self, now: Snapshot, twists: Floats) -> tuple[Floats, Floats]:
        """Return q and v for the engine, of a world whose free parts have these velocities (k, 6)."""
        q, v = np.zeros(self.counts[0]), np.zeros(self.counts[1])
        q[self.part_q], v[self.part_v] = poses_7(now.world_t_node[self.part_rows]), twists
        bases, joints, state = self.bases, self.joints, now.state
        q[bases.engine_q] = poses_7(now.world_t_node[bases.rows])
        rates = state.v[bases.v]
        rates[:, :3] = np.einsum("bij,bj->bi", bases.turns, rates[:, :3])
        v[bases.engine_v] = rates
        q[joints.engine_q], v[joints.engine_v] = state.q[joints.q], state.v[joints.v]
        return q, v

    def robot_state(self, now: State, q: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Return the coordinates (n,) and velocities of robots, at the places `q` and `v`, of the engine's state."""
        all_q, all_v, bases, joints = now.q.copy(), now.v.copy(), self.bases, self.joints
        if len(bases.rows):
            poses, rates = q[bases.engine_q], v[bases.engine_v]
            turned = _product(bases.quaternions, poses[:, 3:])
            # A quaternion and its negative are one rotation: that is taken which is near the last one.
            before = now.q[bases.q][:, 3:]
            turned *= np.where(np.einsum("bi,bi->b", turned, before) < 0.0, -1.0, 1.0)[:, None]
            all_q[bases.q[:, :3]] = np.einsum("bji,bj->bi", bases.turns, poses[:, :3] - bases.origins)
            all_q[bases.q[:, 3:]] = turned
            all_v[bases.v[:, :3]] = np.einsum("bji,bj->bi", bases.turns, rates[:, :3])
            all_v[bases.v[:, 3:]] = rates[:, 3:]
        all_q[joints.q], all_v[joints.v] = q[joints.engine_q], v[joints.engine_v]
        return all_q[self.q], all_v[self.v]

    def commanded(self, structure: Structure, later: State) -> tuple[Floats, Floats]:
        """Return the positions and velocities (m,) that motions command of joints by the end of a tick.

        Of motors that exert an effort, that is in place of the position.
        """
        if not len(self.robots):
            return _NONE, _NONE
        q, v = later.q.copy(), later.v.copy()
        for uid in self.robots:
            robot = structure.robots[uid]
            # Of one that comes under physics in this tick, motions have moved the joints themselves.
            told = later.motored.get(uid) or JointValues(q[robot.q_slice], v[robot.v_slice])
            q[robot.q_slice], v[robot.v_slice] = told.q, told.v
        place, rate = q[self.joints.q], v[self.joints.v]
        exerts = self.joints.modes == MotorMode.EFFORT
        if later.efforts and exerts.any():
            told = [later.efforts.get(uid, {}).get(name, 0.0) for uid, name in self.joints.names]
            return np.where(exerts, told, place), rate
        return np.where(exerts, 0.0, place), rate

    def motors(self, now: State, place: Floats, rate: Floats, seconds: float) -> Motors:
        """Return the motors of a tick at whose end positions and velocities (m,) are commanded."""
        joints = self.joints
        off = place - rate * seconds - now.q[joints.q]
        target = np.where(joints.modes == MotorMode.VELOCITY, rate, 0.0)
        target = np.where(joints.modes == MotorMode.EFFORT, place, target)
        target = np.where(joints.follows, rate + off / FOLLOWING_SECONDS, target)
        springs = joints.modes == MotorMode.POSITION
        # The engine damps against standstill; a spring that is ahead by as much makes it the difference of velocities.
        ahead = np.divide(joints.damping * rate, joints.stiffness, out=np.zeros(len(rate)), where=springs)
        target = np.where(springs, place + ahead, target)
        damping = np.where(springs, joints.damping, 0.0)
        return Motors(joints.modes, target, joints.stiffness, damping, joints.max_effort)


_NONE = np.zeros(0)


def layout_of(now: Snapshot, scene: Scene) -> Layout:
    """Return where what forces move in a scene is."""
    structure, bodies = now.structure, scene.model.bodies
    starts, rates = places(bodies)
    rows = [scene.rows[uid] for uid in scene.parts]
    nodes = structure.nodes
    parents = [inverse(now.world_t(nodes[uid].parent)) for uid in scene.parts]
    place = _places(structure)
    bases = [uid for uid in scene.links if bodies[scene.rows[uid]].joint is BodyJoint.FREE]
    row_of = {row: uid for uid, row in scene.rows.items()}
    turning = [row_of[row] for row in jointed(bodies)]
    joints = _joints(structure, turning, place, [scene.rows[uid] for uid in turning], starts, rates)
    found = _bases(now, bases, place, [scene.rows[uid] for uid in bases], starts, rates)
    robots = dict.fromkeys(robot.uid for uid in scene.links if (robot := structure.robot_of(uid)))
    return Layout(
        part_rows=_integers([structure.rows[uid] for uid in scene.parts]),
        part_uids=np.array(scene.parts, np.int64),
        part_q=_runs([starts[row] for row in rows], 7),
        part_v=_runs([rates[row] for row in rows], 6),
        parents=np.array(parents).reshape(-1, 4, 4),
        driven_rows=_integers([structure.rows[uid] for uid in scene.driven]),
        robots=tuple(robots),
        bases=found,
        joints=joints,
        q=np.sort(np.concatenate([found.q.ravel(), joints.q])).astype(np.int32),
        v=np.sort(np.concatenate([found.v.ravel(), joints.v])).astype(np.int32),
        counts=sizes(bodies),
    )


def _places(structure: Structure) -> dict[int, tuple[int, int]]:
    """Return where the joint of each moved link (uid) begins in the world's q and v."""
    found: dict[int, tuple[int, int]] = {}
    for robot in structure.robots.values():
        starts = zip(robot.q_start, robot.v_start, strict=True)
        found.update(zip(index.moved_links(structure, robot), starts, strict=True))
    return found


def _joint(node: Node) -> Joint:
    assert isinstance(node.data, LinkData)
    return node.data.joint


def _bases(
    now: Snapshot,
    links: list[int],
    place: dict[int, tuple[int, int]],
    rows: list[int],
    starts: Integers,
    rates: Integers,
) -> Bases:
    structure = now.structure
    frames = np.array(
        [now.world_t(structure.nodes[uid].parent) @ now.state.parent_t_node[structure.rows[uid]] for uid in links]
    ).reshape(-1, 4, 4)
    turns = np.array([quaternion(frame[:3, :3]) for frame in frames]).reshape(-1, 4)
    return Bases(
        rows=_integers([structure.rows[uid] for uid in links]),
        q=_runs([place[uid][0] for uid in links], 7),
        v=_runs([place[uid][1] for uid in links], 6),
        engine_q=_runs([starts[row] for row in rows], 7),
        engine_v=_runs([rates[row] for row in rows], 6),
        turns=frames[:, :3, :3].copy(),
        quaternions=turns * [-1.0, -1.0, -1.0, 1.0],
        origins=frames[:, :3, 3].copy(),
    )


def _joints(
    structure: Structure,
    links: list[int],
    place: dict[int, tuple[int, int]],
    rows: list[int],
    starts: Integers,
    rates: Integers,
) -> Joints:
    motors: list[kinds.JointMotor] = []
    names: list[tuple[int, str]] = []
    for uid in links:
        robot, joint = structure.robot_of(uid), _joint(structure.nodes[uid])
        assert robot is not None
        motors.append(motor_of(robot, joint))
        names.append((robot.uid, joint.name))
    held = np.array([one.mode is kinds.MotorMode.POSITION and not one.stiffness for one in motors], np.bool_)
    modes = _integers([_MODES[one.mode] for one in motors])
    return Joints(
        q=_integers([place[uid][0] for uid in links]),
        v=_integers([place[uid][1] for uid in links]),
        engine_q=_integers([starts[row] for row in rows]),
        engine_v=_integers([rates[row] for row in rows]),
        names=tuple(names),
        modes=np.where(held, np.int32(MotorMode.VELOCITY), modes),
        follows=held,
        stiffness=np.array([one.stiffness for one in motors], float),
        damping=np.array([one.damping for one in motors], float),
        max_effort=np.array([one.max_effort or np.inf for one in motors], float),
    )


def poses_7(poses: Floats) -> Floats:
    """Return poses (k, 4, 4) as x, y, z and quaternions x, y, z, w (k, 7)."""
    return np.array([[*pose[:3, 3], *quaternion(pose[:3, :3])] for pose in poses]).reshape(-1, 7)


def poses_4(poses: Floats) -> Floats:
    """Return poses (k, 7) as x, y, z and quaternions x, y, z, w as matrices (k, 4, 4)."""
    matrices = np.zeros((len(poses), 4, 4))
    matrices[:, :3, :3] = np.moveaxis(from_quaternion(poses[:, 3:].T), -1, 0)
    matrices[:, :3, 3] = poses[:, :3]
    matrices[:, 3, 3] = 1.0
    return matrices


def _product(first: Floats, second: Floats) -> Floats:
    """Return the products of quaternions x, y, z, w, (b, 4) each: the second rotation, then the first."""
    a, b = first.T, second.T
    return np.stack(
        [
            a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
            a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
            a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
            a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
        ],
        axis=1,
    )


def _integers(values: list) -> Integers:
    return np.array(values, np.int32)


def _runs(firsts: list, count: int) -> Integers:
    """Return `count` places from each first one on, (k, count)."""
    return _integers(firsts)[:, None] + np.arange(count, dtype=np.int32)
