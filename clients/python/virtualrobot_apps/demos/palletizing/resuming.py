"""The palletizing demo gone on with: which boxes lie where says the scene, and the belt how far it has come."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from virtualrobot import Client

from virtualrobot_apps.demos.palletizing.cell import STATIONS, Station

HOME = "home"
"""Posture of an arm in which it begins and ends."""


@dataclass(frozen=True)
class Done:
    """Progress at a station: boxes on the pallet, whether the tool holds one, and whether one waits on the belt."""

    placed: int
    holds: bool
    waits: bool


def remember_home(client: Client) -> None:
    """Keep where the arms stand, so that one that was stopped anywhere finds back."""
    for station in STATIONS:
        client.robot(station.robot).postures.add(HOME, replace=True)


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
