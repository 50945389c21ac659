"""Programs, and two arms at once, that go along with a belt."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.motion.signals import Condition
from virtualrobot_kernel.motion.tracking_motion import TrackingMotion
from virtualrobot_kernel.planning.moves import Linear, PointToPoint
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import DwellStep, MotionSpec, MoveStep, TrackingSpec, WaitSignalStep, Zone
from virtualrobot_kernel.planning.robots import tcp_frame
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import Command, CreateNodes, CreateSignal, SetJointPositions, SetSignal
from virtualrobot_kernel.world.state import Motion, Signal
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, NodeSpec, RobotData
from virtualrobot_sdk.poses import inverse

from tests.unit.formats.models import ROBOTS, load
from tests.unit.planning.cell import TICK, chain, pictured
from tests.unit.planning.tracking_cell import BELT
from tests.unit.world.builders import after, empty, link, shifted, ticked

DOWN = [-0.6, 0.6, 0.0, -1.4, 0.0, np.pi - 2.0, 0.0]
TRAY = "conveyor.tray"


def world(*names: str) -> Change:
    """Return iiwas whose tools look down on a belt along y from both its sides."""
    change = empty()
    for name in names:
        place = np.eye(4)
        if name == "right":
            place[:3, :3] = Rotation.from_euler("z", np.pi).as_matrix()
            place[:3, 3] = 1.0, -0.7, 0.0
        model = load(ROBOTS["iiwa"], name=name, parent_t_node=place)[0]
        sign = -1.0 if name == "right" else 1.0  # so that both begin where the belt comes from
        posture = [DOWN[0] * sign, *DOWN[1:]]
        joints = {f"lbr_iiwa_joint_{i}": value for i, value in enumerate(posture, 1)}
        change = after(change, CreateNodes(tuple(model.nodes)), SetJointPositions(name, joints))
    belt = Joint("run", JointType.PRISMATIC, (0.0, 1.0, 0.0), BELT)
    robot = NodeSpec("conveyor", Kind.ROBOT, "world", shifted(x=0.5), data=RobotData())
    return after(change, CreateNodes((robot, link(TRAY, "conveyor", belt))))


def tray_t(change: Change, robot: str) -> np.ndarray:
    """Return where a tool centre point is in the tray's frame."""
    snapshot = pictured(change)
    tray = snapshot.world_t(snapshot.structure.node(TRAY).uid)
    return inverse(tray) @ tcp_frame(snapshot, snapshot.structure.node(robot))


def started(change: Change, wish: MotionSpec, *before: Command) -> Change:
    """Return the world with the belt on its way at 0.12 m/s, and the motion started."""
    change = after(change, *before)
    run = MotionSpec((PointToPoint("conveyor", {"run": 10.0}, 0.2),))
    change = after(change, plan_motion(pictured(change), run, chain).command)
    change = ticked(change, 20)
    return after(change, plan_motion(pictured(change), wish, chain).command)


def following(change: Change) -> Motion:
    state = change.state
    return next(motion for motion in (*state.motions, *state.ended) if motion.tracked_joint)


def in_step(motion: Motion) -> bool:
    assert isinstance(motion.running, TrackingMotion)
    return motion.running.in_step


def line(robot: str, goal: np.ndarray) -> Linear:
    return Linear(robot, PoseGoal(goal, TRAY))


@pytest.mark.long
@pytest.mark.parametrize("zone", [None, Zone(meters=0.02)])
def test_a_program_is_done_on_the_belt(zone: Zone | None) -> None:
    """Over, down, waiting for a signal and for a while, up again: the path on the belt is that of the program."""
    change = world("left")
    start = tray_t(change, "left")
    goals = [start @ shifted(x=0.06), start @ shifted(x=0.06, z=0.06)]
    steps = (
        MoveStep((line("left", goals[0]),), zone),
        MoveStep((line("left", goals[1]),)),
        WaitSignalStep(Condition("held")),
        DwellStep(0.1),
        MoveStep((line("left", goals[0]),)),
    )
    wish = MotionSpec(steps=steps, tracking=TrackingSpec(TRAY, 0.8, 0.15))
    change = started(change, wish, CreateSignal(Signal("held", False)))
    begin = tray_t(change, "left")
    path, waited = [], 0
    while not (motion := following(change)).running.ended:
        change = ticked(change)
        motion = following(change)
        if in_step(motion):
            path.append((motion.running.steps_done, tray_t(change, "left")[:3, 3]))
        if motion.running.phase is Phase.WAITING:
            np.testing.assert_allclose(tray_t(change, "left"), goals[1], atol=1e-5)
            waited += 1
            if waited == 50:
                change = after(change, SetSignal("held", True))
    assert motion.running.phase is Phase.SUCCEEDED, motion.cancellation
    assert waited >= 50 + int(0.1 / TICK) - 2
    points = np.array([place for _, place in path])
    polygon = [begin[:3, 3], goals[0][:3, 3], goals[1][:3, 3]]
    off = np.min([_distances(points, a, b) for a, b in pairwise(polygon)], axis=0)
    if zone is None:
        assert off.max() < 1e-5
    else:
        near = np.linalg.norm(points - polygon[1], axis=1) <= zone.meters + 1e-5
        assert off[~near].max() < 1e-5
        assert 1e-4 < off[near].max() < zone.meters
    np.testing.assert_allclose(points[-1], goals[0][:3, 3], atol=1e-5)


def _distances(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return how far points (m, 3) are from a segment."""
    share = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(points - a - share[:, None] * (b - a), axis=1)


def test_two_arms_work_on_one_belt() -> None:
    change = world("left", "right")
    goals = {name: tray_t(change, name) @ shifted(z=0.05) for name in ("left", "right")}
    wish = MotionSpec(tuple(line(name, goal) for name, goal in goals.items()), tracking=TrackingSpec(TRAY, 0.6, 0.15))
    change = started(change, wish)
    starts = {name: tray_t(change, name)[:3, 3] for name in goals}
    checked = 0
    while not (motion := following(change)).running.ended:
        change = ticked(change)
        if in_step(following(change)):
            checked += 1
            for name, goal in goals.items():
                here = tray_t(change, name)[:3, 3]
                assert _distances(here[None], starts[name], goal[:3, 3])[0] < 1e-5
    assert motion.running.phase is Phase.SUCCEEDED, motion.cancellation
    assert checked > 50
    assert {change.structure.nodes[uid].name for uid in motion.robots} == {"left", "right"}
