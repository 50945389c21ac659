"""Pairs that touch as a model is built or stands: allowed on load, told, saved, undone by a call; the rest is red."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest
import virtualrobot
from virtualrobot import Client, pose
from virtualrobot.collisions.allowed_pairs import AllowedPair

from tests.api.client.conftest import Run
from tests.kernels import StartKernel
from tests.unit.formats.models import ROBOTS

KR6 = "model://kr6_r700"
STANDS = ("table", "kr6.base_link", "built", "stands on 'table'")


def told(client: Client) -> list[tuple[str, str, str, str]]:
    """Return the pairs of the load before."""
    return [(pair.first, pair.second, pair.cause, pair.reason) for pair in client.scene.allowed_pairs]


def built(client: Client, *nodes: str) -> list[tuple[str, str, str, str]]:
    """Return the pairs that may touch as built."""
    pairs = client.collisions.allowed.list(*nodes)
    return [(pair.first, pair.second, pair.cause, pair.reason) for pair in pairs if pair.cause == "built"]


@pytest.fixture
def cell(client: Client) -> Client:
    """Return a client of a cell with a KR6 that stands on a table and hangs on the world."""
    client.scene.add_object("table", virtualrobot.box(1.0, 1.0, 0.8), pose=pose(z=0.4))
    client.load_robot(KR6, name="kr6", pose=pose(z=0.8))
    return client


@pytest.mark.long
def test_a_robot_that_stands_on_a_table_is_not_red(cell: Client) -> None:
    assert told(cell) == [STANDS]
    assert not cell.collisions.check()
    cell.clock.set_stepped()
    cell.collisions.set("stop")
    cell.clock.step(10)
    with closing(cell.collisions.watch()) as watch:  # pyright: ignore[reportArgumentType] a generator
        first = next(watch)
    assert (first.touching, first.fault) == ((), "")
    # What the arm reaches into is told as ever.
    assert cell.collisions.check({"kr6": {"joint_a2": 0.6, "joint_a3": 1.0}}, detail="first").pairs[0].first == "table"


@pytest.mark.long
def test_it_is_saved_with_the_scene_and_undone_by_one_call(cell: Client, tmp_path: Path) -> None:
    cell.scene.save(tmp_path / "cell.yaml")
    cell.scene.load_scene(tmp_path / "cell.yaml")
    assert built(cell) == [STANDS]
    assert told(cell) == []  # no models were looked at: the file says what may touch
    assert cell.collisions.allowed.forbid_built("table") == [AllowedPair(*STANDS)]
    assert built(cell) == [] and cell.collisions.allowed.forbid_built() == []
    assert [(pair.first, pair.second) for pair in cell.collisions.check().pairs] == [STANDS[:2]]
    cell.scene.save(tmp_path / "cell.yaml")
    cell.scene.load_scene(tmp_path / "cell.yaml")
    assert built(cell) == []
    cell.collisions.allowed.add(*STANDS[:2], "it stands")
    assert [pair.cause for pair in cell.collisions.allowed.list("table")] == ["client"]


@pytest.mark.long
def test_models_of_a_scene_file_are_looked_at(client: Client, start_kernel: StartKernel, tmp_path: Path) -> None:
    file = tmp_path / "cell.yaml"
    file.write_text(
        f"""
schema_version: 1
nodes:
- name: table
  object: {{}}
  parent_t_node: {{position: {{z: 0.4}}}}
  figures: [{{box: {{size: {{x: 1, y: 1, z: 0.8}}}}}}]
models:
- uri: {KR6}
  name: kr6
  parent_t_node: {{position: {{z: 0.8}}}}
- uri: {ROBOTS["panda"]}
  name: panda
  parent_t_node: {{position: {{y: 2.0}}}}
"""
    )
    client.scene.load_scene(file)
    assert STANDS in told(client) and len(told(client)) == 4
    assert built(client) == told(client)
    assert not client.collisions.check()
    with virtualrobot.connect(start_kernel(str(file)).address) as fresh:
        assert built(fresh) == told(client)


@pytest.mark.long
def test_the_command_line_tells_and_undoes_it(cell: Client, run: Run) -> None:
    lines = run("load", KR6, "--name", "other", "--at", "0,0,0.8").splitlines()
    assert lines == ["loaded robot other", "  table and other.base_link may touch: stands on 'table'"]
    assert run("collision", "forbid-built", "other").split() == [
        *"table other.base_link built stands on".split(),
        "'table'",
    ]
    assert built(cell) == [STANDS]
    assert run("collision", "forbid-built", "other") == "no pairs\n"


def test_a_gripper_that_is_loaded_onto_a_flange_may_touch_what_is_next_to_it(cell: Client) -> None:
    cell.scene.load(ROBOTS["xarm6_gripper"], name="hand", parent="kr6.tool0")
    reasons = {pair[3] for pair in told(cell)}
    assert "touch as built" in reasons
    assert reasons <= {"touch as built", "mounted on 'kr6.tool0'"}
    own = {
        pair.first.split(".")[0] + pair.second.split(".")[0] for pair in cell.collisions.check(robots=["hand"]).pairs
    }
    assert "handhand" not in own


def test_a_gripper_that_is_mounted_may_touch_what_is_next_to_it_whichever_way(client: Client) -> None:
    """A block of 30 cm at the flange of a UR5 reaches into the wrist behind it, and farther."""
    arm = client.load_robot("model://ur5", name="arm")
    client.scene.add_tool("block", "world", virtualrobot.box(0.3, 0.3, 0.3))
    arm.mount("block")
    block = built(client, "block")
    assert block and {pair[3] for pair in block} == {f"mounted on '{arm.flange}'"}
    touching = {(pair.first, pair.second) for pair in client.collisions.check().pairs}
    assert not touching & {pair[:2] for pair in block}
    assert client.collisions.allowed.forbid_built("block")
    assert {(pair.first, pair.second) for pair in client.collisions.check().pairs} == touching | {
        pair[:2] for pair in block
    }


def test_who_has_not_leased_the_arm_is_refused_as_before(cell: Client, run: Run) -> None:
    before = built(cell)
    with cell.lease("kr6"):
        assert "kr6" in run("load", str(ROBOTS["xarm6_gripper"]), "--parent", "kr6.tool0", code=1)
    assert built(cell) == before
