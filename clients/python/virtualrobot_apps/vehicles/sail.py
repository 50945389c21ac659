"""A mission in a kernel: in steps, the vehicle's state is read, its thrusters are told, and time goes on.

`virtualrobot demo auv` shows a BlueROV2 Heavy that follows a path against a current, with an echo sounder below and a
multibeam sonar ahead.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath

import numpy as np
import virtualrobot
from virtualrobot import Client
from virtualrobot.scene.figures import lines

from virtualrobot_apps.chart import Panel, chart
from virtualrobot_apps.pace import Pace
from virtualrobot_apps.vehicles.autopilot import Autopilot
from virtualrobot_apps.vehicles.guidance import Floats
from virtualrobot_apps.vehicles.mission import Follow, Mission, Step, read_mission
from virtualrobot_apps.vehicles.vehicle_file import VehicleFile, read

ROBOT = "rov"
VEHICLE = "bluerov2_heavy"
CURRENT = (0.1, -0.25, 0.0)
"""Velocity of the water (m/s) in the demo."""
PERIOD = 0.04
"""Time between two commands (s), in ticks as many as fit."""
MISSION = FilePath(__file__).parent / "mission.yaml"
BOTTOM = -5.0
"""Height of the bottom (m)."""
PILES = ((9.0, 0.6), (8.5, 3.5), (-2.5, 4.5))
"""Places of piles that stand there (m), RADIUS thick."""
RADIUS = 0.25
ALTIMETER, SONAR = f"{ROBOT}.altimeter", f"{ROBOT}.sonar"
SOUNDER_HEIGHT = -0.2
"""Height of the echo sounder in the vehicle's frame (m)."""
PING_SECONDS = 0.5
"""Time between two pings of the sonars (s), in periods as many as fit."""


@dataclass(frozen=True, eq=False)
class Record:
    """Record of a mission, n instants of it.

    times: (n,) simulation time since the start (s). positions: (n, 3) of the base (m). cross_track: (n,) distance from
    the path (m), NaN where a step has none. speeds: (n,) over ground (m/s). done: the mission came to its end.
    heights: (m, 2) over the bottom by the echo sounder, NaN without an echo, and truly (m). nearest: the least distance
    that the sonar ahead has told (m), inf where it heard nothing.
    """

    times: Floats
    positions: Floats
    cross_track: Floats
    speeds: Floats
    done: bool
    heights: Floats
    nearest: float

    def numbers(self) -> tuple[float, float]:
        """Return root mean square and greatest of the distances from the path (m)."""
        off = self.cross_track[np.isfinite(self.cross_track)]
        return float(np.sqrt(np.mean(off**2))), float(off.max())

    def sounding(self) -> float:
        """Return the root mean square of the echo sounder's errors (m)."""
        return float(np.sqrt(np.nanmean((self.heights[:, 0] - self.heights[:, 1]) ** 2)))


def main(client: Client, file: FilePath | None = None, plot: FilePath | None = None, pace: float = 0.0) -> Record:
    """Replace the world by a vehicle under water, run a mission there, and print its numbers.

    `pace` are simulated seconds for each second of the wall clock; 0: as fast as it can be.
    """
    steps = read_mission(MISSION if file is None else file)
    vehicle = read(VEHICLE)
    build(client, vehicle, steps)
    print(f"BlueROV2 Heavy, a current of {math.hypot(*CURRENT):.2f} m/s across its path", flush=True)
    record = sail(client, vehicle, Mission(steps), pace=pace)
    rms, most = record.numbers()
    print(f"{'mission':22} {'done' if record.done else 'not done'} in {record.times[-1]:.1f} s of simulation time")
    print(f"{'off the path':22} {rms:.3f} m rms, {most:.3f} m at most")
    print(
        f"{'speed over ground':22} {np.median(record.speeds):.2f} m/s in the middle, {record.speeds.max():.2f} at most"
    )
    if len(heard := record.heights[np.isfinite(record.heights[:, 0]), 0]):
        off = f"{1e3 * record.sounding():.0f} mm rms off"
        print(f"{'over the bottom':22} {heard.min():.2f} to {heard.max():.2f} m by the echo sounder, {off}")
    print(f"{'piles':22} as near as {record.nearest:.2f} m by the sonar ahead")
    print("The document tells no number: its figure 8 has a path that differs by currents and thrusters' dynamics.")
    if plot is not None:
        plot.write_text(picture(record), "utf-8")
        print(f"picture in {plot}", flush=True)
    return record


def build(client: Client, vehicle: VehicleFile, steps: Sequence[Step], current: Sequence[float] = CURRENT) -> None:
    """Replace the world by the vehicle with its sonars, at the beginning of its first path, bottom, piles and paths."""
    paths = [step.path for step in steps if isinstance(step, Follow)]
    start = paths[0].points[0] if paths else np.array([0.0, 0.0, -2.0])
    client.scene.clear()
    client.load_robot(f"model://{VEHICLE}", name=ROBOT, pose=virtualrobot.pose(*start.tolist()))
    for number, path in enumerate(paths):
        client.scene.add_annotation(f"path_{number}", lines(path.points, color="#d2841f", width=3))
    client.scene.add_object(
        "bottom", virtualrobot.box(40.0, 40.0, 0.2, color="#8a7a5c"), pose=virtualrobot.pose(z=BOTTOM - 0.1)
    )
    for number, (x, y) in enumerate(PILES):
        pile = virtualrobot.cylinder(RADIUS, -BOTTOM, color="#6b6f73")
        client.scene.add_object(f"pile_{number}", pile, pose=virtualrobot.pose(x, y, 0.5 * BOTTOM))
    hull, down = f"{ROBOT}.hull", virtualrobot.pose(z=SOUNDER_HEIGHT, pitch=math.pi / 2.0)
    client.scene.add_range_sensor(ALTIMETER, virtualrobot.range_sensor("Ping2"), pose=down, parent=hull)
    client.scene.add_range_sensor(
        SONAR, virtualrobot.range_sensor("M750d"), pose=virtualrobot.pose(x=0.25), parent=hull
    )
    client.scene.set_craft(ROBOT, "fossen", {"vehicle": vehicle.document}, current=current)
    client.view.set_camera(position=(-4.0, -6.0, 2.0), target=tuple((start + np.array([3.0, 2.0, -0.5])).tolist()))


def sail(client: Client, vehicle: VehicleFile, mission: Mission, seconds: float = 300.0, pace: float = 0.0) -> Record:
    """Run a mission in steps, for `seconds` at most; the clock is stepped, and stands afterwards."""
    client.clock.set_stepped()
    ticks = round(PERIOD / client.clock.read().tick_length)
    autopilot = Autopilot(vehicle)
    rows: list[tuple[float, Floats, float, float]] = []
    heights: list[tuple[float, float]] = []
    keeper, done, nearest = Pace(pace), False, math.inf
    pings = max(1, round(PING_SECONDS / PERIOD))
    with client.robot(ROBOT).stream("velocity", list(vehicle.thrusters.names), timeout=10.0) as stream:
        before = start = client.clock.simulation_time
        state = client.clock.step(1).robots[ROBOT]
        while (now := state.stamp.simulation_time - start) < seconds:
            pose, rotation = state.world_t_tcp, state.world_t_tcp[:3, :3]
            wanted = mission.wanted(now, pose[:3, 3].copy(), math.atan2(rotation[1, 0], rotation[0, 0]))
            if wanted is None:
                done = True
                break
            rows.append((now, pose[:3, 3].copy(), mission.cross_track, float(np.linalg.norm(state.velocities[:3]))))
            # The base's velocities are along the axes of the joint's frame, which are the world's here, and its turning
            # is about its own.
            twist = np.concatenate([rotation.T @ state.velocities[:3], state.velocities[3:6]])
            elapsed = state.stamp.simulation_time - before
            before = state.stamp.simulation_time
            stream.send(autopilot.speeds(wanted, rotation, twist, elapsed), wait=True)
            seen = client.clock.step(ticks, sensors=[ALTIMETER, SONAR] if len(rows) % pings == 1 else None)
            state = seen.robots[ROBOT]
            if seen.readings:
                below, ahead = seen.readings[ALTIMETER].range, seen.readings[SONAR].range
                heard = float(below.distances[0, 0]) if below.valid.all() else math.nan
                heights.append((heard, float(state.world_t_tcp[2, 3]) + SOUNDER_HEIGHT - BOTTOM))
                nearest = min(nearest, float(ahead.distances[ahead.valid].min(initial=math.inf)))
            keeper.keep(now)
        stream.cancel()
    times, positions, cross_track, speeds = map(np.array, zip(*rows, strict=True))
    return Record(times, positions, cross_track, speeds, done, np.array(heights).reshape(-1, 2), nearest)


def picture(record: Record) -> str:
    """Return an SVG of place, distance from the path and speed over time."""
    return chart(
        record.times,
        [
            Panel("place in m", ("x", "y", "z"), record.positions),
            Panel("off the path in m", ("distance",), np.nan_to_num(record.cross_track)[:, None]),
            Panel("over ground in m/s", ("speed",), record.speeds[:, None]),
        ],
    )
