"""A craft under water at work: its component gives velocities with inertia, so that it moves though no drive does.

What it carries beside its hull, such as an arm, is told to the component, so that the arm's movement moves the vehicle.

A drive's state, the speed of a propeller or the angle of a fin, is the velocity or the position of its joint. What the
drive is told is what a running motion has for that joint; without one a propeller is told to stand, a fin to stay.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import from_quaternion, inverse, quaternion, skew
from virtualrobot_sdk.vehicles import DriveQuantity, Surroundings, VehicleDrive

from virtualrobot_kernel.components.running import ComponentHandle
from virtualrobot_kernel.crafts.burden import Burden, burden
from virtualrobot_kernel.crafts.fitting import Moved, center_of, checked_step, fitted, nonsense, standing
from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.world.craft_data import Craft, Water
from virtualrobot_kernel.world.crafts import base_joint
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import JointType, Node, Structure

Floats = NDArray[np.float64]

SLACK = 1e-9
"""Part of a limit of a drive by which a setpoint may be beyond it: it was reckoned from another unit."""


@dataclass(frozen=True, slots=True, eq=False)
class Vessel:
    """Craft under water of a structure; make it by `vessel`."""

    node: Node
    craft: Craft
    component: ComponentHandle
    link: int
    """Link that the base joint moves (uid)."""
    base_q: int
    base_v: int
    base_t_center: Floats
    center_t_base: Floats
    drive_q: NDArray[np.int32]
    drive_v: NDArray[np.int32]
    ratio: Floats
    is_speed: NDArray[np.bool_]
    drives: dict[str, VehicleDrive]
    """Drives by their joints, in the order of the arrays."""
    lowest: Floats
    highest: Floats
    surroundings: Surroundings
    burden: Burden | None

    def key(self, now: Snapshot, later: Snapshot) -> bytes:
        """Return what the result of `moved` depends on, as bytes."""
        q, v = now.state.q, now.state.v
        base = q[self.base_q : self.base_q + 7], v[self.base_v : self.base_v + 6], q[self.drive_q], v[self.drive_v]
        own = b"".join(part.tobytes() for part in (*base, self._told(now, later)))
        return own + self.burden.key(now, later) if self.burden else own

    def moved(self, now: Snapshot, later: Snapshot) -> Moved | None:
        """Return where it is at the end of the tick; None where it stands still.

        Raises KernelError with what the component does wrong.
        """
        q, v, seconds = now.state.q, now.state.v, now.tick_seconds
        at, rate = self.base_q, self.base_v
        joint_t_link = np.eye(4)
        joint_t_link[:3, :3] = from_quaternion(q[at + 3 : at + 7] / np.linalg.norm(q[at + 3 : at + 7]))
        joint_t_link[:3, 3] = q[at : at + 3]
        world_t_link = now.world_t(self.link)
        # Where the joint is: it may hang on anything.
        world_t_joint = world_t_link @ inverse(joint_t_link)
        # np.cross takes longer than the component.
        turn, arm = self.base_t_center[:3, :3], skew(self.base_t_center[:3, 3])
        linear = joint_t_link[:3, :3].T @ v[rate : rate + 3]
        angular = v[rate + 3 : rate + 6]
        twist = np.concatenate([turn.T @ (linear - arm @ angular), turn.T @ angular])
        states = np.where(self.is_speed, v[self.drive_v], q[self.drive_q]) / self.ratio
        about = (
            replace(self.surroundings, carried=self.burden.carried(now, later)) if self.burden else self.surroundings
        )
        pose, after, reached = self._stepped(
            world_t_joint @ joint_t_link @ self.base_t_center, twist, states, self._told(now, later), seconds, about
        )
        there = inverse(world_t_joint) @ pose @ self.center_t_base
        turning = turn @ after[3:]
        velocity = there[:3, :3] @ (turn @ after[:3] + arm @ turning)
        turned = np.array(quaternion(there[:3, :3]))
        # A quaternion and its negative are one rotation: that is taken which is near the last one.
        if turned @ q[at + 3 : at + 7] < 0.0:
            turned = -turned
        ways = np.where(self.is_speed, seconds * 0.5 * (states + reached), reached - states) * self.ratio
        speeds = np.where(self.is_speed, reached * self.ratio, ways / seconds)
        all_q = dict(zip(range(at, at + 7), [*there[:3, 3].tolist(), *turned.tolist()], strict=True))
        all_q |= dict(zip(self.drive_q.tolist(), (q[self.drive_q] + ways).tolist(), strict=True))
        all_v = dict(zip(range(rate, rate + 6), [*velocity.tolist(), *turning.tolist()], strict=True))
        all_v |= dict(zip(self.drive_v.tolist(), speeds.tolist(), strict=True))
        if all(q[place] == value for place, value in all_q.items()) and not any(all_v.values()):
            return None
        return Moved(all_q, all_v)

    def is_moving(self, now: Snapshot) -> bool:
        """Return whether its base has a velocity."""
        return bool(now.state.v[self.base_v : self.base_v + 6].any())

    def check_told(self, mode: SetpointMode, joints: Sequence[str], values: Sequence[float]) -> None:
        """Raise LimitError for a setpoint of joints that a drive does not follow: its table ends before."""
        ratios = dict(zip(self.drives, self.ratio.tolist(), strict=True))
        for joint, value in zip(joints, values, strict=True):
            drive = self.drives.get(joint)
            if drive is None or (drive.quantity is DriveQuantity.SPEED) != (mode is SetpointMode.VELOCITY):
                continue
            lower, upper = sorted((drive.lowest * ratios[joint], drive.highest * ratios[joint]))
            room = SLACK * max(abs(lower), abs(upper))
            if not lower - room <= value <= upper + room:
                unit = "rad/s" if mode is SetpointMode.VELOCITY else "rad"
                raise LimitError(
                    f"a setpoint is refused: joint {joint!r} is told {value:.6g}, and the table of its drive "
                    f"{drive.name!r} goes from {lower:.6g} to {upper:.6g} {unit}",
                    joint=joint,
                    value=value,
                    lower=lower,
                    upper=upper,
                )

    def at_rest(self, q: Floats) -> Moved:
        """Return it where it is, standing."""
        places = [*range(self.base_q, self.base_q + 7), *self.drive_q.tolist()]
        rates = [*range(self.base_v, self.base_v + 6), *self.drive_v.tolist()]
        return standing(q, places, rates)

    def carry(self, positions: Floats, seconds: float) -> None:
        """Put nothing into rows of coordinates: a brake of its drives does not stop it."""

    def _told(self, now: Snapshot, later: Snapshot) -> Floats:
        """Return what motions tell its drives in this tick (m,)."""
        q, v = now.state.q, np.zeros(len(now.state.v))
        for motion in later.state.motions:
            if any(robot == self.node.uid for robot, _ in motion.joints):
                position, velocity, _ = motion.running.sample()
                q = q.copy()
                q[motion.q_index], v[motion.v_index] = position, velocity[motion.rated]
        told = np.where(self.is_speed, v[self.drive_v], q[self.drive_q]) / self.ratio
        return np.minimum(np.maximum(told, self.lowest), self.highest)

    def _stepped(
        self, pose: Floats, twist: Floats, states: Floats, commands: Floats, seconds: float, about: Surroundings
    ) -> tuple[Floats, Floats, Floats]:
        answer = self.component.call("step", pose, twist, states, commands, seconds, about)
        shapes = (4, 4), (6,), states.shape
        after, rates, reached = checked_step(self.component, answer, "pose, twist and states of drives", *shapes)
        return after, rates, reached


def vessel(structure: Structure, node: Node, craft: Craft, component: ComponentHandle) -> Vessel:
    """Return a craft under water; raise KernelError for a base that doesn't float, and a drive that no joint is."""
    joint, base_q, base_v = base_joint(structure, node)
    if joint.type is not JointType.FLOATING:
        raise KernelError(
            f"the base joint {joint.name!r} of {node.name!r} is {joint.type.name.lower()}; {craft.kinematics!r} moves "
            "a floating one",
            robot=node.name,
            joint=joint.name,
        )
    robot = structure.robots[node.uid]
    link = next(uid for uid in robot.links if getattr(structure.nodes[uid].data, "joint", None) is joint)
    drives = component.call("drives")
    if not isinstance(drives, tuple) or not drives or not all(isinstance(one, VehicleDrive) for one in drives):
        raise nonsense(component, f"drives is {drives!r}; it must be VehicleDrives")
    names = tuple(drive.name for drive in drives)
    found = list(fitted(structure, node, craft, names).values())
    center = center_of(craft)
    drive_q = np.array([one.coordinate.q for one in found], np.int32)
    water = craft.water or Water()
    return Vessel(
        node=node,
        craft=craft,
        component=component,
        link=link,
        base_q=base_q,
        base_v=base_v,
        base_t_center=center,
        center_t_base=inverse(center),
        drive_q=drive_q,
        drive_v=np.array([one.coordinate.v for one in found], np.int32),
        ratio=np.array([one.ratio for one in found]),
        is_speed=np.array([drive.quantity is DriveQuantity.SPEED for drive in drives]),
        drives=dict(zip((one.joint for one in found), drives, strict=True)),
        lowest=np.array([drive.lowest for drive in drives]),
        highest=np.array([drive.highest for drive in drives]),
        surroundings=Surroundings(water.current, water.density, water.surface_height),
        burden=burden(structure, node.uid, link, drive_q.tolist(), center),
    )
