"""Descriptions of nodes, and locks: by client and command line, kept by scene files, taken back by undo."""

from __future__ import annotations

from pathlib import Path

import pytest
import virtualrobot
from virtualrobot import Client, errors, pose

from tests.api.client.conftest import Run


def test_nodes_are_described_and_found_by_tags(client: Client, tmp_path: Path) -> None:
    bench = client.scene.add_object("bench", virtualrobot.box(1.0, 1.0, 0.1))
    client.scene.add_part("box", virtualrobot.box(0.1, 0.1, 0.1))
    client.scene.describe("bench", "Where boxes wait", tags=["fixture", "station 2"], icon="package")
    client.scene.node("box").tags = ["station 2"]
    assert (bench.description, bench.tags, bench.info.icon) == ("Where boxes wait", ("fixture", "station 2"), "package")
    assert [node.name for node in client.scene.nodes(tag="station 2")] == ["bench", "box"]
    assert [node.name for node in client.scene.nodes("part", tag="station 2")] == ["box"]
    client.scene.save(tmp_path / "cell.yaml")
    bench.description = ""
    client.history.undo()
    assert bench.description == "Where boxes wait"
    client.scene.load_scene(tmp_path / "cell.yaml")
    info = client.scene.node("bench").info
    assert (info.description, info.tags, info.icon, info.locked) == (
        *("Where boxes wait", ("fixture", "station 2")),
        *("package", False),
    )
    with pytest.raises(errors.InvalidArgumentError, match="nothing is said"):
        client.scene.describe("bench")


def test_a_lock_keeps_a_node_until_it_is_taken_away(client: Client) -> None:
    bench = client.scene.add_object("bench")
    bench.lock()
    for change in (bench.remove, lambda: bench.rename("desk"), lambda: client.scene.set_pose("bench", pose(1.0))):
        with pytest.raises(errors.WrongStateError, match="'bench' is locked"):
            change()
    assert bench.locked
    with client.scene.batch() as batch:
        batch.lock("bench", False)
        batch.set_pose("bench", pose(1.0))
    assert bench.pose[0, 3] == 1.0 and not bench.locked
    client.history.undo()
    assert bench.locked and bench.pose[0, 3] == 0.0


def test_the_command_line_describes(run: Run, client: Client) -> None:
    client.scene.add_object("bench")
    told = run(
        "describe", "bench", "Where boxes wait", "--tag", "fixture", "--tag", "wood", "--icon", "package", "--lock"
    )
    assert told == "bench (object)\n  Where boxes wait\n  tags: fixture, wood\n  icon: package\n  locked\n"
    assert run("describe", "bench") == told
    assert run("describe", "--tagged", "wood") == "bench (object)\n"
    assert run("describe", "bench", "--unlock", "--no-tags") == "bench (object)\n  Where boxes wait\n  icon: package\n"
    assert "give a NODE, or --tagged" in run("describe", code=2)
    assert "either --tag or --no-tags" in run("describe", "bench", "--tag", "a", "--no-tags", code=2)
