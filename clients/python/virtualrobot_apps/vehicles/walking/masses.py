"""Masses of what machines are made of, and where their centre is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.v1 import scene_pb2

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Masses:
    """Masses (m,) in kg of links, by name, and their centres (m, 3) in the links' frames (m)."""

    links: tuple[str, ...]
    kilograms: Floats
    centers: Floats

    @property
    def total(self) -> float:
        """Mass of all (kg)."""
        return float(self.kilograms.sum())

    def center(self, poses: Mapping[str, Floats]) -> Floats:
        """Return the common centre of mass (3,) in m for poses (4, 4) of the links."""
        frames = np.array([poses[link] for link in self.links])
        places = frames[:, :3, 3] + np.einsum("mij,mj->mi", frames[:, :3, :3], self.centers)
        return self.kilograms @ places / self.total


def masses_of(client: Client, robot: str) -> Masses:
    """Return the masses of the links that have some, of a robot and of those that hang on it.

    Raises ValueError where none has: the machine's centre of mass is unknown then.
    """
    nodes = client.services.scene.GetScene(scene_pb2.GetSceneRequest()).nodes
    parents = {node.name: node.parent for node in nodes}
    found = []
    for node in nodes:
        if not node.HasField("link") or not node.link.HasField("inertial"):
            continue
        above = node.name
        while above not in ("", robot):
            above = parents.get(above, "")
        if above and node.link.inertial.mass_kilograms > 0.0:
            center = node.link.inertial.link_t_inertial.position
            found.append((node.name, node.link.inertial.mass_kilograms, (center.x, center.y, center.z)))
    if not found:
        raise ValueError(f"no link of {robot!r} has a mass, so nobody knows where its centre is")
    names, kilograms, centers = zip(*found, strict=True)
    return Masses(names, np.array(kilograms), np.array(centers))
