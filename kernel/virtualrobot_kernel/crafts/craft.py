"""A craft at work: its component, and where its base, its drives and its passive wheels are in the world's arrays."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import from_quaternion, inverse

from virtualrobot_kernel.components.running import ComponentHandle
from virtualrobot_kernel.crafts.fitting import (
    Fitted,
    Moved,
    center_of,
    checked,
    checked_step,
    fitted,
    nonsense,
    standing,
)
from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.units import MOST_TWIST
from virtualrobot_kernel.world.craft_data import Craft
from virtualrobot_kernel.world.crafts import base_joint
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import JointType, Node, Structure

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

MOST_STEPS = 24
"""Greatest number of steps in which a brake is followed: arcs between them are as good as exact."""

STEERING_SECONDS = 0.5
"""Time (s) in which a component is asked to steer, to learn how far it has to."""

LONG_SECONDS = 1e3
"""Time (s) in which any steering angle comes to anywhere."""

LEVEL = 1e-6
"""Tolerance of the plane in which a base moves: of its normal, and of a height for each meter."""

APPROACH_SECONDS = 0.1
"""Time constant (s) with which a steering angle comes to its end."""


class _Turning(NamedTuple):
    """Drives or passive wheels: their joints, these joints' places in q and v, and joint = ratio * drive."""

    joints: tuple[str, ...]
    q: Integers
    v: Integers
    ratio: Floats


@dataclass(frozen=True, slots=True, eq=False)
class CraftAtWork:
    """Craft of a structure; make it by `at_work`."""

    node: Node
    craft: Craft
    component: ComponentHandle
    is_planar: bool
    base_q: int
    base_v: int
    base_t_center: Floats
    center_t_base: Floats
    drives: _Turning
    passive: _Turning
    passive_places: tuple[int, ...]
    """Places of the passive wheels that the robot has among all of the component."""
    passive_count: int
    """Number of all passive wheels of the component."""
    accelerations: Floats

    @property
    def base_coordinates(self) -> range:
        """Return the places of its base's coordinates in q."""
        return range(self.base_q, self.base_q + (3 if self.is_planar else 7))

    @property
    def base_rates(self) -> range:
        """Return the places of its base's velocities in v."""
        return range(self.base_v, self.base_v + (3 if self.is_planar else 6))

    def states(self, q: Floats) -> Floats:
        """Return where its drives are (m,), of all coordinates (nq,) or of rows of them (n, nq)."""
        return q[..., self.drives.q] / self.drives.ratio

    def key(self, now: Snapshot, later: Snapshot) -> bytes:
        """Return what the result of `moved` depends on, as bytes."""
        q, v = now.state.q, later.state.v
        parts = (later.state.q[self.drives.q], v[self.drives.v], q[self.drives.q], q[list(self.base_coordinates)])
        return b"".join(part.tobytes() for part in parts)

    def is_moving(self, now: Snapshot) -> bool:
        """Return whether its base has a velocity."""
        return bool(now.state.v[list(self.base_rates)].any())

    def moved(self, before: Snapshot, after: Snapshot) -> Moved | None:
        """Return where the craft is once its drives have gone on from one snapshot to the next; None where they stand.

        Raises KernelError with what the component does wrong.
        """
        now, later, later_v, seconds = before.state.q, after.state.q, after.state.v, before.tick_seconds
        states, end = self.states(now), self.states(later)
        commands, rates = (end - states) / seconds, later_v[self.drives.v] / self.drives.ratio
        if not commands.any() and not rates.any():
            return None
        base = self.pose(now)
        begin = base @ self.base_t_center
        pose, reached = self.stepped(begin, states, commands, seconds)
        places = self.base_coordinates
        there = self.coordinates(now[places.start : places.stop], pose @ self.center_t_base, begin, pose)
        q = dict(zip(places, there, strict=True))
        v = dict(zip(self.base_rates, self.rates(pose, self.twist(reached, rates)), strict=True))
        if self.passive_places:
            q |= self._turned(now, states, commands, seconds)
            v |= {
                int(at_v): (q[int(at)] - float(now[at])) / seconds if rates.any() else 0.0
                for at, at_v in zip(self.passive.q, self.passive.v, strict=True)
            }
        return Moved(q, v)

    def at_rest(self, now: Floats) -> Moved:
        """Return the craft where it is, standing."""
        places = [*self.base_coordinates, *self.passive.q.tolist()]
        return standing(now, places, [*self.base_rates, *self.passive.v.tolist()])

    def twist(self, states: Floats, rates: Floats) -> Floats:
        """Return the twist (3,) of the component's base, its drives told `rates`."""
        return self._numbers("base_twist", (3,), states, rates)

    def commands(self, twist: Floats, q: Floats, seconds: float) -> Floats:
        """Return the speeds of its joints (m,) for a twist (3,), of all coordinates (nq,).

        A steering angle comes to where the twist needs it as fast as its joint brakes. Raises KernelError for a twist
        that the craft never has, LimitError for one that no craft has.
        """
        if (fastest := np.abs(twist).max()) > MOST_TWIST:
            raise LimitError(
                f"a twist is at most {MOST_TWIST:g} m/s and rad/s, not {fastest:g}", value=fastest, limit=MOST_TWIST
            )
        states = self.states(q)
        at_once, within = (
            self._numbers("drive_commands", states.shape, twist, states, time) for time in (seconds, STEERING_SECONDS)
        )
        off = np.where(at_once != within, within * STEERING_SECONDS, 0.0)
        slower = np.minimum(np.sqrt(self.accelerations * np.abs(off)), np.abs(off) / APPROACH_SECONDS)
        steered = np.sign(off) * np.minimum(np.abs(at_once), slower)
        return np.where(off != 0.0, steered, at_once) * self.drives.ratio

    def way(self, q: Floats, parts: Floats) -> Floats:
        """Return where its joints are (2 n, m) on a way of parts (n, 3), from coordinates q (nq,) on.

        Each part is a shift (m) and a turn (rad) of the component's base; two rows: steered, and gone. Raises
        KernelError for a part that the craft never goes.
        """
        states, rows = self.states(q), []
        for part in parts:
            slowly, soon = (
                self._numbers("drive_commands", states.shape, part, states, time) for time in (LONG_SECONDS, 1.0)
            )
            steers = slowly != soon
            states = states + np.where(steers, slowly * LONG_SECONDS, 0.0)
            rows.append(states)
            states = states + np.where(steers, 0.0, slowly)
            rows.append(states)
        return np.array(rows).reshape(-1, len(states)) * self.drives.ratio

    def can(self, twist: Floats, q: Floats) -> bool:
        """Return whether its component makes commands for a twist (3,), however long it steers before."""
        try:
            self.component.call("drive_commands", twist, self.states(q), LONG_SECONDS)
        except KernelError as error:
            if error.reason is not Reason.INVALID_ARGUMENT:
                raise
            return False
        return True

    def standing_at(self, q: Floats, x: float, y: float, heading: float) -> Floats:
        """Return coordinates (nq,) with the base level at x, y (m) and a heading (rad), as high as it is."""
        after = q.copy()
        after[self.base_q : self.base_q + 2] = x, y
        if self.is_planar:
            after[self.base_q + 2] = heading
        else:
            half = heading / 2.0
            after[self.base_q + 3 : self.base_q + 7] = 0.0, 0.0, math.sin(half), math.cos(half)
        return after

    def place(self, q: Floats) -> Floats:
        """Return x, y (m) and heading (rad) of the base in the frame of its joint."""
        pose = self.pose(q)
        return np.array([pose[0, 3], pose[1, 3], math.atan2(pose[1, 0], pose[0, 0])])

    def carry(self, positions: Floats, seconds: float) -> None:
        """Put into rows of coordinates (n, nq), `seconds` apart, where the drives take the base."""
        states = self.states(positions)
        last = len(positions) - 1
        if last < 1 or not (states != states[0]).any():
            return
        rows = np.unique(np.linspace(0, last, MOST_STEPS + 1).round().astype(int)).tolist()
        pose = self.pose(positions[0]) @ self.base_t_center
        own = list(self.base_coordinates)
        for begin, end in pairwise(rows):
            time = (end - begin) * seconds
            there, _ = self.stepped(pose, states[begin], (states[end] - states[begin]) / time, time)
            base = there @ self.center_t_base
            positions[end, own] = self.coordinates(positions[begin, own], base, pose, there)
            shares = np.arange(1, end - begin)[:, None] / (end - begin)
            positions[begin + 1 : end, own] = positions[begin, own] * (1.0 - shares) + positions[end, own] * shares
            pose = self.pose(positions[end]) @ self.base_t_center

    def pose(self, q: Floats) -> Floats:
        """Return the pose (4, 4) of the base in the frame of its joint."""
        at, pose = self.base_q, np.eye(4)
        if self.is_planar:
            cosine, sine = math.cos(q[at + 2]), math.sin(q[at + 2])
            pose[:2, :2] = [[cosine, -sine], [sine, cosine]]
            pose[:2, 3] = q[at : at + 2]
            return pose
        pose[:3, :3] = from_quaternion(q[at + 3 : at + 7] / np.linalg.norm(q[at + 3 : at + 7]))
        pose[:3, 3] = q[at : at + 3]
        return pose

    def coordinates(self, before: Floats, pose: Floats, begin: Floats, end: Floats) -> list[float]:
        """Return the coordinates of the base at a pose (4, 4), after it has turned as from `begin` to `end`.

        `before` are those of the base there, (3,) or (7,).
        """
        turned = begin[:3, :3].T @ end[:3, :3]
        angle = math.atan2(turned[1, 0] - turned[0, 1], turned[0, 0] + turned[1, 1])
        if self.is_planar:
            return [float(pose[0, 3]), float(pose[1, 3]), float(before[2]) + angle]
        x, y, z, w = (before[3:] / np.linalg.norm(before[3:])).tolist()
        sine, cosine = math.sin(angle / 2.0), math.cos(angle / 2.0)
        turn = [x * cosine + y * sine, y * cosine - x * sine, z * cosine + w * sine, w * cosine - z * sine]
        return [*pose[:3, 3].tolist(), *turn]

    def rates(self, pose: Floats, twist: Floats) -> list[float]:
        """Return the velocities of the base's joint at a twist (3,) of the component's base at `pose`."""
        vx, vy, omega = twist.tolist()
        x, y = self.center_t_base[:2, 3].tolist()
        shift = pose[:3, :3] @ [vx - omega * y, vy + omega * x, 0.0]
        return [*shift[:2].tolist(), omega] if self.is_planar else [*shift.tolist(), 0.0, 0.0, omega]

    def _turned(self, now: Floats, states: Floats, commands: Floats, seconds: float) -> dict[int, float]:
        """Return where passive wheels are after a step, by their places."""
        passive, places = self.passive, list(self.passive_places)
        before = np.zeros(self.passive_count)
        before[places] = now[passive.q] / passive.ratio
        after = self._numbers("passive_states", before.shape, before, states, commands, seconds)
        return dict(zip(passive.q.tolist(), (after[places] * passive.ratio).tolist(), strict=True))

    def stepped(self, pose: Floats, states: Floats, commands: Floats, seconds: float) -> tuple[Floats, Floats]:
        """Return where the component's base (4, 4) and drives are after a step; raise KernelError for nonsense."""
        answer = self.component.call("step", pose, states, commands, seconds)
        after, reached = checked_step(self.component, answer, "a pose and the states of drives", (4, 4), states.shape)
        up, gone = pose[:3, 2], after[:3, 3] - pose[:3, 3]
        if np.abs(after[:3, 2] - up).max() > LEVEL or abs(up @ gone) > LEVEL * (1.0 + np.abs(gone).max()):
            raise nonsense(self.component, "step tilts or lifts the base; it must stay in the plane on which it stands")
        return after, reached

    def _numbers(self, method: str, shape: tuple[int, ...], *arguments: object) -> Floats:
        return checked(self.component, method, self.component.call(method, *arguments), shape)


def at_work(structure: Structure, node: Node, craft: Craft, component: ComponentHandle) -> CraftAtWork:
    """Return a craft with its component; raise KernelError where the component has a drive that no joint is."""
    joint, base_q, base_v = base_joint(structure, node)
    names, all_passive = component.call("drive_names"), component.call("passive_names")
    found = fitted(structure, node, craft, names, all_passive)
    driving = [found[name] for name in names]
    passive = {place: found[name] for place, name in enumerate(all_passive) if name in found}
    center = center_of(craft)
    drives = _turning(driving)
    return CraftAtWork(
        node=node,
        craft=craft,
        component=component,
        is_planar=joint.type is JointType.PLANAR,
        base_q=base_q,
        base_v=base_v,
        base_t_center=center,
        center_t_base=inverse(center),
        drives=drives,
        passive=_turning(passive.values()),
        passive_places=tuple(passive),
        passive_count=len(all_passive),
        accelerations=np.array([one.coordinate.joint.limits.acceleration for one in driving]) / np.abs(drives.ratio),
    )


def _turning(found: Iterable[Fitted]) -> _Turning:
    joints = tuple(found)
    return _Turning(
        tuple(one.joint for one in joints),
        np.array([one.coordinate.q for one in joints], np.int32),
        np.array([one.coordinate.v for one in joints], np.int32),
        np.array([one.ratio for one in joints]),
    )
