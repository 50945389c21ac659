"""Arms that go along tool paths of their own by one law: what leads each, and which places of external axes will do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.free_path import FramePath, frame_path, frame_t_tools
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.spline import spline
from virtualrobot_kernel.paths.carriers import carriers_of, limits_with
from virtualrobot_kernel.paths.closed_forms import LedArm, led_arm
from virtualrobot_kernel.paths.find import Site
from virtualrobot_kernel.paths.space import PathSpace
from virtualrobot_kernel.paths.tool_grid import Ladder, beyond_limits, freedom_of, grid_of
from virtualrobot_kernel.paths.tool_query import ToolPathQuery
from virtualrobot_kernel.paths.tool_reasons import Places
from virtualrobot_kernel.planning.planned_move import joint_limits
from virtualrobot_kernel.planning.robots import arm_of, standing_at, with_state
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

Floats = NDArray[np.float64]

AWAY = 1e3
"""Distance (m) at which an arm is out of the way of those that are looked at without it."""


@dataclass(frozen=True, slots=True, eq=False)
class _Columns:
    """Joints of some arms and of what carries them, as `PathSpace` asks for them."""

    q_index: NDArray[np.int32]
    lower: Floats
    upper: Floats
    ratios: Floats
    least: Floats
    most: Floats

    def with_partner(self, query: ToolPathQuery, own: int) -> _Columns:
        """Return these, and the joints of a partner, of which `own` are its own: others are those of the leader's."""
        count = len(self.q_index)
        places = [
            *range(count, count + own),
            *(self.q_index.tolist().index(one) for one in query.q_index[own:].tolist()),
        ]
        ratios = np.zeros((len(self.ratios) + len(query.ratios), count + own))
        ratios[: len(self.ratios), :count] = self.ratios
        ratios[len(self.ratios) :, places] = query.ratios
        return _Columns(
            np.concatenate([self.q_index, query.q_index[:own]]),
            np.concatenate([self.lower, query.lower[:own]]),
            np.concatenate([self.upper, query.upper[:own]]),
            ratios,
            np.concatenate([self.least, query.least]),
            np.concatenate([self.most, query.most]),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """Arm that is led along a path, alone or with others.

    Attributes:
        query: its path.
        arm: its closed form, with external axes.
        frames: the path of its frames.
        limits: of its own joints (`own` of them), and of external axes.
        all_limits: of the leader's joints, external axes, and the partners' up to this one, as `space` has them.
        space: what touches when all of these are somewhere; partners that come later are out of the way.
    """

    query: ToolPathQuery
    arm: LedArm
    frames: FramePath
    limits: JointLimits
    own: int
    all_limits: JointLimits
    space: PathSpace


def members_of(site: Site, query: ToolPathQuery) -> list[Member]:
    """Return the arm that leads, and its partners."""
    snapshot, found = site.snapshot, list[Member]()
    columns = _Columns(query.q_index, query.lower, query.upper, query.ratios, query.least, query.most)
    for place, one in enumerate((query, *query.partners)):
        node = snapshot.structure.node(one.robot, Kind.ROBOT)
        chain = arm_of(snapshot, node, one.group).serial()
        own, limits = len(one.joint_names), joint_limits(snapshot, node, one.joint_names)[0]
        if query.partners:
            limits = _told(limits, one.robot)
        if place:
            columns = columns.with_partner(one, own)
            every = _after(found[-1].all_limits, limits)
        else:
            every = limits_with(limits, one.externals)
        there = _without(snapshot, [later.robot for later in query.partners[place:]])
        found.append(
            Member(
                one,
                led_arm(chain, carriers_of(snapshot, one.base, one.reference, one.externals)),
                frame_path(spline(one.frames[0], list(one.frames[1:]))),
                limits_with(limits, one.externals),
                own,
                every,
                PathSpace(site.scene, there, columns, site.given_up),
            )
        )
    return found


def unreached(partner: Member, ladder: Ladder) -> dict[int, KernelError]:
    """Block the places of external axes from which a partner has no posture, on the rungs of the leader's ladder.

    Return refusals by those rungs on which it has none at all. Places of the partner's tool are looked at about as far
    apart as those of a ladder.
    """
    arm, query, rungs = partner.arm, partner.query, ladder.rungs
    held = int(arm.held is not None)
    freedom, steps = freedom_of(query.tolerances, arm, False)
    places, of = np.unique(ladder.carried, axis=0, return_inverse=True)
    of = of.reshape(-1)
    values = grid_of(freedom, steps, len(rungs) * len(places)).values
    offsets = frame_t_tools(values[:, :6]) @ inverse(query.tip_t_tcp)
    limits, reached = np.stack([query.lower, query.upper]), np.zeros((len(rungs), len(places)), np.bool_)
    for number, frame in enumerate(partner.frames.poses(rungs)):
        free = np.concatenate(
            [np.tile(values[:, 6 : 6 + held], (len(places), 1)), np.repeat(places, len(values), axis=0)], axis=1
        )
        q = arm.postures(np.tile(frame @ offsets, (len(places), 1, 1)), free)[0]
        inside = (beyond_limits(q, limits, arm.turns).max(axis=2) <= 0.0).any(axis=1)
        reached[number] = inside.reshape(len(places), -1).any(axis=1)
    ladder.blocked[~reached[:, of]] = 1
    told = Places(query.robot, partner.frames, rungs)
    why = "no posture reaches there within joint limits and tolerances" + (
        ", wherever the external axes are" if query.externals else ""
    )
    return {
        rung: told.error(float(rungs[rung]), why, Reason.UNREACHABLE)
        for rung in np.flatnonzero(~reached.any(axis=1)).tolist()
    }


def too_steep(snapshot: Snapshot, member: Member, at: Floats, values: Floats) -> Floats:
    """Return by how much (rad) a member's frames slope more than they may: at parameters (n,), for values (..., m).

    The values of external axes are broadcast against the parameters: (n, m), or (1, m) for one and the same place.
    """
    query = member.query
    if query.externals:
        index = np.concatenate([one.q_index for one in query.externals])
        turned = [standing_at(snapshot, index, one).world_t(query.reference)[2, :3] for one in values]
        down = -np.array(turned)
    else:
        down = -snapshot.world_t(query.base)[None, 2, :3]
    z = member.frames.poses(at)[:, :3, 2]
    return np.arccos(np.clip((z * down).sum(axis=1), -1.0, 1.0)) - query.slope


def block_steep(snapshot: Snapshot, members: Sequence[Member], ladder: Ladder) -> dict[int, KernelError]:
    """Block places of external axes at which frames slope too much; return refusals by rungs where all of them do."""
    rungs, refused = ladder.rungs, dict[int, KernelError]()
    places, of = np.unique(ladder.carried, axis=0, return_inverse=True)
    for member in members:
        if not member.query.slope:
            continue
        over = np.stack([too_steep(snapshot, member, rungs, one[None]) for one in places], axis=1)
        ladder.blocked[(over > 0.0)[:, of.reshape(-1)]] = 1
        told = Places(member.query.robot, member.frames, rungs)
        for rung in np.flatnonzero((over > 0.0).all(axis=1)).tolist():
            refused[rung] = steep(told, float(rungs[rung]), float(over[rung].min()), member.query.slope)
    return refused


def steep(places: Places, at: float, over: float, slope: float) -> KernelError:
    """Return the error that a frame slopes too much at a parameter."""
    why = (
        f"its z would be {np.degrees(slope + over):.3g} degrees from straight down, and may be {np.degrees(slope):.3g}"
    )
    return places.error(at, why, Reason.LIMIT_EXCEEDED, value=slope + over, limit=slope)


def _without(snapshot: Snapshot, robots: list[str]) -> Snapshot:
    """Return the world with robots far away."""
    if not robots:
        return snapshot
    poses = snapshot.state.parent_t_node.copy()
    for name in robots:
        poses[snapshot.structure.rows[snapshot.structure.node(name, Kind.ROBOT).uid], 2, 3] += AWAY
    return with_state(snapshot, replace(snapshot.state, parent_t_node=poses))


def _told(limits: JointLimits, robot: str) -> JointLimits:
    """Return limits whose joints are told with the robot's name."""
    sliding = frozenset(f"{robot}.{name}" for name in limits.sliding)
    return replace(limits, names=tuple(f"{robot}.{name}" for name in limits.names), sliding=sliding)


def _after(first: JointLimits, second: JointLimits) -> JointLimits:
    """Return limits of some joints and of others after them."""
    fields = ("lower", "upper", "velocity", "acceleration", "jerk")
    arrays = (np.concatenate([getattr(one, field) for one in (first, second)]) for field in fields)
    return JointLimits((*first.names, *second.names), *arrays, sliding=first.sliding | second.sliding)
