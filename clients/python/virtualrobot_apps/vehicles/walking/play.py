"""Walks played by a kernel: what is read from it tick by tick, and what is drawn meanwhile."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import virtualrobot
from numpy.typing import NDArray
from virtualrobot.scene.figures import lines, points

from virtualrobot_apps.pace import Pace
from virtualrobot_apps.vehicles.walking.machine import Machine
from virtualrobot_apps.vehicles.walking.masses import masses_of
from virtualrobot_apps.vehicles.walking.support import stability_margin, support_polygon
from virtualrobot_apps.vehicles.walking.walk import Walk

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
DRAWN = 0.1
"""Time (s) after which the support polygon is drawn anew, also where no foot was lifted or set down."""
FALLEN_TILT = np.radians(45.0)
"""Tilt (rad) from which on a body has fallen."""
ABOVE = 0.003
"""Height above the ground (m) at which lines are drawn."""


@dataclass(frozen=True, eq=False)
class Record:
    """Record of a walk as the kernel had it, n ticks.

    times: (n,) since the start (s). bodies: (n, 4, 4) world_t_body. feet: (n, l, 3) middles of the feet (m). centers:
    (n, 3) of mass (m). stance: (n, l) feet that are to be on the ground. margins: (n,) static stability margin (m).
    """

    times: Floats
    bodies: Floats
    feet: Floats
    centers: Floats
    stance: Booleans
    margins: Floats

    @property
    def slips(self) -> Floats:
        """Distance that each foot (l,) moved at most while it was on the ground (m)."""
        slips = np.zeros(self.feet.shape[1])
        for leg in range(self.feet.shape[1]):
            place = None
            for foot, standing in zip(self.feet[:, leg], self.stance[:, leg], strict=True):
                place = (foot if place is None else place) if standing else None
                if place is not None:
                    slips[leg] = max(slips[leg], float(np.linalg.norm(foot - place)))
        return slips

    def speed(self, begin: float, end: float) -> float:
        """Return the mean speed over ground (m/s) of the body, seen from above along its way, between two times (s)."""
        during = (self.times >= begin - 1e-9) & (self.times <= end + 1e-9)
        places, times = self.bodies[during, :2, 3], self.times[during]
        return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum() / (times[-1] - times[0]))


@dataclass(frozen=True, slots=True)
class Strayed:
    """Difference of a walk by forces from its plan.

    way: how far the body is from its place in the end (m). tilt: how far it was tilted against its plan at most (rad).
    fell: when it lay lower than half its height, or was tilted by more than 45 degrees (s); None where it stood.
    """

    way: float
    tilt: float
    fell: float | None


def strayed(record: Record, walk: Walk) -> Strayed:
    """Return how far a record is from the walk that was planned."""
    planned = walk.bodies[np.searchsorted(walk.times, record.times - 1e-9).clip(max=len(walk.times) - 1)]
    ups = record.bodies[:, :3, 2]
    tilts = np.arccos(np.clip((ups * planned[:, :3, 2]).sum(axis=1), -1.0, 1.0))
    below = record.feet.mean(axis=1) - walk.stand.foot_radius * ups
    heights = ((record.bodies[:, :3, 3] - below) * ups).sum(axis=1)
    fallen = np.flatnonzero((tilts > FALLEN_TILT) | (heights < 0.5 * walk.stand.height))
    way = float(np.linalg.norm(record.bodies[-1, :3, 3] - planned[-1, :3, 3]))
    return Strayed(way, float(tilts.max()), float(record.times[fallen[0]]) if len(fallen) else None)


def play(machine: Machine, walk: Walk, pace: float = 0.0, shown: bool = True) -> Record:
    """Put a machine where a walk begins, let the kernel play it in steps, and return what it told each tick.

    `pace` are simulated seconds for each second of the wall clock; 0: as fast as it can be. With `shown` the ways of
    the feet, footholds and the support polygon are drawn.

    Raises UnreachableError or LimitError where a foot cannot get to its place, MotionAbortedError where the kernel ends
    the motion.
    """
    client = machine.client
    client.clock.set_stepped()
    machine.put(walk)
    masses = masses_of(client, machine.robot.name)
    if shown:
        draw_ways(machine, walk)
    drawing = Support(machine, walk) if shown else None
    motion = machine.start(walk)
    feet = [leg.foot for leg in machine.legs]
    names = [machine.trunk, *feet, *masses.links]
    trunk_t_body = np.linalg.inv(machine.body_t_trunk)
    tick = client.clock.read().tick_length
    count = round(np.ceil(walk.times[-1] / tick - 1e-6))
    rows = []
    keeper = Pace(pace)
    for number in range(count + 1):
        if number:
            client.clock.step(1)
        poses = client.scene.poses(names)
        now = number * tick
        stance = walk.stance_at(now)
        places, center = np.array([poses[foot][:3, 3] for foot in feet]), masses.center(poses)
        margin = stability_margin(center[:2], places[stance][:, :2])
        rows.append((now, poses[machine.trunk] @ trunk_t_body, places, center, stance, margin))
        if drawing is not None:
            drawing.draw(now, stance, places, center)
        keeper.keep(now)
    motion.state.raise_early_end()
    return Record(*(np.array(column) for column in zip(*rows, strict=True)))


def draw_ways(machine: Machine, walk: Walk) -> None:
    """Draw the ways of the feet through the air, and the places where they are set down."""
    scene = machine.client.scene
    for name in ("ways of feet", "footholds"):
        if name in scene:
            scene.remove(name)
    ways = [lines(walk.feet[::3, leg], color="#e08a1e", width=1) for leg in range(walk.feet.shape[1])]
    places = np.array([step.goal for of in walk.steps for step in of] + list(walk.feet[0]))
    places[:, 2] += ABOVE - machine.foot_radius
    scene.add_annotation("ways of feet", ways)
    scene.add_annotation("footholds", points(places, color="#c0392b", size=0.012))


class Support:
    """Polygon of the feet on the ground, and the point below the centre of mass, as lines that follow a walk."""

    def __init__(self, machine: Machine, walk: Walk) -> None:
        """Add the node that shows them."""
        self._scene = machine.client.scene
        self._radius = walk.stand.foot_radius
        self._stance: bytes = b""
        self._drawn = -np.inf
        if "support" in self._scene:
            self._scene.remove("support")
        self._node = self._scene.add_annotation("support", [])

    def draw(self, now: float, stance: Booleans, feet: Floats, center: Floats) -> None:
        """Draw them where feet stand (l, 3) and the centre of mass is (3,), when that is due."""
        if stance.tobytes() == self._stance and now - self._drawn < DRAWN:
            return
        self._stance, self._drawn = stance.tobytes(), now
        standing = feet[stance]
        corners = support_polygon(standing[:, :2])
        near = np.linalg.norm(standing[None, :, :2] - corners[:, None], axis=2).argmin(axis=1)
        edge = np.column_stack([corners, standing[near, 2] - self._radius + ABOVE])
        figures = []
        if len(edge) > 1:
            figures.append(lines(np.vstack([edge, edge[:1]]), color="#2e8b57", width=4))
        below = np.array([*center[:2], edge[:, 2].mean() if len(edge) else 0.0])
        figures += [
            lines(np.array([center, below]), color="#1f5fa8", width=2),
            virtualrobot.sphere(0.006, color="#1f5fa8", pose=virtualrobot.pose(*below), roles=["visual"]),
        ]
        self._node.set_figures(figures)
