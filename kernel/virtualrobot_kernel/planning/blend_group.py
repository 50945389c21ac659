"""Blend groups: steps that zones join, with the columns and limits that they share, and path and law of each."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.apart_path import ApartTcp
from virtualrobot_kernel.motion.blend import Rounded
from virtualrobot_kernel.motion.blend_law import law_through
from virtualrobot_kernel.motion.bounds import JointBound, TcpBound, TimeLaw
from virtualrobot_kernel.motion.limits import CartesianLimits, JointLimits
from virtualrobot_kernel.motion.path_law import law_along
from virtualrobot_kernel.motion.planned import Track
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial, stacked
from virtualrobot_kernel.motion.rates import Rate, joint_rates, stretch_needed, tcp_rate
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics
from virtualrobot_kernel.motion.superposed import Led
from virtualrobot_kernel.planning.actuators import first_beyond
from virtualrobot_kernel.planning.planned_move import PlannedMove, joint_limits
from virtualrobot_kernel.planning.robots import Arm, arm_if_chain, tip_t_tcp, tips_of
from virtualrobot_kernel.planning.steps import Column, PlannedStep
from virtualrobot_kernel.planning.zones import Position
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.groups import Group
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]

_LOOKS, _ROUNDING = 33, 1e-6
"""Number of moments at which limits are looked at, and excess over one that is none."""


class BlendGroup:
    """Group of steps that are joined by zones, with their common columns and limits."""

    def __init__(self, steps: Sequence[PlannedStep], columns: Sequence[Column] = ()) -> None:
        """Take steps of which each begins where the one before it ends; `columns` come first, moved or not."""
        self.steps = steps
        self.columns = list(dict.fromkeys([*columns, *(column for step in steps for column in step.columns)]))
        self.places = {column: place for place, column in enumerate(self.columns)}
        structure = steps[0].snapshot.structure
        self.q_index = np.array(
            [single_joint(structure, structure.node(robot), joint)[1] for robot, joint in self.columns]
        )
        self.limits = self._limits()

    def keeps_actuators(self, path: PiecewisePolynomial) -> bool:
        """Return True if a path of all columns keeps the limits of actuators, where those are not the joints'."""
        snapshot = self.steps[0].snapshot
        for name in dict.fromkeys(robot for robot, _ in self.columns):
            own = [place for place, (robot, _) in enumerate(self.columns) if robot == name]
            part = PiecewisePolynomial(path.breaks, path.coefficients[:, :, own])
            node, joints = snapshot.structure.node(name), [self.columns[place][1] for place in own]
            if first_beyond(snapshot, node, joints, part) is not None:
                return False
        return True

    def leds(self, pair: Sequence[PlannedStep]) -> dict[tuple[int, Group], Led]:
        """Return the tool centre points that are led along Cartesian paths in both steps, by robot (uid) and group."""
        sides = [{(one.robot.uid, one.group): one for one in step.moves} for step in pair]
        found = {}
        for arm, one in sides[1].items():
            bound = self._placed(one, (0.0, 0.0))
            if bound and isinstance(bound.tcp, TcpKinematics) and arm in sides[0] and sides[0][arm].tcp:
                found[arm] = Led(bound.tcp, np.asarray(bound.columns))
        return found

    def positions(self, steps: Sequence[PlannedStep], only: Collection[tuple[int, Group]] = ()) -> list[Position]:
        """Return the positions of the steps' tool centre points, as functions of the joints of all columns.

        only: those of which robots (uid) and groups count; empty means all.
        """
        snapshot = steps[0].snapshot
        robots = {(one.robot.uid, one.group): one.robot for step in steps for one in step.moves}
        robots = {arm: robot for arm, robot in robots.items() if not only or arm in only}
        found: list[Position] = []
        for (uid, group), robot in robots.items():
            arm = arm_if_chain(snapshot, robot, group)
            own = [one for step in steps for one in step.moves if (one.robot.uid, one.group) == (uid, group)]
            if apart := next((one for one in own if one.tcp and isinstance(one.tcp.tcp, ApartTcp)), None):
                found.append(self._apart(apart))
            elif arm is not None and arm.chain is not None:
                found.append(_position(snapshot, arm, self.q_index))
        return found

    def _apart(self, one: PlannedMove) -> Position:
        """Return the function of a tool that stands apart, seen from what a move carries, by joints of all columns."""
        tcp, columns = one.tcp and one.tcp.tcp, [self.places[one.robot.name, name] for name in one.joint_names]
        assert isinstance(tcp, ApartTcp)
        return lambda q: np.array([tcp.position(joints[columns]) for joints in q])

    def _limits(self) -> JointLimits:
        snapshot, parts, places, vectors = self.steps[0].snapshot, [], [], []
        for name in dict.fromkeys(robot for robot, _ in self.columns):
            own = [place for place, (robot, _) in enumerate(self.columns) if robot == name]
            joints = [self.columns[place][1] for place in own]
            parts.append(joint_limits(snapshot, snapshot.structure.node(name), joints)[0])
            vectors += [tuple(own[column] for column in vector) for vector in parts[-1].vectors]
            places += own
        fields, order = ("lower", "upper", "velocity", "acceleration", "jerk"), np.argsort(places)
        values = {field: np.concatenate([getattr(part, field) for part in parts])[order] for field in fields}
        names, sliding = tuple(joint for _, joint in self.columns), frozenset().union(*(part.sliding for part in parts))
        return JointLimits(names, **values, vectors=tuple(vectors), quaternions=(), sliding=sliding)

    def track(self, step: PlannedStep) -> Track:
        """Return path and law of a step for all columns; its moves have one law, and so go along in step."""
        moved = [one for one in step.moves if one.joint_names]
        if len(moved) == 1 and not moved[0].relative_tcp:
            track = moved[0].plan.tracks[0]
            return Track(self._among_all(step, moved, track.path.start, track.path.end), track.time_law)
        path = self._among_all(step, moved, 0.0, step.plan.duration)
        return Track(path, law_along(self._rates(path, [step], Rounded(path, ((path.start, path.end),), ())), step.law))

    def track_through(self, steps: Sequence[PlannedStep], whole: Rounded, entry: float = 0.0) -> Track:
        """Return the law along the path of steps whose corners are rounded, which begins with the rate `entry`."""
        rates = self._rates(whole.path, steps, whole)
        if steps[0].law is TimeLaw.TIME_OPTIMAL:
            return Track(whole.path, law_along(rates, TimeLaw.TIME_OPTIMAL))
        return Track(whole.path, law_through(whole, rates, entry))

    def keeps_limits(
        self, step: PlannedStep, path: PiecewisePolynomial, law: PiecewisePolynomial, begin: float
    ) -> bool:
        """Return True if a law along the path of a step keeps its limits from a nominal time (s) to the law's end."""
        whole = Rounded(path, ((path.start, path.end),), ())
        taus = np.linspace(begin, law.end, _LOOKS)
        return bool(stretch_needed(self._rates(path, [step], whole), law, taus).max() <= 1.0 + _ROUNDING)

    def _rates(self, path: PiecewisePolynomial, steps: Sequence[PlannedStep], whole: Rounded) -> list[Rate]:
        """Return the limited rates along the path of steps, with the ranges of their moves and corners."""
        joints = [JointBound(*part, self._shares(step)) for part, step in zip(whole.moves, steps, strict=True)]
        tcps = [self._placed(one, part) for part, step in zip(whole.moves, steps, strict=True) for one in step.moves]
        seen = [
            TcpBound(*part, slice(0, len(self.columns)), one.relative_tcp.by(self.q_index), one.relative_tcp.limits)
            for part, step in zip(whole.moves, steps, strict=True)
            for one in step.moves
            if one.relative_tcp
        ]
        for place, part in enumerate(whole.corners):
            pair = steps[place : place + 2]
            joints.append(JointBound(*part, self._shares(*pair)))
            tcps += [replace(bound, begin=part[0], end=part[1]) for bound in self.cartesian_through(pair)]
        return [
            *joint_rates(path, self.limits, [bound for bound in joints if bound.end > bound.begin]),
            *(tcp_rate(path, bound) for bound in [*tcps, *seen] if bound and bound.end > bound.begin),
        ]

    def _among_all(
        self, step: PlannedStep, moved: Sequence[PlannedMove], begin: float, end: float
    ) -> PiecewisePolynomial:
        """Return the paths of a step's moves, each on the parameters from begin to end, for all columns."""
        parts = [one.plan.tracks[0].path.onto(begin, end) for one in moved]
        still = [column for column in self.columns if column not in step.columns]
        if still:
            there = step.snapshot.state.q[self.q_index[[self.places[column] for column in still]]]
            parts.append(PiecewisePolynomial(np.array([begin, end]), there[None, None, :]))
        path = stacked(parts)
        order = np.argsort([self.places[column] for column in [*step.columns, *still]])
        return PiecewisePolynomial(path.breaks, path.coefficients[:, :, order])

    def _shares(self, *steps: PlannedStep) -> Floats:
        """Return shares (3, n) of velocity, acceleration and jerk for the columns; 1 where no move moves one.

        Of several moves of a column the larger ones count.
        """
        shares = np.zeros((len(steps), 3, len(self.columns)))
        for rows, step in zip(shares, steps, strict=True):
            for one in step.moves:
                own = [self.places[one.robot.name, name] for name in one.joint_names]
                rows[:, own] = np.array([[one.speed_factor], [one.gentle[0]], [one.gentle[1]]])
        shares = shares.max(axis=0)
        return np.where(shares > 0.0, shares, 1.0)

    def _placed(self, one: PlannedMove, part: tuple[float, float]) -> TcpBound | None:
        """Return the bound of an arm's tool centre point, on a part of a path and in its columns."""
        if one.tcp is None:
            return None
        columns = np.array([self.places[one.robot.name, name] for name in one.joint_names])
        return replace(one.tcp, begin=part[0], end=part[1], columns=columns)

    def corner_limits(self, pair: Sequence[PlannedStep]) -> Floats:
        """Return velocity, acceleration and jerk (3, n) that the joints keep in the corner between two steps."""
        limits = self.limits
        jerk = np.full(len(self.columns), np.inf) if pair[0].law is TimeLaw.TIME_OPTIMAL else limits.jerk
        found = np.stack([limits.velocity, limits.acceleration, jerk]) * self._shares(*pair)
        for vector in map(list, limits.vectors):
            found[:, vector] /= np.sqrt(len(vector))  # whatever its direction, it keeps the limit of its length
        return found

    def cartesian_through(self, pair: Sequence[PlannedStep]) -> list[TcpBound]:
        """Return the bounds of tool centre points in the corner between two steps.

        The larger limits of those that are led along a Cartesian path on both sides; one that is led on one side and
        stands still on the other keeps that side's.
        """
        led = [{(one.robot.uid, one.group): one for one in step.moves if one.tcp} for step in pair]
        arms = [{(one.robot.uid, one.group) for one in step.moves} for step in pair]
        result = []
        for arm in led[0] | led[1]:
            ones = [side[arm] for side in led if arm in side]
            if len(ones) == 1 and arm in arms[0] and arm in arms[1]:
                continue
            bounds = [bound for one in ones if (bound := self._placed(one, (0.0, 0.0)))]
            limits = [bound.limits for bound in bounds]
            result.append(replace(bounds[0], limits=_larger(limits[0], limits[-1])))
        return result


def _larger(one: CartesianLimits, other: CartesianLimits) -> CartesianLimits:
    return CartesianLimits(*(max(pair) for pair in zip(vars(one).values(), vars(other).values(), strict=True)))


def _position(snapshot: Snapshot, arm: Arm, q_index: NDArray[np.int32]) -> Position:
    """Return the function of a robot's tool centre point by the joints of the columns `q_index`."""
    tips, point = tips_of(snapshot, arm), tip_t_tcp(snapshot, arm)[:, 3]
    own = np.array([int(np.flatnonzero(arm.q_index == index)[0]) for index in q_index if index in arm.q_index], np.intp)
    columns = np.flatnonzero(np.isin(q_index, arm.q_index))
    base = snapshot.state.q[arm.q_index]

    def position(q: Floats) -> Floats:
        mine = np.tile(base, (len(q), 1))
        mine[:, own] = q[:, columns]
        return (tips(mine) @ point)[:, :3]

    return position
