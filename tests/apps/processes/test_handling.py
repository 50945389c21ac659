"""Processes that handle parts: palletizing and tending, as files describe them and as they go in a cell."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot
from virtualrobot.errors import MalformedFileError
from virtualrobot_apps.cell_io.yaml_file import parse
from virtualrobot_apps.processes.command import EXAMPLES
from virtualrobot_apps.processes.handling import read_pallet
from virtualrobot_apps.processes.palletize import read_palletize
from virtualrobot_apps.processes.process import plan_file
from virtualrobot_apps.processes.tend import read_tend

SIZE = 0.08
"""Edge (m) of the cubes."""
MACHINE = """<robot name="mill">
  <link name="bed"><collision><origin xyz="0 0 0.1"/><geometry><box size="0.5 0.4 0.2"/></geometry></collision></link>
  <link name="table"><collision>
    <origin xyz="0 0 0.02"/><geometry><box size="0.2 0.2 0.04"/></geometry></collision></link>
  <link name="panel"><collision>
    <origin xyz="0 0 0.2"/><geometry><box size="0.5 0.02 0.4"/></geometry></collision></link>
  <joint name="table" type="prismatic"><parent link="bed"/><child link="table"/><origin xyz="0 0 0.21"/>
    <axis xyz="1 0 0"/><limit lower="-0.1" upper="0.1" velocity="0.5" effort="1000"/></joint>
  <joint name="door" type="prismatic"><parent link="bed"/><child link="panel"/><origin xyz="0 -0.25 0.2"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.6" velocity="1" effort="100"/></joint>
</robot>"""
"""A machine whose table goes along x, and whose door slides before it."""


def cell(client: Client, parts: dict[str, tuple[float, float]]) -> Robot:
    """Return an arm with a cup, before cubes that stand on a bench at places (m) of it."""
    arm = client.load_robot("model://irb2400_16_155", name="arm")
    cup = virtualrobot.cylinder(0.02, 0.1, pose=virtualrobot.pose(z=0.05))
    tip = {"tip": virtualrobot.pose(z=0.105)}
    client.scene.add_tool("cup", arm.flange, [cup], tool_center_points=tip, states={"off": {}, "on": {}})
    client.scene.add_object("bench", virtualrobot.box(1.2, 1.6, 0.5), pose=virtualrobot.pose(1.2, 0.0, 0.25))
    for name, (x, y) in parts.items():
        client.scene.add_part(name, virtualrobot.box(SIZE, SIZE, SIZE), pose=virtualrobot.pose(x, y, 0.505 + SIZE / 2))
    found = arm.solve_inverse(virtualrobot.pose(1.0, 0.0, 1.1, roll=np.pi))
    client.scene.set_joint_positions("arm", dict(zip(found.joint_names, found.solutions[0].tolist(), strict=True)))
    return arm


def done(client: Client, folder: Path, text: str) -> list[str]:
    """Plan a file, run what it plans, which keeps all limits and touches nothing; return the steps in the cell."""
    (file := folder / "work.yaml").write_text(f"schema_version: 1\nrobot: arm\n{text}")
    work = plan_file(client, file)
    assert work.program.check().first_violation is None
    motion = work.program.start(wait=False)
    client.clock.run(motion)
    assert motion.state.phase is virtualrobot.Phase.SUCCEEDED
    return list(work.measures)


def test_boxes_are_palletized_in_layers_that_turn(steps: Client, tmp_path: Path) -> None:
    """Two places of a layer along x, those of the second one along y, each part upright and within 0.01 mm of it."""
    boxes = {f"box {number}": (0.9, -0.4 + 0.15 * number) for number in range(3)}
    cell(steps, boxes)
    steps.scene.add_frame("pallet", pose=virtualrobot.pose(1.3, 0.2, 0.51))
    text = """process: palletize
parts: [box 0, box 1, box 2]
grip: {at: [0, 0, 0.04]}
tool: {hold: "on", release: "off"}
pallet: {frame: pallet, columns: 2, rows: 1, layers: 2, pitch: [0.1, 0, 0.081], height: 0.04, turn_degrees: 90}
clear: 0
"""
    assert done(steps, tmp_path, text) == ["3 parts in 2 layers of 2 x 1, 1 places left free"]
    nodes = [steps.scene[name] for name in boxes]
    assert [node.parent for node in nodes] == ["pallet"] * 3
    found = np.array([node.pose[:3, 3] for node in nodes]) - [1.3, 0.2, 0.51]
    wanted = [[-0.05, 0.0, 0.04], [0.05, 0.0, 0.04], [0.0, -0.05, 0.121]]
    np.testing.assert_allclose(found, wanted, atol=1e-5)
    np.testing.assert_allclose([node.pose[2, 2] for node in nodes], 1.0, atol=1e-8)


def test_a_machine_is_tended(steps: Client, tmp_path: Path) -> None:
    """A blank goes onto the table of a machine, which works behind a closed door, and then into the rack."""
    cell(steps, {"blank": (0.9, -0.4)})
    (model := tmp_path / "mill.urdf").write_text(MACHINE)
    mill = steps.load_robot(model, name="mill", pose=virtualrobot.pose(1.3, 0.4, 0.51))
    steps.scene.add_frame("rack", pose=virtualrobot.pose(0.9, -0.2, 0.51))
    steps.signals.create("spindle")
    text = """process: tend
parts: [blank]
grip: {at: [0, 0, 0.04]}
tool: {hold: "on", release: "off"}
machine:
  robot: mill
  open: {door: 0.5}
  closed: {door: 0}
  cycle: [{table: 0.08}, {table: 0}]
  running: {signal: spindle, start_seconds: 0.2}
  chuck: mill.table
  at: [0, 0, 0.08]
rack: {frame: rack, columns: 1, rows: 1, pitch: [0, 0, 0], height: 0.04}
"""
    assert done(steps, tmp_path, text) == ["1 parts through 'mill', 2 moves each in it"]
    assert not steps.signals["spindle"]
    assert dict(zip(mill.joint_names, mill.positions, strict=True)) == pytest.approx({"door": 0.5, "table": 0.0})
    blank = steps.scene["blank"]
    assert blank.parent == "rack"
    np.testing.assert_allclose(blank.pose[:3, 3], [0.9, -0.2, 0.551], atol=1e-5)


def read(name: str, changes: dict[str, str]) -> Any:  # noqa: ANN401  what any process reads
    """Return what a changed example says, as its process reads it."""
    text = (EXAMPLES / f"{name}.yaml").read_text("utf-8")
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    return {"palletize": read_palletize, "tend": read_tend}[name](parse(text, "work.yaml"))


def test_places_are_laid_out_as_a_pattern_of_a_program_is() -> None:
    """By the formula of docs/programs.md, row by row; the second layer is turned by a quarter."""
    item = parse("schema_version: 1\npallet: {frame: p, columns: 3, rows: 2, layers: 2, pitch: [1, 2, 3]}", "a")
    places = read_pallet(item.mapping()["pallet"]).places
    assert places.shape == (12, 4, 4)
    np.testing.assert_allclose(places[[0, 2, 5, 11], :3, 3], [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [1, 1, 3]])


@pytest.mark.parametrize(
    ("name", "changes", "words"),
    [
        ("palletize", {"[box 1, box 2, box 3, box 4]": "[]"}, "the name of a part belongs here"),
        ("palletize", {"box 2,": "box 1,"}, "'box 1' is in the list already"),
        ("palletize", {"layers: 2": "layers: 1"}, "4 parts, and 2 places: add a layer"),
        ("palletize", {"[0.12, 0, 0.1]": "[0, 0, 0.1]"}, "2 columns are apart by more than 0 m"),
        ("palletize", {"columns: 2": "columns: 1000", "rows: 1": "rows: 1000"}, "2,000,000 places; 10,000 are the"),
        ("palletize", {'{hold: "on", release: "off"}': "{hold: x}"}, "the field 'release' is missing"),
        ("palletize", {"at: [0, 0, 0.05]": "at: [0, 0]"}, "three numbers belong here, not 2"),
        ("tend", {"{door: 0.4}": "{}"}, "joints and their places"),
        ("tend", {"{door: 0.4}": "{door: .nan}"}, "a finite number belongs here"),
        ("tend", {"columns: 2": "columns: 1"}, "2 parts, and 1 places"),
    ],
)
def test_what_a_file_says_wrong_is_told_with_its_line(name: str, changes: dict[str, str], words: str) -> None:
    with pytest.raises(MalformedFileError, match=words) as refused:
        read(name, changes)
    assert refused.value.metadata["file"] == "work.yaml" and int(refused.value.metadata["line"]) >= 1
