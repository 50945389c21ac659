"""A cell that palletizes: a conveyor brings boxes, an iiwa and a Panda build two pallets. `virtualrobot demo` runs it.

Three programs run at the same time and talk by signals, as in a real cell: the conveyor says `box_at_iiwa` and
waits until the arm has taken the box away, the arm says `pallet_full_iiwa` at its end; likewise for the Panda.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from contextlib import nullcontext
from pathlib import Path
from threading import Lock
from typing import NamedTuple

import numpy as np
from virtualrobot import Client, Pattern, Program, pose

from virtualrobot_apps.demos.palletizing import cell
from virtualrobot_apps.demos.palletizing.cell import STATIONS, Station
from virtualrobot_apps.demos.palletizing.film import filmed
from virtualrobot_apps.demos.palletizing.handling import box_program
from virtualrobot_apps.demos.viewer import show_viewer

PITCH = 0.5  # meters that the belt moves at a time
PATIENCE = 3600.0  # seconds
TELLING = Lock()
COLUMNS, ROWS = 2, 3  # of boxes in a layer


class Begun(NamedTuple):
    """A cell in which work was begun: what gets the belt to where a move ends, and which that is; what an arm does."""

    move: Callable[[Client, int], int]
    work: Callable[[Client, Station, int, dict[str, list[float]]], None]


def main(
    client: Client,
    loop: bool = False,
    headless: bool = False,
    layers: int = 3,
    film: Path | None = None,
    begun: Begun | None = None,
) -> None:
    """Build the cell, fill both pallets and print how it went; with `loop` again and again, until interrupted.

    `film` is the file of a film of it all, .mp4 or .gif; where its pictures are drawn too slowly, time goes slower.
    With `begun` it goes on in a cell that stands there already.
    """
    if begun is None:
        cell.load(client)
    show_viewer(client, headless)
    with nullcontext() if film is None else filmed(client, film):
        run(client, layers, begun)
        while loop:
            cell.load(client)
            run(client, layers)
    if film is not None:
        print(f"film in {film}", flush=True)


def run(client: Client, layers: int, begun: Begun | None = None) -> None:
    """Let conveyor and arms work until both pallets are full; print each box, and a table at the end."""
    count, start = COLUMNS * ROWS * layers, now(client)
    cycles: dict[str, list[float]] = {station.robot: [] for station in STATIONS}
    move, work = (begun.move(client, count), begun.work) if begun else (0, palletize)
    with ThreadPoolExecutor(len(STATIONS) + 1) as threads:
        programs = [threads.submit(feed, client, count, move)]
        programs += [threads.submit(work, client, station, layers, cycles) for station in STATIONS]
        try:
            while not all(program.done() for program in programs):
                ended, _ = wait(programs, 0.2, FIRST_EXCEPTION)  # never for long: Windows would not hear Ctrl-C
                for program in ended:
                    program.result()  # raises what the program raised
        except BaseException:
            client.close()  # the other programs hear of it at once, and the kernel stops the arms
            raise
    print("\nrobot  boxes  seconds a box: mean, least, most")
    for robot, times in cycles.items():
        if times:
            print(f"{robot:5} {len(times):6} {np.mean(times):20.2f} {min(times):6.2f} {max(times):6.2f}")
    print(f"total {sum(map(len, cycles.values())):6} in {now(client) - start:.1f} s of simulation time", flush=True)


def feed(client: Client, count: int, begun: int = 0) -> None:
    """Bring `count` boxes to each arm: the conveyor's program for each move of the belt that isn't `begun`."""
    conveyor = client.robot("conveyor")
    if begun:
        program = client.program()
        for station in STATIONS:
            program.wait(f"box_at_{station.robot}", False)
        program.start(wait=False).wait(timeout=PATIENCE)
    for move in range(begun + 1, count + max(station.moves for station in STATIONS)):
        with client.scene.batch() as batch:
            for station in STATIONS if move <= count else ():
                x = station.pick_x - (move - 1 + station.moves) * PITCH  # on the belt
                belt_t_box = pose(x, z=station.box[2] / 2, yaw=station.belt_yaw)
                name = f"{station.robot}-box-{move}"
                batch.add_part(name, station.figures(), pose=belt_t_box, parent="conveyor.belt")
        if move <= count:
            client.collisions.allowed.change(pair for station in STATIONS for pair in station.touches(move))
        arrived = [f"box_at_{station.robot}" for station in STATIONS if 0 <= move - station.moves < count]
        program = client.program().set("conveyor_running").move(conveyor.ptp({"belt": move * PITCH}))
        program.set("conveyor_running", False)
        for signal in arrived:
            program.set(signal)
        for signal in arrived:
            program.wait(signal, False)
        program.start(wait=False).wait(timeout=PATIENCE)


def arm_program(client: Client, station: Station, layers: int) -> Program:
    """Return an arm's program: put the boxes that come onto the pallet, every second layer turned so that it holds."""
    robot, (length, width, height) = client.robot(station.robot), station.box
    home = dict(zip(robot.joint_names, robot.positions.tolist(), strict=True))
    places = Pattern(
        *(COLUMNS, ROWS, layers, length + station.gap, width + station.gap, height),
        pose=pose(z=height / 2),
        layer_turn=np.pi / 2,
    )
    box = box_program(client, station, "place", pose())
    program = client.program().pattern("place", places, box, reference=f"pallet-{station.robot}")
    return program.move(robot.ptp(home)).set(f"pallet_full_{station.robot}")


def palletize(client: Client, station: Station, layers: int, cycles: dict[str, list[float]]) -> None:
    """Run an arm's program and tell of each box the seconds from when the arm and it are there until it is placed."""
    motion, begin = arm_program(client, station, layers).start(wait=False), now(client)
    total = len(STATIONS) * COLUMNS * ROWS * layers
    for state in motion.watch(max_rate=100):
        inside, _, step = state.step_path.removeprefix("0[").partition("].")
        with TELLING:
            while len(cycles[station.robot]) < (int(inside) if step else total // len(STATIONS)):
                tell(station, now(client) - begin, cycles, total)
        if step in ("0", "1"):  # on its way to the belt, or there before the box
            begin = now(client)
    motion.wait(timeout=PATIENCE)


def tell(station: Station, seconds: float, cycles: dict[str, list[float]], total: int, before: int = 0) -> None:
    """Note and print how long a box took; `before` were placed by others. Whoever calls it holds `TELLING`."""
    cycles[station.robot].append(seconds)
    print(f"box {before + sum(map(len, cycles.values())):2} of {total}: {station.robot:5} {seconds:5.2f} s", flush=True)


def now(client: Client) -> float:
    """Return simulation time in seconds."""
    return client.clock.read().stamp.simulation_time
