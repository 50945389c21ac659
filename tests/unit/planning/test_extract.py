"""Cutting a chain out of a forest keeps its poses, its coordinates and its limits."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.numeric.forest import PLANAR
from virtualrobot_plugins.chain.serial import chain_frames

from ..numeric.urdf_arrays import URDFS, read, world_poses
from ..plugins.chain.arms import extract


def test_tip_poses_are_those_of_the_forest_seen_from_the_base(rng: np.random.Generator) -> None:
    forest = read(URDFS["panda"])
    for base, tip in (("panda_link0", "panda_grasptarget"), ("panda_link3", "panda_rightfinger")):
        chain, coordinates = extract(forest, base, tip)
        for q in rng.uniform(forest.lower, forest.upper, (20, len(forest.lower))):
            world = world_poses(forest, q)
            expected = np.linalg.inv(world[forest.links.index(base)]) @ world[forest.links.index(tip)]
            np.testing.assert_allclose(chain_frames(chain, q[coordinates])[-1], expected, atol=1e-12)
        np.testing.assert_array_equal(chain.lower, forest.lower[coordinates])


def test_a_mimic_finger_uses_the_coordinate_of_its_source() -> None:
    forest = read(URDFS["panda"])
    names = [forest.joints[i] for i in extract(forest, "panda_link6", "panda_rightfinger")[1]]
    assert names == ["panda_joint7", "panda_finger_joint1"]


def test_what_is_no_chain_is_refused() -> None:
    forest = read(URDFS["panda"])
    with pytest.raises(KernelError, match="does not hang on"):
        extract(forest, "panda_leftfinger", "panda_link3")
    with pytest.raises(KernelError, match="no joint moves"):
        extract(forest, "panda_link8", "panda_hand")
    forest.joint_type[forest.links.index("panda_link2")] = PLANAR
    with pytest.raises(KernelError, match="planar"):
        extract(forest, "panda_link0", "panda_link4")
