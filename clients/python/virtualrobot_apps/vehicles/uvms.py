"""An underwater vehicle with a manipulator: its arm pushes it about, and keeps its tool in place while it drifts.

`virtualrobot demo uvms` shows a BlueROV2 Heavy with a six-axis arm, first with its thrusters off while the arm reaches
out, then in a current, with the arm stiff and with the arm correcting what the thrusters leave.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import virtualrobot
from virtualrobot import Client
from virtualrobot.robots.values import RobotState
from virtualrobot.stepping import motion_ends

from virtualrobot_apps.chart import Panel, chart
from virtualrobot_apps.pace import Pace
from virtualrobot_apps.vehicles.autopilot import Autopilot
from virtualrobot_apps.vehicles.guidance import Floats, held
from virtualrobot_apps.vehicles.sail import ROBOT, VEHICLE
from virtualrobot_apps.vehicles.tool_keeper import ToolKeeper, apart, carried_along
from virtualrobot_apps.vehicles.vehicle_file import VehicleFile, read

ARM = "arm"
MOUNT = virtualrobot.pose(x=0.22, z=-0.06, pitch=math.pi / 2.0)
"""Pose of the arm in the hull's frame: its column points ahead."""
FOLDED = {"joint_2": 2.8, "joint_3": 1.2}
WORKING = {"joint_2": math.pi / 2.0, "joint_3": 0.0}
"""Postures of the arm; other joints stand as the model has them."""
CURRENT = (-0.08, 0.12, 0.03)
"""Velocity of the water (m/s) from the beginning on, which the autopilot does not know."""
DENSITY = 1000.0 * 13.5 / 13.4
"""Density of water (kg/m^3) in which the vehicle neither rises nor sinks."""
DEPTH = -3.0
SECONDS = 10.0
PERIOD = 0.02
"""Time between two commands (s), in ticks as many as fit."""


@dataclass(frozen=True, eq=False)
class Record:
    """Record of a hold, n instants of it.

    times: (n,) simulation time since the start (s). tool: (n, 2) how far the tool is from its place (m, rad).
    hull: (n,) distance of the vehicle from its place (m).
    """

    times: Floats
    tool: Floats
    hull: Floats

    @property
    def rms(self) -> float:
        """Return the root mean square of the tool's distance from its place (m)."""
        return float(np.sqrt(np.mean(self.tool[:, 0] ** 2)))


def main(client: Client, plot: Path | None = None, pace: float = 0.0, seconds: float = SECONDS) -> dict[str, Record]:
    """Replace the world by a vehicle with an arm, run it with and without correction, and print the numbers.

    `pace` are simulated seconds for each second of the wall clock; 0: as fast as it can be. Returns the runs by name.
    """
    vehicle = read(VEHICLE)
    build(client, vehicle, FOLDED)
    way, angle = reach_out(client, pace)
    print(
        f"BlueROV2 Heavy with an arm of 2.2 kg, a current of {math.hypot(*CURRENT):.2f} m/s against its station",
        flush=True,
    )
    turned = f"{1e3 * way:.0f} mm and {math.degrees(angle):.1f} deg"
    print(f"{'arm reaches out':24} the vehicle, left alone, gives way by {turned}")
    records: dict[str, Record] = {}
    for name in ("stiff", "corrects"):
        build(client, vehicle, WORKING, CURRENT)
        record = records[name] = hold(client, vehicle, name == "corrects", seconds, pace)
        most, turn = record.tool.max(axis=0)
        print(
            f"{'tool held, arm ' + name:24} {1e3 * record.rms:.1f} mm rms, {1e3 * most:.1f} mm and "
            f"{math.degrees(turn):.2f} deg at most; the vehicle {1e3 * record.hull.max():.0f} mm",
            flush=True,
        )
    print(
        "The documents (SimUEP-Robotics, VirtualRobot) tell no number of an arm on a vehicle, nor of a vehicle alone."
    )
    if plot is not None:
        plot.write_text(picture(records), "utf-8")
        print(f"picture in {plot}", flush=True)
    return records


def build(
    client: Client, vehicle: VehicleFile, posture: dict[str, float], current: Sequence[float] = (0.0, 0.0, 0.0)
) -> None:
    """Replace the world by the vehicle with its arm in a posture, in water that flows from now on."""
    client.clock.set_stepped()
    client.scene.clear()
    client.load_robot(f"model://{VEHICLE}", name=ROBOT, pose=virtualrobot.pose(z=DEPTH))
    arm = client.load_robot("model://ar_manipulator", name=ARM, parent=f"{ROBOT}.hull", pose=MOUNT)
    arm.set_positions(posture)
    settings = {"vehicle": vehicle.document}
    client.scene.set_craft(ROBOT, "fossen", settings, current=current, density=DENSITY, surface=0.0)
    client.view.set_camera(position=(1.2, -2.0, DEPTH + 0.8), target=(0.3, 0.0, DEPTH))


def reach_out(client: Client, pace: float = 0.0) -> tuple[float, float]:
    """Move the arm to its working posture, thrusters off; return how far the vehicle goes (m) and turns (rad)."""
    keeper = Pace(pace)
    before = client.clock.step(1).robots[ROBOT]
    motion = client.robot(ARM).move_joints(WORKING, speed_factor=0.5, wait=False)
    state = before
    while not motion.phase.ended:
        state = client.clock.step(10, until=[motion_ends(motion)]).robots[ROBOT]
        keeper.keep(state.stamp.simulation_time - before.stamp.simulation_time)
    gone = apart(before.world_t_tcp, state.world_t_tcp)
    return float(np.linalg.norm(gone[:3])), float(np.linalg.norm(gone[3:]))


def hold(client: Client, vehicle: VehicleFile, corrects: bool, seconds: float = SECONDS, pace: float = 0.0) -> Record:
    """Keep vehicle and tool where they are, in steps; the arm moves only where it `corrects`."""
    ticks = max(1, round(PERIOD / client.clock.read().tick_length))
    arm, autopilot, pacer = client.robot(ARM), Autopilot(vehicle), Pace(pace)
    law = ToolKeeper(np.array([limits.velocity for limits in arm.limits.values()]))
    robots = client.clock.step(1).robots
    place, wanted = robots[ROBOT].world_t_tcp[:3, 3].copy(), robots[ARM].world_t_tcp.copy()
    heading = _heading(robots[ROBOT])
    start = before = robots[ROBOT].stamp.simulation_time
    rows: list[tuple[float, ...]] = []
    while True:
        hull, tool = robots[ROBOT], robots[ARM].world_t_tcp
        now = hull.stamp.simulation_time
        error, position, rotation = apart(tool, wanted), hull.world_t_tcp[:3, 3], hull.world_t_tcp[:3, :3]
        off = np.linalg.norm(error[:3]), np.linalg.norm(error[3:]), np.linalg.norm(position - place)
        rows.append((now - start, *map(float, off)))
        if now - start >= seconds:
            break
        # The base's velocities are along the axes of the joint's frame, the world's here; it turns about its own.
        velocity, turning = hull.velocities[:3], hull.velocities[3:6]
        twist = np.concatenate([rotation.T @ velocity, turning])
        speeds = autopilot.speeds(held(place, position, heading), rotation, twist, now - before)
        told = {ROBOT: dict(zip(vehicle.thrusters.names, speeds.tolist(), strict=True))}
        if corrects:
            jacobian = arm.solve_jacobian()
            along = carried_along(tool[:3, 3], position, velocity, rotation @ turning)
            rates = law.rates(jacobian.tcp, error, along)
            told[ARM] = dict(zip(jacobian.joint_names, rates.tolist(), strict=True))
        before = now
        robots = client.clock.step(ticks, velocities=told).robots
        pacer.keep(now - start)
    client.stop()
    table = np.array(rows)
    return Record(table[:, 0], table[:, 1:3], table[:, 3])


def picture(records: dict[str, Record]) -> str:
    """Return an SVG of how far the tool and the vehicle are from their places over time."""
    runs = list(records.values())
    count = min(len(record.times) for record in runs)

    def curves(values: Sequence[Floats]) -> Floats:
        return 1e3 * np.column_stack([one[:count] for one in values])

    return chart(
        runs[0].times[:count],
        [
            Panel("tool off its place in mm", tuple(records), curves([record.tool[:, 0] for record in runs])),
            Panel("vehicle off its place in mm", tuple(records), curves([record.hull for record in runs])),
        ],
    )


def _heading(state: RobotState) -> float:
    return math.atan2(state.world_t_tcp[1, 0], state.world_t_tcp[0, 0])
