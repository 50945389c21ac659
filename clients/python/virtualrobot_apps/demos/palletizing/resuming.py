"""The palletizing demo gone on with: which boxes lie where says the scene, and the belt how far it has come."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from virtualrobot import Client, pose

from virtualrobot_apps.demos.palletizing.cell import HOME, STATIONS, Station
from virtualrobot_apps.demos.palletizing.handling import box_program
from virtualrobot_apps.demos.palletizing.palletize import COLUMNS, PATIENCE, PITCH, ROWS, TELLING, Begun, now, tell


@dataclass(frozen=True)
class Done:
    """Progress at a station: boxes on the pallet, whether the tool holds one, and whether one waits on the belt."""

    placed: int
    holds: bool
    waits: bool


def begun(client: Client, layers: int = 3) -> Begun | None:
    """Return how a cell that stands there is gone on with; None where there is none, or its pallets are full."""
    if not is_begun(client, COLUMNS * ROWS * layers):
        return None
    # Counted once: later one arm may have placed a box that the other one has not told yet.
    placed = sum(done(client, station, 0).placed for station in STATIONS)
    print(f"going on: {placed} of {len(STATIONS) * COLUMNS * ROWS * layers} boxes are on their pallets", flush=True)
    return Begun(finish_move, partial(palletize_rest, before=placed))


def is_begun(client: Client, count: int) -> bool:
    """Return whether the cell stands there with pallets that have less than `count` boxes each."""
    names = set(client.scene)
    cell = {"conveyor", *(f"pallet-{station.robot}" for station in STATIONS)}
    if not cell <= names or any(HOME not in list(client.robot(one.robot).postures) for one in STATIONS):
        return False
    return any(done(client, station, 0).placed < count for station in STATIONS)


def done(client: Client, station: Station, moves: int) -> Done:
    """Return what is done at a station after so many moves of the belt."""
    parents = {node.name: node.parent for node in client.scene.nodes("part")}
    boxes = {name: parent for name, parent in parents.items() if name.startswith(f"{station.robot}-box-")}
    places = list(boxes.values())
    waiting = boxes.get(f"{station.robot}-box-{moves - station.moves + 1}")
    held = any(place not in (f"pallet-{station.robot}", "conveyor.belt") for place in places)
    return Done(places.count(f"pallet-{station.robot}"), held, waiting == "conveyor.belt")


def moves_begun(client: Client, pitch: float) -> int:
    """Return how many moves the belt has made or begun; boxes are put onto it before its move."""
    made = math.ceil(float(client.robot("conveyor").positions[0]) / pitch - 1e-6)
    numbers = [int(name.rpartition("-")[2]) for name in client.scene if "-box-" in name]
    return max(made, *numbers, 0) if numbers else made


def places(station: Station, columns: int, rows: int, layers: int) -> Sequence[np.ndarray]:
    """Return pallet_t_box, 4x4, of each place in the order of the pattern: column by column, layer by layer."""
    length, width, height = station.box
    found = []
    for layer in range(layers):
        turn = np.pi / 2 * (layer % 2)
        for column in range(columns):
            for row in range(rows):
                x = (column - (columns - 1) / 2) * (length + station.gap)
                y = (row - (rows - 1) / 2) * (width + station.gap)
                place = np.eye(4)
                cos, sin = math.cos(turn), math.sin(turn)
                place[:2, :2] = [[cos, -sin], [sin, cos]]
                place[:3, 3] = cos * x - sin * y, sin * x + cos * y, height / 2 + layer * height
                found.append(place)
    return found


def finish_move(client: Client, count: int) -> int:
    """Bring the belt to the end of a move that it had begun, say which boxes wait there, and return the move."""
    conveyor, move = client.robot("conveyor"), moves_begun(client, PITCH)
    client.collisions.allowed.change(
        pair for station in STATIONS for number in range(1, min(move, count) + 1) for pair in station.touches(number)
    )
    client.program().move(conveyor.ptp({"belt": move * PITCH})).start(wait=False).wait(timeout=PATIENCE)
    waiting = {f"box_at_{one.robot}": done(client, one, move).waits for one in STATIONS}
    client.signals.set({"conveyor_running": False, **waiting})
    return move


def palletize_rest(
    client: Client, station: Station, layers: int, cycles: dict[str, list[float]], before: int = 0
) -> None:
    """Have an arm that was stopped anywhere fill the rest of its pallet, box by box, and tell of each its seconds.

    `before` is how many boxes both pallets had when it was gone on.
    """
    robot, pallet, let_go = client.robot(station.robot), f"pallet-{station.robot}", station.tool_states[1]
    tcp = robot.tcp
    here = done(client, station, 0)
    if (up := station.travel_height - tcp[2, 3]) > 0.0:
        client.program().move(robot.linear(pose(z=up) @ tcp)).start(wait=False).wait(timeout=PATIENCE)
    if not here.holds:
        client.program().tool_state(robot, let_go).start(wait=False).wait(timeout=PATIENCE)
    holds, total = here.holds, len(STATIONS) * COLUMNS * ROWS * layers
    for place in places(station, COLUMNS, ROWS, layers)[here.placed :]:
        begin = now(client)
        box_program(client, station, pallet, place, holds).start(wait=False).wait(timeout=PATIENCE)
        holds = False
        with TELLING:
            tell(station, now(client) - begin, cycles, total, before)
    program = client.program().move(robot.ptp(robot.postures[HOME])).set(f"pallet_full_{station.robot}")
    program.start(wait=False).wait(timeout=PATIENCE)
