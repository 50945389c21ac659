"""Commands that build a cell and work in it, on a real kernel; JSON answers; names that complete."""

from __future__ import annotations

import json

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot
from virtualrobot.cli.options import Target
from virtualrobot.cli.shell import completions

from tests.api.client.conftest import MODELS, Run


@pytest.mark.long
def test_a_cell_is_built_piece_by_piece(run: Run, client: Client) -> None:
    run("add", "table", "bench", "--size", "1.2,0.8,0.75", "--at", "0.6,0,0")
    run("add", "part", "block", "--size", "0.1,0.1,0.1", "--at", "0,0,0.8", "--parent", "bench", "--mass", "0.5")
    run("add", "part", "ball", "--radius", "0.05")
    run("add", "part", "rod", "--radius", "0.02", "--length", "0.3")
    run("add", "box", "wall", "--size", "0.1,2,1", "--at", "-1,0,0.5,0,0,90", "--degrees", "--color", "grey")
    run("add", "frame", "pick place", "--parent", "bench")
    run("add", "mesh", str(MODELS / "duck.obj"), "duck", "--scale", "0.1", "--part")
    run("add", "light", "lamp", "--kind", "spot", "--intensity", "4", "--at", "0,0,3")
    run("add", "sensor", "lidar", "LDS-01", "--at", "0,0,1")
    run("add", "sensor", "eye", "--camera", "--rate", "5")
    kinds = {node.name: node.kind for node in client.scene.nodes()}
    assert kinds == {
        **{"world": "world", "bench": "object", "wall": "object", "pick place": "object"},
        **dict.fromkeys(("block", "ball", "rod", "duck"), "part"),
        **{"lamp": "light", "lidar": "range_sensor", "eye": "camera_sensor"},
    }
    np.testing.assert_allclose(client.scene.pose("block")[:3, 3], [0.6, 0.0, 0.8])
    np.testing.assert_allclose(client.scene.pose("wall"), virtualrobot.pose(-1, 0, 0.5, yaw=np.pi / 2), atol=1e-12)


def test_a_table_is_as_high_as_it_says(run: Run, client: Client) -> None:
    """A ray from above meets it at its height; beside a leg one along the floor goes through below the top."""
    run("add", "table", "bench", "--size", "1.0,0.6,0.7")
    down, through = client.rays.cast([[0.0, 0.0, 2.0], [-2.0, 0.0, 0.3]], [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]).distances
    np.testing.assert_allclose(down, 1.3, atol=1e-6)
    assert not np.isfinite(through)


def test_nodes_are_renamed_attached_and_removed(run: Run, client: Client) -> None:
    run("add", "box", "a", "--size", "1,1,1", "--at", "0,0,0.5")
    run("add", "box", "b", "--size", "1,1,1", "--at", "2,0,0.5")
    assert run("rename", "b", "c") == "renamed b to c\n"
    run("attach", "c", "a")
    np.testing.assert_allclose(client.scene.pose("c")[:3, 3], [2, 0, 0.5])
    run("attach", "c", "a", "--at", "0,0,1")
    np.testing.assert_allclose(client.scene.pose("c")[:3, 3], [0, 0, 1.5])
    assert "'nobody'" in run("remove", "c", "nobody", code=1)
    assert len(client.scene.nodes()) == 3, "a batch is refused whole"
    run("remove", "a")
    assert [node.name for node in client.scene.nodes()] == ["world"]


def test_what_is_wrong_is_said_and_changes_nothing(run: Run, client: Client) -> None:
    for words, said in (
        (("add", "part", "p"), "say how big"),
        (("add", "part", "p", "--length", "1"), "say how big"),
        (("add", "sensor", "s"), "say what it is"),
        (("add", "box", "b", "--size", "1,1"), "3 are wanted"),
        (("add", "box", "b", "--size", "1,nan,1"), "not finite"),
        (("remove",), "NODES"),
        (("rename", "", "b"), "is empty"),
        (("speed", "1.5"), "1.5"),
        (("lease",), "name the robots"),
        (("tool", "arm", "--point", "tip"), "goes with --select"),
        (("mvoe", "arm"), "did you mean 'move'"),
        (("ls", "--linsk"), "--links"),
    ):
        with pytest.raises(AssertionError, match=said):  # the code is 2, and the usage stands before the word
            run(*words)
    assert "'LDS-1'" in run("add", "sensor", "s", "LDS-1", code=1)
    assert len(client.scene.nodes()) == 1


def test_a_part_is_grasped_and_let_go(run: Run, client: Client, iiwa: Robot) -> None:
    client.scene.add_tool("hand", iiwa.flange, states={"open": {}, "closed": {}})
    run("add", "part", "block", "--size", "0.1,0.1,0.1", "--at", ",".join(map(str, iiwa.tcp[:3, 3])))
    assert run("grasp", "iiwa") == "iiwa holds block\n"
    assert client.scene.node("block").parent == "hand"
    assert run("tool", "iiwa", "closed") == "hand is closed\n"
    assert run("tool", "iiwa") == "* hand  closed  of: open, closed\n"
    run("release", "iiwa", "block", "--to", "iiwa")
    assert client.scene.node("block").parent == "iiwa"
    run("attach", "block", "world", "--at", "9,0,0")
    assert "farther than 0.01 m" in run("grasp", "iiwa", "block", "--within", "0.01", code=1)
    run("tool", "iiwa", "--select", "--tool", "hand")


def test_motions_are_slowed_paused_and_resumed(run: Run, iiwa: Robot) -> None:
    assert run("speed") == "1\n"
    assert run("speed", "0.5") == "0.5\n"
    assert run("speed", "0.25", "iiwa") == "0.25\n"
    motion = iiwa.move_joints([1.0] * 7, wait=False, speed_factor=0.01, on_disconnect="continue")
    assert run("pause", "iiwa") == f"paused {motion.id} of iiwa\n"
    assert run("resume") == f"resumed {motion.id} of iiwa\n"
    motion.cancel()
    assert "'nobody'" in run("pause", "nobody", code=1)


def test_the_clock_is_set(run: Run, client: Client) -> None:
    assert run("clock").startswith("realtime: 1 times the wall clock")
    assert run("clock", "--speed", "4").startswith("realtime: 4 times")
    assert run("clock", "stepped").startswith("stepped: time goes on by steps")
    assert client.clock.mode == "stepped"
    assert run("clock", "realtime").startswith("realtime: 1 times")


def test_answers_are_the_contracts_as_json(run: Run, iiwa: Robot) -> None:
    lines = [json.loads(line) for line in run("ls", "--json").splitlines()]
    scene = next(line["answer"] for line in lines if line["rpc"] == "GetScene")
    assert [node["name"] for node in scene["nodes"]][:2] == ["world", "iiwa"]
    assert scene["nodes"][1]["robot"]["joint_names"] == iiwa.joint_names
    states = [json.loads(line) for line in run("--json", "state", "iiwa").splitlines()]
    assert {"GetClock", "GetRobotStates"} <= {line["rpc"] for line in states}
    error = json.loads(run("state", "nobody", "--json", code=1))["error"]
    assert (error["reason"], "nobody" in error["message"]) == ("UNKNOWN_NAME", True)


def test_names_complete_from_the_kernel(client: Client, iiwa: Robot, environment: None) -> None:
    client.scene.add_object("table")
    client.scene.add_part("a box", virtualrobot.box(0.1, 0.1, 0.1))
    client.signals.create("gate", True)

    def after(*words: str) -> list[str]:
        return [word for word, _ in completions(Target(), list(words[:-1]), words[-1])]

    assert after("mov") == ["move"]
    assert after("move", "i") == ["iiwa"]
    assert after("attach", "t") == ["table"]
    assert after("grasp", "iiwa", "") == ["a box"]
    assert after("signal", "") == ["gate"]
    assert after("add", "bo") == ["box"]
    assert after("clock", "") == ["realtime", "stepped"]
    assert "model://puma560" in after("load", "model://pum")
    assert after("move", "i", "--address", "127.0.0.1:1") == []
