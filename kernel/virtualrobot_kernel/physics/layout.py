"""Layout of a scene: where what forces move is in the arrays of the world, and where in those of an engine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.physics import Body, BodyJoint, Coupling, MotorMode, Motors, jointed, motors_off, places, sizes
from virtualrobot_sdk.poses import inverse, quaternion

from virtualrobot_kernel.numeric.forces import FOLLOWS, bring_parts, bring_robots, tell_motors
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
    told_q: Integers
    """(b, 7) places among those of the layout's q."""
    told_v: Integers
    """(b, 6) places among those of the layout's v."""
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
    told_q: Integers
    """(m,) places among those of the layout's q."""
    told_v: Integers
    own_q: Integers
    """(m,) places among the coordinates of the layout's robots, one robot after the other."""
    own_v: Integers
    names: tuple[tuple[int, str], ...]
    """Their robots (uids) and names."""
    exerts: NDArray[np.intp]
    """Those whose motors exert an effort that clients say."""
    slots: NDArray[np.intp]
    """(m,) places among the motors of the engine, which has some for joints that mimic others, too."""
    settings: Motors
    """Settings of the engine's motors besides their targets; those of joints that mimic others are off."""
    kinds: Integers
    """(m,) values of the engine's MotorMode, but FOLLOWS where a velocity is held by which a joint comes to the
    position that is commanded."""
    stiffness: Floats
    damping: Floats
    """(m,) of springs; 0 of others."""


@dataclass(frozen=True, slots=True, eq=False)
class Followers:
    """The f joints of robots that mimic others: arrays (f,) of places in the engine's q and v, and by how much."""

    engine_q: Integers
    engine_v: Integers
    leader_q: Integers
    leader_v: Integers
    ratio: Floats
    offset: Floats


class PartState(NamedTuple):
    """The k free parts as an engine has them.

    parent_t_part (k, 4, 4). twists (k, 6). speeds (k, 2): the lengths of both halves of these. off (k,): by how much
    an entry of their poses in the world has changed at most.
    """

    parent_t_part: Floats
    twists: Floats
    speeds: Floats
    off: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """Places of parts, bases and joints; make it by `layout_of`."""

    part_rows: Integers
    """(k,) rows of the free parts in the world."""
    part_uids: NDArray[np.int64]
    part_q: Integers
    """(k, 7) places in the engine's q."""
    part_v: Integers
    part_order: NDArray[np.intp]
    """(k,) these parts by their uids, rising."""
    parents: Floats
    """(k, 4, 4) parent_t_world of the parents of these parts, which stand."""
    driven_rows: Integers
    robots: tuple[int, ...]
    """Robots (uids) that forces move."""
    bases: Bases
    joints: Joints
    followers: Followers | None
    """None where no joint mimics another one."""
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
        if (mimics := self.followers) is not None:
            q[mimics.engine_q] = mimics.ratio * q[mimics.leader_q] + mimics.offset
            v[mimics.engine_v] = mimics.ratio * v[mimics.leader_v]
        return q, v

    def part_state(self, now: Snapshot, q: Floats, v: Floats) -> PartState:
        """Return where parts are by the engine's state, of a world as it is `now`."""
        count = len(self.part_rows)
        state = PartState(np.empty((count, 4, 4)), np.empty((count, 6)), np.empty((count, 2)), np.empty(count))
        bring_parts(q, v, self.part_q, self.part_v, self.part_rows, self.parents, now.world_t_node, *state)
        return state

    def robot_state(self, now: State, q: Floats, v: Floats) -> tuple[Floats, Floats, float]:
        """Return coordinates (n,) and velocities of robots, at the places `q` and `v`, by the engine's state.

        And the greatest of these velocities, whatever its sign.
        """
        told_q, told_v, bases, joints = np.empty(len(self.q)), np.empty(len(self.v)), self.bases, self.joints
        fastest = bring_robots(
            *(q, v, now.q, bases.q, bases.engine_q, bases.engine_v, bases.told_q, bases.told_v),
            *(bases.turns, bases.quaternions, bases.origins),
            *(joints.engine_q, joints.engine_v, joints.told_q, joints.told_v, told_q, told_v),
        )
        return told_q, told_v, fastest

    def commanded(self, structure: Structure, later: State) -> tuple[Floats, Floats]:
        """Return the positions and velocities (m,) that motions command of joints by the end of a tick."""
        if not self.robots:
            return _NONE, _NONE
        # Of one that comes under physics in this tick, motions have moved the joints themselves.
        told = [later.motored.get(uid) or _own(structure, later, uid) for uid in self.robots]
        q, v = np.concatenate([one.q for one in told]), np.concatenate([one.v for one in told])
        return q[self.joints.own_q], v[self.joints.own_v]

    def efforts(self, told: Mapping[int, Mapping[str, float]]) -> Floats:
        """Return what motors exert that exert an effort, of what is told by robot (uid) and joint; 0 unless said."""
        names = (self.joints.names[at] for at in self.joints.exerts.tolist())
        return np.array([told.get(uid, _NOTHING).get(name, 0.0) for uid, name in names])

    def motors(self, now: State, place: Floats, rate: Floats, seconds: float) -> Motors:
        """Return the motors of a tick at whose end positions and velocities (m,) are commanded.

        Of motors that exert an effort, that is in place of the position.
        """
        joints, target = self.joints, np.empty(len(place))
        tell_motors(
            *(joints.kinds, joints.stiffness, joints.damping, place, rate, now.q, joints.q),
            *(seconds, FOLLOWING_SECONDS, target),
        )
        if self.followers is not None:
            all_targets = np.zeros(len(joints.settings.target))
            all_targets[joints.slots] = target
            target = all_targets
        told = joints.settings
        return Motors(told.mode, target, told.stiffness, told.damping, told.max_effort)


_NOTHING: Mapping[str, float] = {}
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
    turning = [row_of[row] for row in jointed(bodies) if row_of[row] not in scene.followers]
    robots = tuple(dict.fromkeys(robot.uid for uid in scene.links if (robot := structure.robot_of(uid))))
    q = _all_places([(place[uid][0], 7) for uid in bases] + [(place[uid][0], 1) for uid in turning])
    v = _all_places([(place[uid][1], 6) for uid in bases] + [(place[uid][1], 1) for uid in turning])
    return Layout(
        part_rows=_integers([structure.rows[uid] for uid in scene.parts]),
        part_uids=np.array(scene.parts, np.int64),
        part_q=_runs([starts[row] for row in rows], 7),
        part_v=_runs([rates[row] for row in rows], 6),
        part_order=np.argsort(scene.parts),
        parents=np.array(parents).reshape(-1, 4, 4),
        driven_rows=_integers([structure.rows[uid] for uid in scene.driven]),
        robots=robots,
        bases=_bases(now, bases, place, [scene.rows[uid] for uid in bases], starts, rates, q, v),
        joints=_joints(structure, robots, turning, place, [scene.rows[uid] for uid in turning], bodies, q, v),
        followers=_followers(scene.model.couplings, starts, rates),
        q=q,
        v=v,
        counts=sizes(bodies),
    )


def _all_places(runs: Sequence[tuple[int, int]]) -> Integers:
    """Return all places of some runs, each from its first place on, rising; nobody can write to them."""
    found = _integers(sorted(place for first, count in runs for place in range(first, first + count)))
    found.setflags(write=False)
    return found


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
    all_q: Integers,
    all_v: Integers,
) -> Bases:
    structure = now.structure
    frames = np.array(
        [now.world_t(structure.nodes[uid].parent) @ now.state.parent_t_node[structure.rows[uid]] for uid in links]
    ).reshape(-1, 4, 4)
    turns = np.array([quaternion(frame[:3, :3]) for frame in frames]).reshape(-1, 4)
    q, v = _runs([place[uid][0] for uid in links], 7), _runs([place[uid][1] for uid in links], 6)
    return Bases(
        rows=_integers([structure.rows[uid] for uid in links]),
        q=q,
        v=v,
        told_q=_among(all_q, q),
        told_v=_among(all_v, v),
        engine_q=_runs([starts[row] for row in rows], 7),
        engine_v=_runs([rates[row] for row in rows], 6),
        turns=frames[:, :3, :3].copy(),
        quaternions=turns * [-1.0, -1.0, -1.0, 1.0],
        origins=frames[:, :3, 3].copy(),
    )


def _joints(
    structure: Structure,
    robots: Sequence[int],
    links: list[int],
    place: dict[int, tuple[int, int]],
    rows: list[int],
    bodies: Sequence[Body],
    all_q: Integers,
    all_v: Integers,
) -> Joints:
    starts, rates = places(bodies)
    motors: list[kinds.JointMotor] = []
    names: list[tuple[int, str]] = []
    for uid in links:
        robot, joint = structure.robot_of(uid), _joint(structure.nodes[uid])
        assert robot is not None
        motors.append(motor_of(robot, joint))
        names.append((robot.uid, joint.name))
    held = np.array([one.mode is kinds.MotorMode.POSITION and not one.stiffness for one in motors], np.bool_)
    modes = np.where(held, np.int32(MotorMode.VELOCITY), _integers([_MODES[one.mode] for one in motors]))
    springs = modes == MotorMode.POSITION
    all_rows = jointed(bodies)
    slots, settings = np.searchsorted(all_rows, rows), motors_off(len(all_rows))
    settings.mode[slots] = modes
    settings = replace(settings, stiffness=np.zeros(len(all_rows)), damping=np.zeros(len(all_rows)))
    settings.stiffness[slots] = [one.stiffness for one in motors]
    settings.damping[slots] = np.where(springs, [one.damping for one in motors], 0.0)
    settings.max_effort[slots] = [one.max_effort or np.inf for one in motors]
    q, v = _integers([place[uid][0] for uid in links]), _integers([place[uid][1] for uid in links])
    slices = [structure.robots[uid] for uid in robots]
    return Joints(
        q=q,
        v=v,
        engine_q=_integers([starts[row] for row in rows]),
        engine_v=_integers([rates[row] for row in rows]),
        told_q=_among(all_q, q),
        told_v=_among(all_v, v),
        own_q=_in_a_row([one.q_slice for one in slices], q),
        own_v=_in_a_row([one.v_slice for one in slices], v),
        names=tuple(names),
        exerts=np.flatnonzero(modes == MotorMode.EFFORT),
        slots=slots,
        settings=settings,
        kinds=np.where(held, np.int32(FOLLOWS), modes),
        stiffness=settings.stiffness[slots],
        damping=settings.damping[slots],
    )


def _followers(couplings: Sequence[Coupling], starts: Integers, rates: Integers) -> Followers | None:
    if not couplings:
        return None
    rows, leaders = (_integers([getattr(one, name) for one in couplings]) for name in ("follower", "leader"))
    return Followers(
        engine_q=starts[rows],
        engine_v=rates[rows],
        leader_q=starts[leaders],
        leader_v=rates[leaders],
        ratio=np.array([one.ratio for one in couplings]),
        offset=np.array([one.offset for one in couplings]),
    )


def _among(places: Integers, asked: Integers) -> Integers:
    """Return where places that were asked for are among all, which rise."""
    return np.searchsorted(places, asked).astype(np.int32)


def _in_a_row(slices: Sequence[slice], asked: Integers) -> Integers:
    """Return where places are once the values of some slices, one after the other, are an array of their own."""
    places = [place for one in slices for place in range(one.start, one.stop)]
    found = {place: at for at, place in enumerate(places)}
    return _integers([found[place] for place in asked.tolist()])


def poses_7(poses: Floats) -> Floats:
    """Return poses (k, 4, 4) as x, y, z and quaternions x, y, z, w (k, 7)."""
    return np.array([[*pose[:3, 3], *quaternion(pose[:3, :3])] for pose in poses]).reshape(-1, 7)


def _own(structure: Structure, state: State, uid: int) -> JointValues:
    """Return where the joints of a robot are, and how fast."""
    robot = structure.robots[uid]
    return JointValues(state.q[robot.q_slice], state.v[robot.v_slice])


def _integers(values: list) -> Integers:
    return np.array(values, np.int32)


def _runs(firsts: list, count: int) -> Integers:
    """Return `count` places from each first one on, (k, count)."""
    return _integers(firsts)[:, None] + np.arange(count, dtype=np.int32)
