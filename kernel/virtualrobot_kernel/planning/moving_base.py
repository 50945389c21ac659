"""Moves that other moves of the same step carry: on a moving base, or towards a reference that moves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.cartesian_path import CartesianPath
from virtualrobot_kernel.motion.cartesian_plan import checked_joint_path, checked_start
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.moving_frame_path import MovingFramePath
from virtualrobot_kernel.motion.planned import planned
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.profile import jerk_limited_profile
from virtualrobot_kernel.planning.planned_move import PlannedMove, joint_limits
from virtualrobot_kernel.planning.relative_frame import RelativeTcp, relative_frame, rows_above
from virtualrobot_kernel.planning.robots import Arm, SolverOf, standing_at, tip_t_tcp
from virtualrobot_kernel.world.change import joint_places
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import WORLD_UID, Node

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class MovingBase:
    """Planned moves that carry another one, together k joints, and where these are in all coordinates (k,)."""

    snapshot: Snapshot
    moves: tuple[PlannedMove, ...]
    q_index: NDArray[np.int32]

    def at(self, u: float) -> tuple[Floats, Floats]:
        """Return the joints (k,) at the fraction `u` of their moves, and their derivatives by u.

        Just outside of [0, 1] they go on smoothly, as a path does.
        """
        within = min(max(u, 0.0), 1.0)
        states = []
        for one in self.moves:
            path = one.plan.tracks[0].path
            length = path.end - path.start
            # One that stands still has a path of length zero.
            states.append(path.state(path.start + within * length, 2) * np.array([[1.0], [length], [length**2]]))
        q, rate, curvature = np.concatenate(states, axis=1)
        beyond = u - within
        return q + beyond * (rate + 0.5 * beyond * curvature), rate + beyond * curvature

    @property
    def turns(self) -> tuple[float, ...]:
        """Fractions between 0 and 1 where the third derivative of a path may jump."""
        found: set[float] = set()
        for one in self.moves:
            path = one.plan.tracks[0].path
            found |= {float(u) for u in (path.breaks[1:-1] - path.start) / (path.end - path.start)}
        return tuple(sorted(found))

    def arrived(self) -> Snapshot:
        """Return the world with the joints where their moves end."""
        return standing_at(self.snapshot, self.q_index, self.at(1.0)[0])

    def frame(self, arm: Arm, reference: int, moving: bool) -> Callable[[float], tuple[Array, Array]]:
        """Return the function of base_t_frame (4, 4) and its twist (6,) by u, for the base of an arm.

        The frame is that of the node `reference`, or, when it is not `moving`, where that is at the start.
        """
        node, point = (reference, np.eye(4)) if moving else (WORLD_UID, self.snapshot.world_t(reference))
        relative = relative_frame(self.snapshot, arm.base, node, point, self.q_index)

        def frame(u: float) -> tuple[Array, Array]:
            q, rate = self.at(u)
            return relative.pose(q), relative.jacobian(q) @ rate

        return frame


def moving_base(snapshot: Snapshot, moves: Sequence[PlannedMove]) -> MovingBase:
    """Return planned moves as those that carry others."""
    joints = tuple((one.robot.uid, name) for one in moves for name in one.joint_names)
    return MovingBase(snapshot, tuple(moves), joint_places(snapshot.structure, joints)[0])


def carried_by(
    snapshot: Snapshot, needed: Sequence[set[tuple[int, str]]], frames: Sequence[Sequence[int]]
) -> list[set[int]]:
    """Return for each of m moves which others carry it.

    needed: the joints of each, (robot uid, joint). frames: for each the nodes (uids) whose places count for it while it
    moves; none for a move that is only about its own joints. Raises KernelError when moves carry each other.
    """
    structure = snapshot.structure
    moved = [
        # What is no joint of the robot is refused by whoever plans the move.
        {
            int(place)
            for place in joint_places(
                structure, tuple(one for one in joints if one[1] in structure.robots[one[0]].coordinates)
            )[0]
        }
        for joints in needed
    ]
    result: list[set[int]] = []
    for nodes in frames:
        rows = {row for uid in nodes for row in rows_above(structure, uid)}
        above = {place for row in rows for place in structure.coordinates_at(row)}
        result.append({other for other, places in enumerate(moved) if places & above})
    return result


def in_order(carrying: Sequence[set[int]], names: Sequence[str]) -> list[int]:
    """Return the moves in an order in which each comes after those that carry it; `names` are for the refusal."""
    order: list[int] = []
    left = list(range(len(carrying)))
    while left:
        free = [place for place in left if carrying[place] <= set(order)]
        if not free:
            robots = " and ".join(repr(names[place]) for place in left)
            raise KernelError(
                f"the moves of {robots} go along with each other in a circle; let one of them stand on what does not "
                "move, or give its goal in a frame that does not",
                robot=names[left[0]],
            )
        order += free
        left = [place for place in left if place not in free]
    return order


def check_turns(moves: Iterable[PlannedMove], carried: Node) -> None:
    """Raise KernelError where one of the moves that go together with a carried one turns a floating joint."""
    for one in moves:
        if one.plan.tracks[0].quasi is not None:
            raise no_common_law(f"move of {one.robot.name!r} turns a floating joint", carried)


def no_common_law(what: str, carried: Node) -> KernelError:
    """Return the error that a move can't have one law with that of a carried robot."""
    return KernelError(
        f"the {what}, and moves that go together with a carried one, that of {carried.name!r}, have one law; give "
        "other moves, or a step for each",
        robot=carried.name,
    )


def plan_on_moving_base(
    arm: Arm,
    base: MovingBase,
    tcp_path_from: Callable[[Array], CartesianPath],
    reference: int,
    moving: bool,
    limits: CartesianLimits,
    speed_factor: float,
    solver_of: SolverOf,
    gentle: tuple[float, float] = (1.0, 1.0),
) -> PlannedMove:
    """Return the move of an arm along a Cartesian path in a frame that moves relative to its base.

    tcp_path_from: from reference_t_tcp (4, 4) at the start to the path in that frame. The TCP keeps `limits` in the
    frame that the goal is given in: that of `reference` (a uid) when it is `moving`, else the world's. The plan's own
    law is that of the path's fraction; the step's law, for all its moves, comes from `planning.blending`.
    """
    snapshot, node = base.snapshot, arm.robot
    check_turns(base.moves, node)
    joints, start = joint_limits(snapshot, node, arm.joint_names)
    start, tcp = checked_start("Cartesian", solver_of(snapshot, arm), start, joints, tip_t_tcp(snapshot, arm))
    frame = base.frame(arm, reference, moving)
    base_t_tcp = tcp.pose(start)
    inner = tcp_path_from(inverse(frame(0.0)[0]) @ base_t_tcp)
    tcp_path = MovingFramePath(base_t_tcp, inner, frame, base.turns)
    path = checked_joint_path("Cartesian", tcp, tcp_path, start, joints)
    plan = planned(tcp_path.kind, path, jerk_limited_profile(1.0, 1.0, 1.0, 1.0), joints)
    within = reference if moving else WORLD_UID
    relative = RelativeTcp(snapshot, within, arm.tip, tcp.tip_t_tcp, limits.scaled(speed_factor))
    return PlannedMove(node, arm.joint_names, plan, speed_factor=speed_factor, gentle=gentle, relative_tcp=relative)
