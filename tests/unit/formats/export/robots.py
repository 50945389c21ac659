"""Robots for the tests of export, and what their links are."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.world.figures import Figure, Mesh
from virtualrobot_kernel.world.structure import Joint, Kind, LinkData, NodeSpec, RobotData


def links_of(nodes: tuple[NodeSpec, ...]) -> dict[str, NodeSpec]:
    """Return the links by their names without the robot's."""
    robot = nodes[0].name
    return {node.name.removeprefix(f"{robot}."): node for node in nodes[1:]}


def link_data(node: NodeSpec) -> LinkData:
    assert isinstance(node.data, LinkData)
    return node.data


def shapes(node: NodeSpec, visual: bool) -> list[tuple]:
    """Return the shapes of one role: geometry (a mesh by its content and scale) and colour."""
    found = []
    for figure in node.figures:
        if figure.visual if visual else figure.collision:
            shape = figure.geometry
            what = (shape.sha256, shape.scale, [sha for _, sha in shape.files]) if isinstance(shape, Mesh) else shape
            found.append((what, figure.material.color if figure.material and visual else None))
    return found


def made(*links: NodeSpec, **data: object) -> list[NodeSpec]:
    """Return a robot `r` with the given links."""
    return [NodeSpec("r", Kind.ROBOT, data=RobotData(**data)), *links]  # pyright: ignore[reportArgumentType]


def link(
    name: str, parent: str = "r", joint: Joint | None = None, place: np.ndarray | None = None, *figures: Figure
) -> NodeSpec:
    return NodeSpec(
        f"r.{name}",
        Kind.LINK,
        parent,
        np.eye(4) if place is None else place,
        figures=figures,
        data=LinkData(joint or Joint(f"to_{name}")),
    )


def turned(rng: np.random.Generator) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(rng=rng).as_matrix()
    pose[:3, 3] = rng.uniform(-1.0, 1.0, 3)
    return pose
