"""Contacts as a path search counts them: pairs that the arm moves against each other, whatever else touches."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_kernel.paths.find import find_path
from virtualrobot_kernel.paths.program import planned_program
from virtualrobot_kernel.paths.space import PathSpace, off_lines
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, NodeSpec, RobotData

from tests.tiers import Draws
from tests.unit.collision.worlds import after, scene_of, with_robots
from tests.unit.paths.cells import LEFT, PANDA_RIGHT, RIGHT, HereSite, query, walled
from tests.unit.world.builders import link, shifted


def gripper() -> CreateNodes:
    """Return a gripper on an iiwa whose two fingers, 2 cm thick, are just closed: rounding says whether they touch."""
    limits = JointLimits(0.0, 0.05, 0.1, 1.0, 10.0)
    finger = (Figure(Box((0.02, 0.02, 0.05))),)
    specs = [NodeSpec("gripper", Kind.ROBOT, "iiwa.lbr_iiwa_link_7", shifted(z=0.1), data=RobotData())]
    for name, side in (("left", 1.0), ("right", -1.0)):
        joint = Joint(f"{name}_joint", JointType.PRISMATIC, (0.0, side, 0.0), limits)
        made = link(f"gripper.{name}", "gripper", joint, shifted(y=0.01 * side))
        specs.append(NodeSpec(made.name, made.kind, made.parent, made.parent_t_node, data=made.data, figures=finger))
    return CreateNodes(tuple(specs))


def test_fingers_that_the_arm_does_not_move_are_no_matter_at_any_posture(
    rng: np.random.Generator, draws: Draws
) -> None:
    snapshot = after(with_robots("iiwa"), gripper())
    fingers = {snapshot.structure.node(f"gripper.{name}").uid for name in ("left", "right")}
    question, scene = query(snapshot, "iiwa", LEFT), scene_of(snapshot)
    touching, apart = [], []
    while len(touching) < draws(50) or len(apart) < draws(50):
        q = rng.uniform(question.lower, question.upper)
        scene.place(standing_at(snapshot, question.q_index, q))
        found = [set(pair) for pair in scene.touching()]
        if found in ([], [fingers]):
            (touching if found else apart).append(q)
    begins = standing_at(snapshot, question.q_index, apart[0])
    space = PathSpace(scene, begins, query(begins, "iiwa", LEFT), lambda: False)
    assert [space.contact(q) for q in (*touching, *apart)] == [None] * (len(touching) + len(apart))
    names = dict(zip(question.joint_names, (apart[0] + 0.01 * np.sign(touching[0] - apart[0])).tolist(), strict=True))
    assert find_path(HereSite(begins), query(begins, "iiwa", names))["straight"]


@pytest.mark.parametrize(("kind", "goal", "margin"), [("iiwa", RIGHT, 0.0), ("panda", PANDA_RIGHT, 4e-3)])
def test_trees_that_meet_have_a_way_whose_lines_are_free_wherever_fcl_looks(
    kind: str, goal: dict[str, float], margin: float, rng: np.random.Generator
) -> None:
    snapshot = walled(kind)
    question = query(snapshot, kind, goal)
    space = PathSpace(scene_of(snapshot), snapshot, question, lambda: False)
    told: list[int] = []
    way = space.connected(question.goals, 0.1, margin, rng, lambda count: not told.append(count))
    assert way is not None and told[-1] >= len(way)
    np.testing.assert_array_equal(way[[0, -1]], [space.start, question.goals[0]])
    assert np.abs(np.diff(way, axis=0)).max(axis=1).min() > 0.0
    for begin, end in pairwise(way):
        assert space.is_certain(begin, end, 0.1, margin)
        count = max(1, int(np.ceil(np.abs(end - begin).max() / 0.1)))
        for share in np.arange(1, count + 1) / count:
            assert space.contact(begin + (end - begin) * share) is None
    assert not space.is_certain(space.start, question.goals[0], 0.1, margin)
    assert space.connected(question.goals, 0.1, margin, rng, lambda count: False) is None


def test_lines_that_are_certain_keep_the_limits_of_joints_and_of_actuators() -> None:
    snapshot = with_robots("iiwa")
    question = query(snapshot, "iiwa", LEFT)
    first = np.eye(len(question.lower))[0]
    coupled = replace(question, ratios=first[None], least=np.array([-0.5]), most=np.array([0.5]))
    for one, most in ((question, question.upper[0]), (coupled, 0.5)):
        space = PathSpace(scene_of(snapshot), snapshot, one, lambda: False)
        for beyond in (-1e-6, 1e-6):
            assert space.is_certain(space.start, space.start + (most + beyond - space.start[0]) * first, 0.1, 0.0) == (
                beyond < 0
            )


def test_all_of_a_rounded_motion_but_its_corners_is_on_the_lines_between_waypoints(
    rng: np.random.Generator, draws: Draws
) -> None:
    """A sample is on a line where its ways to both ends are as long together as the line is."""
    snapshot = walled()
    question = query(snapshot, "iiwa", RIGHT)
    start = snapshot.state.q[question.q_index]
    for _ in range(draws(10)):
        waypoints = np.vstack([start, rng.uniform(question.lower, question.upper, (3, len(start)))])
        program, _ = planned_program(snapshot, question, waypoints, [float(rng.uniform(5.0, 50.0)), 20.0, 0.0])
        begins, ends = waypoints[:-1], waypoints[1:]
        stages = [stage.plan.tracks[0].path for stage in program.stages if stage.plan is not None]
        corners = 0
        for path in stages:
            stretches = off_lines(path, waypoints)
            corners += len(stretches)
            assert all(end < begin for (_, end), (begin, _) in pairwise(stretches)), "they are apart"
            for u in np.linspace(path.start, path.end, 200):
                q = path.evaluate(u)
                ways = np.linalg.norm(q - begins, axis=1) + np.linalg.norm(q - ends, axis=1)
                far = float((ways - np.linalg.norm(ends - begins, axis=1)).min())
                assert far < 1e-8 or any(begin <= u <= end for begin, end in stretches)
        assert corners + len(stages) - 1 == 2, "a corner is rounded, or two motions meet there at rest"
        lines = [off_lines(path, path.evaluate(path.breaks[[0, -1]])) for path in stages]
        assert all(lines) or len(stages) > 1, "without the waypoint between, what is beyond the corner is on no line"
