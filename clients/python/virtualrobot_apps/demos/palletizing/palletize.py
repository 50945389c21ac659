"""A cell that palletizes: a conveyor brings boxes, an iiwa and a Panda build two pallets. `virtualrobot demo` runs it.

Three programs run at the same time and talk by signals, as in a real cell: the conveyor says `box_at_iiwa` and
waits until the arm has taken the box away, the arm says `pallet_full_iiwa` at its end; likewise for the Panda.
"""

from __future__ import annotations

import queue
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext, suppress
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client, pose

from virtualrobot_apps.demos.palletizing import cell
from virtualrobot_apps.demos.palletizing.cell import STATIONS, Station
from virtualrobot_apps.demos.palletizing.film import filmed
from virtualrobot_apps.demos.viewer import show_viewer

PITCH = 0.5  # meters that the belt moves at a time
COLUMNS, ROWS = 2, 3  # of boxes in a layer


def pattern(station: Station, layers: int) -> Iterator[NDArray[np.float64]]:
    """Yield `pallet_t_box` in order; every second layer is turned by a right angle, so that the stack holds."""
    length, width, height = station.box
    for layer in range(layers):
        for column in range(COLUMNS):
            for row in range(ROWS):
                x = (column - (COLUMNS - 1) / 2) * (length + station.gap)
                y = (row - (ROWS - 1) / 2) * (width + station.gap)
                yield pose(yaw=layer % 2 * np.pi / 2) @ pose(x, y, (layer + 0.5) * height)


def main(client: Client, loop: bool = False, headless: bool = False, layers: int = 3, film: Path | None = None) -> None:
    """Build the cell, fill both pallets and print how it went; with `loop` again and again, until interrupted.

    `film` is the file of a film of it all, .mp4 or .gif; where its pictures are drawn too slowly, time goes slower.
    """
    cell.load(client)
    show_viewer(client, headless)
    with nullcontext() if film is None else filmed(client, film):
        run(client, layers)
        while loop:
            cell.load(client)
            run(client, layers)
    if film is not None:
        print(f"film in {film}", flush=True)


def run(client: Client, layers: int) -> None:
    """Let conveyor and arms work until both pallets are full; print each box, and a table at the end."""
    count = COLUMNS * ROWS * layers
    placed: queue.Queue[tuple[str, float]] = queue.Queue()
    cycles: dict[str, list[float]] = {station.robot: [] for station in STATIONS}
    start = now(client)
    with ThreadPoolExecutor(len(STATIONS) + 1) as threads:
        programs = [threads.submit(feed, client, count)]
        programs += [threads.submit(palletize, client, station, layers, placed) for station in STATIONS]
        try:
            while (number := sum(map(len, cycles.values())) + 1) <= len(STATIONS) * count:
                for program in programs:
                    if program.done():
                        program.result()  # raises what the program raised
                with suppress(queue.Empty):  # never wait for long: Ctrl-C would not get through on Windows
                    robot, seconds = placed.get(timeout=0.2)
                    cycles[robot].append(seconds)
                    print(f"box {number:2} of {len(STATIONS) * count}: {robot:5} {seconds:5.2f} s", flush=True)
            for program in programs:
                program.result()
        except BaseException:
            client.close()  # the other programs hear of it at once, and the kernel stops the arms
            raise
    print("\nrobot  boxes  seconds a box: mean, least, most")
    for robot, times in cycles.items():
        print(f"{robot:5} {len(times):6} {np.mean(times):20.2f} {min(times):6.2f} {max(times):6.2f}")
    print(f"total {len(STATIONS) * count:6} in {now(client) - start:.1f} s of simulation time", flush=True)


def feed(client: Client, count: int) -> None:
    """Bring `count` boxes to each arm: the conveyor's program."""
    conveyor = client.robot("conveyor")
    for move in range(1, count + max(station.moves for station in STATIONS)):
        with client.scene.batch() as batch:
            for station in STATIONS if move <= count else ():
                x = station.pick_x - (move - 1 + station.moves) * PITCH  # on the belt
                belt_t_box = pose(x, z=station.box[2] / 2, yaw=station.belt_yaw)
                name = f"{station.robot}-box-{move}"
                batch.add_part(name, station.figures(), pose=belt_t_box, parent="conveyor.belt")
        if move <= count:
            client.collisions.allowed.change(pair for station in STATIONS for pair in station.touches(move))
        client.signals["conveyor_running"] = True
        conveyor.move_joints({"belt": move * PITCH})
        arrived = [f"box_at_{station.robot}" for station in STATIONS if 0 <= move - station.moves < count]
        client.signals.set({"conveyor_running": False, **dict.fromkeys(arrived, True)})
        for signal in arrived:
            client.signals.wait_for(signal, False)


def palletize(client: Client, station: Station, layers: int, placed: queue.Queue[tuple[str, float]]) -> None:
    """Put the boxes that come onto the pallet: an arm's program. A box takes from its arrival until the arm is free."""
    robot, signal = client.robot(station.robot), f"box_at_{station.robot}"
    home, hold, let_go = robot.positions, *station.tool_states
    box_t_tcp = pose(z=station.box[2] / 2 - station.grip_depth, roll=np.pi)  # the tool points down
    belt, pallet = client.scene.pose("conveyor.belt"), client.scene.pose(f"pallet-{station.robot}")
    pick = pose(station.pick_x, belt[1, 3], belt[2, 3] + station.box[2] / 2, yaw=station.belt_yaw) @ box_t_tcp
    line = partial(robot.move_linear, velocity=0.5, acceleration=3.0)
    for number, pallet_t_box in enumerate(pattern(station, layers), start=1):
        place = pallet @ pallet_t_box @ box_t_tcp
        above_pick, above_place = (pose(z=station.travel_height - goal[2, 3]) @ goal for goal in (pick, place))
        # Solved from the same posture each time, so that the elbow does not wander.
        robot.move_joints(robot.solve_inverse(above_pick, seed=home).by_name())
        client.signals.wait_for(signal)
        begin = now(client)
        line(pick)
        robot.tool().set(hold)
        robot.pick(f"{station.robot}-box-{number}")
        line(above_pick)
        client.signals[signal] = False
        robot.move_joints(robot.solve_inverse(above_place, seed=home).by_name())
        line(place)
        robot.place(parent=f"pallet-{station.robot}")
        robot.tool().set(let_go)
        line(above_place)
        placed.put((station.robot, now(client) - begin))
    robot.move_joints(home)
    client.signals[f"pallet_full_{station.robot}"] = True


def now(client: Client) -> float:
    """Return simulation time in seconds."""
    return client.clock.read().stamp.simulation_time
