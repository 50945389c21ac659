"""A cell that palletizes: a conveyor brings boxes, an iiwa and a Panda build two pallets. Run it by `virtualrobot demo`.

Three programs run at the same time and talk by digital signals, as the controllers of a real cell do: the conveyor says
`box_at_iiwa` and waits until the arm has cleared it, each arm says `pallet_full_...` at its end.
"""

from __future__ import annotations

import queue
import webbrowser
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import virtualrobot
from virtualrobot import Client, Robot, pose

CELL = Path(__file__).parent / "models" / "cell.yaml"
PITCH = 0.5  # meters that the belt moves at a time
COLUMNS, ROWS = 2, 3

# KUKA's data sheet of the LBR iiwa 7 R800, degrees a second for A1 to A7; the model file says 10 rad/s for all.
IIWA_SPEEDS = np.radians([98, 98, 100, 130, 140, 180, 180])


@dataclass(frozen=True)
class Station:
    """An arm with what it stacks: box edges, the gap between boxes and where it takes them, in meters and radians."""

    robot: str
    box: tuple[float, float, float]
    gap: float
    color: str
    pick_x: float  # in the world: where a box waits for the arm,
    moves: int  # after so many moves of the belt,
    belt_yaw: float  # turned so
    grip_depth: float  # how far below the top of a box the tool centre point is
    travel_height: float  # of the tool centre point in the world
    grip: str
    release: str

    def pattern(self, layers: int) -> Iterator[NDArray[np.float64]]:
        """Yield `pallet_t_box`: layers of 2 columns and 3 rows, every second one turned so that the boxes interlock."""
        length, width, height = self.box
        for layer in range(layers):
            for column in range(COLUMNS):
                for row in range(ROWS):
                    x = (column - (COLUMNS - 1) / 2) * (length + self.gap)
                    y = (row - (ROWS - 1) / 2) * (width + self.gap)
                    yield pose(yaw=layer % 2 * np.pi / 2) @ pose(x, y, (layer + 0.5) * height)


STATIONS = (
    Station("iiwa", (0.155, 0.10, 0.11), 0.01, "#c99a62", 0.625, 4, np.pi / 2, 0.0, 0.78, "on", "off"),
    Station("panda", (0.105, 0.06, 0.07), 0.03, "#2f7fb8", -0.625, 2, -np.pi / 2, 0.02, 0.68, "closed", "open"),
)


class Placed(NamedTuple):
    """A box on its pallet: who placed it, and the seconds of simulation time since the arm's box before."""

    robot: str
    seconds: float


def main(client: Client, loop: bool = False, headless: bool = False, layers: int = 2) -> None:
    """Build the cell in the kernel, fill both pallets and print how it went; with `loop` go on until interrupted."""
    client.scene.load_scene(CELL)
    limit_speeds(client, client.robot("iiwa"), IIWA_SPEEDS)
    client.view.background = "#e8edf2"
    client.view.grid = False
    client.view.set_camera((0.35, -2.75, 2.1), (0.0, 0.35, 0.45))
    if client.info.viewer_url:
        print(f"viewer: {client.info.viewer_url}", flush=True)
        if not headless:
            webbrowser.open(client.info.viewer_url)
    run(client, layers)
    while loop:
        clear(client)
        run(client, layers)


def run(client: Client, layers: int) -> None:
    """Let conveyor and arms work until both pallets are full; print each box and a table at the end."""
    count = COLUMNS * ROWS * layers
    placed: queue.Queue[Placed] = queue.Queue()
    cycles: dict[str, list[float]] = {station.robot: [] for station in STATIONS}
    start = now(client)
    with ThreadPoolExecutor(len(STATIONS) + 1) as programs:
        running = [programs.submit(feed, client, count)]
        running += [programs.submit(palletize, client, station, layers, placed) for station in STATIONS]
        try:
            while not all(program.done() for program in running) or not placed.empty():
                with suppress(queue.Empty):  # never wait without a limit: Ctrl-C would not get through on Windows
                    robot, seconds = placed.get(timeout=0.2)
                    cycles[robot].append(seconds)
                    done = sum(map(len, cycles.values()))
                    print(f"box {done:2} of {len(STATIONS) * count}: {robot:5} in {seconds:4.1f} s", flush=True)
                for program in running:
                    if program.done():
                        program.result()  # raises what the program raised
        except BaseException:
            with suppress(virtualrobot.VirtualRobotError):
                client.stop()
            client.close()  # whoever waits for a signal hears of it
            raise
    print("\nrobot   boxes   mean cycle   shortest   longest")
    for robot, seconds in cycles.items():
        print(f"{robot:5}   {len(seconds):5}   {np.mean(seconds):8.2f} s   {min(seconds):6.2f} s   {max(seconds):5.2f} s")
    print(f"total {sum(map(len, cycles.values())):7}   {now(client) - start:8.2f} s of simulation time", flush=True)


def feed(client: Client, count: int) -> None:
    """Bring `count` boxes to each station: the conveyor's program."""
    conveyor = client.robot("conveyor")
    for move in range(count + max(station.moves for station in STATIONS) - 1):
        if move < count:
            with client.scene.batch() as batch:
                for station in STATIONS:
                    x = station.pick_x - (move + station.moves) * PITCH  # on the belt
                    place = pose(x, z=station.box[2] / 2, yaw=station.belt_yaw)
                    figure = virtualrobot.box(*station.box, color=station.color)
                    batch.add_part(f"box-{station.robot}-{move + 1}", figure, pose=place, parent="conveyor.belt")
        client.signals["conveyor_running"] = True
        conveyor.move_joints({"belt": (move + 1) * PITCH})
        arrived = [f"box_at_{station.robot}" for station in STATIONS if 0 <= move + 1 - station.moves < count]
        client.signals.set({"conveyor_running": False, **dict.fromkeys(arrived, True)})
        for signal in arrived:
            client.signals.wait_for(signal, False)


def palletize(client: Client, station: Station, layers: int, placed: queue.Queue[Placed]) -> None:
    """Put the boxes that come onto the pallet: an arm's program."""
    robot, signal = client.robot(station.robot), f"box_at_{station.robot}"
    home = robot.positions
    top_t_grip = pose(z=station.box[2] / 2 - station.grip_depth, roll=np.pi)  # the tool points down
    pallet, begin = client.scene.pose(f"pallet-{station.robot}"), now(client)
    belt = client.scene.pose("conveyor.belt")
    for number, pallet_t_box in enumerate(station.pattern(layers), start=1):
        pick = pose(station.pick_x, belt[1, 3], belt[2, 3] + station.box[2] / 2, yaw=station.belt_yaw) @ top_t_grip
        place = pallet @ pallet_t_box @ top_t_grip
        above_pick, above_place = (raised(goal, station.travel_height) for goal in (pick, place))
        # Solved from the same posture each time, so that the elbow does not wander.
        robot.move_joints(robot.solve_inverse(above_pick, seed=home).by_name())
        client.signals.wait_for(signal)
        robot.move_linear(pick, velocity=0.5, acceleration=3.0)
        set_tool(client, robot, station.grip)
        robot.pick(f"box-{station.robot}-{number}")
        robot.move_linear(above_pick, velocity=0.5, acceleration=3.0)
        client.signals[signal] = False
        robot.move_joints(robot.solve_inverse(above_place, seed=home).by_name())
        robot.move_linear(place, velocity=0.5, acceleration=3.0)
        robot.place(parent=f"pallet-{station.robot}")
        set_tool(client, robot, station.release)
        robot.move_linear(above_place, velocity=0.5, acceleration=3.0)
        end = now(client)
        placed.put(Placed(station.robot, end - begin))
        begin = end
    robot.move_joints(home)
    client.signals[f"pallet_full_{station.robot}"] = True


def set_tool(client: Client, robot: Robot, state: str) -> None:
    """Put the robot's tool into a state: fingers move there, a vacuum is there at once."""
    tool = robot.tool()
    if tool.states[state]:
        tool.set(state)
    else:
        client.scene.set_tool_state(tool.name, state)


def raised(goal: NDArray[np.float64], height: float) -> NDArray[np.float64]:
    """Return a pose straight above or below `goal`, at a height in the world."""
    return pose(z=height - goal[2, 3]) @ goal


def limit_speeds(client: Client, robot: Robot, speeds: NDArray[np.float64]) -> None:
    """Give a robot's joints other speed limits, in rad/s, and accelerations that reach them in a quarter of a second."""
    for link, speed in zip(robot.links[-len(speeds) :], speeds, strict=True):
        node = client.scene.node(link).message
        limits = node.link.joint.limits
        limits.velocity, limits.acceleration, limits.jerk = speed, 4 * speed, 40 * speed
        client.scene.update(link, node, "link")


def clear(client: Client) -> None:
    """Take the boxes away and the belt back to its start."""
    with client.scene.batch() as batch:
        for part in client.scene.nodes("part"):
            batch.remove(part.name)
        batch.set_joint_positions("conveyor", {"belt": 0.0})
        for station in STATIONS:
            batch.set_signal(f"pallet_full_{station.robot}", False)


def now(client: Client) -> float:
    """Return simulation time in seconds."""
    return client.clock.read().stamp.simulation_time_seconds
