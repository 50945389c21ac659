"""A tool goes round and round while the links of its arm keep away from a post and from a ball that comes by.

`virtualrobot avoid` runs it: twice, without and with the control law of `law.py`, and draws how far links were
from obstacles and the tool from where it should be, as figures 18 and 19 of the paper do.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import virtualrobot
from numpy.typing import NDArray
from virtualrobot import Client

from virtualrobot_apps.chart import Panel, chart
from virtualrobot_apps.demos.avoidance.control import Gains, Record, Reference, Trajectory, track
from virtualrobot_apps.demos.viewer import show_viewer

Floats = NDArray[np.float64]

ROBOT, POST, BALL = "arm", "post", "ball"
POST_RADIUS, POST_HEIGHT, BALL_RADIUS = 0.05, 1.2, 0.08
CIRCLE_RADIUS, ROUNDS = 0.08, 3
POINTS = 200
"""Number of samples that the picture shows: more would only make it larger."""
TOLD = 0.01
"""A link is in the picture when avoidance has changed its distance by more than this (m)."""


@dataclass(frozen=True, slots=True)
class Cell:
    """An arm and what is in its way.

    Attributes:
        model: the arm's file.
        start: the joint positions that it begins at (rad).
        post: position of the post in the world's frame: x, y (m).
        ball: points (n, 3) that the ball passes at even times.
    """

    model: str
    start: tuple[float, ...]
    post: tuple[float, float]
    ball: tuple[tuple[float, float, float], ...]


CELLS = {
    "iiwa": Cell(
        "package://pybullet_data/kuka_iiwa/model.urdf",
        (0.0, 0.5, 0.0, -1.5, 0.0, 1.1416, 0.0),
        (0.2, 0.36),
        ((-0.4, -0.9, 0.75), (0.2, -0.2, 0.75), (0.25, -0.2, 0.75), (0.6, -0.22, 0.45), (0.9, -0.9, 0.45)),
    ),
    "panda": Cell(
        "package://pybullet_data/franka_panda/panda.urdf",
        (0.0, 0.6, 0.0, -1.5, 0.0, 2.1, 0.785),
        (0.2, 0.36),
        ((-0.5, -0.9, 0.6), (0.2, -0.2, 0.6), (0.25, -0.2, 0.6), (0.6, -0.25, 0.3), (0.9, -0.9, 0.3)),
    ),
}
"""In both the ball comes to the elbow, stays there for a moment, and leaves past the tool."""


def main(
    client: Client,
    cell: str = "iiwa",
    hold: bool = False,
    seconds: float = 12.0,
    file: Path | None = None,
    headless: bool = False,
) -> tuple[Record, Record]:
    """Build the cell, let the arm work without and with avoidance, print how it went, and draw it.

    Args:
        client: of the kernel whose world is replaced.
        cell: one of CELLS.
        hold: the tool stays where it is, instead of going round.
        seconds: duration of each of both, in s of simulation time.
        file: of the picture, an SVG.
        headless: open no browser.
    """
    build(client, CELLS[cell])
    show_viewer(client, headless)
    gains = Gains()
    print("avoidance  least distance   greatest error  error at the end")
    without, by_law = (
        run(client, CELLS[cell], hold, seconds, some, told)
        for some, told in ((replace(gains, alpha=0.0, repulsion=0.0), "without"), (gains, "with"))
    )
    if file is not None:
        file.write_text(picture(without, by_law), "utf-8")
        print(f"picture in {file}", flush=True)
    return without, by_law


def build(client: Client, cell: Cell) -> None:
    """Replace the world by a cell."""
    client.scene.clear()
    client.load_robot(cell.model, name=ROBOT)
    post = virtualrobot.cylinder(POST_RADIUS, POST_HEIGHT, color="#8d99a6")
    client.scene.add_object(POST, post, pose=virtualrobot.pose(*cell.post, POST_HEIGHT / 2))
    client.scene.add_object(BALL, virtualrobot.sphere(BALL_RADIUS, color="#d0463b"))
    client.view.set_camera(position=(1.6, -1.9, 1.5), target=(0.25, 0.0, 0.5))


def run(client: Client, cell: Cell, hold: bool, seconds: float, gains: Gains, told: str) -> Record:
    """Put arm and ball where they begin, lead the tool, and print a line about it."""
    robot, ball = client.robot(ROBOT), client.scene.node(BALL)
    robot.set_positions(dict(zip(robot.chain_joint_names, cell.start, strict=True)))

    def move_ball(time: float) -> None:
        ball.parent_t_node = virtualrobot.pose(*place_of(cell, time / seconds))

    move_ball(0.0)
    trajectory = round_trip(robot.tcp, 0.0 if hold else CIRCLE_RADIUS, seconds)
    record = track(client, robot, trajectory, seconds, gains, move_ball)
    errors = 1000 * np.linalg.norm(record.errors, axis=1)
    least = f"{1000 * record.least.min():11.1f} mm"
    print(f"{told:9} {least:>15} {errors.max():13.2f} mm {errors[-1]:14.2f} mm", flush=True)
    return record


def place_of(cell: Cell, part: float) -> Floats:
    """Return where the ball is (3,) when a part of the time is over, 0 to 1; it rests for a moment at each point."""
    points = np.array(cell.ball)
    along = min(max(part, 0.0), 1.0) * (len(points) - 1)
    first = min(int(along), len(points) - 2)
    s = along - first
    return points[first] + s * s * (3.0 - 2.0 * s) * (points[first + 1] - points[first])


def round_trip(start: Floats, radius: float, seconds: float) -> Trajectory:
    """Return a way round circles in the plane of y and z that begins and ends at rest at a pose (4, 4).

    The tool keeps its orientation; the part of the way that is done is 10 s^3 - 15 s^4 + 6 s^5, s that of the time.
    """

    def trajectory(time: float) -> Reference:
        s = min(max(time / seconds, 0.0), 1.0)
        angle = 2.0 * np.pi * ROUNDS * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        rate = 2.0 * np.pi * ROUNDS * 30.0 * s * s * (1.0 - s) ** 2 / seconds
        pose = start.copy()
        pose[:3, 3] += radius * np.array([0.0, np.sin(angle), 1.0 - np.cos(angle)])
        return Reference(pose, radius * rate * np.array([0.0, np.cos(angle), np.sin(angle)]), np.zeros(3))

    return trajectory


def picture(without: Record, by_law: Record) -> str:
    """Return an SVG over time: the least distance, those of the links that it is about, and the position errors."""
    times = np.linspace(0.0, min(without.times[-1], by_law.times[-1]), POINTS)

    def at_times(record: Record, values: Floats) -> Floats:
        return np.column_stack([np.interp(times, record.times, column) for column in values.T])

    def both(values: Callable[[Record], Floats]) -> Floats:
        return np.column_stack([at_times(record, values(record)[:, None]) for record in (by_law, without)])

    names = ("with avoidance", "without")
    panels = [Panel("least distance, m", names, both(lambda record: record.least))]
    for link in dict.fromkeys((*by_law.links, *without.links)):
        curves = both(partial(Record.of_link, link=link))
        if curves.min() < Gains().eta_0 and np.abs(curves[:, 0] - curves[:, 1]).max() > TOLD:
            panels.append(Panel(f"{link.removeprefix(f'{ROBOT}.').removeprefix('lbr_iiwa_')}, m", names, curves, 75))
    for name, record in zip(("with", "without"), (by_law, without), strict=True):
        errors = 1000.0 * at_times(record, record.errors)
        panels.append(Panel(f"error {name}, mm", [f"{axis} {name}" for axis in "xyz"], errors, 110))
    return chart(times, panels)
