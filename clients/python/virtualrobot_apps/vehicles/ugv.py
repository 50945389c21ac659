"""A UGV drives a square by waypoints, with a PI controller and then with a PID controller: `virtualrobot demo ugv`.

In steps: each period the controller gets the state and says how to drive, and time goes on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import virtualrobot
from virtualrobot import Client
from virtualrobot.scene.figures import lines

from virtualrobot_apps.chart import Panel, chart, plan, stacked
from virtualrobot_apps.pace import Pace
from virtualrobot_apps.vehicles import room
from virtualrobot_apps.vehicles.floor import FRICTION, NO_PHYSICS
from virtualrobot_apps.vehicles.waypoints import (
    CONTROLLERS,
    FASTEST,
    PERIOD,
    QUICKEST,
    REACHED,
    Floats,
    Waypoints,
    square,
)

ROBOT = "ugv"
SIDE = 2.0
"""Side of the square (m)."""
LONGEST = 120.0
"""Simulation time (s) after which a run is given up."""


@dataclass(frozen=True, eq=False)
class Record:
    """Record of a run, n instants of it.

    times: (n,) simulation time since the start (s). poses: (n, 3) x, y (m) and heading (rad) in the world. angles: (n,)
    from the heading to the waypoint (rad). cross_track: (n,) distance from the line between waypoints (m). twists:
    (n, 2) speed (m/s) and turning rate (rad/s) that were told. reached: times at which waypoints were reached (s).
    clearance: least distance from furniture (m); None without.
    """

    times: Floats
    poses: Floats
    angles: Floats
    cross_track: Floats
    twists: Floats
    reached: tuple[float, ...]
    clearance: float | None = None

    @property
    def rms(self) -> float:
        """Root mean square of the distances from the lines (m)."""
        return float(np.sqrt(np.mean(self.cross_track**2)))


def main(
    client: Client,
    side: float | None = SIDE,
    plot: Path | None = None,
    pace: float = 0.0,
    engine: str = NO_PHYSICS,
) -> dict[str, Record]:
    """Replace the world by a UGV, drive a square with each controller, print the numbers, and return the runs by name.

    Without a `side` it drives around the table of a furnished room. `pace` are simulated seconds for each second of
    the wall clock; 0: as fast as it can be. With an `engine` it stands and rolls on its wheels and caster by forces.
    """
    points = list(room.ROUTE) if side is None else square(side)
    by = "" if engine == NO_PHYSICS else f" by {engine}"
    way = "furnished room" if side is None else f"square of {side:g} m"
    print(
        f"UGV{by}, {way}: waypoints within {REACHED:g} m, at most {FASTEST:g} m/s and {QUICKEST:g} "
        f"rad/s, {1.0 / PERIOD:g} Hz",
        flush=True,
    )
    records: dict[str, Record] = {}
    for name, gains in CONTROLLERS.items():
        build(client, points, engine)
        if side is None:
            room.furnish(client)
        record = records[name] = drive(client, Waypoints(points, gains), pace, indoors=side is None)
        end = f"{record.times[-1]:.1f} s" if len(record.reached) == len(points) else "not done"
        print(
            f"{name:4} {len(record.reached)} of {len(points)} waypoints in {end}, off the lines "
            f"{1e3 * record.rms:.0f} mm rms, {1e3 * record.cross_track.max():.0f} mm at most{_kept(record)}",
            flush=True,
        )
    print("The document tells the limits and a picture of each run, neither times nor distances.")
    if plot is not None:
        plot.write_text(picture(records, points), "utf-8")
        print(f"picture in {plot}", flush=True)
    return records


def build(client: Client, points: list, engine: str = NO_PHYSICS) -> None:
    """Replace the world by a floor, the UGV at its origin, and the waypoints; with an engine it moves by forces."""
    client.scene.clear()
    floor = virtualrobot.box(14.0, 14.0, 0.1, color="#b8bcc0").with_surface(friction=FRICTION)
    client.scene.add_object("floor", floor, pose=virtualrobot.pose(2.0, 2.0, -0.05))
    client.physics.set(engine)
    client.load_robot(f"model://{ROBOT}", name=ROBOT, base="planar" if engine == NO_PHYSICS else "floating")
    if engine != NO_PHYSICS:
        client.physics.enable(ROBOT)
    corners = np.array([(0.0, 0.0, 0.01), *((x, y, 0.01) for x, y in points)])
    client.scene.add_annotation("way", lines(corners, color="#1f5fa8", width=3))
    client.view.set_camera(position=(1.0, -3.5, 3.5), target=(1.0, 0.8, 0.0))


def drive(
    client: Client, waypoints: Waypoints, pace: float = 0.0, robot: str = ROBOT, *, indoors: bool = False
) -> Record:
    """Drive a craft through waypoints in steps, for LONGEST at most; the clock is stepped, and stands afterwards.

    `indoors`: note how near it comes to the furniture of a room.
    """
    client.clock.set_stepped()
    tick = client.clock.read().tick_length
    rows: list[tuple[float, ...]] = []
    clearance = np.inf if indoors else None
    keeper = Pace(pace)
    with client.robot(robot).stream_twist(timeout=10.0) as stream:
        state = client.clock.step(1).robots[robot]
        start = state.stamp
        while (now := state.stamp.simulation_time - start.simulation_time) < LONGEST:
            pose = state.world_t_tcp
            heading = math.atan2(pose[1, 0], pose[0, 0])
            if clearance is not None:
                clearance = min(clearance, client.collisions.distance(robot, to=[room.FURNITURE]).distance)
            twist = waypoints.twist(pose[:2, 3], heading, now)
            told = twist or (0.0, 0.0)
            rows.append((now, *pose[:2, 3], heading, waypoints.angle, waypoints.cross_track, *told))
            if twist is None:
                break
            stream.send((told[0], 0.0, told[1]), wait=True)
            # A period need not be whole ticks: what it leaves over is made up for by the next one.
            due = start.tick + round((len(rows) * PERIOD) / tick)
            state = client.clock.step(due - state.stamp.tick).robots[robot]
            keeper.keep(now)
        stream.cancel()
    table = np.array(rows)
    reached = tuple(waypoints.reached)
    return Record(table[:, 0], table[:, 1:4], table[:, 4], table[:, 5], table[:, 6:8], reached, clearance)


def _kept(record: Record) -> str:
    """Return words about the furniture of a room."""
    return "" if record.clearance is None else f", {1e3 * record.clearance:.0f} mm from furniture at least"


def picture(records: dict[str, Record], points: list) -> str:
    """Return an SVG: the ways of all runs on the floor, and of each its errors and commands over time."""
    ways = {"waypoints": np.array([(0.0, 0.0), *points])}
    ways |= {name: record.poses[:, :2] for name, record in records.items()}
    curves = [
        chart(
            record.times,
            [
                Panel(f"{name}: off the line in mm", ("distance",), 1e3 * record.cross_track[:, None]),
                Panel("angle in °", ("to the waypoint",), np.degrees(record.angles)[:, None]),
                Panel("told", ("m/s", "rad/s"), record.twists),
            ],
            record.reached[:-1],
        )
        for name, record in records.items()
    ]
    return stacked(plan(ways), *curves)
