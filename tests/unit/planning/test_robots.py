"""Arms cut out of a world: the tip by the arm's own rows is where the forward pass of the whole world has it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from virtualrobot_kernel.planning.robots import arm_of, poses_of_rows, tip_of, world_poses
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_sdk.poses import inverse

from tests.unit.world.builders import after, arm, empty


def test_the_tip_by_the_arm_s_rows_is_where_the_world_has_it(rng: np.random.Generator) -> None:
    cell = after(empty(), arm("left"), arm("right"))
    structure, state = cell.structure, cell.state
    snapshot = Snapshot(structure, state, world_poses(structure, state), 1, 0.0, 0.004)
    right = arm_of(snapshot, structure.node("right"))
    chain = right.serial()
    tip = tip_of(snapshot, right)
    base, flange = structure.rows[right.base], structure.rows[right.tip]
    for _ in range(20):
        q = rng.uniform(np.maximum(chain.lower, -3.0), np.minimum(chain.upper, 3.0))
        everything = rng.normal(size=state.q.shape)
        everything[right.q_index] = q
        world = world_poses(structure, replace(state, q=everything))
        np.testing.assert_allclose(tip(q), inverse(world[base]) @ world[flange], atol=1e-14)


def test_the_world_s_own_node_is_where_the_forward_pass_has_it() -> None:
    structure, state = empty().structure, empty().state
    passed = poses_of_rows(structure, structure.forest.order, state.parent_t_node, state.q)
    alone = world_poses(structure, state)
    assert alone.tobytes() == passed.tobytes() and alone.shape == passed.shape
    assert not alone.flags.writeable and alone is not state.parent_t_node
