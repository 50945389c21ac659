"""The links of real robots against coal: what touches, and distances to 1e-6 m."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.pairs import near_pairs
from virtualrobot_kernel.collision.placed import Placed
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.state import State

from tests.unit.collision.solids import coal, model_in_coal
from tests.unit.formats.models import ROBOTS, load, structure_of

FAR = 10.0


def placed_links(
    name: str, rng: np.random.Generator
) -> tuple[list[tuple[Mesh, np.ndarray]], Callable[[Mesh], tuple[Submesh, ...]]]:
    """Return the collision meshes of a robot at random joint positions, with their poses, and what reads them."""
    model, library = load(ROBOTS[name], name="arm")
    structure, poses = structure_of(model.nodes)
    state = State(0, rng.uniform(-1.5, 1.5, structure.q_count), np.zeros(structure.v_count), poses)
    world = world_poses(structure, state)
    found = [
        (figure.geometry, world[structure.rows[node.uid]] @ figure.node_t_figure)
        for node in structure.nodes.values()
        for figure in node.figures
        if figure.collision and isinstance(figure.geometry, Mesh)
    ]
    return found, library.load


def coal_models(
    links: list[tuple[Mesh, np.ndarray]], read: Callable[[Mesh], tuple[Submesh, ...]]
) -> Mapping[Mesh, Any]:
    models = {}
    for mesh, _ in links:
        parts = read(mesh)
        starts = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
        faces = np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)])
        models[mesh] = model_in_coal(np.concatenate([part.vertices for part in parts]), faces)
    return models


@pytest.mark.parametrize("name", ["panda", "iiwa"])
def test_links_of_two_robots_against_coal(rng: np.random.Generator, name: str) -> None:
    """Two of a kind that stand in each other's way."""
    (ours, read), (theirs, _) = placed_links(name, rng), placed_links(name, rng)
    turn = np.eye(4)
    turn[:2, :2] = [[-1, 0], [0, -1]]
    turn[:3, 3] = *rng.uniform(-0.3, 0.3, 2), 0.1
    theirs = [(mesh, turn @ pose) for mesh, pose in theirs]
    library = CollisionShapes(read)

    def placed(links: list[tuple[Mesh, np.ndarray]]) -> Placed:
        return Placed([s for mesh, _ in links if (s := library.get(mesh))], np.array([pose for _, pose in links]))

    pairs = near_pairs(placed(ours), placed(theirs), FAR)
    assert len(pairs) == len(ours) * len(theirs)
    models = coal_models(ours, read)
    touch, apart = coal.CollisionRequest(), coal.DistanceRequest()
    touch.gjk_tolerance = apart.gjk_tolerance = 1e-9  # by itself it takes what is nearer than 1e-6 m for touching
    checked = rng.choice(len(pairs), min(len(pairs), 60), replace=False)
    for pair in (pairs[i] for i in checked):
        (mesh, pose), (other, place) = ours[pair.first], theirs[pair.second]
        at, to = (coal.Transform3s(each[:3, :3], each[:3, 3]) for each in (pose, place))
        collides = coal.collide(models[mesh], at, models[other], to, touch, coal.CollisionResult())
        distance = coal.distance(models[mesh], at, models[other], to, apart, coal.DistanceResult())
        if collides or distance <= 0.0:
            assert pair.distance <= 1e-9
        else:
            assert pair.distance == pytest.approx(distance, abs=1e-6)
            assert pair.normal is None
