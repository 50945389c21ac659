"""Known models in worlds of their own: whole, and in their posture `home`."""

from __future__ import annotations

import numpy as np
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.scenes.alone import model_alone
from virtualrobot_kernel.world.structure import RobotData

from tests.unit.formats.models import MODELS, XacroAndSdf

LIBRARY = MeshLibrary(AssetStore(), XacroAndSdf())


def test_an_arm_stands_alone_in_its_home() -> None:
    assert "ur5e" in MODELS
    snapshot = model_alone("model://ur5e", LIBRARY, world_poses)
    ((uid, robot),) = snapshot.structure.robots.items()
    data = snapshot.structure.nodes[uid].data
    assert isinstance(data, RobotData)
    home = data.postures["home"]
    positions = dict(zip(robot.joint_names, snapshot.state.q[robot.q_slice].tolist(), strict=True))
    assert positions == {name: home[name] for name in robot.joint_names}
    # Nothing of another world, and what is told of poses is of all nodes.
    assert snapshot.world_t_node.shape == (len(snapshot.structure.nodes), 4, 4)
    assert np.isfinite(snapshot.world_t_node).all()


def test_a_gripper_stands_alone_too() -> None:
    snapshot = model_alone("model://parallel_gripper", LIBRARY, world_poses)
    assert len(snapshot.structure.tools) == 1
