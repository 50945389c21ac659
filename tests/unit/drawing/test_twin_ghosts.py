"""Ghosts of twins: which robots are elsewhere, and where what they are made of is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from virtualrobot_kernel.drawing.twin_ghosts import APART, GhostKind, as_view_ghosts, ghost_poses, twin_ghosts
from virtualrobot_kernel.world.commands import SetJointPositions
from virtualrobot_kernel.world.state import JointValues, Snapshot

from tests.drawing.cell import Cell
from tests.unit.drawing.test_ghosts import slide


def cell() -> Cell:
    """Return a cell of a slide with an arm, and a second one that stands on its carriage."""
    made = Cell()
    slide(made, "slide")
    slide(made, "second", parent="slide.carriage")
    made.do(SetJointPositions("slide", {"along": 3.0}))
    return made


def x_of(snapshot: Snapshot, world_t_node: np.ndarray, name: str) -> float:
    return float(world_t_node[snapshot.structure.rows[snapshot.structure.node(name).uid], 0, 3])


def test_robots_that_are_where_the_world_has_them_have_no_ghost() -> None:
    made = cell()
    here = {made.uid("slide"): np.array([3.0 + 0.9 * APART, 0.0]), made.uid("second"): np.zeros(2), 999: np.ones(2)}
    assert twin_ghosts(made.snapshot, {}) == ()
    assert twin_ghosts(made.snapshot, here) == ()


def test_a_ghost_is_where_the_real_robot_was_measured_and_what_stands_on_it_goes_along() -> None:
    made = cell()
    slide_uid, second = made.uid("slide"), made.uid("second")
    ghosts = twin_ghosts(made.snapshot, {slide_uid: np.array([2.0, 0.0]), second: np.array([0.5, 0.0])})
    assert [(one.robot, one.kind) for one in ghosts] == [(slide_uid, GhostKind.MEASURED), (second, GhostKind.MEASURED)]
    world_t_node = ghost_poses(made.snapshot, ghosts)
    assert x_of(made.snapshot, world_t_node, "slide.carriage") == 2.0
    assert x_of(made.snapshot, world_t_node, "second.carriage") == 2.5
    assert x_of(made.snapshot, made.snapshot.world_t_node, "second.carriage") == 3.0
    colors = {one.robot: (one.rows, one.color) for one in as_view_ghosts(ghosts)}
    assert colors[slide_uid][0] == ((2.0, 0.0),)


def test_the_ghost_of_a_monitored_robot_is_where_motions_command_it() -> None:
    made = cell()
    uid = made.uid("slide")
    commanded = {uid: JointValues(np.array([1.0, 0.0]), np.zeros(2))}
    snapshot = replace(made.snapshot, state=replace(made.snapshot.state, commanded=commanded))
    (ghost,) = twin_ghosts(snapshot, {uid: np.array([2.0, 0.0])})
    assert (ghost.kind, ghost.q.tolist()) == (GhostKind.COMMANDED, [1.0, 0.0])
    assert x_of(snapshot, ghost_poses(snapshot, (ghost,)), "slide.carriage") == 1.0
