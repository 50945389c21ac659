"""Free paths of an iiwa and a Panda round a wall, looked at by coal; what counts and what is refused."""

from __future__ import annotations

import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_kernel.collision.scene import Detail
from virtualrobot_kernel.errors import KernelError, LimitError, Reason, UnknownNameError
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.paths.find import find_path
from virtualrobot_kernel.paths.program import planned_program
from virtualrobot_kernel.paths.query import PathQuery, cleared
from virtualrobot_kernel.paths.search import FIRST, PLANNERS
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.planning.sampling import joint_states
from virtualrobot_kernel.world.commands import CreateNodes, SetAllowedPairs, SetCollisionSettings
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, NodeSpec, RobotData

from tests.unit.collision.worlds import after, coal_distances, scene_of, with_robots, world
from tests.unit.collision.worlds import asked as pairs_of
from tests.unit.paths.cells import (
    LEFT,
    OPTIONS,
    PANDA_RIGHT,
    RIGHT,
    Floats,
    HereSite,
    query,
    standing,
    touched_on,
    wall,
    walled,
)
from tests.unit.world.builders import link, shifted

pytestmark = pytest.mark.long

GOALS = {"iiwa": RIGHT, "panda": PANDA_RIGHT}


def asked(snapshot: Snapshot, kind: str, **options: object) -> PathQuery:
    return query(snapshot, kind, GOALS[kind], replace(OPTIONS, **options))  # pyright: ignore[reportArgumentType]


def between(waypoints: Floats, step: float = 0.02) -> Floats:
    """Return configurations on the lines between waypoints, no farther apart than a step (rad)."""
    lines = [np.linspace(begin, end, 2 + int(np.abs(end - begin).max() / step)) for begin, end in pairwise(waypoints)]
    return np.concatenate(lines)


def driven(snapshot: Snapshot, question: PathQuery, found: dict) -> tuple[Program, Floats]:
    """Return the motion that the kernel plans of what was found, and where its joints are every 4 ms."""
    program, index = planned_program(snapshot, question, found["waypoints"], found["zones"])
    assert index.tolist() == question.q_index.tolist()
    return program, joint_states(program, np.arange(0.0, program.duration, 0.004))[0]


@pytest.mark.parametrize("kind", ["iiwa", "panda"])
def test_a_path_round_a_wall_is_free_and_so_is_the_motion_along_it(kind: str, seed: int) -> None:
    snapshot = walled(kind)
    question = asked(snapshot, kind, seed=seed % 2**32)
    straight = np.stack([snapshot.state.q[question.q_index], question.goals[0]])
    assert touched_on(snapshot, question.q_index, between(straight))
    found = find_path(HereSite(snapshot), question)
    way = found["waypoints"]
    assert not found["straight"] and len(way) > 2
    np.testing.assert_array_equal(way[[0, -1]], straight)
    assert np.all((question.lower <= way) & (way <= question.upper))
    assert found["length"] == pytest.approx(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
    assert found["length"] > found["straight_length"] == pytest.approx(np.linalg.norm(straight[1] - straight[0]))
    assert touched_on(snapshot, question.q_index, between(way)) == []
    program, positions = driven(snapshot, question, found)
    assert program.duration == pytest.approx(found["duration"])
    assert touched_on(snapshot, question.q_index, positions) == []
    assert touched_on(snapshot, question.q_index, straight) == []


def test_the_same_seed_finds_the_same_path_and_another_one_another() -> None:
    snapshot = walled()
    paths = [find_path(HereSite(snapshot), asked(snapshot, "iiwa", seed=seed)) for seed in (5, 5, 6)]
    np.testing.assert_array_equal(paths[0]["waypoints"], paths[1]["waypoints"])
    assert paths[0]["zones"] == paths[1]["zones"]
    assert paths[0]["waypoints"].shape != paths[2]["waypoints"].shape or (
        np.abs(paths[0]["waypoints"] - paths[2]["waypoints"]).max() > 1e-3
    )


def test_a_free_straight_way_is_the_path() -> None:
    snapshot = standing(with_robots("iiwa"), "iiwa", LEFT)
    found = find_path(HereSite(snapshot), asked(snapshot, "iiwa"))
    assert found["straight"] and found["states"] == 0 and found["zones"] == (0.0,)
    np.testing.assert_array_equal(found["waypoints"][1], found["waypoints"][0] * [-1, 1, 1, 1, 1, 1, 1])
    assert found["length"] == found["straight_length"] == pytest.approx(1.8)


def test_a_wall_thinner_than_a_step_is_no_gap() -> None:
    """A sheet of a tenth of a millimetre before the iiwa: places 0.1 rad apart are on either side of it."""
    sheet = Figure(Box((0.6, 0.0001, 0.8)))
    specs = CreateNodes((NodeSpec("sheet", Kind.OBJECT, "world", shifted(x=0.9, z=0.4), figures=(sheet,)),))
    snapshot = standing(after(with_robots("iiwa"), specs), "iiwa", LEFT)
    question = asked(snapshot, "iiwa")
    found = find_path(HereSite(snapshot), question)
    assert not found["straight"]
    assert touched_on(snapshot, question.q_index, between(found["waypoints"], 0.001)) == []


def test_what_may_touch_is_in_nobodys_way() -> None:
    snapshot = walled()
    names = [node.name for node in snapshot.structure.nodes.values() if node.kind is Kind.LINK]
    allowed = after(snapshot, SetAllowedPairs(tuple((name, "wall", "paper") for name in names)))
    assert find_path(HereSite(allowed), asked(allowed, "iiwa"))["straight"]


def test_a_path_keeps_the_padding_of_a_wall() -> None:
    """Seven centimetres, by coal's distances along the motion."""
    assert 0.07 - 1e-6 < nearest_on_the_way(after(walled(), SetCollisionSettings(paddings=(("wall", 0.07),)))) < 0.2


def test_a_path_keeps_a_clearance_from_what_is_not_the_robots_and_from_paddings() -> None:
    """Seven centimetres; with a padding of three there are ten. Links of the arm are nearer to each other than that."""
    assert 0.07 - 1e-6 < nearest_on_the_way(walled(), 0.07) < 0.2
    padded = after(walled(), SetCollisionSettings(paddings=(("wall", 0.03),)))
    assert 0.10 - 1e-6 < nearest_on_the_way(padded, 0.07) < 0.23


def nearest_on_the_way(snapshot: Snapshot, clearance: float = 0.0) -> float:
    """Return how near the iiwa comes to a wall on the way that is found, in m by coal, which knows of no padding."""
    question = asked(snapshot, "iiwa", clearance=clearance)
    there = cleared(snapshot, snapshot.structure.node("iiwa"), clearance)
    found = find_path(HereSite(there), question)
    assert not found["straight"]
    scene = scene_of(snapshot)
    uid = snapshot.structure.node("wall").uid
    pairs = [pair for pair in pairs_of(scene) if uid in pair and "link_0" not in _names(snapshot, pair)]
    program, positions = driven(snapshot, question, found)
    assert program.duration > 0.0
    nearest = []
    for q in positions[::5]:
        scene.place(standing_at(snapshot, question.q_index, q))
        nearest.append(min(coal_distances(scene, pairs)))
    return min(nearest)


def test_a_start_nearer_than_the_clearance_is_refused_with_what_is_near() -> None:
    snapshot = walled(distance=0.0)
    question = asked(snapshot, "iiwa", clearance=0.3)
    there = cleared(snapshot, snapshot.structure.node("iiwa"), 0.3)
    with pytest.raises(
        KernelError, match=r"at the start of the path 'iiwa' .* is nearer to 'wall' than 0.3 m"
    ) as refusal:
        find_path(HereSite(there), question)
    assert refusal.value.reason is Reason.COLLISION


def _names(snapshot: Snapshot, pair: tuple[int, int]) -> str:
    return " ".join(snapshot.structure.nodes[uid].name for uid in pair)


def test_what_stands_in_the_floor_does_not_count() -> None:
    """The base of the iiwa touches a floor, which the arm does not move: only its links count."""
    floor = NodeSpec("floor", Kind.OBJECT, "world", shifted(z=-0.05), figures=(Figure(Box((3.0, 3.0, 0.11))),))
    snapshot = standing(after(with_robots("iiwa"), CreateNodes((floor,)), wall()), "iiwa", LEFT)
    question = asked(snapshot, "iiwa")
    assert HereSite(snapshot).scene.collisions(Detail.FIRST)
    found = find_path(HereSite(snapshot), question)
    assert touched_on(snapshot, question.q_index, between(found["waypoints"])) == []


def test_a_joint_without_limits_goes_the_other_way_round() -> None:
    """A beam of 60 cm turns from 0 to 120 degrees with a post at 60: only the way by -240 degrees is left."""
    limits = JointLimits(-np.inf, np.inf, 1.0, 4.0, 40.0)
    beam = Figure(Box((0.6, 0.05, 0.05)))
    specs = (
        NodeSpec("turner", Kind.ROBOT, data=RobotData(flange="hand")),
        link("axis", "turner", Joint("turn", JointType.CONTINUOUS, (0.0, 0.0, 1.0), limits), shifted(z=0.3)),
        replace(link("hand", "axis", Joint("fixed"), shifted(x=0.3)), figures=(beam,)),
        NodeSpec("post", Kind.OBJECT, "world", shifted(x=0.25, y=0.43), figures=(Figure(Box((0.05, 0.05, 1.0))),)),
    )
    snapshot = world(CreateNodes(specs))
    goal = np.radians(120.0)
    question = query(snapshot, "turner", {"turn": float(goal)})
    np.testing.assert_allclose(question.goals, [[goal], [goal - 2 * np.pi]])
    found = find_path(HereSite(snapshot), question)
    assert not found["straight"]
    np.testing.assert_allclose(found["waypoints"][[0, -1]], [[0.0], [goal - 2 * np.pi]])
    assert touched_on(snapshot, question.q_index, between(found["waypoints"])) == []


def test_start_and_goal_that_touch_are_refused_by_name() -> None:
    snapshot = walled()
    inside = {**LEFT, "lbr_iiwa_joint_1": 0.0}
    with pytest.raises(KernelError, match=r"at the goal of the path 'iiwa' is in collision: .* touches 'wall'") as one:
        find_path(HereSite(snapshot), query(snapshot, "iiwa", inside))
    assert one.value.reason is Reason.COLLISION and one.value.metadata["second"] == "wall"
    there = standing(snapshot, "iiwa", inside)
    with pytest.raises(KernelError, match=r"at the start of the path .* touches 'wall'"):
        find_path(HereSite(there), query(there, "iiwa", LEFT))


def test_a_goal_behind_a_wall_without_end_is_refused_in_time() -> None:
    """Walls before and behind the iiwa, and one above its shoulder: nothing comes past, but both sides are free."""
    sizes = (((2.0, 0.05, 3.0), 1.2, 0.0), ((2.0, 0.05, 3.0), -1.2, 0.0), ((0.5, 0.05, 2.0), 0.0, 1.6))
    specs = [
        NodeSpec(f"wall {number}", Kind.OBJECT, "world", shifted(x=x, z=z), figures=(Figure(Box(size)),))
        for number, (size, x, z) in enumerate(sizes)
    ]
    snapshot = standing(after(with_robots("iiwa"), CreateNodes(tuple(specs))), "iiwa", LEFT)
    with pytest.raises(KernelError, match=r"no path of 'iiwa' .* in 1 s") as one:
        find_path(HereSite(snapshot), asked(snapshot, "iiwa", time_limit=1.0))
    assert one.value.reason is Reason.UNREACHABLE and int(one.value.metadata["states"]) > 0


def test_names_and_limits() -> None:
    snapshot = walled()
    with pytest.raises(LimitError, match="lbr_iiwa_joint_2"):
        query(snapshot, "iiwa", {"lbr_iiwa_joint_2": 3.0})
    with pytest.raises(UnknownNameError, match="joint"):
        query(snapshot, "iiwa", {"elbow": 0.0})
    hand = with_robots("panda")
    with pytest.raises(UnknownNameError, match="moves the flange of 'panda'"):
        query(hand, "panda", {"panda_finger_joint1": 0.02})


def test_without_ompl_the_refusal_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ompl", None)
    snapshot = walled()
    with pytest.raises(KernelError, match=r"pip install 'virtualrobot\[planning\]'") as one:
        find_path(HereSite(snapshot), asked(snapshot, "iiwa"))
    assert one.value.reason is Reason.WRONG_STATE


def test_who_goes_away_ends_the_search() -> None:
    snapshot = walled()
    site = HereSite(snapshot)
    site.told = lambda value: site.gone.set()  # pyright: ignore[reportAttributeAccessIssue]
    with pytest.raises((InterruptedError, KernelError)):
        find_path(site, asked(snapshot, "iiwa", planner="RRTstar", time_limit=600.0))


@pytest.mark.parametrize("planner", PLANNERS)
def test_each_planner_finds_a_way(planner: str) -> None:
    snapshot = walled()
    question = asked(snapshot, "iiwa", planner=planner, time_limit=60.0 if planner in FIRST else 5.0)
    found = find_path(HereSite(snapshot), question)
    assert found["planner"] == planner
    assert touched_on(snapshot, question.q_index, between(found["waypoints"], 0.05)) == []
