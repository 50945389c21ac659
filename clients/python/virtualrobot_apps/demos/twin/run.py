"""Two arms whose controllers are emulated stack boxes, and a carton stands in the way: `virtualrobot demo twin`.

Each arm is a twin in mode EXECUTE: an order is checked as a whole, done by the twin, and by its robot a lead later. One
that would collide is refused, and nothing is sent.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot import Client, Program, pose
from virtualrobot.errors import CollisionError, DriverFaultError, MotionEndedError, VirtualRobotError, WrongStateError

from virtualrobot_apps.demos.palletizing.handling import box_program
from virtualrobot_apps.demos.palletizing.palletize import COLUMNS, PITCH, ROWS
from virtualrobot_apps.demos.palletizing.resuming import places
from virtualrobot_apps.demos.twin import cell, controllers
from virtualrobot_apps.demos.twin.cell import CARTON, STATIONS
from virtualrobot_apps.demos.viewer import show_viewer

LEAD = 0.4
"""Lead (s): a computer that draws, plans and emulates besides may be as late, and no robot has to brake."""

FOLLOWING_WARNING, FOLLOWING_LIMIT = 0.2, 0.25
"""Following errors (rad): emulated arms are late by less than the first at their greatest speed."""

LATE = 0.5
"""Time (s) without a word after which driver and controller give each other up; a busy computer keeps that."""

LAYERS = 3
PATIENCE = 120.0
"""Longest time (s) of an order."""

TRIES = 200
"""Number of times that robots go on which had to brake, since the computer was too late; a busy one needs many."""


@dataclass(slots=True, eq=False)
class Tally:
    """Numbers of one robot: orders sent and refused, boxes, setpoints, readings, and its following error (rad)."""

    driver: str
    settings: Mapping[str, object]
    sent: int = 0
    refused: int = 0
    boxes: int = 0
    setpoints: int = 0
    readings: int = 0
    error_sum: float = 0.0
    error_most: float = 0.0


def main(client: Client, loops: int = 1, headless: bool = False) -> None:
    """Build the cell, start the controllers, have each arm stack three boxes a loop, and print how it went."""
    cell.load(client)
    show_viewer(client, headless)
    with ExitStack() as stack:
        port = controllers.free_port()
        ur, host = controllers.universal_robots()
        stack.enter_context(ur)
        abb = stack.enter_context(controllers.guided_by(port, cell.HOMES["abb"]))
        print(
            f"controllers: UR at {host} (process {ur.pid}), ABB by EGM to port {port} (process {abb.pid})", flush=True
        )
        tallies = {
            "ur": Tally("ur_rtde", {"host": host, "rate": controllers.RATE, "watchdog": LATE, "silence": LATE}),
            "abb": Tally("abb_egm", {"port": port, "rate": controllers.RATE, "silence": LATE}),
        }
        stack.enter_context(client.lease(*tallies, owner="demo twin"))
        stack.callback(disconnect, client, tallies)
        execute(client, tallies)
        with watched(client, tallies):
            stack_boxes(client, tallies, loops)
            do_all(client, tallies, ways_to(client, cell.HOMES))
    tell(tallies)


def connect(client: Client, robot: str, tally: Tally) -> None:
    """Connect a robot's driver to its controller, and say so."""
    told = client.drivers.connect(
        *(robot, tally.driver, tally.settings),
        lead=LEAD,
        following_warning=FOLLOWING_WARNING,
        following_limit=FOLLOWING_LIMIT,
    ).controller
    print(f"{robot} is connected: {tally.driver}, {told.joint_count} joints, {told.rate:g} Hz", flush=True)


def disconnect(client: Client, robots: Iterable[str]) -> None:
    """End the drivers; the robots come to rest first."""
    for robot in robots:
        with suppress(VirtualRobotError):  # it was not connected yet, or the kernel is gone
            client.drivers.disconnect(robot)


def execute(client: Client, tallies: Mapping[str, Tally]) -> None:
    """Let the robots follow their twins, from where they stand; what that needs is done first."""
    for _ in range(TRIES):
        if are_ready(client, tallies):
            return
        try:
            begin(client, tallies)
        except (DriverFaultError, WrongStateError) as error:
            print(f"not ready: {error}", flush=True)
    raise VirtualRobotError(f"the robots did not follow in {TRIES} times: this computer has too much else to do")


def begin(client: Client, tallies: Mapping[str, Tally]) -> None:
    """Wait until all robots rest, connect those that need it, end what stopped them, and let them follow."""
    drivers = client.drivers
    for status in drivers.list():
        if status.robot in tallies and status.state != "error":
            drivers.set_mode(status.robot, "simulated")  # returns once the robot rests
    connected = {status.robot: status for status in drivers.list()}
    for robot, tally in tallies.items():
        if robot not in connected:
            connect(client, robot, tally)
        elif connected[robot].state == "error":
            print(f"{robot} was in ERROR: {connected[robot].text}", flush=True)
            connect(client, robot, tally)
    if client.cell.stopped:
        client.cell.release()
    for robot in tallies:
        drivers.set_mode(robot, "execute")


def stack_boxes(client: Client, tallies: Mapping[str, Tally], loops: int) -> None:
    """Have each arm put three boxes a loop onto its pallet; as the second ones come, a carton stands in the way."""
    full = COLUMNS * ROWS * LAYERS
    for number in range(1, ROWS * loops + 1):
        place = (number - 1) % full
        if number > 1 and place == 0:
            clear(client, range(number - full, number))
        feed(client, number)
        left = boxes_left(client, number, place)
        if number == 2:
            meet_carton(client, tallies, left)
        do_all(client, tallies, left)
        for tally in tallies.values():
            tally.boxes += 1
        print(f"box {number} of {ROWS * loops} is on each pallet", flush=True)


def do_all(client: Client, tallies: Mapping[str, Tally], left: Callable[[], Mapping[str, Program]]) -> None:
    """Order what is left to do until nothing is; robots that had to brake go on from where they were measured."""
    for _ in range(TRIES):
        if not (programs := left()):
            return
        done = order(client, tallies, programs)
        if done and are_ready(client, tallies):
            continue
        ends = {robot: client.robot(robot).positions for robot in programs}
        execute(client, tallies)
        lift(client, tallies)
        if done:  # a robot stopped on the last bit, a lead after its twin had come there: both go there now
            do_all(client, tallies, ways_to(client, ends))
    raise VirtualRobotError(f"the robots had to brake {TRIES} times: this computer has too much else to do")


def meet_carton(client: Client, tallies: Mapping[str, Tally], left: Callable[[], Mapping[str, Program]]) -> None:
    """Put a carton in the way of an arm, whose order is refused then while the other arm works, and take it away."""
    robot, *others = tallies
    print(f"a carton is put in the way of {robot}", flush=True)
    cell.put_carton(client)
    programs = left()
    for _ in range(TRIES):
        execute(client, tallies)
        stood = client.drivers[robot].positions
        try:
            programs[robot].start(wait=False)
        except CollisionError as error:
            tallies[robot].refused += 1
            print(f"{robot} refuses: {error}", flush=True)
            break
        except (DriverFaultError, WrongStateError):
            continue  # a robot stopped just now
        raise VirtualRobotError(f"{robot} was to refuse an order that would collide with a carton, and did not")
    else:
        raise VirtualRobotError(f"the robots had to brake {TRIES} times: this computer has too much else to do")
    order(client, tallies, {one: programs[one] for one in others})
    moved = np.abs(client.drivers[robot].positions - stood).max()
    print(f"{robot} stood still: it moved by {1e3 * moved:.2f} mrad", flush=True)
    client.scene.remove(CARTON)
    print("the carton is taken away", flush=True)


def clear(client: Client, numbers: Iterable[int]) -> None:
    """Take the boxes from full pallets."""
    with client.scene.batch() as batch:
        for number in numbers:
            for station in STATIONS:
                batch.remove(f"{station.robot}-box-{number}")


def feed(client: Client, number: int) -> None:
    """Put a box for each arm onto the belt, and bring both to where the arms take them."""
    with client.scene.batch() as batch:
        for station in STATIONS:
            belt_t_box = pose(station.pick_x - number * PITCH, z=station.box[2] / 2, yaw=station.belt_yaw)
            batch.add_part(f"{station.robot}-box-{number}", station.figures(), pose=belt_t_box, parent="conveyor.belt")
    client.collisions.allowed.change(pair for station in STATIONS for pair in station.touches(number))
    client.robot("conveyor").move_joints({"belt": number * PITCH})
    client.signals.set({f"box_at_{station.robot}": True for station in STATIONS})


def boxes_left(client: Client, number: int, place: int) -> Callable[[], dict[str, Program]]:
    """Return a function that gives, by robot, the programs for boxes of a number that aren't on their pallets yet."""

    def left() -> dict[str, Program]:
        return {
            station.robot: box_program(
                *(client, station, f"pallet-{station.robot}"),
                places(station, COLUMNS, ROWS, LAYERS)[place],
                holds=parent != "conveyor.belt",
            )
            for station in STATIONS
            if (parent := client.scene.node(f"{station.robot}-box-{number}").parent) != f"pallet-{station.robot}"
        }

    return left


def are_ready(client: Client, robots: Iterable[str]) -> bool:
    """Return whether all robots do what their twins do: an order to one that doesn't is refused."""
    follow = {one.robot for one in client.drivers.list() if (one.mode, one.state) == ("execute", "active")}
    return follow.issuperset(robots)


def order(client: Client, tallies: Mapping[str, Tally], programs: Mapping[str, Program]) -> bool:
    """Order programs at once and wait for their ends; return whether all came to theirs."""
    if not are_ready(client, tallies):
        return False
    motions, went_well = {}, True
    for robot, program in programs.items():
        try:
            motions[robot] = program.start(wait=False)
            tallies[robot].sent += 1
        except (DriverFaultError, WrongStateError) as error:  # a robot had to brake meanwhile, and so did both
            went_well = False
            print(f"{robot} is not ready: {error}", flush=True)
    for robot, motion in motions.items():
        try:
            motion.wait(timeout=PATIENCE)
        except MotionEndedError as error:
            went_well = False
            print(f"{robot} stopped: {error}", flush=True)
    return went_well


def lift(client: Client, tallies: Mapping[str, Tally]) -> None:
    """Bring tools straight up to where nothing is in their way."""
    programs = {}
    for station in STATIONS:
        robot = client.robot(station.robot)
        if (up := station.travel_height - robot.tcp[2, 3]) > 1e-3:
            programs[station.robot] = client.program().move(robot.linear(pose(z=up) @ robot.tcp))
    order(client, tallies, programs)


def ways_to(client: Client, goals: Mapping[str, ArrayLike]) -> Callable[[], dict[str, Program]]:
    """Return a function that gives, by robot, the programs for those that aren't at their goals (k,) yet."""

    def left() -> dict[str, Program]:
        arms = {robot: (client.robot(robot), np.asarray(goal, float)) for robot, goal in goals.items()}
        return {
            robot: client.program().move(arm.ptp(goal))
            for robot, (arm, goal) in arms.items()
            if np.abs(arm.positions - goal).max() > 1e-6
        }

    return left


@contextmanager
def watched(client: Client, tallies: Mapping[str, Tally]) -> Iterator[None]:
    """Note setpoints and following errors while the block runs."""
    over = threading.Event()

    def watch() -> None:
        cycles: dict[str, int] = {}
        with suppress(VirtualRobotError):  # its kernel may be gone
            for statuses in client.drivers.watch():
                for status in statuses:
                    tally, before = tallies[status.robot], cycles.pop(status.robot, None)
                    if status.state != "active" or not len(status.following_error):
                        continue
                    error = float(np.abs(status.following_error).max())
                    tally.readings += 1
                    tally.error_sum += error
                    tally.error_most = max(tally.error_most, error)
                    tally.setpoints += 0 if before is None else max(0, status.cycles - before)
                    cycles[status.robot] = status.cycles
                if over.is_set():
                    return

    thread = threading.Thread(target=watch, name="following error", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join(5.0)


def tell(tallies: Mapping[str, Tally]) -> None:
    """Print the numbers of all robots."""
    print("\nrobot  driver   boxes  orders sent  refused  setpoints  following error: mean, greatest")
    for robot, one in tallies.items():
        mean = one.error_sum / max(1, one.readings)
        print(
            f"{robot:6} {one.driver:8} {one.boxes:5} {one.sent:12} {one.refused:8} {one.setpoints:10} "
            f"{1e3 * mean:20.1f} {1e3 * one.error_most:6.1f} mrad",
            flush=True,
        )
