"""Tool paths of a Puma: which of many seams it has a way for, against all ways on a finer grid; turns, and progress."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import KDTree
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.free_path import frame_path, frame_t_tool
from virtualrobot_kernel.motion.path import smooth_path
from virtualrobot_kernel.motion.spline import spline
from virtualrobot_kernel.paths.tool_path import find_tool_path
from virtualrobot_kernel.paths.tool_query import Tolerances, ToolPathAsked, ToolPathQuery, tool_path_query
from virtualrobot_kernel.planning.planned_move import joint_limits
from virtualrobot_kernel.planning.robots import arm_of, standing_at
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.groups import WHOLE
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind
from virtualrobot_plugins import models
from virtualrobot_sdk.compiled.closed import BRANCHES, inverse_many, spherical_wrist
from virtualrobot_sdk.poses import inverse, rotation_matrix
from virtualrobot_sdk.reference import tip_pose

from tests.unit.collision.worlds import robot_nodes, with_robots, world
from tests.unit.paths.cells import HereSite
from tests.unit.world.builders import shifted

pytestmark = pytest.mark.long

Floats = NDArray[np.float64]

SPEED, SEAMS = 0.08, 10
ABOUT_Z = np.arange(6) == 5
FOLDER = models.__path__[0]
PUMA = f"{FOLDER}/puma560.urdf"


@cache
def puma() -> Snapshot:
    return world(CreateNodes(robot_nodes(PUMA, "arm")))


def asked(frames: Floats, bounds: Floats | None = None, endless: NDArray[np.bool_] = ABOUT_Z) -> ToolPathQuery:
    tolerances = Tolerances(np.zeros((2, 6)) if bounds is None else bounds, endless)
    return tool_path_query(puma(), "arm", ToolPathAsked(WHOLE, frames, "", tolerances, SPEED, 0.0, 60.0))


def arc(centre: Floats, turn: Floats, radius: float, angle: float, count: int = 25) -> Floats:
    """Return frames on an arc, the tool along its axis, x along the way; all turned by a rotation (3, 3)."""
    frames = np.tile(np.eye(4), (count, 1, 1))
    for frame, at in zip(frames, np.linspace(0.0, angle, count), strict=True):
        x, z = np.array([-np.sin(at), np.cos(at), 0.0]), np.array([0.0, 0.0, -1.0])
        frame[:3, :3] = turn @ np.stack([x, np.cross(z, x), z], axis=1)
        frame[:3, 3] = centre + radius * turn @ np.array([np.cos(at), np.sin(at), 0.0])
    return frames


def seams(count: int) -> list[Floats]:
    """Return arcs of 0.1 to 0.25 m somewhere about the arm, tools pointing anywhere downward; many out of reach."""
    rng = np.random.default_rng(23)
    found = []
    for _ in range(count):
        centre = np.array([rng.uniform(0.1, 0.7), rng.uniform(-0.6, 0.6), rng.uniform(0.3, 1.2)])
        found.append(arc(centre, rotation_matrix(rng.normal(0.0, 0.5, 3)), 0.05, rng.uniform(2.0, 5.0)))
    return found


def has_any_way(query: ToolPathQuery) -> bool:
    """Return whether joints within limits and speeds lead along a path: rungs of 2.5 mm, every 5 degrees, all edges.

    Each step may go from any rotation and branch to any other one, at all turns; nothing is said of accelerations,
    singularities and collisions, which only forbid more.
    """
    snapshot = puma()
    arm = arm_of(snapshot, snapshot.structure.node("arm", Kind.ROBOT))
    chain = arm.serial()
    limits = joint_limits(snapshot, arm.robot, chain.joint_names)[0]
    path = frame_path(spline(query.frames[0], list(query.frames[1:])))
    rungs = np.linspace(0.0, 1.0, int(np.ceil(path.length / 0.0025)) + 1)
    step = limits.velocity * path.length / SPEED / (len(rungs) - 1)
    turned = [frame_t_tool(angle * ABOUT_Z) for angle in np.linspace(-np.pi, np.pi, 72, False)]
    before = None
    for rung in rungs:
        tips = np.array([path.pose(rung) @ one for one in turned]) @ inverse(query.tip_t_tcp)
        q, wrist = np.empty((72, BRANCHES, 6)), np.empty((72, BRANCHES))
        inverse_many(spherical_wrist(chain), tips, q, wrist)
        q = q.reshape(-1, 6)
        q = q[np.isfinite(q[:, 0])]
        for joint in range(6):
            q = np.concatenate([q + 2.0 * np.pi * turns * (np.arange(6) == joint) for turns in (-1, 0, 1)])
            q = q[(limits.lower[joint] <= q[:, joint]) & (q[:, joint] <= limits.upper[joint])]
        if before is not None:
            # Those that are within a step of one before, in every joint: the greatest of them in steps is 1.
            near = KDTree(before / step).query(q / step, p=np.inf, distance_upper_bound=1.0 + 1e-12)[0]
            q = q[np.isfinite(near)]
        if not len(q):
            return False
        before = q
    return True


def test_each_seam_that_has_a_way_on_a_finer_grid_is_led_along() -> None:
    """None is lost, and none is found that has no way."""
    refused: dict[int, KernelError] = {}
    for number, frames in enumerate(seams(SEAMS)):
        try:
            find_tool_path(HereSite(puma()), asked(frames))
        except KernelError as error:
            refused[number] = error
    ways = [has_any_way(asked(frames)) for frames in seams(SEAMS)]
    assert [number not in refused for number in range(SEAMS)] == ways, refused
    assert 2 <= len(refused) <= SEAMS - 4


def test_a_frame_that_turns_for_ever_is_followed_without_turning_the_tool_so_far() -> None:
    """Two turns of an arc: joint 6 has ±266 degrees, so with the rotation fixed it can't be, and is told so."""
    frames = arc(np.array([0.45, -0.15, 0.75]), np.eye(3), 0.05, 4.0 * np.pi, 97)
    with pytest.raises(KernelError) as fixed:
        find_tool_path(HereSite(puma()), asked(frames, endless=np.zeros(6, np.bool_)))
    assert fixed.value.reason is Reason.LIMIT_EXCEEDED
    result = find_tool_path(HereSite(puma()), asked(frames))
    # The frame turns on by two turns against the base, the tool by less than joint 6 has: the rest is its freedom.
    assert np.ptp(result["freedoms"][:, 5]) > 4.0 * np.pi - np.radians(532.0)


def test_joints_keep_their_limits_between_the_rows_too() -> None:
    bounds = np.zeros((2, 6))
    bounds[:, 3:5] = [[-0.3, -0.2], [0.1, 0.4]]
    query = asked(arc(np.array([0.4, -0.2, 0.7]), rotation_matrix(np.array([0.2, -0.3, 0.0])), 0.08, 3.0), bounds)
    result = find_tool_path(HereSite(puma()), query)
    path = smooth_path(*result["trajectory"])
    times = np.linspace(0.0, path.end, 5000)
    limits = joint_limits(puma(), puma().structure.node("arm", Kind.ROBOT), query.joint_names)[0]
    q, v, a = path.states(times, 2)
    assert ((limits.lower <= q) & (q <= limits.upper)).all()
    assert (np.abs(v) <= limits.velocity).all()
    assert (np.abs(a) <= 1.01 * limits.acceleration).all()
    chain = arm_of(puma(), puma().structure.node("arm", Kind.ROBOT)).serial()
    for frame, posture, freedom in zip(query.frames, result["positions"], result["freedoms"], strict=True):
        np.testing.assert_allclose(tip_pose(chain, posture) @ query.tip_t_tcp, frame @ frame_t_tool(freedom), atol=1e-6)
        assert ((bounds[0] - 1e-9 <= freedom) & (freedom <= bounds[1] + 1e-9))[:5].all()


def test_who_gives_up_is_heard_before_the_next_search() -> None:
    site = HereSite(puma())
    site.gone.set()
    with pytest.raises(InterruptedError):
        find_tool_path(site, asked(arc(np.array([0.45, -0.15, 0.75]), np.eye(3), 0.05, 2.0)))
    assert not site.reports


@pytest.mark.parametrize("kind", ["iiwa", "panda"])
def test_an_arm_of_seven_joints_is_led_with_one_of_them_as_a_free_value(kind: str) -> None:
    """All joints keep their limits, and the tool is within 1e-6 m and rad of what its free values say."""
    snapshot = with_robots(kind)
    frames = arc(np.array([0.5, 0.0, 0.35]), np.eye(3), 0.08, 4.0)
    tolerances = Tolerances(np.zeros((2, 6)), ABOUT_Z)
    query = tool_path_query(snapshot, kind, ToolPathAsked(WHOLE, frames, "", tolerances, SPEED, 0.0, 60.0))
    result = find_tool_path(HereSite(snapshot), query)
    chain = arm_of(snapshot, snapshot.structure.node(kind, Kind.ROBOT)).serial()
    path = smooth_path(*result["trajectory"])
    q, v, _ = path.states(np.linspace(0.0, path.end, 2000), 2)
    limits = joint_limits(snapshot, snapshot.structure.node(kind, Kind.ROBOT), query.joint_names)[0]
    assert (
        q.shape[1] == 7 and ((limits.lower <= q) & (q <= limits.upper)).all() and (np.abs(v) <= limits.velocity).all()
    )
    for frame, posture, freedom in zip(query.frames, result["positions"], result["freedoms"], strict=True):
        np.testing.assert_allclose(tip_pose(chain, posture) @ query.tip_t_tcp, frame @ frame_t_tool(freedom), atol=1e-6)


def on_a_rail() -> Snapshot:
    """Return a Puma on the carriage of a rail along y."""
    arm = robot_nodes(PUMA, "arm")
    rail = CreateNodes(robot_nodes(f"{FOLDER}/rail.urdf", "rail"))
    return world(rail, CreateNodes((replace(arm[0], parent="rail.carriage"), *arm[1:])))


def before_a_table() -> Snapshot:
    """Return a Puma before a positioner."""
    table = robot_nodes(f"{FOLDER}/positioner.urdf", "table")
    placed = replace(table[0], parent_t_node=shifted(x=0.55, z=0.2))
    return world(CreateNodes((placed, *table[1:])), CreateNodes(robot_nodes(PUMA, "arm")))


@pytest.mark.parametrize("carried", ["rail", "table"])
def test_external_axes_lead_along_what_the_arm_alone_cannot(carried: str) -> None:
    """2.4 m along a rail, and a ring on a table: in its own frame the tool is on its frames to 1e-6 m and rad."""
    frames = np.tile(np.diag([1.0, -1.0, -1.0, 1.0]), (25, 1, 1))
    share = np.linspace(0.0, 1.0, 25)
    if carried == "rail":
        snapshot, reference = on_a_rail(), ""
        begin = snapshot.world_t(snapshot.structure.node("arm").uid)[:3, 3] + [0.45, -1.2, 0.7]
        frames[:, :3, 3] = begin + 2.4 * share[:, None] * [0.0, 1.0, 0.0]
    else:
        snapshot, reference, angles = before_a_table(), "table.plate", 1.9 * np.pi * share
        frames[:, :3, 3] = np.stack([0.12 * np.cos(angles), 0.12 * np.sin(angles), 0.1 + 0.0 * angles], axis=1)
    still = Tolerances(np.zeros((2, 6)), np.zeros(6, np.bool_))
    given = ToolPathAsked(WHOLE, frames, reference, still, 0.1, 0.0, 120.0, (carried,))
    query = tool_path_query(snapshot, "arm", given)
    result = find_tool_path(HereSite(snapshot), query)
    arm = arm_of(snapshot, snapshot.structure.node("arm", Kind.ROBOT))
    for frame, posture in zip(query.frames, result["positions"], strict=True):
        there = standing_at(snapshot, query.q_index, posture)
        tool = there.world_t(arm.tip) @ query.tip_t_tcp
        np.testing.assert_allclose(tool, there.world_t(query.reference) @ frame, atol=1e-6)
    path = smooth_path(*result["trajectory"])
    q, v, _ = path.states(np.linspace(0.0, path.end, 3000), 2)
    assert ((query.lower <= q) & (q <= query.upper)).all()
    slide = 1.5 if carried == "rail" else 2.5
    assert np.abs(v[:, 6:]).max() <= slide and (carried == "table" or np.ptp(q[:, 6]) > 0.7)
