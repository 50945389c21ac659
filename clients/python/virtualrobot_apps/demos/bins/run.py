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
from virtualrobot_apps.seeing.grasping.heights import (
    APART,
    CELL,
    KEPT,
    SHALLOWEST,
    Floats,
    FromAbove,
    Heights,
    grasps_from_above,
)

SPACING, BELT_SPEED = 0.12, 0.4
"""Way (m) from one box on the belt to the next, and speed of the belt (m/s)."""
CLEAR, DROP = 0.16, 0.07
"""Heights (m) over a grasp at which boxes pass the walls, and over the bin's bottom at which they are let go."""
SETTLING = 750
"""Ticks after the last box has fallen: those that lie above the rim at first slide down."""
CLOSED = 0.006
"""Width (m) to which fingers close, and by how much more they are apart where something is between them."""
STIRS, STIRRED, SPREAD = 3, 0.06, 0.02
"""Number of times that boxes which leave fingers no room are pushed apart, how far, and the room for fingers (m)."""
PUSHED = 0.004
"""Distance (m) by which fingers push walls and boxes aside where no other grasp is left."""
TRIES = 3
"""Number of tries for each box, taken together."""
INSIDE, OUTSIDE = (np.array(cell.FROM) + np.outer([-half, half], [1.0, 1.0]) for half in cell.HALVES)
"""Corners of the first bin, within its walls and with them."""
BOTTOM = cell.TOP + cell.WALL


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
    for _ in range(TRIES * count):
        if not (found := seen(client)) and not (found := stirred(client, keeper)):
            break
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


def look(client: Client) -> Heights:
    """Return the map of heights of the first bin, as the scanner sees it now."""
    reading = client.sensors[cell.SCANNER].read(points=True, frame="world").range
    assert reading.points is not None
    return Heights.of(reading.points[reading.valid].astype(np.float64), *OUTSIDE)


def seen(client: Client) -> list[FromAbove]:
    """Return grasps of what the scanner sees in the first bin, the best first."""
    heights = look(client)
    free = grasps_from_above(heights, cell.JAW, BOTTOM, *INSIDE)
    return free or grasps_from_above(heights, cell.JAW, BOTTOM, *INSIDE, clear=-PUSHED)


def stirred(client: Client, keeper: Pace) -> list[FromAbove]:
    """Push what leaves fingers no room apart; return grasps of it then, none where the bin is empty."""
    arm, found = client.robot(cell.ARM), list[FromAbove]()
    hand = arm.tool()

    def run(motion: Motion) -> None:
        keeper.keep(client.clock.run(motion).stamp.simulation_time)

    for _ in range(STIRS):
        way = push(look(client))
        if found or way is None:
            break
        run(hand.move_to_width(CLOSED, wait=False))
        try:
            run(arm.move_pose(above(way[0]), wait=False))
            for pose in (*way, above(way[1])):
                run(arm.move_linear(pose, wait=False))
        except VirtualRobotError as error:
            print(f"pushing at {np.round(way[0][:3, 3], 3)}: {error}", flush=True)
        run(hand.move_to_width(cell.JAW.opening, wait=False))
        run(arm.move_pose(above(at(np.array(cell.TO))), wait=False))
        found = seen(client)
    return found


def push(heights: Heights) -> tuple[Floats, Floats] | None:
    """Return poses of the tool before and after a push, from the free place that is nearest to what lies there.

    The way leads through the middle of that; None where nothing lies there, or no place is free.
    """
    rows, columns = np.indices(heights.heights.shape)
    places = heights.low + (np.stack([columns, rows], axis=-1) + 0.5) * CELL
    # Beside walls, cells have echoes of these.
    beside, inside = (
        ((places > INSIDE[0] + off) & (places < INSIDE[1] - off)).all(axis=-1) for off in (2.0 * CELL, SPREAD)
    )
    taken = places[beside & (heights.heights > BOTTOM + SHALLOWEST)]
    if not len(taken):
        return None
    middle = taken.mean(axis=0)
    free = places[inside]
    free = free[[bool(np.hypot(*(taken - place).T).min() > SPREAD) for place in free]]
    if not len(free):
        return None
    start = free[np.hypot(*(free - middle).T).argmin()]
    end = start + (middle - start) * (STIRRED / max(float(np.hypot(*(middle - start))), CELL))
    return at(start), at(np.clip(end, INSIDE[0] + SPREAD, INSIDE[1] - SPREAD))


def at(place: Floats) -> Floats:
    """Return the pose of the tool that looks down at a place (2,) of the bin, tips just above its bottom."""
    pose = virtualrobot.pose(float(place[0]), float(place[1]), BOTTOM + KEPT + cell.JAW.tip)
    pose[:3, :3] = np.diag([-1.0, 1.0, -1.0])
    return pose


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
