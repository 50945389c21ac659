"""Trajectories and grippers by actions, sent by roslibpy: what is run, told, cancelled and refused."""

from __future__ import annotations

from collections.abc import Iterator
from queue import Queue
from typing import Any

import pytest
import roslibpy
from virtualrobot import Client

from tests import ros2_control
from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import GUARD, Heard, bridge, roslibpy_client
from tests.waiting import repeated

JOINTS = ("lbr_iiwa_joint_1", "lbr_iiwa_joint_2", "lbr_iiwa_joint_4")
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6  # action_msgs/GoalStatus
FOLLOW = "control_msgs/action/FollowJointTrajectory"


@pytest.fixture
def world(client: Client) -> Iterator[Client]:
    """Return a client of a stepped world with an arm that has a gripper."""
    client.clock.set_stepped()
    arm = client.load_robot(IIWA, name="arm")
    arm.mount("model://parallel_gripper", name="hand")
    yield client
    client.clock.set_realtime()


@pytest.fixture
def ros(world: Client) -> Iterator[roslibpy.Ros]:
    """Return roslibpy, connected to a bridge."""
    with bridge(world) as (url, _), roslibpy_client(url) as ros:
        yield ros


class Goal:
    """A goal that roslibpy has sent, with all that comes back."""

    def __init__(self, ros: roslibpy.Ros, action: str, type: str, goal: dict[str, Any]) -> None:
        """Send it."""
        self._came: Queue[Any] = Queue()
        self.feedback: list[dict[str, Any]] = []
        self._client = roslibpy.ActionClient(ros, action, type)
        sent = roslibpy.Goal(goal)
        self._id = self._client.send_goal(sent, self._came.put, self.feedback.append, self._came.put)

    def result(self) -> Any:  # noqa: ANN401
        """Return status and values of the end; of a goal that was refused the values are words."""
        told = self._came.get(timeout=GUARD)
        return {**told, "status": told["status"].value}

    def cancel(self) -> None:
        """Ask for its end."""
        self._client.cancel_goal(self._id)


def duration(seconds: float) -> dict[str, int]:
    """Return a duration of whole nanoseconds."""
    sec, nanosec = divmod(round(seconds * 1e9), 10**9)
    return {"sec": sec, "nanosec": nanosec}


def trajectory(
    points: list[ros2_control.Point], joints: tuple[str, ...] = JOINTS, start: float = 0.0
) -> dict[str, Any]:
    """Return a trajectory of points."""
    names = ("positions", "velocities", "accelerations")
    told = [
        {"time_from_start": duration(time), **dict(zip(names, map(list, rows), strict=True))} for time, *rows in points
    ]
    return {"header": {"stamp": duration(start)}, "joint_names": list(joints), "points": told}


POINTS: list[ros2_control.Point] = [
    (0.5, (0.2, -0.1, 0.3), (0.3, 0.1, 0.2), (0.1, 0.0, -0.1)),
    (1.3, (0.5, 0.2, 0.4), (0.1, 0.3, 0.0), (0.0, 0.2, 0.1)),
    (2.0, (0.4, 0.5, 0.4), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
]


def test_each_tick_is_the_spline_of_ros2_control(world: Client, ros: roslibpy.Ros) -> None:
    with world.streams.watch("/robots/arm/joint_states", "/motions") as watch:
        goal = Goal(ros, "/arm/follow_joint_trajectory", FOLLOW, {"trajectory": trajectory(POINTS)})
        while not world.robot("arm").state.motion_ids:
            pass
        began = next(one for one in world.motions() if not one.state.phase.ended).state.start_time
        world.clock.step(600)
        told = goal.result()
        samples = {}
        end = world.clock.simulation_time
        while not samples or max(samples) < end - 1e-9:
            sample = watch.next(GUARD)
            assert sample is not None
            if sample.stream.endswith("joint_states") and sample.time >= began:
                samples[sample.time] = sample.values
    assert told["values"] == {"error_code": 0, "error_string": ""}
    assert told["status"] == SUCCEEDED
    still = (began, (0.0,) * 3, (0.0,) * 3, (0.0,) * 3)
    for time, values in samples.items():
        positions, velocities = ros2_control.sample(POINTS, still, began, time)
        assert [values[f"{one}/position"] for one in JOINTS] == pytest.approx(positions, abs=1e-6)
        if time < began + 2.0:
            assert [values[f"{one}/velocity"] for one in JOINTS] == pytest.approx(velocities, abs=1e-6)


@pytest.mark.long
def test_feedback_comes_and_a_cancelled_goal_brakes(world: Client, ros: roslibpy.Ros) -> None:
    far: list[ros2_control.Point] = [(30.0, (2.0, 1.0, 1.0), (), ())]
    goal = Goal(ros, "/arm/follow_joint_trajectory", FOLLOW, {"trajectory": trajectory(far)})
    with repeated(lambda: world.clock.step(2), 0.01):
        while len(goal.feedback) < 3:
            pass
        goal.cancel()
        told = goal.result()
    assert told["status"] == CANCELED
    last = goal.feedback[-1].get("values", goal.feedback[-1])
    assert last["joint_names"] == list(JOINTS)
    assert last["desired"]["positions"] == last["actual"]["positions"] and 0.0 < last["actual"]["positions"][0] < 2.0
    assert last["error"]["positions"] == [0.0, 0.0, 0.0]


@pytest.mark.long
def test_a_goal_takes_over_from_another_without_stopping(world: Client, ros: roslibpy.Ros) -> None:
    first = Goal(
        ros, "/arm/follow_joint_trajectory", FOLLOW, {"trajectory": trajectory([(3.0, (1.0, 0.5, 0.5), (), ())])}
    )
    with repeated(lambda: world.clock.step(2), 0.01):
        while not first.feedback:
            pass
        second = Goal(
            ros, "/arm/follow_joint_trajectory", FOLLOW, {"trajectory": trajectory([(0.5, (0.1, 0.1, 0.1), (), ())])}
        )
        told = first.result()
        assert told["status"] == ABORTED and "motion" in told["values"]["error_string"], told
        assert second.result()["status"] == SUCCEEDED
    positions = dict(zip(world.robot("arm").joint_names, world.robot("arm").positions, strict=True))
    assert [positions[one] for one in JOINTS] == pytest.approx([0.1, 0.1, 0.1], abs=1e-6)


@pytest.mark.parametrize(
    ("change", "code", "words"),
    [
        ({"joint_names": ["elbow", *JOINTS[1:]]}, -2, "there is no joint 'elbow'; known: lbr_iiwa_joint_1"),
        ({"joint_names": [JOINTS[0]] * 3}, -2, "names each joint that shall move once"),
        ({"points": []}, -1, "at least one point"),
        ({"points": [{"positions": [1.0], "time_from_start": duration(1)}]}, -1, r"points\[0\] has 1 positions for 3"),
        ({"points": [{"positions": [None, 0, 0], "time_from_start": duration(1)}]}, -1, r"points\[0\].positions has a"),
        ({"points": [{"positions": [0, 0, 0]}, {"positions": [1, 0, 0]}]}, -1, "'time_from_start' grows from point"),
        ({"points": [{"velocities": [1, 0, 0], "time_from_start": duration(1)}]}, -1, "each point has positions"),
        ({"points": [{"positions": [9, 0, 0], "time_from_start": duration(9)}]}, -1, "lbr_iiwa_joint_1"),
        ({"header": {"stamp": {"sec": 0, "nanosec": 1}}}, -3, "the trajectory ends at"),
    ],
)
def test_goals_that_can_not_be_run_are_refused_with_their_code(
    world: Client, ros: roslibpy.Ros, change: dict[str, Any], code: int, words: str
) -> None:
    world.clock.step(1000)
    goal = {"trajectory": {**trajectory(POINTS), **change}}
    told = Goal(ros, "/arm/follow_joint_trajectory", FOLLOW, goal).result()
    assert (told["status"], told["values"]["error_code"]) == (ABORTED, code), told
    with pytest.raises(AssertionError, match=words):
        raise AssertionError(told["values"]["error_string"])
    assert not world.robot("arm").state.motion_ids


@pytest.mark.long
def test_trajectories_of_a_topic_take_over_from_each_other(world: Client, ros: roslibpy.Ros) -> None:
    heard = Heard(ros, "/arm/joint_states", "sensor_msgs/JointState")
    topic = roslibpy.Topic(ros, "/arm/joint_trajectory", "trajectory_msgs/JointTrajectory")
    topic.publish(trajectory([(3.0, (1.0, 0.5, 0.5), (), ())]))
    with repeated(lambda: world.clock.step(2), 0.01):
        heard.until(lambda one: one["position"][0] > 0.05)
        topic.publish(trajectory([(0.5, (0.2, 0.0, 0.0), (), ())]))
        last = heard.until(lambda one: one["position"][0] == pytest.approx(0.2, abs=1e-9))[-1]
    assert last["position"][1] == pytest.approx(0.0, abs=1e-9)


def test_a_gripper_opens_as_wide_as_it_is_told(world: Client, ros: roslibpy.Ros) -> None:
    with repeated(lambda: world.clock.step(2), 0.005):
        goal = {"command": {"position": 0.04, "max_effort": 10.0}}
        told = Goal(ros, "/hand/gripper_cmd", "control_msgs/action/GripperCommand", goal).result()
        assert isinstance(told["values"], dict), told
        assert (told["status"], told["values"]["reached_goal"]) == (SUCCEEDED, True)
        assert told["values"]["position"] == pytest.approx(0.04, abs=1e-6)
        assert world.robot("arm").tool().width == pytest.approx(0.04, abs=1e-6)
        goal = {"command": {"name": ["hand"], "position": [0.02]}}
        told = Goal(ros, "/hand/parallel_gripper_cmd", "control_msgs/action/ParallelGripperCommand", goal).result()
        assert (told["status"], told["values"]["reached_goal"]) == (SUCCEEDED, True), told
        assert told["values"]["state"]["name"] == ["hand.tool"]
        assert told["values"]["state"]["position"] == [pytest.approx(0.02, abs=1e-6)]
    wide = Goal(ros, "/hand/gripper_cmd", "control_msgs/action/GripperCommand", {"command": {"position": 5.0}})
    assert "5" in str(wide.result())
