"""A craft at work: its component, and where its base, its drives and its passive wheels are in the world's arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.errors import ComponentFault, FaultKind

from virtualrobot_kernel.components.running import ComponentHandle
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.crafts import base_joint
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Craft, JointType, Node, Structure

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

RIGID = 1e-6
"""Largest error of a pose that a component returns from a rigid one."""

MOST_STEPS = 24
"""Greatest number of steps in which a brake is followed: arcs between them are as good as exact."""


STEERING_SECONDS = 0.5
"""Time (s) in which a component is asked to steer, to learn how far it has to."""

LONG_SECONDS = 1e3
"""Time (s) in which any steering angle comes to anywhere."""

APPROACH_SECONDS = 0.1
"""Time constant (s) with which a steering angle comes to its end."""


class _Turning(NamedTuple):
    """Drives or passive wheels: their names, joints, places in q and v, and joint = ratio * drive."""

    names: tuple[str, ...]
    joints: tuple[str, ...]
    q: Integers
    v: Integers
    ratio: Floats


class Moved(NamedTuple):
    """Coordinates and velocities of a craft at the end of a tick, by their places."""

    q: dict[int, float]
    v: dict[int, float]


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
    drives: _Turning
    passive: _Turning
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
        base = self._pose(now)
        begin = base @ self.base_t_center
        pose, reached = self._stepped(begin, states, commands, seconds)
        there = self._coordinates(now, pose @ _inverse(self.base_t_center), begin, pose)
        q = dict(zip(self.base_coordinates, there, strict=True))
        v = dict(zip(self.base_rates, self._rates(pose, self.twist(reached, rates)), strict=True))
        if len(self.passive.names):
            q |= self._turned(now, states, commands, seconds)
            v |= {
                int(at_v): (q[int(at)] - float(now[at])) / seconds if rates.any() else 0.0
                for at, at_v in zip(self.passive.q, self.passive.v, strict=True)
            }
        return Moved(q, v)

    def at_rest(self, now: Floats) -> Moved:
        """Return the craft where it is, standing."""
        places = [*self.base_coordinates, *self.passive.q.tolist()]
        rates = [*self.base_rates, *self.passive.v.tolist()]
        return Moved({at: float(now[at]) for at in places}, dict.fromkeys(rates, 0.0))

    def twist(self, states: Floats, rates: Floats) -> Floats:
        """Return the twist (3,) of the component's base, its drives told `rates`."""
        return self._numbers("base_twist", (3,), states, rates)

    def commands(self, twist: Floats, q: Floats, seconds: float) -> Floats:
        """Return the speeds of its joints (m,) for a twist (3,), of all coordinates (nq,).

        A steering angle comes to where the twist needs it as fast as its joint brakes. Raises KernelError for a twist
        that the craft never has.
        """
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

    def place(self, q: Floats) -> Floats:
        """Return x, y (m) and heading (rad) of the base in the frame of its joint."""
        pose = self._pose(q)
        return np.array([pose[0, 3], pose[1, 3], math.atan2(pose[1, 0], pose[0, 0])])

    def carry(self, positions: Floats, seconds: float) -> None:
        """Put into rows of coordinates (n, nq), `seconds` apart, where the drives take the base."""
        states = self.states(positions)
        last = len(positions) - 1
        if last < 1 or not (states != states[0]).any():
            return
        rows = np.unique(np.linspace(0, last, MOST_STEPS + 1).round().astype(int)).tolist()
        pose = self._pose(positions[0]) @ self.base_t_center
        own = list(self.base_coordinates)
        for begin, end in pairwise(rows):
            time = (end - begin) * seconds
            there, _ = self._stepped(pose, states[begin], (states[end] - states[begin]) / time, time)
            base = there @ _inverse(self.base_t_center)
            positions[end, own] = self._coordinates(positions[begin], base, pose, there)
            shares = np.arange(1, end - begin)[:, None] / (end - begin)
            positions[begin + 1 : end, own] = positions[begin, own] * (1.0 - shares) + positions[end, own] * shares
            pose = self._pose(positions[end]) @ self.base_t_center

    def _pose(self, q: Floats) -> Floats:
        """Return the pose (4, 4) of the base in the frame of its joint."""
        at, pose = self.base_q, np.eye(4)
        if self.is_planar:
            cosine, sine = math.cos(q[at + 2]), math.sin(q[at + 2])
            pose[:2, :2] = [[cosine, -sine], [sine, cosine]]
            pose[:2, 3] = q[at : at + 2]
            return pose
        x, y, z, w = q[at + 3 : at + 7] / np.linalg.norm(q[at + 3 : at + 7])
        pose[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        pose[:3, 3] = q[at : at + 3]
        return pose

    def _coordinates(self, before: Floats, pose: Floats, begin: Floats, end: Floats) -> list[float]:
        """Return the coordinates of the base at a pose (4, 4), after it has turned as from `begin` to `end`."""
        turned = begin[:3, :3].T @ end[:3, :3]
        angle = math.atan2(turned[1, 0] - turned[0, 1], turned[0, 0] + turned[1, 1])
        at = self.base_q
        if self.is_planar:
            return [float(pose[0, 3]), float(pose[1, 3]), float(before[at + 2]) + angle]
        x, y, z, w = (before[at + 3 : at + 7] / np.linalg.norm(before[at + 3 : at + 7])).tolist()
        sine, cosine = math.sin(angle / 2.0), math.cos(angle / 2.0)
        turn = [x * cosine + y * sine, y * cosine - x * sine, z * cosine + w * sine, w * cosine - z * sine]
        return [*pose[:3, 3].tolist(), *turn]

    def _rates(self, pose: Floats, twist: Floats) -> list[float]:
        """Return the velocities of the base's joint at a twist (3,) of the component's base at `pose`."""
        vx, vy, omega = twist.tolist()
        x, y = _inverse(self.base_t_center)[:2, 3].tolist()
        shift = pose[:3, :3] @ [vx - omega * y, vy + omega * x, 0.0]
        return [*shift[:2].tolist(), omega] if self.is_planar else [*shift.tolist(), 0.0, 0.0, omega]

    def _turned(self, now: Floats, states: Floats, commands: Floats, seconds: float) -> dict[int, float]:
        """Return where passive wheels are after a step, by their places."""
        passive, all_names = self.passive, self.component.call("passive_names")
        before = np.zeros(len(all_names))
        places = [all_names.index(name) for name in passive.names]
        before[places] = now[passive.q] / passive.ratio
        after = self._numbers("passive_states", before.shape, before, states, commands, seconds)
        return dict(zip(passive.q.tolist(), (after[places] * passive.ratio).tolist(), strict=True))

    def _stepped(self, pose: Floats, states: Floats, commands: Floats, seconds: float) -> tuple[Floats, Floats]:
        answer = self.component.call("step", pose, states, commands, seconds)
        if not isinstance(answer, tuple) or len(answer) != 2:
            raise self._nonsense(f"step returned {type(answer).__name__}; it must be a pose and the states of drives")
        after = self._checked("step", answer[0], (4, 4))
        if np.abs(after[:3, :3].T @ after[:3, :3] - np.eye(3)).max() > RIGID:
            raise self._nonsense(f"step returned a pose that is not rigid: {after.tolist()}")
        return after, self._checked("step", answer[1], states.shape)

    def _numbers(self, method: str, shape: tuple[int, ...], *arguments: object) -> Floats:
        return self._checked(method, self.component.call(method, *arguments), shape)

    def _checked(self, method: str, value: object, shape: tuple[int, ...]) -> Floats:
        if not isinstance(value, np.ndarray) or value.dtype != np.float64 or value.shape != shape:
            raise self._nonsense(f"{method} returned {type(value).__name__}; it must be a float64 array {shape}")
        if not np.isfinite(value).all():
            raise self._nonsense(f"{method} returned {value.tolist()}; all must be finite")
        return value

    def _nonsense(self, said: str) -> KernelError:
        return self.component.failed(ComponentFault(FaultKind.NONSENSE, said))


def at_work(structure: Structure, node: Node, craft: Craft, component: ComponentHandle) -> CraftAtWork:
    """Return a craft with its component; raise KernelError where the component has a drive that no joint is."""
    joint, base_q, base_v = base_joint(structure, node)
    center = np.eye(4)
    cosine, sine = math.cos(craft.heading), math.sin(craft.heading)
    center[:2, :2] = [[cosine, -sine], [sine, cosine]]
    center[:2, 3] = craft.center_x, craft.center_y
    own = {one.drive: (one.joint, one.ratio) for one in craft.drives}
    coordinates = structure.robots[node.uid].coordinates

    def turning(names: Sequence[str], needed: bool) -> _Turning:
        found = {name: own.get(name, (name, 1.0)) for name in names}
        missing = [name for name, (of, _) in found.items() if of not in coordinates]
        if missing and needed:
            raise KernelError(
                f"the component {craft.kinematics!r} has the drive {missing[0]!r}, and {node.name!r} no such joint; "
                f"say in `drives` which joint it is; joints are {', '.join(coordinates)}",
                robot=node.name,
                drive=missing[0],
            )
        kept = {name: one for name, one in found.items() if name not in missing}
        places = [coordinates[of] for of, _ in kept.values()]
        return _Turning(
            tuple(kept),
            tuple(of for of, _ in kept.values()),
            np.array([one.q for one in places], np.int32),
            np.array([one.v for one in places], np.int32),
            np.array([ratio for _, ratio in kept.values()]),
        )

    drives, passive = component.call("drive_names"), component.call("passive_names")
    if unknown := [name for name in own if name not in (*drives, *passive)]:
        raise KernelError(
            f"the component {craft.kinematics!r} has no drive {unknown[0]!r}; its drives are {', '.join(drives)}"
            + (f", and {', '.join(passive)} turn with it" if passive else ""),
            robot=node.name,
            drive=unknown[0],
        )
    driving = turning(drives, True)
    limits = np.array([coordinates[own.get(name, (name, 1.0))[0]].joint.limits.acceleration for name in driving.names])
    return CraftAtWork(
        node=node,
        craft=craft,
        component=component,
        is_planar=joint.type is JointType.PLANAR,
        base_q=base_q,
        base_v=base_v,
        base_t_center=center,
        drives=driving,
        passive=turning(passive, False),
        accelerations=limits / np.abs(driving.ratio),
    )


def _inverse(pose: Floats) -> Floats:
    """Return the inverse of a rigid pose (4, 4)."""
    back = np.eye(4)
    back[:3, :3] = pose[:3, :3].T
    back[:3, 3] = -back[:3, :3] @ pose[:3, 3]
    return back
