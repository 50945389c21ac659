"""A walking machine in a kernel: a body on a floating base and its legs, which are robots or groups of one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client, Robot
from virtualrobot.geometry import rows_from_poses
from virtualrobot.motions.motion import Motion
from virtualrobot.motions.moves import Move
from virtualrobot.robots.group import Group

from virtualrobot_apps.vehicles.walking.masses import masses_of
from virtualrobot_apps.vehicles.walking.walk import Walk

Floats = NDArray[np.float64]
BASE = "base"
"""Name of the joint that the body moves by."""
HEXAPOD_LEGS = ("left_front", "right_front", "left_middle", "right_middle", "left_rear", "right_rear")


@dataclass(frozen=True, slots=True)
class Quadruped:
    """Quadruped of the catalogue: one robot whose legs are chains of three joints each.

    trunk: its body. toes: the feet, left front, right front, left rear, right rear. home: joints of each leg, from the
    body on, in the posture in which it stands (rad). foot_radius: of the ball that a foot is (m).
    """

    trunk: str
    toes: tuple[str, str, str, str]
    home: tuple[float, float, float]
    foot_radius: float


_UNITREE = "FL_toe", "FR_toe", "RL_toe", "RR_toe"
QUADRUPEDS = {
    "a1": Quadruped("trunk", _UNITREE, (0.0, 0.8, -1.6), 0.02),
    "aliengo": Quadruped("trunk", _UNITREE, (0.0, 0.8, -1.6), 0.0265),
}
"""Quadrupeds by their names in the catalogue."""


@dataclass(frozen=True, slots=True)
class Leg:
    """Leg of a machine: what solves and moves it, and the link that is its foot."""

    mechanism: Robot | Group
    foot: str


@dataclass(frozen=True, eq=False)
class Machine:
    """Walking machine of a kernel.

    robot: with the floating base. trunk: the link that the base moves. legs: in the order of the gaits. home: joints of
    the posture in which it stands, by leg. foot_radius: of the ball that a foot is (m). body_t_trunk: pose (4, 4) of
    the trunk in the frame of the body, which has x forward and z up. by_forces: it stands on its feet under physics,
    and a walk moves its legs alone.
    """

    client: Client
    robot: Robot
    trunk: str
    legs: Sequence[Leg]
    home: Sequence[Mapping[str, float]]
    foot_radius: float
    body_t_trunk: Floats = field(default_factory=lambda: np.eye(4))
    by_forces: bool = False

    def under_physics(self, engine: str) -> Machine:
        """Return the machine after it has been let stand by forces, which an engine such as `mujoco` computes."""
        self.client.physics.set(engine)
        self.client.physics.enable(*dict.fromkeys([self.robot.name, *(leg.mechanism.name for leg in self.legs)]))
        return replace(self, by_forces=True)

    def stance(self) -> tuple[Floats, float, Floats]:
        """Return places (l, 2) of the feet in the frame of the body, its height (m) and its centre of mass (2,).

        They are those of the posture `home`, in which the machine is put for it.
        """
        self._put(np.eye(4), self.home)
        feet = [leg.foot for leg in self.legs]
        masses = masses_of(self.client, self.robot.name)
        poses = self.client.scene.poses([self.trunk, *feet, *masses.links])
        to_body = self.body_t_trunk @ np.linalg.inv(poses[self.trunk])
        places = np.array([(to_body @ poses[foot])[:3, 3] for foot in feet])
        center = (to_body @ np.append(masses.center(poses), 1.0))[:2]
        return places[:, :2], float(self.foot_radius - places[:, 2].mean()), center

    def put(self, walk: Walk) -> None:
        """Put the machine where a walk begins."""
        self._put(walk.bodies[0], [self._joints(walk, number, 1) for number in range(len(self.legs))])

    def moves(self, walk: Walk) -> list[Move]:
        """Return the moves of body and legs (by forces: of legs alone) that are a walk: their joints at its instants.

        Raises UnreachableError or LimitError where a foot cannot get to its place.
        """
        base = rows_from_poses(walk.bodies @ self.body_t_trunk)
        legs = [self._solved(walk, number, len(walk.times)) for number in range(len(self.legs))]
        if all(isinstance(leg.mechanism, Robot) for leg in self.legs):
            own = [leg.mechanism.trajectory(walk.times, rows) for leg, (_, rows) in zip(self.legs, legs, strict=True)]
            return own if self.by_forces else [self.robot.trajectory(walk.times, base, joints=[BASE]), *own]
        names = [name for joints, _ in legs for name in joints]
        rows = np.hstack([rows for _, rows in legs])
        if self.by_forces:
            return [self.robot.trajectory(walk.times, rows, joints=names)]
        return [self.robot.trajectory(walk.times, np.hstack([base, rows]), joints=[BASE, *names])]

    def start(self, walk: Walk) -> Motion:
        """Start a walk from where it begins; nobody waits for it."""
        return self.client.move_together(self.moves(walk), wait=False)

    def _solved(self, walk: Walk, number: int, count: int) -> tuple[tuple[str, ...], Floats]:
        """Return a leg's joints, and where they are (n, k) at the first instants of a walk."""
        trunk_t_body = np.linalg.inv(self.body_t_trunk)
        points = walk.body_t_feet[:count, number] @ trunk_t_body[:3, :3].T + trunk_t_body[:3, 3]
        leg = self.legs[number]
        found = leg.mechanism.solve_points(points, seed=self.home[number], reference=self.trunk)
        return found.joint_names, found.all

    def _joints(self, walk: Walk, number: int, count: int) -> dict[str, float]:
        names, rows = self._solved(walk, number, count)
        return dict(zip(names, rows[0].tolist(), strict=True))

    def _put(self, body: Floats, legs: Sequence[Mapping[str, float]]) -> None:
        """Put the body at a pose (4, 4), and its legs at joints."""
        base = rows_from_poses((body @ self.body_t_trunk)[None])[0]
        names = [f"{BASE}/{coordinate}" for coordinate in ("x", "y", "z", "qx", "qy", "qz", "qw")]
        with self.client.scene.batch() as batch:
            batch.set_joint_positions(self.robot.name, dict(zip(names, base.tolist(), strict=True)))
            for leg, joints in zip(self.legs, legs, strict=True):
                batch.set_joint_positions(leg.mechanism.name, dict(joints))


def hexapod(client: Client, name: str = "hexapod") -> Machine:
    """Load the hexapod of the catalogue, a body with six robots as legs, and return it."""
    robot = client.load_robot("model://hexapod", name=name, base="floating")
    robots = [client.robot(f"{name}.{leg}") for leg in HEXAPOD_LEGS]
    legs = [Leg(leg, leg.flange) for leg in robots]
    home = [leg.postures["home"] for leg in robots]
    return Machine(client, robot, f"{name}.body", legs, home, 0.008)


def quadruped(client: Client, model: str = "a1") -> Machine:
    """Load a quadruped of the catalogue, one of QUADRUPEDS, whose legs are groups, and return it."""
    found = QUADRUPEDS[model]
    robot = client.load_robot(f"model://{model}", name=model, base="floating")
    trunk = f"{model}.{found.trunk}"
    legs = [Leg(robot.group(base=trunk, tip=f"{model}.{toe}"), f"{model}.{toe}") for toe in found.toes]
    home = [dict(zip(leg.mechanism.chain_joint_names, found.home, strict=True)) for leg in legs]
    return Machine(client, robot, trunk, legs, home, found.foot_radius)
