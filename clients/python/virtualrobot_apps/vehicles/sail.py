"""A mission in a kernel: in steps, the vehicle's state is read, its thrusters are told, and time goes on.

`virtualrobot demo auv` shows a BlueROV2 Heavy that follows a path against a current.
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


@dataclass(frozen=True, eq=False)
class Record:
    """Record of a mission, n instants of it.

    times: (n,) simulation time since the start (s). positions: (n, 3) of the base (m). cross_track: (n,) distance from
    the path (m), NaN where a step has none. speeds: (n,) over ground (m/s). done: the mission came to its end.
    """

    times: Floats
    positions: Floats
    cross_track: Floats
    speeds: Floats
    done: bool

    def numbers(self) -> tuple[float, float]:
        """Return root mean square and greatest of the distances from the path (m)."""
        off = self.cross_track[np.isfinite(self.cross_track)]
        return float(np.sqrt(np.mean(off**2))), float(off.max())


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
    print("The document tells no number: its figure 8 has a path that differs by currents and thrusters' dynamics.")
    if plot is not None:
        plot.write_text(picture(record), "utf-8")
        print(f"picture in {plot}", flush=True)
    return record


def build(client: Client, vehicle: VehicleFile, steps: Sequence[Step], current: Sequence[float] = CURRENT) -> None:
    """Replace the world by the vehicle, at the beginning of its first path, and the paths as lines."""
    paths = [step.path for step in steps if isinstance(step, Follow)]
    start = paths[0].points[0] if paths else np.array([0.0, 0.0, -2.0])
    client.scene.clear()
    client.load_robot(f"model://{VEHICLE}", name=ROBOT, pose=virtualrobot.pose(*start.tolist()))
    for number, path in enumerate(paths):
        client.scene.add_annotation(f"path_{number}", lines(path.points, color="#d2841f", width=3))
    client.scene.set_craft(ROBOT, "fossen", {"vehicle": vehicle.document}, current=current)
    client.view.set_camera(position=(-4.0, -6.0, 2.0), target=tuple((start + np.array([3.0, 2.0, -0.5])).tolist()))


def sail(client: Client, vehicle: VehicleFile, mission: Mission, seconds: float = 300.0, pace: float = 0.0) -> Record:
    """Run a mission in steps, for `seconds` at most; the clock is stepped, and stands afterwards."""
    client.clock.set_stepped()
    ticks = round(PERIOD / client.clock.read().tick_length)
    autopilot = Autopilot(vehicle)
    rows: list[tuple[float, Floats, float, float]] = []
    keeper, done = Pace(pace), False
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
            state = client.clock.step(ticks).robots[ROBOT]
            keeper.keep(now)
        stream.cancel()
    times, positions, cross_track, speeds = zip(*rows, strict=True)
    return Record(np.array(times), np.array(positions), np.array(cross_track), np.array(speeds), done)


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
