"""A cell that palletizes: a conveyor brings boxes, an iiwa and a Panda build two pallets. `virtualrobot demo` runs it.

Three programs run at the same time and talk by signals, as in a real cell: the conveyor says `box_at_iiwa` and
waits until the arm has taken the box away, the arm says `pallet_full_iiwa` at its end; likewise for the Panda.
"""

from __future__ import annotations

from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from contextlib import nullcontext
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from virtualrobot import Client, Pattern, Program, pose

from virtualrobot_apps.demos.palletizing import cell
from virtualrobot_apps.demos.palletizing.cell import STATIONS, Station
from virtualrobot_apps.demos.palletizing.film import filmed
from virtualrobot_apps.demos.palletizing.resuming import HOME, done, is_begun, moves_begun, places, remember_home
from virtualrobot_apps.demos.viewer import show_viewer

PITCH = 0.5  # meters that the belt moves at a time
RISE = 0.2  # meters above its place that a box comes from
PATIENCE = 3600.0  # seconds
TELLING = Lock()
COLUMNS, ROWS = 2, 3  # of boxes in a layer


def main(
    client: Client,
    loop: bool = False,
    headless: bool = False,
    layers: int = 3,
    film: Path | None = None,
    resume: bool = False,
) -> None:
    """Build the cell, fill both pallets and print how it went; with `loop` again and again, until interrupted.

    `film` is the file of a film of it all, .mp4 or .gif; where its pictures are drawn too slowly, time goes slower.
    With `resume` it goes on in a cell that stands there already, if its pallets aren't full.
    """
    going_on = resume and is_begun(client, COLUMNS * ROWS * layers)
    if not going_on:
        build(client)
    show_viewer(client, headless)
    with nullcontext() if film is None else filmed(client, film):
        run(client, layers, going_on)
        while loop:
            build(client)
            run(client, layers)
    if film is not None:
        print(f"film in {film}", flush=True)


def build(client: Client) -> None:
    """Replace the world by the cell, and note how its arms stand."""
    cell.load(client)
    remember_home(client)


def run(client: Client, layers: int, going_on: bool = False) -> None:
    """Let conveyor and arms work until both pallets are full; print each box, and a table at the end."""
    count, start = COLUMNS * ROWS * layers, now(client)
    cycles: dict[str, list[float]] = {station.robot: [] for station in STATIONS}
    begun, work = 0, palletize
    if going_on:
        begun, work = moves_begun(client, PITCH), palletize_rest
        finish_move(client, begun, count)
    with ThreadPoolExecutor(len(STATIONS) + 1) as threads:
        programs = [threads.submit(feed, client, count, begun)]
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


def finish_move(client: Client, move: int, count: int) -> None:
    """Bring the belt to the end of a move that it had begun, and say which boxes wait there."""
    conveyor = client.robot("conveyor")
    client.collisions.allowed.change(
        pair for station in STATIONS for number in range(1, min(move, count) + 1) for pair in station.touches(number)
    )
    client.program().move(conveyor.ptp({"belt": move * PITCH})).start(wait=False).wait(timeout=PATIENCE)
    waiting = {f"box_at_{one.robot}": done(client, one, move).waits for one in STATIONS}
    client.signals.set({"conveyor_running": False, **waiting})


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
    robot, signal, pallet = client.robot(station.robot), f"box_at_{station.robot}", f"pallet-{station.robot}"
    length, width, height = station.box
    hold, let_go = station.tool_states
    box_t_tcp = pose(z=height / 2 - station.grip_depth, roll=np.pi)  # the tool points down
    belt = client.scene.pose("conveyor.belt")
    pick = pose(station.pick_x, belt[1, 3], belt[2, 3] + height / 2, yaw=station.belt_yaw) @ box_t_tcp
    home = dict(zip(robot.joint_names, robot.positions.tolist(), strict=True))
    line = {"velocity": 0.5, "acceleration": 3.0}
    # Near the same posture each time, so that the elbow does not wander.
    near: dict[str, Any] = {"prefer": {name: home[name] for name in robot.chain_joint_names}}
    rise = station.travel_height - pick[2, 3]
    box = client.program().move(robot.ptp(pose(z=rise) @ pick, **near)).wait(signal)
    box.pick_at(robot, pick, approach=rise, state=hold, **line, **near).set(signal, False)
    box.place_at(robot, box_t_tcp, reference="place", approach=RISE, state=let_go, parent=pallet, **line, **near)
    places = Pattern(
        *(COLUMNS, ROWS, layers, length + station.gap, width + station.gap, height),
        pose=pose(z=height / 2),
        layer_turn=np.pi / 2,
    )
    program = client.program().pattern("place", places, box, reference=pallet)
    return program.move(robot.ptp(home)).set(f"pallet_full_{station.robot}")


def palletize(client: Client, station: Station, layers: int, cycles: dict[str, list[float]]) -> None:
    """Run an arm's program and tell of each box the seconds from when the arm and it are there until it is placed."""
    motion, begin = arm_program(client, station, layers).start(wait=False), now(client)
    total = len(STATIONS) * COLUMNS * ROWS * layers
    for state in motion.watch(max_rate=100):
        inside, _, step = state.step_path.removeprefix("0[").partition("].")
        with TELLING:
            while len(cycles[station.robot]) < (int(inside) if step else total // len(STATIONS)):
                cycles[station.robot].append(seconds := now(client) - begin)
                number = sum(map(len, cycles.values()))
                print(f"box {number:2} of {total}: {station.robot:5} {seconds:5.2f} s", flush=True)
        if step in ("0", "1"):  # on its way to the belt, or there before the box
            begin = now(client)
    motion.wait(timeout=PATIENCE)


def palletize_rest(client: Client, station: Station, layers: int, cycles: dict[str, list[float]]) -> None:
    """Have an arm that was stopped anywhere fill the rest of its pallet, box by box, and tell of each its seconds."""
    robot, signal, pallet = client.robot(station.robot), f"box_at_{station.robot}", f"pallet-{station.robot}"
    height, (hold, let_go) = station.box[2], station.tool_states
    home = robot.postures[HOME]
    line = {"velocity": 0.5, "acceleration": 3.0}
    near: dict[str, Any] = {"prefer": {name: home[name] for name in robot.chain_joint_names}}
    box_t_tcp = pose(z=height / 2 - station.grip_depth, roll=np.pi)
    belt, tcp = client.scene.pose("conveyor.belt"), robot.tcp
    pick = pose(station.pick_x, belt[1, 3], belt[2, 3] + height / 2, yaw=station.belt_yaw) @ box_t_tcp
    above = pose(z=station.travel_height - pick[2, 3]) @ pick
    here = done(client, station, 0)
    if (up := station.travel_height - tcp[2, 3]) > 0.0:
        client.program().move(robot.linear(pose(z=up) @ tcp)).start(wait=False).wait(timeout=PATIENCE)
    if not here.holds:
        client.program().tool_state(robot, let_go).start(wait=False).wait(timeout=PATIENCE)
    holds, total = here.holds, len(STATIONS) * COLUMNS * ROWS * layers
    for place in places(station, COLUMNS, ROWS, layers)[here.placed :]:
        begin, program = now(client), client.program().move(robot.ptp(above, **near))
        if not holds:
            program.wait(signal).pick_at(robot, pick, approach=above[2, 3] - pick[2, 3], state=hold, **line, **near)
            program.set(signal, False)
        goal = place @ box_t_tcp
        program.place_at(robot, goal, reference=pallet, approach=RISE, state=let_go, parent=pallet, **line, **near)
        program.start(wait=False).wait(timeout=PATIENCE)
        holds = False
        with TELLING:
            cycles[station.robot].append(seconds := now(client) - begin)
            number = sum(done(client, one, 0).placed for one in STATIONS)
            print(f"box {number:2} of {total}: {station.robot:5} {seconds:5.2f} s", flush=True)
    client.program().move(robot.ptp(home)).set(f"pallet_full_{station.robot}").start(wait=False).wait(timeout=PATIENCE)


def now(client: Client) -> float:
    """Return simulation time in seconds."""
    return client.clock.read().stamp.simulation_time
