"""Refusals of the world that come after a message was taken: whoever has published it is told, and nobody else."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import virtualrobot
from virtualrobot import Client

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import answer, bridge, say, socket
from tests.waiting import until

JOINT = "lbr_iiwa_joint_1"


@pytest.fixture
def url(client: Client) -> Iterator[str]:
    """Return the address of a bridge to a world with an arm, a craft and a signal, whose time goes on."""
    client.load_robot(IIWA, name="arm")
    client.load_robot("model://ugv", name="ugv", base="planar", pose=virtualrobot.pose(y=3.0))
    client.signals.create("lamps", [True, False])
    try:
        with bridge(client) as (url, _):
            yield url
    finally:
        client.signals.pop("lamps", None)


def _point(position: float) -> dict[str, object]:
    return {"joint_names": [JOINT], "points": [{"positions": [position], "time_from_start": {"sec": 2}}]}


@pytest.mark.parametrize(
    ("topic", "message", "words"),
    [
        ("/arm/joint_trajectory", {**_point(0.1), "joint_names": ["elbow"]}, "there is no joint 'elbow'; known: lbr_"),
        ("/arm/joint_trajectory", _point(9.0), JOINT),
        ("/arm/joint_trajectory", {"joint_names": [JOINT]}, "a trajectory has at least one point"),
        ("/ugv/cmd_vel", {"linear": {"x": 1e300}}, "a twist is at most 1000 m/s and rad/s, not 1e+300"),
        ("/ugv/cmd_vel", {"linear": {"x": -100.0}}, "its limit is"),
        ("/signals/lamps/set", {"data": [1]}, "lamps"),
        ("/collision_object", {"id": "bin", "primitives": [{"type": 9}], "primitive_poses": [{}]}, "a primitive is 1"),
    ],
)
def test_a_publisher_is_told_what_the_world_refuses(url: str, topic: str, message: object, words: str) -> None:
    with socket(url) as one, socket(url) as bystander:
        say(one, op="publish", topic=topic, msg=message, id="mine")
        told = answer(one, op="status")
        assert (told["level"], told["id"]) == ("error", "mine") and told["msg"].startswith(f"{topic} does not take")
        assert words in told["msg"], told
        say(bystander, op="publish", topic="/clock", msg={})
        assert "/clock is told by the world" in answer(bystander, op="status")["msg"]  # the first that it is told


def test_a_craft_that_was_told_nonsense_follows_the_next_twist(client: Client, url: str) -> None:
    with socket(url) as one:
        say(one, op="publish", topic="/ugv/cmd_vel", msg={"linear": {"x": 1e300}})
        answer(one, op="status", level="error")
        assert client.streams.sample("/robots/ugv/base").values["x"] == 0.0

        def drives() -> bool:
            say(one, op="publish", topic="/ugv/cmd_vel", msg={"linear": {"x": 0.2}})
            return client.streams.sample("/robots/ugv/base").values["x"] > 0.02

        until(drives)
