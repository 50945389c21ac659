"""Streams as messages: names, and what of a sample goes where."""

from __future__ import annotations

import pytest
from virtualrobot.streams.sample import Sample
from virtualrobot_apps.bridges.ros.mapping.names import FrameNames, topic_name
from virtualrobot_apps.bridges.ros.mapping.robots import joint_state


def test_joints_with_one_coordinate_are_told_and_efforts_where_there_are_any() -> None:
    values = {"a/position": 1.0, "a/velocity": 2.0, "base/x/position": 9.0, "base/x/velocity": 9.0}
    values |= {"base/x/effort": 9.0, "a/effort": 3.0, "b/position": 4.0, "b/velocity": 5.0, "b/effort": 6.0}
    told = joint_state(Sample("/robots/r/joint_states", 3, 0.012, 0.0, values, 0))
    assert (told.name, told.header.stamp.sec, told.header.stamp.nanosec) == (["a", "b"], 0, 12_000_000)
    assert [one.tolist() for one in (told.position, told.velocity, told.effort)] == [[1.0, 4.0], [2.0, 5.0], [3.0, 6.0]]
    without = {key: value for key, value in values.items() if not key.endswith("effort")}
    assert joint_state(Sample("", 3, 0.012, 0.0, without, 0)).effort.tolist() == []


@pytest.mark.parametrize(
    ("parts", "name"),
    [
        (("ugv.lidar", "scan"), "/ugv/lidar/scan"),
        (("my arm-1", "joint_states"), "/my_arm_1/joint_states"),
        (("2nd", "odom"), "/_2nd/odom"),
        (("eye", "image_raw/compressed"), "/eye/image_raw/compressed"),
    ],
)
def test_names_of_topics_are_those_that_ros_allows(parts: tuple[str, ...], name: str) -> None:
    assert topic_name(*parts) == name


def test_frames_of_links_have_their_robot_in_front_or_not() -> None:
    robots = ["arm", "arm.hand"]
    assert [FrameNames(robots)(one) for one in ("arm", "arm.link_1", "arm.hand.finger", "wall", "my part")] == [
        *("arm", "arm/link_1", "arm.hand/finger", "wall", "my_part")
    ]
    assert FrameNames(robots, bare=True)("arm.link_1") == "link_1"
