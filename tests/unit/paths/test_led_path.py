"""Arms of seven joints, one of which is held: their postures, and their joints along a path, exactly."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.free_path import FreePath, frame_path, frame_t_tool, frame_t_tools, within_hull
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.spline import rotations, spline
from virtualrobot_kernel.paths.carriers import carriers_of, externals_of
from virtualrobot_kernel.paths.closed_forms import Carriers, LedArm, led_arm
from virtualrobot_kernel.paths.led_path import LedPath
from virtualrobot_kernel.paths.tool_grid import (
    FEWEST_RUNGS,
    freedom_of,
    grid_of,
    laid_out,
    rungs_of,
    smoothed,
    turned_within,
)
from virtualrobot_kernel.paths.tool_query import Tolerances
from virtualrobot_kernel.paths.tool_reasons import Places
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_plugins import models
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE, SerialChain
from virtualrobot_sdk.poses import inverse, rotation_matrix
from virtualrobot_sdk.reference import joint_motion, tip_pose
from virtualrobot_sdk.testing.chains import iiwa, ur5

from tests.unit.collision.worlds import robot_nodes, world
from tests.unit.sdk.test_meeting_axes import panda

POSTURE = np.array([0.2, 0.6, 0.3, -1.4, 0.3, 0.9, 0.1])
TOOL = np.eye(4) + 0.1 * (np.arange(16).reshape(4, 4) == 11)


def on_a_rail() -> SerialChain:
    """Return a UR5 on a rail of 2 m along y, which is its first joint."""
    arm = ur5()
    return arm._replace(
        pre=np.concatenate([np.eye(4)[None], arm.pre]),
        axis=np.concatenate([[[0.0, 1.0, 0.0]], arm.axis]),
        joint_type=np.append(np.int8(PRISMATIC), arm.joint_type).astype(np.int8),
        q_index=np.arange(7, dtype=np.int32),
        multiplier=np.ones(7),
        offset=np.zeros(7),
        lower=np.append(0.0, arm.lower),
        upper=np.append(2.0, arm.upper),
        joint_names=("slide", *arm.joint_names),
    )


ARMS = {"iiwa": (iiwa, 2), "panda": (panda, 6), "ur5 on a rail": (on_a_rail, 0)}


@pytest.mark.parametrize("name", ARMS)
def test_a_joint_is_held_and_the_others_lead_to_the_pose(seed: int, name: str) -> None:
    make, held = ARMS[name]
    arm = led_arm(make())
    assert arm.held == held
    given = np.random.default_rng(seed).uniform(-1.5, 1.5, (12, 7))
    given[:, held] = np.abs(given[:, held]) * np.where(np.arange(12) < 9, 1.0, 0.0)
    poses = tip_pose(arm.chain, given)
    q, clear = arm.postures(poses, given[:, [held]])
    there = np.isfinite(q).all(axis=2)
    assert np.any(there, axis=1).all() and q.shape == (12, 8, 7) and clear.shape == (12, 8)
    np.testing.assert_allclose(tip_pose(arm.chain, q[there]), np.repeat(poses, there.sum(axis=1), axis=0), atol=1e-6)
    assert (q[..., held][there] == np.repeat(given[:, held], there.sum(axis=1))).all()


def test_arms_without_a_closed_form_are_told_what_they_lack() -> None:
    with pytest.raises(ArgumentError, match=r"the arm has 7 joints .* whichever of them is held"):
        led_arm(
            iiwa()._replace(
                pre=iiwa().pre + 0.05 * (np.arange(16).reshape(4, 4) % 4 == 3) * (np.arange(4) < 3)[:, None]
            )
        )
    with pytest.raises(ArgumentError, match="whichever of them is held"):
        led_arm(on_a_rail()._replace(q_index=np.array([0, 1, 2, 3, 4, 5, 5], np.int32)))


def turned(values: np.ndarray) -> np.ndarray:
    """Return where a table 0.6 m before the base stands (..., 4, 4), which turns about z by what its joint says."""
    table = joint_motion(REVOLUTE, np.array([0.0, 0.0, 1.0]), values[..., 0])
    table[..., :3, 3] = 0.6, 0.0, 0.1
    return table


TABLE = Carriers(np.array([-3.0]), np.array([3.0]), np.array([True]), turned)


def test_external_axes_carry_the_path(seed: int) -> None:
    """A posture's pose in the table's frame, with the table turned: the postures that reach there are that one's."""
    arm = led_arm(ur5(), TABLE)
    assert arm.free == [6] and arm.solved == list(range(6)) and arm.turns.all()
    rng = np.random.default_rng(seed)
    given, angles = rng.uniform(-1.5, 1.5, (9, 6)), rng.uniform(-3.0, 3.0, (9, 1))
    poses = np.array([inverse(turned(a)) @ tip_pose(arm.chain, q) for a, q in zip(angles, given, strict=True)])
    q, _ = arm.postures(poses, angles)
    there = np.isfinite(q).all(axis=2)
    assert (q[..., 6][there] == np.repeat(angles, there.sum(axis=1))).all()
    off = np.abs(q[:, :, :6] - given[:, None])
    off = np.where(there, np.abs(off - 2.0 * np.pi * np.round(off / (2.0 * np.pi))).max(axis=2), np.inf).min(axis=1)
    assert off.max() < 1e-5


def test_poses_in_arrays_are_those_one_by_one(seed: int) -> None:
    """Of a path and of freedoms, before its start and behind its end, too; and turns as small as none."""
    path, _, _ = along(led_arm(iiwa()), np.array([0.3, 0.3]))
    u = np.linspace(-5e-4, 1.0 + 5e-4, 60)
    np.testing.assert_allclose(path.poses(u), [path.pose(one) for one in u.tolist()], atol=1e-13)
    rng = np.random.default_rng(seed)
    freedoms = rng.uniform(-3.0, 3.0, (20, 6))
    np.testing.assert_allclose(frame_t_tools(freedoms), [frame_t_tool(one) for one in freedoms], atol=1e-14)
    vectors = np.concatenate([freedoms[:, :3], 1e-9 * freedoms[:2, :3], np.zeros((1, 3))])
    np.testing.assert_allclose(rotations(vectors), [rotation_matrix(one) for one in vectors], atol=1e-14)


@pytest.mark.parametrize("carried", ["positioner", "rail"])
def test_external_axes_carry_as_the_world_says(seed: int, carried: str) -> None:
    """A product of joint motions, against the world's own poses: a table of two axes, and an arm on a carriage."""
    folder = models.__path__[0]
    here = world(CreateNodes(robot_nodes(f"{folder}/{carried}.urdf", "axes")))
    base, reference = ("axes", "axes.plate") if carried == "positioner" else ("axes.carriage", "axes")
    base_uid, reference_uid = (here.structure.node(name).uid for name in (base, reference))
    externals = externals_of(here, "arm", base_uid, reference_uid, ("axes",))
    found = carriers_of(here, base_uid, reference_uid, externals)
    assert found is not None and found.base_t_reference.__name__ == "base_t_reference"  # the quick one
    least, most = np.clip([found.lower, found.upper], -np.pi, np.pi)
    values = np.random.default_rng(seed).uniform(least, most, (4, len(found.lower)))
    worlds = [standing_at(here, externals[0].q_index, one) for one in values]
    exact = [inverse(one.world_t(base_uid)) @ one.world_t(reference_uid) for one in worlds]
    np.testing.assert_allclose(found.base_t_reference(values), exact, atol=1e-12)
    np.testing.assert_array_equal(found.base_t_reference(values[0]), found.base_t_reference(values)[0])


def test_a_tool_stays_on_a_path_that_a_table_carries() -> None:
    """In the table's frame, while it turns by 0.4 rad, and with the third joint of seven going its own way, too."""
    arm = led_arm(iiwa(), TABLE)
    assert arm.free == [2, 7]
    path, held_path, limits = along(arm, np.array([[0.3, 0.0], [0.5, 0.4]]))
    joints = held_path.joints(np.append(POSTURE, 0.0), limits)
    for u in np.linspace(0.0, 1.0, 33):
        at = joints.evaluate(np.array([u]))[0]
        pose = inverse(turned(at[7:])) @ tip_pose(arm.chain, at[:7]) @ TOOL
        assert np.abs(path.deviation(u, pose)).max() < 1e-7
    ends = joints.evaluate(np.array([0.0, 1.0]))[:, 7]
    assert ends[0] == pytest.approx(0.0, abs=0.05) and ends[1] == pytest.approx(0.4, abs=0.05)


def along(arm: LedArm, held: np.ndarray, limits: float = 10.0) -> tuple[FreePath, LedPath, JointLimits]:
    """Return a path of a tool from POSTURE, on a bend of 0.2 m, whose joint that is held goes over values."""
    rows = held.reshape(len(held), -1)
    begin = inverse(arm.base_t_reference(rows[0])) @ tip_pose(arm.chain, POSTURE) @ TOOL
    frames = []
    for share in np.linspace(0.0, 1.0, 9):
        frame = begin.copy()
        frame[:3, :3] = rotation_matrix(np.array([0.0, 0.2 * share, 0.3 * share])) @ begin[:3, :3]
        frame[:3, 3] += [0.0, 0.15 * share, 0.05 * np.sin(np.pi * share)]
        frames.append(frame)
    path = frame_path(spline(frames[0], frames[1:]))
    rungs = rungs_of(path, 0.02)
    freedoms = np.zeros((len(rungs) + 2, 6))
    freedoms[:, 5] = 0.2 * np.sin(np.linspace(0.0, 3.0, len(freedoms))) - 0.2 * np.sin(0.0)
    freedoms[:2, 5] = 0.0
    free = FreePath(path.pose(0.0), path, within_hull(rungs, freedoms))
    at = np.linspace(0.0, 1.0, len(rungs) + 2), np.linspace(0.0, 1.0, len(held))
    values = np.stack([np.interp(*at, column) for column in rows.T], axis=1)
    branches = arm.postures((free.pose(0.0) @ inverse(TOOL))[None], values[1:2])[0][0]
    branch = int(np.nanargmin(np.abs(branches[:, :7] - POSTURE).max(axis=1)))
    ends = np.full(len(arm.turns), limits)
    names = ("a", "b", "c", "d", "e", "f", "g", "h")[: len(ends)]
    kept = JointLimits(names=names, lower=-ends, upper=ends, velocity=ends, acceleration=ends, jerk=ends)
    return free, LedPath(arm, TOOL, free, within_hull(rungs, values), branch, Places("arm", path, rungs)), kept


@pytest.mark.parametrize("held", [[0.3, 0.3], [0.3, 0.5, 0.1]], ids=["stands", "moves"])
def test_the_tool_is_on_its_path_between_the_knots_too(held: list[float]) -> None:
    """To 1e-7 m and rad, and the joint that is held goes as it is told to."""
    arm = led_arm(iiwa())
    path, held_path, limits = along(arm, np.array(held))
    joints = held_path.joints(POSTURE, limits)
    for u in np.linspace(0.0, 1.0, 57):
        at = joints.evaluate(np.array([u]))[0]
        assert np.abs(path.deviation(u, tip_pose(arm.chain, at) @ TOOL)).max() < 1e-7
    states = joints.states(np.linspace(0.0, 1.0, 400), 2)
    # Twice continuously differentiable: what derivatives say is what differences of the values are.
    slope = np.gradient(states[0], np.linspace(0.0, 1.0, 400), axis=0)
    np.testing.assert_allclose(slope[2:-2], states[1][2:-2], atol=2e-3 * np.abs(states[1]).max())


def test_what_is_beyond_a_limit_or_out_of_reach_is_told_with_its_place() -> None:
    arm = led_arm(iiwa())
    _, held_path, limits = along(arm, np.array([0.3, 0.3]), 1.39)
    with pytest.raises(KernelError, match=r"joint .* beyond its limits") as beyond:
        held_path.joints(POSTURE, limits)
    assert beyond.value.reason is Reason.LIMIT_EXCEEDED and "fraction" in beyond.value.metadata


def test_the_values_of_a_held_joint_are_its_limits_and_a_rail_goes_in_longer_steps() -> None:
    still = Tolerances(np.zeros((2, 6)), np.arange(6) == 5)
    freedom, steps = freedom_of(still, led_arm(on_a_rail()))
    assert freedom.bounds[:, 6].tolist() == [0.0, 2.0] and steps[6] == 0.05 and not freedom.endless[6]
    grid = grid_of(freedom, steps, 20)
    assert len(np.unique(grid.values[:, 6])) == 36 and len(np.unique(grid.values[:, 5])) == 36
    turning, _ = freedom_of(still, led_arm(iiwa()._replace(lower=np.full(7, -np.inf), upper=np.full(7, np.inf))))
    assert turning.endless.tolist() == [False] * 5 + [True, True]
    assert freedom_of(still, LedArm(ur5()))[0].bounds.shape == (2, 6)


@pytest.mark.parametrize("speed", [0.01, 0.05, 0.5])
def test_each_free_joint_has_the_time_for_a_step_of_its_values(speed: float) -> None:
    """A table that turns and one of seven joints, at 1.5 rad/s: the way from rung to rung is long enough for both."""
    arm = led_arm(iiwa(), TABLE)
    begin = np.eye(4)
    frames = [begin + 0.1 * place * (np.arange(16).reshape(4, 4) == 3) for place in range(8)]
    path = frame_path(spline(frames[0], frames[1:]))
    freedom, steps = freedom_of(Tolerances(np.zeros((2, 6)), np.arange(6) == 5), arm)
    rungs, grid = laid_out(path, freedom, steps, np.full(2, speed / 1.5))
    apart = np.diff(rungs).mean() * path.length
    widest = max(np.diff(np.unique(column)).max() for column in grid.values[:, 6:].T)
    assert len(rungs) * len(grid.values) <= 60_000
    assert len(rungs) <= FEWEST_RUNGS or widest * speed / 1.5 <= 1.05 * apart


@pytest.mark.parametrize("turn", [2.0 * np.pi, 4.0 * np.pi], ids=["once", "twice"])
def test_free_values_round_a_circle_go_as_evenly_as_the_circle_does(turn: float) -> None:
    """With x along the way and a tool that stands still it is a ramp, of which the ladder has steps of ten degrees.

    The ramp beats with these steps; what is left of that is 2% of its slope, and a tenth of the bends.
    """
    step = np.radians(10.0)
    ramp = np.linspace(0.0, -turn, int(turn / 0.1) + 1)
    stairs = step * np.round(ramp / step)
    wrapped = np.zeros((len(ramp), 6))
    wrapped[:, 5] = stairs - 2.0 * np.pi * np.round(stairs / (2.0 * np.pi))
    free = Tolerances(np.zeros((2, 6)), np.arange(6) == 5)
    soft, stiff = (smoothed(wrapped, free, stiffness)[1:-1, 5] for stiffness in (1e3, 1e6))
    np.testing.assert_allclose(stiff, ramp, atol=0.5 * step)
    inner = np.s_[8:-8]
    assert np.abs(np.diff(stiff, 2)[inner]).max() < 0.1 * np.abs(np.diff(soft, 2)[inner]).max()
    assert np.abs(np.diff(stiff)[inner] + turn / (len(ramp) - 1)).max() < 0.02 * 0.1


def test_smoothed_values_stay_within_their_bounds_and_others_as_they_are() -> None:
    values = np.zeros((20, 6))
    values[:, 3] = np.where(np.arange(20) < 10, -0.2, 0.2)
    bounds = np.zeros((2, 6))
    bounds[:, 3] = -0.2, 0.2
    found = smoothed(values, Tolerances(bounds, np.zeros(6, np.bool_)), 10.0)
    assert found.shape == (22, 6) and np.abs(found[:, 3]).max() <= 0.2 and not found[:, [0, 1, 2, 4, 5]].any()
    assert np.abs(np.diff(found[:, 3])).max() < 0.2
    np.testing.assert_array_equal(smoothed(values, Tolerances(bounds, np.zeros(6, np.bool_)), 0.0)[1:-1], values)


def test_no_turn_is_wished_where_any_will_do() -> None:
    bounds = np.zeros((2, 6))
    bounds[:, 3] = -0.2, 0.2
    grid = grid_of(Tolerances(bounds, np.arange(6) == 5), np.append(np.full(3, 0.002), np.full(3, 0.1)), 20)
    for tilt in np.unique(grid.values[:, 3]):
        same = grid.wish[grid.values[:, 3] == tilt]
        assert np.ptp(same) == 0.0 and (same[0] == 0.0) == (abs(tilt) < 1e-12)


def test_a_way_is_turned_into_its_limits_as_a_whole() -> None:
    """Ways of 1 rad: from 7 and from 0.5 rad on, of a joint with less room, and of one without limits."""
    joints = np.array([[7.0, 0.5, 3.0, 40.0], [8.0, 1.5, 4.0, 41.0]])
    limits = np.array([[-6.3, -6.3, -0.4, -np.inf], [6.3, 6.3, 0.4, np.inf]])
    shifts, beyond = turned_within(joints, limits)
    np.testing.assert_allclose(shifts[[0, 1, 3]], [-2.0 * np.pi, 0.0, 0.0])
    assert beyond.tolist() == [False, False, True, False]
