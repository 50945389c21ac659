"""Descriptions are read once and kept until an answer tells of another structure."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import pytest
import virtualrobot
from virtualrobot import Client, JointGroup, Robot
from virtualrobot._wire import descriptions
from virtualrobot.v1 import geometry_pb2, robot_pb2

from tests.api.client.conftest import IIWA
from tests.kernels import KernelProcess


@pytest.fixture
def asked(client: Client, iiwa: Robot, monkeypatch: pytest.MonkeyPatch) -> Callable[[], int]:
    """Return a function that says how often the client has asked what a robot is made of; time does not matter."""
    monkeypatch.setattr(descriptions, "TRUSTED_SECONDS", math.inf)
    count = 0
    ask = client.services.robot.GetRobot

    def counted(request: robot_pb2.GetRobotRequest) -> robot_pb2.GetRobotResponse:
        nonlocal count
        count += 1
        return ask(request)

    monkeypatch.setattr(client.services.robot, "GetRobot", counted)
    return lambda: count


@pytest.fixture
def other(kernel: KernelProcess, client: Client) -> Iterator[Client]:
    """Return a second client of the same kernel."""
    with virtualrobot.connect(kernel.address) as other:
        yield other


def test_all_that_describes_a_robot_is_one_call(client: Client, iiwa: Robot, asked: Callable[[], int]) -> None:
    for _ in range(3):
        assert (len(iiwa.limits), len(iiwa.joint_names), len(iiwa.joint_types)) == (7, 7, 7)
        assert iiwa.flange == iiwa.links[-1]
        assert not (iiwa.postures or iiwa.groups or iiwa.tools or iiwa.actuators)
        iiwa.set_positions(dict.fromkeys(iiwa.joint_names, 0.1))
        assert len(iiwa.positions) == len(client.robot("iiwa").chain_joint_names)
    assert asked() == 1


def test_own_changes_are_seen(client: Client, iiwa: Robot, asked: Callable[[], int]) -> None:
    assert iiwa.tools == []
    client.scene.add_tool("hand", iiwa.flange, states={"open": {}})
    assert (iiwa.tools, list(iiwa.tool("hand").states)) == (["hand"], ["open"])
    iiwa.set_groups([JointGroup("wrist", joint_names=("lbr_iiwa_joint_7",))])
    assert list(iiwa.groups) == ["wrist"]
    client.scene.rename("hand", "grip")
    assert iiwa.tools == ["grip"]
    assert asked() == 4


@pytest.mark.usefixtures("asked")
def test_a_change_by_another_client_is_seen_with_the_next_answer(client: Client, iiwa: Robot, other: Client) -> None:
    assert iiwa.tools == []
    other.scene.add_tool("hand", iiwa.flange)
    _ = client.clock.mode  # any answer tells of the structure
    assert iiwa.tools == ["hand"]
    with client.scene.batch() as batch:
        batch.remove("hand")
    watch = client.scene.watch()
    next(watch)
    assert iiwa.tools == []
    other.scene.add_tool("hand", iiwa.flange)
    while not any(node.name == "hand" for node in next(watch).nodes):
        pass
    assert iiwa.tools == ["hand"]


def test_a_change_is_seen_without_an_answer_after_a_while(
    iiwa: Robot, other: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(descriptions, "TRUSTED_SECONDS", 0.0)
    assert iiwa.tools == []
    other.scene.add_tool("hand", iiwa.flange)
    assert iiwa.tools == ["hand"]


def test_a_robot_that_is_gone_has_no_description(client: Client, iiwa: Robot) -> None:
    assert iiwa.flange
    client.scene.remove("iiwa")
    with pytest.raises(virtualrobot.UnknownNameError):
        _ = iiwa.flange
    assert client.load_robot(IIWA, name="iiwa").flange == iiwa.flange


def test_late_answers_bring_nothing_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was read of revision 2 is not kept when another thread has been told of 3 meanwhile."""
    monkeypatch.setattr(descriptions, "TRUSTED_SECONDS", math.inf)
    kept = descriptions.Descriptions()

    def answer(revision: int) -> robot_pb2.GetRobotResponse:
        return robot_pb2.GetRobotResponse(stamp=geometry_pb2.Stamp(structure_revision=revision))

    def late() -> robot_pb2.GetRobotResponse:
        kept.saw(answer(3).stamp, asked_at=0.0)
        kept.saw(answer(2).stamp)
        return answer(2)

    assert kept.get("arm", late).stamp.structure_revision == 2
    assert kept.get("arm", lambda: answer(3)).stamp.structure_revision == 3
    assert kept.get("arm", late).stamp.structure_revision == 3
    # A kernel that was started anew counts from the beginning.
    kept.saw(answer(1).stamp)
    assert kept.get("arm", lambda: answer(1)).stamp.structure_revision == 1
