"""Arc welding as files describe it: what is read, the frames that follow, and what is refused, with its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, VirtualRobotError
from virtualrobot_apps.cell_io.yaml_file import parse
from virtualrobot_apps.curves.way import Way
from virtualrobot_apps.processes.arc_weld import ArcWeld, read_weld
from virtualrobot_apps.processes.process import plan_file
from virtualrobot_apps.processes.source import Cell, ways_of
from virtualrobot_apps.processes.sources.edges import edges
from virtualrobot_apps.processes.switching import Switch

from tests.apps.processes.workpieces import plate, tee_joint

WHOLE = """\
schema_version: 1
process: arc_weld
robot: arm
seams:
- {part: plate, near: [0, 0.1, 0], trim: [0.01, 0.02], reverse: true}
- {part: [plate, wall], edge: convex, near: [0, 0, 0.1]}
- {part: plate, points: [[0, 0, 0], [0.1, 0, 0]], normal: [0, 0, 1]}
- {part: plate, targets: [first, second]}
torch: {work_degrees: 40, base: [0, 1, 0], travel_degrees: -10, standoff: 0.002}
tolerance: {rotation: 20, work_degrees: 5, travel_degrees: 10}
speed: 0.01
weave: {width: 0.004, length: 0.006, shape: triangle}
passes: [[0, 0], [0.003, 0.003]]
arc: {signal: arc, start_seconds: 0.2, end_seconds: 0.3}
approach: 0.08
chord: 0.00005
step: 0.004
"""
SHORT = """\
schema_version: 1
process: arc_weld
robot: arm
seams: [{part: plate}]
speed: 0.01
"""


def read(text: str) -> ArcWeld:
    """Return what a text says."""
    return read_weld(parse(text, "weld.yaml"))


def way_of(text: str, mesh: trimesh.Trimesh) -> Way:
    """Return the way of the first seam of a text, on a mesh."""
    torch = read(text).torch
    (way,) = ways_of(torch.sources[0], Cell(lambda parts: mesh, lambda target, part: np.eye(4)), torch.density)
    return way


def test_all_of_a_file_is_read() -> None:
    weld = read(WHOLE)
    torch = weld.torch
    assert (torch.robot, torch.speed, torch.standoff, torch.approach) == ("arm", 0.01, 0.002, 0.08)
    assert torch.work == pytest.approx(np.radians(40.0)) and torch.travel == pytest.approx(np.radians(-10.0))
    assert torch.base.tolist() == [0.0, 1.0, 0.0]
    assert torch.tolerance == pytest.approx(
        {"rotation_x": np.radians(5.0), "rotation_y": np.radians(10.0), "rotation_z": np.radians(20.0)}
    )
    assert weld.weave == (0.004, 0.006, "triangle") and weld.passes == ((0.0, 0.0), (0.003, 0.003))
    assert weld.switch == Switch("arc", True, 0.2, 0.3)
    assert (torch.density.chord, torch.density.step) == (5e-5, 0.004)
    edge, other, picked, _ = torch.sources
    assert edge.parts == ("plate",) and edge.reverse and edge.trim == (0.01, 0.02) and edge.near is not None
    assert other.parts == ("plate", "wall") and picked.near is None
    plain = read(SHORT)
    assert plain.torch.tolerance == {"rotation_z": "free"} and plain.weave is None and plain.passes == ((0.0, 0.0),)
    assert plain.torch.work is None and plain.switch.signal is None


def test_the_seam_is_the_edge_that_was_meant() -> None:
    """The foot of a wall towards +y, 170 of its 200 mm, woven at the speed that the seam is to be welded at."""
    way = way_of(WHOLE, tee_joint())
    np.testing.assert_allclose(way.points[[0, -1]], [[0.09, 0.005, 0.0], [-0.08, 0.005, 0.0]], atol=1e-9)
    frames, speed = read(WHOLE).frames(way)
    waves, swing = 28, np.hypot(0.17 / 28 / 8, 0.001) * 8
    assert len(frames) == waves * 8 + 1
    assert speed == pytest.approx(0.01 * waves * swing / 0.17)
    # From the wall's normal, +y, and dragged: against the way, which goes to -x.
    z = frames[0, :3, 2]
    assert np.degrees(np.arctan2(-z[2], -z[1])) == pytest.approx(40.0)
    assert np.degrees(np.arcsin(z[0])) == pytest.approx(10.0)


def test_an_edge_is_said_where_there_are_several() -> None:
    with pytest.raises(
        MalformedFileError,
        match=r"weld.yaml:4: seams\[0\]: 'plate' has 4 concave edges: say by `near: \[x, y, z\]` in m which one: "
        r"200 mm from \[-0.1, 0.005, 0\]; 200 mm from \[0.1, -0.005, 0\]; 10 mm",
    ):
        way_of(SHORT, tee_joint())
    with pytest.raises(MalformedFileError, match="'plate' has no concave edge"):
        way_of(SHORT, plate())
    with pytest.raises(MalformedFileError, match="the trim leaves nothing of a way of 200 mm"):
        way_of(SHORT.replace("part: plate", "part: plate, near: [0, 1, 0], trim: [0.1, 0.1]"), tee_joint())


def test_too_many_frames_are_told() -> None:
    (way, *_) = edges(tee_joint())
    weld = read(SHORT + "weave: {width: 0.002, length: 0.002}\n")
    with pytest.raises(InvalidArgumentError, match=r"a way of 200 mm has 1201 frames, and a tool path 1001 at most"):
        weld.frames(way)
    with pytest.raises(InvalidArgumentError, match="the tool would be along the way"):
        read(SHORT).frames(Way(way.points, np.stack([way.tangents, way.tangents], axis=1)))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("speed: 0.01", "speed: 0", "5: speed: a number from 1e-05 to 10 belongs here, not 0"),
        ("speed: 0.01", "sped: 0.01", "there is no field 'sped'; did you mean 'speed'"),
        ("robot: arm\n", "", "1: the field 'robot' is missing"),
        ("seams: [{part: plate}]", "seams: []", "4: seams: a source of ways belongs here"),
        ("{part: plate}", "{part: []}", "the name of a part belongs here"),
        ("{part: plate}", "{edge: concave}", "the field 'part' is missing"),
        ("{part: plate}", "{part: plate, edge: sharp}", "'sharp' is not known; it is one of concave, convex"),
        ("{part: plate}", "{part: plate, near: [1, 2]}", "three numbers belong here, not 2"),
        ("{part: plate}", "{part: plate, near: [1, 2, .nan]}", "a finite number belongs here"),
        ("{part: plate}", "{part: plate, trim: [1]}", "two lengths in m belong here: at the beginning and at the end"),
        ("{part: plate}", "{part: plate, points: [[0, 0, 0]]}", "a way through points needs the normal"),
        (
            "{part: plate}",
            "{part: plate, normal: [0, 0, 1]}",
            "edge has its own",
        ),
        (
            "{part: plate}",
            "{part: p, points: [], normal: [0, 0, 1], near: [0, 0, 0]}",
            "and points are one",
        ),
        (
            "{part: plate}",
            "{part: p, targets: [a, b], edge: convex}",
            "and 'edge' is given, too",
        ),
        ("speed: 0.01", "speed: 0.01\ntorch: {work_degrees: 90}", "a number from -89 to 89 belongs here, not 90"),
        ("speed: 0.01", "speed: 0.01\ntorch: {travel_degrees: 85}", "a number from -80 to 80 belongs here, not 85"),
        ("speed: 0.01", "speed: 0.01\nweave: {width: 0.01}", "6: weave: the field 'length' is missing"),
        ("speed: 0.01", "speed: 0.01\nweave: {width: 1, length: 1, shape: zig}", "a number from|'zig' is not known"),
        ("speed: 0.01", "speed: 0.01\npasses: []", "a pass belongs here"),
        ("speed: 0.01", "speed: 0.01\npasses: [[1, 2, 3]]", "a number from -1 to 1|two lengths in m belong here"),
        ("speed: 0.01", "speed: 0.01\ntolerance: {rotation: full}", "a finite number belongs here, not 'full'"),
        ("speed: 0.01", "speed: 0.01\narc: {start_seconds: 1}", "the field 'signal' is missing"),
    ],
)
def test_what_a_file_says_wrong_is_told_with_its_line(old: str, new: str, words: str) -> None:
    assert old in SHORT
    with pytest.raises(MalformedFileError, match=words) as refused:
        read(SHORT.replace(old, new))
    assert refused.value.metadata["file"] == "weld.yaml" and int(refused.value.metadata["line"]) >= 1


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ("[]", r"the points of a way have the shape \(n, 3\), n at least 2, not \(0, 3\)"),
        ("[[0, 0, 0], [0, 0, 0]]", r"points\[1\] of the way is the same as points\[0\]"),
        ("[[0, 0, 0], [0, 0, 0.1]]", "the tool would be along the way"),
    ],
    ids=["empty", "doubled", "along"],
)
def test_points_that_make_no_seam_are_refused(points: str, words: str) -> None:
    text = SHORT.replace("{part: plate}", f"{{part: plate, points: {points}, normal: [0, 0, 1]}}")
    weld = read(text)
    with pytest.raises(VirtualRobotError, match=words):
        weld.frames(way_of(text, plate()))


def test_a_process_is_found_by_its_name(tmp_path: Path) -> None:
    """The processes are those of entry points; a file that names none, or another one, is refused before any call."""
    file = tmp_path / "weld.yaml"
    for text, words in (
        (SHORT.replace("arc_weld", "arc_wield"), "2: process: 'arc_wield' is not known; did you mean 'arc_weld'"),
        (SHORT.replace("process: arc_weld\n", ""), "the field 'process' is missing; there are arc_weld"),
    ):
        file.write_text(text)
        with pytest.raises(MalformedFileError, match=words):
            plan_file(None, file)  # pyright: ignore[reportArgumentType] no client is needed


PAIR = (
    SHORT
    + """\
external: [table]
flat_degrees: 15
torch: {work_degrees: 40}
arc: {signal: arc, start_seconds: 0.2, end_seconds: 0.5}
together:
- robot: second
  seams: [{part: wall}]
- robot: third
  seams: [{part: wall}]
  torch: {travel_degrees: 5}
  speed: 0.02
  flat_degrees: 30
  arc: {signal: other, start_seconds: 0.3}
"""
)


def test_an_arm_that_welds_along_is_as_the_first_one_but_for_what_it_says() -> None:
    work = read(PAIR)
    second, third = work.together
    assert [one.work.torch.robot for one in work.together] == ["second", "third"]
    assert [one.paced for one in work.together] == [False, True]
    assert second.work.torch.sources[0].parts == ("wall",) and work.torch.sources[0].parts == ("plate",)
    assert second.work.torch.work == work.torch.work == pytest.approx(np.radians(40.0))
    assert third.work.torch.work is None and third.work.torch.travel == pytest.approx(np.radians(5.0))
    assert [one.torch.speed for one in (work, second.work, third.work)] == [0.01, 0.01, 0.02]
    assert [one.torch.slope for one in (work, third.work)] == pytest.approx(np.radians([15.0, 30.0]))
    assert [one.signal for one in (work.switch, *work.switch.others)] == ["arc", "arc", "other"]


@pytest.mark.parametrize(
    ("old", "new", "line", "told"),
    [
        ("- robot: second\n", "- speed: 0.01\n", 11, "the field 'robot' is missing: each arm has its own"),
        ("  seams: [{part: wall}]\n- robot: third", "- robot: third", 11, "the field 'seams' is missing"),
        ("  speed: 0.02", "  external: [table]", 16, "'external' is one for all arms"),
        ("  speed: 0.02", "  split: true", 16, "'split' is one for all arms"),
        ("  speed: 0.02", "  weeve: 1", 16, "there is no field 'weeve'; did you mean 'weave'?"),
        ("external: [table]", "split: true", 6, "arms that go together can't go in parts"),
        ("flat_degrees: 15", "flat_degrees: 0", 7, "a number from 0.1 to 180 belongs here, not 0"),
        ("- robot: second\n  seams: [{part: wall}]\n", "- second\n", 11, "a mapping (key: value) belongs here"),
    ],
)
def test_what_an_arm_that_welds_along_says_wrong_is_told_with_its_line(
    old: str, new: str, line: int, told: str
) -> None:
    assert old in PAIR
    with pytest.raises(MalformedFileError) as caught:
        read(PAIR.replace(old, new, 1))
    assert f"weld.yaml:{line}: " in str(caught.value) and told in str(caught.value)
