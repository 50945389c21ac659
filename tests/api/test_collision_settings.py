"""What is done about collisions: set, read, saved, undone with its nodes, and what is refused."""

from __future__ import annotations

import math
from typing import Any, cast

import pytest
from virtualrobot.v1 import collision_pb2, scene_pb2

from tests.api.asking import IIWA, PANDA, apply, box, create, load, refusal
from tests.kernels import Stubs

Mode = collision_pb2.RobotCollisionMode
OFF, MONITOR, STOP, GUARD = (
    collision_pb2.COLLISION_MODE_OFF,
    collision_pb2.COLLISION_MODE_MONITOR,
    collision_pb2.COLLISION_MODE_STOP,
    collision_pb2.COLLISION_MODE_GUARD,
)
DEFAULTS = collision_pb2.CollisionSettings(mode=OFF)


Settings = collision_pb2.SetCollisionSettings


def change(stubs: Stubs, command: collision_pb2.SetCollisionSettings) -> None:
    apply(stubs, scene_pb2.Command(set_collision_settings=command))


def settings(stubs: Stubs) -> collision_pb2.CollisionSettings:
    return stubs.collision.GetCollisionSettings(collision_pb2.GetCollisionSettingsRequest()).settings


def test_settings_are_set_one_by_one_and_follow_their_nodes(stubs: Stubs) -> None:
    assert settings(stubs) == DEFAULTS
    load(stubs, IIWA, "left")
    load(stubs, PANDA, "right")
    apply(stubs, create(box("box", x=2.0)))
    change(stubs, Settings(mode=STOP, robots=[Mode(robot="right", mode=GUARD)]))
    paddings = [collision_pb2.NodePadding(node="box", padding_meters=0.02)]
    change(stubs, Settings(look_ahead_seconds=1.5, paddings=paddings))
    wanted = collision_pb2.CollisionSettings(
        mode=STOP, robots=[Mode(robot="right", mode=GUARD)], look_ahead_seconds=1.5, paddings=paddings
    )
    assert settings(stubs) == wanted
    change(stubs, Settings(look_ahead_seconds=0.0))
    apply(stubs, scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="right")))
    apply(stubs, scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="box")))
    assert settings(stubs) == collision_pb2.CollisionSettings(mode=STOP)
    change(stubs, Settings(mode=OFF, robots=[Mode(robot="left", mode=MONITOR)]))
    change(stubs, Settings(robots=[Mode(robot="left")]))
    assert settings(stubs) == DEFAULTS


def test_a_scene_file_keeps_settings(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    plain = stubs.scene.SaveScene(scene_pb2.SaveSceneRequest())
    assert "collision_settings" not in plain.text
    paddings = [collision_pb2.NodePadding(node="arm", padding_meters=0.005)]
    request = Settings(mode=MONITOR, robots=[Mode(robot="arm", mode=GUARD)], look_ahead_seconds=3.0, paddings=paddings)
    change(stubs, request)
    before = settings(stubs)
    saved = stubs.scene.SaveScene(scene_pb2.SaveSceneRequest())
    change(stubs, Settings(mode=OFF, look_ahead_seconds=0.0))
    stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text=saved.text))
    assert settings(stubs) == before


@pytest.mark.parametrize(
    ("request_", "reason", "words"),
    [
        (Settings(mode=cast(Any, 9)), "INVALID_ARGUMENT", "mode is 9, which has no meaning"),
        (Settings(robots=[Mode(robot="arm", mode=cast(Any, 7))]), "INVALID_ARGUMENT", "mode is 7"),
        (Settings(robots=[Mode(robot="nobody", mode=STOP)]), "UNKNOWN_NAME", "nobody"),
        (Settings(robots=[Mode(robot="box", mode=STOP)]), "UNKNOWN_NAME", "box"),
        (Settings(robots=[Mode(robot="arm", mode=STOP)] * 2), "INVALID_ARGUMENT", "names 'arm' again"),
        (Settings(look_ahead_seconds=math.nan), "INVALID_ARGUMENT", "look_ahead_seconds"),
        (Settings(look_ahead_seconds=61.0), "LIMIT_EXCEEDED", "0 to 60"),
        (Settings(look_ahead_seconds=-1.0), "LIMIT_EXCEEDED", "0 to 60"),
        (Settings(paddings=[collision_pb2.NodePadding(node="box", padding_meters=-0.1)]), "LIMIT_EXCEEDED", "padding"),
        (
            Settings(paddings=[collision_pb2.NodePadding(node="box", padding_meters=math.inf)]),
            "INVALID_ARGUMENT",
            "pad",
        ),
        (Settings(paddings=[collision_pb2.NodePadding(node="gone", padding_meters=0.1)]), "UNKNOWN_NAME", "gone"),
    ],
)
def test_what_cannot_be_is_refused_and_changes_nothing(
    stubs: Stubs, request_: collision_pb2.SetCollisionSettings, reason: str, words: str
) -> None:
    load(stubs, IIWA, "arm")
    apply(stubs, create(box("box", x=2.0)))
    refused = refusal(lambda: change(stubs, request_))
    assert refused.reason == reason
    assert words in refused.message
    assert settings(stubs) == DEFAULTS


def test_a_padding_is_kept_away_from(stubs: Stubs) -> None:
    """A box 0.3 m beside another: distances are less by both paddings, and where these reach it is a collision."""
    robot = box("robot")
    robot.robot.SetInParent()
    apply(stubs, create(robot), create(box("part", x=0.4)))

    def padded(**paddings: float) -> tuple[float, bool]:
        nodes = [collision_pb2.NodePadding(node=name, padding_meters=one) for name, one in paddings.items()]
        change(stubs, Settings(paddings=nodes))
        (pair,) = stubs.collision.MeasureDistances(collision_pb2.MeasureDistancesRequest(first=["robot"])).pairs
        assert (pair.first_point.x, pair.second_point.x) == pytest.approx((0.05, 0.35), abs=1e-9)
        return pair.distance_meters, bool(stubs.collision.CheckCollision(collision_pb2.CheckCollisionRequest()).pairs)

    assert padded(part=0.2) == (pytest.approx(0.1, abs=1e-9), False)
    assert padded(robot=0.09) == (pytest.approx(0.01, abs=1e-9), False)
    assert padded(robot=0.11) == (0.0, True)
    assert padded(robot=0.0, part=0.0) == (pytest.approx(0.3, abs=1e-9), False)
