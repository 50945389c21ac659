"""Boxes fall from a conveyor into a bin, and an arm brings them to another one, held by friction alone.

In steps: the same in every run. Where boxes lie a scanner over the bin says, and whether one is held the fingers, which
don't close then; where boxes truly are is asked for counting them.
"""

from __future__ import annotations

import colorsys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import virtualrobot
from virtualrobot import Client, Motion, VirtualRobotError

from virtualrobot_apps.demos.bins import cell
from virtualrobot_apps.pace import Pace
from virtualrobot_apps.seeing.grasping.heights import APART, Floats, FromAbove, Heights, grasps_from_above

SPACING, BELT_SPEED = 0.12, 0.4
"""Way (m) from one box on the belt to the next, and speed of the belt (m/s)."""
CLEAR, DROP = 0.16, 0.07
"""Heights (m) over a grasp at which boxes pass the walls, and over the bin's bottom at which they are let go."""
SETTLING = 750
"""Ticks after the last box has fallen: those that lie above the rim at first slide down."""
CLOSED = 0.006
"""Width (m) to which fingers close, and by how much more they are apart where something is between them."""
PUSHED = 0.004
"""Distance (m) by which fingers push walls and boxes aside where no other grasp is left."""
TRIES = 3
"""Number of tries for each box, taken together."""


@dataclass(frozen=True, slots=True)
class Result:
    """Numbers of a run: boxes, those that fell into the first bin, those that came to the second, and tries.

    seconds: simulation time (s) of each box that was brought.
    """

    boxes: int
    fallen: int
    brought: int
    tries: int
    seconds: tuple[float, ...]


def main(
    client: Client,
    boxes: int = 8,
    seed: int = 1,
    engine: str = "mujoco",
    pace: float = 0.0,
    effort: float = cell.EFFORT,
) -> Result:
    """Replace the world by the cell, let the boxes fall, bring them over, print the numbers, and return them.

    `pace` are simulated seconds for each second of the wall clock; 0: as fast as it can be. `effort` (N) is that of
    the gripper's motor.
    """
    client.clock.set_stepped()
    cell.load(client, engine, effort)
    keeper = Pace(pace)
    print(f"{boxes} boxes of {cell.MASS} kg by {engine}, seed {seed}; the gripper's motor has {effort:g} N", flush=True)
    names = list(feed(client, boxes, np.random.default_rng(seed), keeper))
    fallen = [name for name in names if cell.holds(cell.FROM, place(client, name))]
    print(f"in the first bin         {len(fallen)} of {boxes}", flush=True)
    result = bring(client, names, len(fallen), keeper)
    mean = f", {np.mean(result.seconds):.1f} s each" if result.seconds else ""
    print(f"brought to the second    {result.brought} of {len(fallen)} in {result.tries} tries{mean}", flush=True)
    least = cell.MASS * 9.81 / cell.FRICTION
    print(f"effort that friction needs by m g / mu: {least:.2f} N", flush=True)
    return result


def feed(client: Client, boxes: int, rng: np.random.Generator, keeper: Pace) -> Iterator[str]:
    """Let boxes ride on the belt and fall from its end, and yield their names as they do."""
    belt, rides = client.robot(cell.CONVEYOR), {}
    for at in range(boxes):
        name = f"box_{at + 1}"
        where = virtualrobot.pose(cell.BELT_LENGTH - 0.1 - at * SPACING, rng.uniform(-0.06, 0.06), 0.5 * cell.EDGE)
        where[:3, :3] = virtualrobot.pose(yaw=rng.uniform(-np.pi, np.pi))[:3, :3]
        color = colorsys.hls_to_rgb(at / boxes, 0.55, 0.6)
        figure = virtualrobot.box(cell.EDGE, cell.EDGE, cell.EDGE, color=color).with_surface(friction=cell.FRICTION)
        parent = f"{cell.CONVEYOR}.belt"
        client.scene.add_part(name, figure, pose=where, parent=parent, mass=cell.MASS, dynamic=True)
        rides[name] = where[0, 3]
    length = boxes * SPACING + 0.2
    motion = belt.move_joints([belt.positions[0] + length], wait=False, speed_factor=BELT_SPEED / 0.5)
    begin = belt.positions[0]
    while not motion.state.phase.ended:
        keeper.keep(client.clock.step(5).stamp.simulation_time)
        for name, start in list(rides.items()):
            if start + belt.positions[0] - begin > cell.BELT_LENGTH:
                client.scene.attach(name, "world")
                del rides[name]
                yield name
    client.clock.step(SETTLING)


def bring(client: Client, names: Sequence[str], count: int, keeper: Pace) -> Result:
    """Take boxes out of the first bin until the scanner sees none that can be gripped, or tries are over."""
    failed, times = list[Floats](), list[float]()
    begun = client.clock.read().stamp.simulation_time
    while len(failed) + len(times) < TRIES * count and (found := seen(client)):
        # What has failed at a place before comes after all else.
        grasp = min(found, key=lambda one: sum(np.linalg.norm(one.pose[:3, 3] - at) < APART for at in failed))
        held = take(client, grasp, drop_pose(len(times), grasp), keeper)
        now = client.clock.read().stamp.simulation_time
        if held:
            times.append(now - begun)
        else:
            failed.append(grasp.pose[:3, 3])
        begun = now
    brought = sum(cell.holds(cell.TO, place(client, name)) for name in names)
    return Result(len(names), count, brought, len(failed) + len(times), tuple(times))


def seen(client: Client) -> list[FromAbove]:
    """Return grasps of what the scanner sees in the first bin, the best first."""
    reading = client.sensors[cell.SCANNER].read(points=True, frame="world").range
    assert reading.points is not None
    points = reading.points[reading.valid].astype(np.float64)
    inside, outside = (np.array(cell.FROM) + np.outer([-half, half], [1.0, 1.0]) for half in cell.HALVES)
    heights, bottom = Heights.of(points, *outside), cell.TOP + cell.WALL
    free = grasps_from_above(heights, cell.JAW, bottom, *inside)
    return free or grasps_from_above(heights, cell.JAW, bottom, *inside, clear=-PUSHED)


def take(client: Client, grasp: FromAbove, put: Floats, keeper: Pace) -> bool:
    """Take what is at a grasp and let it go at a pose of the tool (4, 4); return whether the fingers held something.

    The arm ends where it is out of the scanner's view.
    """
    arm = client.robot(cell.ARM)
    hand = arm.tool()

    def run(motion: Motion) -> None:
        keeper.keep(client.clock.run(motion).stamp.simulation_time)

    held = False
    try:
        run(arm.move_pose(above(grasp.pose), wait=False))
        run(arm.move_linear(grasp.pose, wait=False))
        run(hand.move_to_width(CLOSED, wait=False))
        run(arm.move_linear(above(grasp.pose), wait=False))
        held = holding(client)
        run(arm.move_pose(above(put), wait=False))
        held = held and holding(client)
        if held:
            run(arm.move_linear(put, wait=False))
    except VirtualRobotError as error:
        print(f"at {np.round(grasp.pose[:3, 3], 3)}: {error}", flush=True)
    run(hand.move_to_width(cell.JAW.opening, wait=False))
    if held:
        run(arm.move_linear(above(put), wait=False))
    return held


def holding(client: Client) -> bool:
    """Return whether fingers that were told to close are apart."""
    return bool(2.0 * client.robot(cell.HAND).positions[0] > 2.0 * CLOSED)


def above(world_t_tcp: Floats) -> Floats:
    """Return a pose straight above another one, over the walls."""
    return virtualrobot.pose(z=CLEAR) @ world_t_tcp


def drop_pose(count: int, grasp: FromAbove) -> Floats:
    """Return where the tool lets the next box go: place after place on a grid of the second bin."""
    column, row = count % 3 - 1, count // 3 % 3 - 1
    pose = grasp.pose.copy()
    pose[:3, 3] = cell.TO[0] + 0.075 * column, cell.TO[1] + 0.075 * row, cell.TOP + DROP + 0.045 * (count // 9)
    return pose


def place(client: Client, name: str) -> Floats:
    """Return where a node is in the world (3,)."""
    return np.asarray(client.scene.pose(name))[:3, 3]
