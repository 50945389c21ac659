"""Laws of saved scenes: what is loaded is what was saved."""

from __future__ import annotations

import numpy as np
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.scenes.reading import read_scene
from virtualrobot_kernel.scenes.writing import write_scene
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import AttachNode, CreateNodes, SetJointPositions
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, NodeSpec

from tests.unit.world.builders import LIMITS, Z, after, empty, link, part, shifted, world_t


def text(world: Change) -> str:
    poses = world_poses(world.structure, world.state)
    return write_scene(Snapshot(world.structure, world.state, poses, 0, 0.0, 0.004), False)[0]


def loaded(text: str) -> Change:
    store = AssetStore()
    commands, *_ = read_scene(text, "", Files(store), MeshLibrary(store))
    return after(empty(), *commands)


def test_joints_of_links_created_in_any_order_are_where_they_were(rng: np.random.Generator) -> None:
    """Links of two fingers, created finger by finger or knuckle by knuckle, with a part on one of them."""
    names = ["a1", "b1", "a2", "b2"] if rng.random() < 0.5 else ["b1", "a1", "b2", "a2"]
    links = [
        link(
            f"r.{name}",
            f"r.{name[0]}1" if name[1] == "2" else "r",
            Joint(name, JointType.REVOLUTE, Z, LIMITS),
            shifted(x=0.1),
        )
        for name in names
    ]
    positions = dict(zip(names, rng.uniform(-2.0, 2.0, 4).tolist(), strict=True))
    world = after(
        empty(),
        CreateNodes((part("p", shifted()), NodeSpec("r", Kind.ROBOT), *links)),
        SetJointPositions("r", positions),
        AttachNode("p", "r.a2"),
    )
    again = loaded(text(world))
    robot = again.structure.robot("r")[1]
    assert dict(zip(robot.joint_names, again.state.q.tolist(), strict=True)) == positions
    assert text(again) == text(world)
    for name in ("p", "r.a2", "r.b2"):
        np.testing.assert_allclose(world_t(again, name), world_t(world, name), atol=1e-14)
