"""Sources of ways as files describe them: each gives what its function gives, in the frame of its part."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from virtualrobot import pose
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, MissingFileError
from virtualrobot_apps.cell_io.yaml_file import parse
from virtualrobot_apps.curves.way import Way
from virtualrobot_apps.processes.leading import read_leading
from virtualrobot_apps.processes.source import Cell, Density, read_source, ways_of
from virtualrobot_apps.processes.tool_path import Follow

from tests.apps.cad_files import vda
from tests.apps.processes.workpieces import tee_joint

TARGETS = {"a": pose(0.0, 0.0, 0.0, roll=np.pi), "b": pose(0.1, 0.0, 0.0, roll=np.pi)}


def ways(folder: Path, source: str) -> list[Way]:
    """Return the ways of a source of a file in a folder, on a wall on a plate."""
    cell = Cell(lambda parts: tee_joint(), lambda target, part: TARGETS[target])
    (item,) = parse(f"schema_version: 1\nways:\n- {source}\n", str(folder / "path.yaml")).mapping()["ways"].items()
    return ways_of(read_source(item), cell, Density(chord=1e-4, step=0.01))


def test_each_source_gives_its_ways(tmp_path: Path) -> None:
    """A wall of 200 x 10 x 100 mm on a plate: its foot, its section, its top; a circle of G-code, a curve of VDA-FS."""
    (tmp_path / "ring.nc").write_text("G21 G90\nG0 X50 Y0\nG3 X50 Y0 I-50 F600\nM2\n")
    curve = vda("K = CIRCLE / 0., 0., 0., 50., 1., 0., 0., 0., 1., 0., 0., 90.", "L = PSET / 2, 0,0,0, 30,0,40")
    (tmp_path / "part.vda").write_text(curve)
    (foot,) = ways(tmp_path, "{part: plate, near: [0, 0.1, 0], trim: [0.01, 0.02], reverse: true}")
    np.testing.assert_allclose(foot.points[[0, -1]], [[0.09, 0.005, 0.0], [-0.08, 0.005, 0.0]], atol=1e-9)
    (line,) = ways(tmp_path, "{part: plate, targets: [a, b]}")
    np.testing.assert_allclose(line.outward, np.tile([0.0, 0.0, 1.0], (len(line.points), 1)), atol=1e-12)
    cuts = ways(tmp_path, "{part: plate, section: {origin: [0, 0, 0.05], normal: [0, 0, 1]}}")
    assert sorted(way.length for way in cuts) == pytest.approx([0.01, 0.01, 0.2, 0.2], abs=1e-6)
    passes = ways(tmp_path, "{part: plate, raster: {step_over: 0.02, direction: [1, 0, 0], axis: [0, 0, -1]}}")
    assert all(np.ptp(way.points[:, 1]) < 1e-9 for way in passes) and len(passes) >= 15
    (ring,) = ways(tmp_path, "{part: plate, gcode: ring.nc}")
    assert ring.length == pytest.approx(0.1 * np.pi, rel=2e-3)
    quarter, straight = ways(tmp_path, "{part: plate, curves: {file: part.vda}, normal: [0, 0, 1]}")
    np.testing.assert_allclose(np.linalg.norm(quarter.points, axis=1), 0.05, atol=1e-4)
    np.testing.assert_allclose(straight.points[[0, -1]], [[0.0, 0.0, 0.0], [0.03, 0.0, 0.04]], atol=1e-12)
    assert len(ways(tmp_path, "{part: plate, curves: {file: part.vda, names: [L]}, normal: [1, 0, 0]}")) == 1


def test_a_tool_has_angles_or_a_heading(tmp_path: Path) -> None:
    """With a heading its x stays, and it goes down where the way does."""
    (tmp_path / "drill.nc").write_text("G0 X0 Y0 Z0\nG1 Z-20 F100\n")
    (hole,) = ways(tmp_path, "{part: plate, gcode: drill.nc}")
    tool = "{heading: [0, 1, 0], standoff: 0.001}"
    text = f"{{schema_version: 1, robot: arm, ways: [{{part: plate}}], speed: 0.1, tool: {tool}}}"
    fields = parse(text, "path.yaml").mapping()
    follow = Follow(read_leading(fields, fields["ways"], fields["tool"]))
    ((name, _, frames, speed),) = follow.stretches(hole, "way 1")
    assert (name, speed) == ("way 1", 0.1)
    np.testing.assert_allclose(frames[0], pose(0, 0, 0.001, roll=np.pi, yaw=np.pi / 2), atol=1e-12)
    np.testing.assert_allclose(frames[-1, :3, 3], [0.0, 0.0, -0.019], atol=1e-12)
    fields = parse(text.replace("heading: [0, 1, 0]", "heading: [0, 1, 0], travel_degrees: 5"), "path.yaml").mapping()
    with pytest.raises(MalformedFileError, match="a tool with a heading is against the normal"):
        read_leading(fields, fields["ways"], fields["tool"])


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("{part: plate, section: {origin: [0, 0, 0]}}", "the field 'normal' is missing"),
        (
            "{part: plate, raster: {step_over: 0, direction: [1, 0, 0]}}",
            "a number from 1e-05 to 10 belongs",
        ),
        ("{part: plate, curves: {name: C1}}", "there is no field 'name'; did you mean 'names'"),
        ("{part: plate, gcode: a.nc, curves: {file: b.vda}}", "one source belongs here, and 'gcode' is given, too"),
        ("{part: plate, section: {origin: [0, 0, 0], normal: [0, 0, 1]}, normal: [0, 0, 1]}", "section has its own"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(tmp_path: Path, source: str, words: str) -> None:
    with pytest.raises(MalformedFileError, match=words):
        ways(tmp_path, source)


def test_files_of_sources_are_beside_theirs(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"none\.nc can't be read: No such file"):
        ways(tmp_path, "{part: plate, gcode: none.nc}")
    (tmp_path / "part.vda").write_text(vda("L = PSET / 2, 0,0,0, 30,0,40"))
    (line,) = ways(tmp_path, "{part: plate, curves: {file: part.vda}}")
    with pytest.raises(InvalidArgumentError, match="the surface's normal is not known; give one"):
        _ = line.outward
