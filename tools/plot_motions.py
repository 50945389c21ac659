"""Writes the pictures of docs/motion-profiles.md: what each kind of motion does, as the running kernel plans it.

Usage: python tools/plot_motions.py docs/pictures
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
import virtualrobot
from numpy.typing import NDArray
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.motions.moves import Move
from virtualrobot.motions.plans import MotionPlan, RobotTrajectory
from virtualrobot.motions.program import Program
from virtualrobot_apps.chart import Panel, chart

IIWA, PANDA = "package://pybullet_data/kuka_iiwa/model.urdf", "package://pybullet_data/franka_panda/panda.urdf"
READY, THERE = (0.3, 0.6, -0.2, -1.4, 0.1, 0.9, 0.2), (1.5, 0.2, 0.4, -0.6, 0.8, 0.3, -0.5)
POINTS = 160
"""How many samples a picture shows: more would only make it larger."""

FINGER = "panda_finger_joint1"
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Cell:
    """The robots that move; nothing of it changes between two pictures."""

    client: virtualrobot.Client
    iiwa: virtualrobot.Robot
    panda: virtualrobot.Robot

    def lifted(self, *by: float) -> Floats:
        """Return where the iiwa's flange is, moved by x, y, z meters in the world."""
        pose = self.iiwa.tcp
        pose[:3, 3] += by
        return pose


@dataclass(frozen=True, eq=False)
class Drawing:
    """Panels over times (n,) in s, and times that are marked."""

    times: Floats
    panels: list[Panel]
    marks: tuple[float, ...] = ()


Profile = Callable[[Cell], Drawing]


def joint_panel(told: RobotTrajectory, of: str = "velocity") -> Panel:
    """Return the velocities (or accelerations) of the joints that move."""
    values, unit = (told.velocities, "rad/s") if of == "velocity" else (told.accelerations, "rad/s²")
    moving = np.flatnonzero(np.abs(told.velocities).max(axis=0) > 1e-3)
    names = [told.joint_names[column].removeprefix("lbr_iiwa_").removeprefix("panda_") for column in moving]
    return Panel(f"{of}, {unit}", names, values[:, moving])


def tool_panel(plan: MotionPlan) -> Panel:
    """Return the speeds of the tool centre points."""
    speeds = np.stack([told.tcp_speeds for told in plan.robots.values()], axis=1)
    return Panel("TCP speed, m/s", list(plan.robots) if len(plan.robots) > 1 else ["TCP"], speeds)


def usual(plan: MotionPlan) -> list[Panel]:
    """Return the velocities of the joints of the first robot, and the speeds of the tool centre points."""
    return [joint_panel(next(iter(plan.robots.values()))), tool_panel(plan)]


def with_accelerations(plan: MotionPlan) -> list[Panel]:
    """Return velocities and accelerations of the joints."""
    told = next(iter(plan.robots.values()))
    return [joint_panel(told), joint_panel(told, "acceleration")]


def fingers(plan: MotionPlan) -> list[Panel]:
    """Return positions and velocities of fingers."""
    told = plan.robots["panda"]
    names = [name.removeprefix("panda_") for name in told.joint_names]
    return [Panel("position, m", names, told.positions), Panel("velocity, m/s", names, told.velocities)]


def samples(cell: Cell) -> list[Move]:
    """Return a trajectory of the iiwa's first and fourth joint: a cosine and back, 40 samples in 4 s."""
    times = np.linspace(0.0, 4.0, 41)
    wave = 0.5 - 0.5 * np.cos(np.pi * times / 2.0)
    positions = np.array(READY)[[0, 3]] + wave[:, None] * (0.8, 0.5)
    return [cell.iiwa.trajectory(times, positions, joints=["lbr_iiwa_joint_1", "lbr_iiwa_joint_4"])]


def corners(cell: Cell, zone: float) -> Program:
    """Return a program along three sides of a square of 20 cm, its corners rounded off."""
    program = cell.client.program()
    for step, by in enumerate(((0.0, 0.2, 0.0), (0.0, 0.2, 0.2), (0.0, 0.0, 0.2))):
        program.move(cell.iiwa.linear(cell.lifted(*by)), zone=zone if step < 2 else None)
    return program


def search(cell: Cell) -> Drawing:
    """Return a line that a signal ends, as it was run: the signal comes after 0.7 s, where the dashed line is."""
    client, at = cell.client, 0.7
    client.signals["touch"] = False
    line = cell.iiwa.linear(cell.lifted(0.0, 0.3, -0.1), until="touch")
    motion = cell.iiwa.start(line, wait=False, on_disconnect="continue")
    times, places = [0.0], [cell.iiwa.tcp[:3, 3]]
    while not motion.phase.ended:
        seen = client.clock.step()
        times.append(times[-1] + client.clock.read().tick_length)
        places.append(seen.robots["iiwa"].world_t_tcp[:3, 3])
        if abs(times[-1] - at) < 1e-9:
            client.signals["touch"] = True
    rates = np.linalg.norm(np.gradient(np.array(places), times, axis=0), axis=1)
    cell.iiwa.set_positions(READY)
    return Drawing(np.array(times), [Panel("TCP speed, m/s", ["TCP"], rates[:, None])], (at,))


def tracking(cell: Cell) -> Drawing:
    """Return a line down to a belt that runs at 0.1 m/s in y, and up again, as it was run."""
    client, tick = cell.client, cell.client.clock.read().tick_length
    x, y, _ = cell.iiwa.tcp[:3, 3]
    base = virtualrobot.pose(x, y - 0.7, 0.0, yaw=np.pi / 2)
    conveyor = client.load_robot("model://conveyor", name="conveyor", pose=base)
    conveyor.move_joints({"belt": 100.0}, speed_factor=0.2, wait=False, on_disconnect="continue")
    client.clock.step(250)
    belt = "conveyor.belt"
    belt_t_world = np.linalg.inv(client.scene.node(belt).pose)
    program = client.program()
    for height in (-0.08, 0.0):
        program.move(cell.iiwa.linear(belt_t_world @ cell.lifted(0.0, 0.0, height), reference=belt))
    along = virtualrobot.Tracking(belt, window=0.35, max_velocity=0.12)
    motion = program.start(wait=False, on_disconnect="continue", tracking=along)
    rows = [(0.0, cell.iiwa.tcp[1, 3], cell.iiwa.tcp[2, 3], 0.1)]
    while not motion.phase.ended:
        robots = client.clock.step().robots
        place = robots["iiwa"].world_t_tcp[:3, 3]
        rows.append((len(rows) * tick, place[1], place[2], float(robots["conveyor"].velocities[0])))
    times, along_belt, height, speed = np.array(rows).T
    speeds = np.stack([speed, np.gradient(along_belt, times)], axis=1)
    conveyor.stop()
    while client.clock.step().robots["conveyor"].motion_ids:
        pass
    client.scene.remove("conveyor")
    cell.iiwa.set_positions(READY)
    panels = [Panel("along the belt, m/s", ["belt", "TCP"], speeds), Panel("height, m", ["TCP"], height[:, None])]
    return Drawing(times, panels)


def stream(cell: Cell) -> Drawing:
    """Return a joint that follows velocities, as it was run: 0.8, -0.4 and 0 rad/s."""
    joint, tick = "lbr_iiwa_joint_1", cell.client.clock.read().tick_length
    rows: list[tuple[float, float, float]] = []

    def run(wanted: float, ticks: int) -> None:
        for _ in range(ticks):
            velocity = float(cell.client.clock.step().robots["iiwa"].velocities[0])
            rows.append((len(rows) * tick, wanted, velocity))

    setpoints = cell.iiwa.stream("velocity", [joint], timeout=1.0)
    for wanted, ticks in ((0.8, 125), (-0.4, 125), (0.0, 60)):
        setpoints.send([wanted], wait=True)
        run(wanted, ticks)
    cell.iiwa.stop()  # to close the stream well would wait for ticks that only this program makes
    while cell.client.clock.step().robots["iiwa"].motion_ids:
        pass
    setpoints.cancel()
    table = np.array(rows)
    cell.iiwa.set_positions(READY)
    return Drawing(table[:, 0], [Panel("velocity, rad/s", ["setpoint", "joint_1"], table[:, 1:])])


def planned(
    wishes: Callable[[Cell], Iterable[Move] | Program], panels: Callable[[MotionPlan], list[Panel]] = usual
) -> Profile:
    """Return the profile of a motion as PlanMotion tells it, with a line where each step of a program begins."""

    def drawing(cell: Cell) -> Drawing:
        wanted = wishes(cell)
        plan = wanted.plan() if isinstance(wanted, Program) else cell.client.plan(wanted)
        for note in plan.notes:
            click.echo(f"  {note.message}")
        begins = tuple(float(plan.times[row]) for row in np.flatnonzero(np.diff(plan.steps)) + 1)
        return Drawing(plan.times, panels(plan), begins)

    return drawing


PROFILES: dict[str, Profile] = {
    "point_to_point": planned(lambda cell: [cell.iiwa.ptp(THERE)], with_accelerations),
    "time_optimal": planned(lambda cell: [cell.iiwa.ptp(THERE, time_law="time_optimal")], with_accelerations),
    "linear": planned(lambda cell: [cell.iiwa.linear(cell.lifted(0.0, 0.3, -0.1))]),
    "circular": planned(
        lambda cell: [cell.iiwa.circular(cell.lifted(0.0, 0.1, 0.1)[:3, 3], cell.lifted(0.0, 0.2, 0.0))]
    ),
    "spline": planned(
        lambda cell: [cell.iiwa.spline([cell.lifted(0.0, 0.08 * k, 0.06 * (-1) ** k) for k in range(1, 5)])]
    ),
    "joint_trajectory": planned(samples),
    "joint_jog": planned(lambda cell: [cell.iiwa.joint_jog("lbr_iiwa_joint_1", 0.5, 1.0)], with_accelerations),
    "cartesian_jog": planned(lambda cell: [cell.iiwa.cartesian_jog((0.0, 1.0, 0.0), velocity=0.2, distance=0.25)]),
    "tool_state": planned(lambda cell: [cell.panda.tool("hand").state_move("open")], fingers),
    "group": planned(
        lambda cell: [
            cell.iiwa.linear(cell.lifted(0.0, 0.3, -0.1)),
            cell.panda.ptp({"panda_joint1": 0.8, "panda_joint4": -1.2}),
        ],
        lambda plan: [joint_panel(plan.robots["iiwa"]), joint_panel(plan.robots["panda"]), tool_panel(plan)],
    ),
    "program": planned(lambda cell: corners(cell, 0.05)),
    "search": search,
    "stream": stream,
    "tracking": tracking,
}
"""The pictures by their names in the page; those of moves are the fields of the contract's `Move`."""


def made(client: virtualrobot.Client) -> Cell:
    """Load the robots and put them where all motions start; time goes on by steps."""
    client.clock.set_stepped()
    client.signals.create("touch")
    iiwa = client.load_robot(IIWA, name="iiwa")
    iiwa.set_positions(READY)
    panda = client.load_robot(PANDA, name="panda", pose=virtualrobot.pose(y=-1.0))
    panda.set_positions({"panda_joint2": -0.3, "panda_joint4": -2.0, "panda_joint6": 1.7})
    states = {"closed": {FINGER: 0.0}, "open": {FINGER: 0.04}}
    client.scene.add_tool("hand", panda.flange, states=states)
    return Cell(client, iiwa, panda)


def thinned(drawing: Drawing) -> str:
    """Return a drawing as SVG."""
    rows = np.unique(np.linspace(0, len(drawing.times) - 1, POINTS).astype(int))
    panels = [Panel(panel.label, panel.names, panel.curves[rows], panel.height) for panel in drawing.panels]
    return chart(drawing.times[rows], panels, drawing.marks)


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False, exists=True))
def main(folder: Path) -> None:
    """Write a picture of each kind of motion to FOLDER: motion-NAME.svg."""
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        cell = made(client)
        for name, profile in PROFILES.items():
            drawing = profile(cell)
            text = thinned(drawing)
            (folder / f"motion-{name}.svg").write_text(text, "utf-8")
            click.echo(f"{name}: {drawing.times[-1]:.3f} s, {len(text) / 1024:.0f} kB")


if __name__ == "__main__":
    main()
