"""Processes as files describe them: what is read and refused, and what their tools go along."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from virtualrobot.errors import InvalidArgumentError, MalformedFileError
from virtualrobot_apps.cell_io.yaml_file import Item, parse
from virtualrobot_apps.curves.way import Way
from virtualrobot_apps.processes.cut import read_cut
from virtualrobot_apps.processes.dispense import Bead, read_dispense
from virtualrobot_apps.processes.drill import read_drill
from virtualrobot_apps.processes.grind import read_grind
from virtualrobot_apps.processes.leading import Leading
from virtualrobot_apps.processes.mill import read_mill
from virtualrobot_apps.processes.paint import read_paint
from virtualrobot_apps.processes.source import Cell, ways_of
from virtualrobot_apps.processes.sources.spots import shortest_order, spots
from virtualrobot_apps.processes.spot_weld import read_spot_weld
from virtualrobot_apps.processes.switching import Switch, read_switch

from tests.apps.processes.workpieces import tee_joint

HEAD = "schema_version: 1\nprocess: any\nrobot: arm\nspeed: 0.1\n"
LINE = "{part: plate, points: [[0, 0, 0], [0.1, 0, 0]], normal: [0, 0, 1]}"
HOLES = "{part: plate, spots: {points: [[0, 0, 0], [0.1, 0, 0]], normal: [0, 0, 1], depth: 0.02, pecks: 2}}"
SPOTS = "{part: plate, spots: {targets: [a, b]}}"


def read(text: str, folder: Path = Path()) -> Item:
    """Return what a text says beside the head of a file in a folder."""
    return parse(HEAD + text, str(folder / "work.yaml"))


def ways(tool: Leading) -> list[Way]:
    """Return the ways of a tool on a wall on a plate, whose targets are at the origin and 0.1 m beside it."""

    def target(name: str, part: str) -> np.ndarray:
        found = np.diag([1.0, -1.0, -1.0, 1.0])
        found[0, 3] = 0.1 * (name == "b")
        return found

    cell = Cell(lambda parts: tee_joint(), target)
    return [way for source in tool.sources for way in ways_of(source, cell, tool.density)]


class Written:
    """Program that keeps what it is given, in words."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.steps: list[tuple[Any, ...]] = []

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401  any step of a program
        """Return what keeps a step."""
        return lambda *values: self.steps.append((name, *values))


class Gone:
    """Tool path of two seconds."""

    program, duration = "way", 2.0


def written(work: Any) -> tuple[list[tuple[Any, ...]], float]:  # noqa: ANN401  any process
    """Return what a process adds to a program for a tool path, and for how long it works."""
    program, path = Written(), Gone()
    seconds = work.along(program, path, "way 1")  # pyright: ignore[reportArgumentType] as far as they are asked
    return program.steps, seconds


def test_a_switch_is_on_along_a_way_and_stands_at_its_ends() -> None:
    item = read("signal: {signal: arc, start_seconds: 0.2, end_seconds: 0.3}").mapping()["signal"]
    steps, seconds = written(read_switch(item))
    assert steps == [
        ("set", "arc", True),
        ("dwell", 0.2),
        ("call", "way", "way 1"),
        ("dwell", 0.3),
        ("set", "arc", False),
    ]
    assert seconds == 2.5
    assert written(Switch("flow", 1.5))[0][-1] == ("set", "flow", 0.0)
    assert written(read_switch(None)) == ([("call", "way", "way 1")], 2.0)


@pytest.mark.parametrize(("width", "height"), [(0.004, 0.002), (0.006, 0.001), (0.003, 0.003)])
def test_a_bead_is_a_segment_of_a_circle(width: float, height: float) -> None:
    """Its area by the sum of many strips; of half a circle it is pi r^2 / 2, of a whole one nearly all of it."""
    radius = (0.25 * width**2 + height**2) / (2.0 * height)
    z = (np.arange(200_000) + 0.5) / 200_000 * height - height + radius
    strips = 2.0 * np.sqrt(np.maximum(radius**2 - z**2, 0.0)) * height / 200_000
    assert Bead(width, height).area == pytest.approx(strips.sum(), rel=1e-4)
    assert Bead(0.004, 0.002).area == pytest.approx(0.5 * np.pi * 0.002**2)


def test_dispensing_lays_a_bead_that_does_not_run_into_itself() -> None:
    text = f"ways: [{LINE}]\nbead: {{width: 0.004, height: 0.002}}\nvalve: glue\n"
    work = read_dispense(read(text))
    (way,) = ways(work.gun)
    ((name, _, frames, speed),) = work.stretches(way, "bead 1")
    assert (name, speed) == ("bead 1", 0.1) and len(frames) > 10
    assert written(work)[0][0] == ("set", "glue", True)
    angles = np.linspace(0.0, np.pi, 40)
    bend = np.stack([0.001 * np.cos(angles), 0.001 * np.sin(angles), 0.0 * angles], axis=1)
    with pytest.raises(InvalidArgumentError, match="a bead 4 mm wide would run into itself"):
        list(work.stretches(Way(bend, np.tile([[0.0, 0.0, 1.0]], (40, 1, 1))), "bead 1"))


def test_a_cut_is_half_a_kerf_beside_its_way() -> None:
    """On the left seen from outside and along it, which is +y of a way to +x; a hole as narrow as the kerf can't be."""
    text = f"cuts: [{LINE}]\nkerf: 0.002\nside: left\nbeam: {{signal: laser, start_seconds: 0.5}}\n"
    work = read_cut(read(text))
    (way,) = ways(work.head)
    ((_, _, frames, _),) = work.stretches(way, "cut 1")
    np.testing.assert_allclose(frames[:, 1, 3], 0.001, atol=1e-12)
    assert written(work)[0][:2] == [("set", "laser", True), ("dwell", 0.5)]
    angles = np.linspace(0.0, 6.0, 60)
    hole = np.stack([0.0008 * np.cos(angles), 0.0008 * np.sin(angles), 0.0 * angles], axis=1)
    with pytest.raises(InvalidArgumentError, match="the way bends closer than 1 mm"):
        list(work.stretches(Way(hole, np.tile([[0.0, 0.0, 1.0]], (60, 1, 1))), "cut 1"))


def test_grinding_goes_to_and_fro_and_presses() -> None:
    work = read_grind(read(f"ways: [{LINE}]\npress: 0.002\nstiffness: 10000\nstrokes: 3\nmotor: disc\n"))
    assert work.force == pytest.approx(20.0)
    (way,) = ways(work.tool)
    found = list(work.stretches(way, "way 1"))
    assert [one[0] for one in found] == [f"way 1, stroke {number}" for number in (1, 2, 3)]
    ends = [one[2][[0, -1], :3, 3] for one in found]
    np.testing.assert_allclose(ends[0], [[0.0, 0.0, -0.002], [0.1, 0.0, -0.002]], atol=1e-12)
    np.testing.assert_allclose(ends[1], ends[0][::-1], atol=1e-12)
    swung = read_grind(read(f"ways: [{LINE}]\nswing: {{width: 0.01, length: 0.02}}\n"))
    ((_, _, frames, _),) = swung.stretches(way, "way 1")
    assert np.ptp(frames[:, 1, 3]) == pytest.approx(0.01, rel=0.01)


def test_milling_cuts_at_the_feeds_of_its_g_code(tmp_path: Path) -> None:
    """Two cuts, the second with a slow plunge: each at its least feed; the spindle stays on until the end."""
    (tmp_path / "pocket.nc").write_text("G21 G90\nG0 X0 Y0 Z5\nG1 X50 F600\nG0 X0\nG1 Z-2 F120\nG1 X50 F600\nM2\n")
    text = (
        "cuts: [{part: plate, gcode: pocket.nc}]\ncutter: {heading: [1, 0, 0]}\nspindle: {signal: turn, value: 12000}\n"
    )
    work = read_mill(read(text, tmp_path))
    assert work.cutter.straight
    speeds = [speed for way in ways(work.cutter) for _, _, _, speed in work.stretches(way, "cut")]
    assert speeds == pytest.approx([0.01, 0.002])
    assert written(work)[0] == [("set", "turn", 12000.0), ("call", "way", "way 1")]
    (tmp_path / "pocket.nc").write_text("G1 X50\n")
    with pytest.raises(MalformedFileError, match=r"pocket\.nc:1: this cut has no feed"):
        read_mill(read(text, tmp_path))


def test_drilling_pecks_deeper_and_deeper() -> None:
    work = read_drill(read(f"holes: [{HOLES}]\ndrill: {{heading: [1, 0, 0]}}\nspindle: turn\n"))
    ends = [way.points[[0, -1]].tolist() for way in ways(work.drill)]
    assert ends == [
        [[x, 0.0, pytest.approx(0.01)], [x, 0.0, pytest.approx(-depth)]] for x in (0.0, 0.1) for depth in (0.01, 0.02)
    ]
    assert work.drill.straight and written(work)[0][-1][0] == "call"


def test_spots_are_welded_where_targets_are() -> None:
    work = read_spot_weld(
        read(f"spots: [{SPOTS}]\ntongs: {{heading: [1, 0, 0]}}\nweld: {{signal: gun, seconds: 0.4}}\n")
    )
    ends = np.array([way.points[-1] for way in ways(work.tongs)])
    np.testing.assert_allclose(ends, [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]], atol=1e-12)
    steps, seconds = written(work)
    assert steps == [("call", "way", "way 1"), ("set", "gun", True), ("dwell", 0.4), ("set", "gun", False)]
    assert seconds == 0.4


def test_a_way_may_be_split_and_robots_move_along() -> None:
    tool = read_grind(read(f"ways: [{LINE}]\nsplit: true\nexternal: [rail, table]\n")).tool
    assert tool.split and tool.external == ("rail", "table") and not tool.straight
    plain = read_grind(read(f"ways: [{LINE}]\n")).tool
    assert not plain.split and plain.external == ()


def test_painting_has_a_jet() -> None:
    text = (
        f"ways: [{LINE}]\ngun: {{standoff: 0.2}}\njet: {{width: 0.15, flow_millilitres: 4, solids: 0.5}}\ntrigger: t\n"
    )
    work = read_paint(read(text))
    assert (work.jet.width, work.jet.standoff, work.jet.flow) == pytest.approx((0.15, 0.2, 2e-6))
    (way,) = ways(work.gun)
    ((_, _, frames, _),) = work.stretches(way, "pass 1")
    np.testing.assert_allclose(frames[:, 2, 3], 0.2, atol=1e-12)


def test_an_order_of_spots_is_short(seed: int) -> None:
    """On a line it is the line's; of random places no two stretches that are turned round make it shorter."""
    rng = np.random.default_rng(seed)
    line = np.outer(np.append(0.0, rng.permutation(np.arange(1.0, 12.0))), [1.0, 2.0, 0.0])
    order = shortest_order(line)
    assert (np.diff(line[order, 0]) > 0.0).all()
    places = rng.uniform(0.0, 1.0, (30, 3))
    order = shortest_order(places)
    assert sorted(order) == list(range(30)) and order[0] == 0

    def length(rows: list[int]) -> float:
        return float(np.linalg.norm(np.diff(places[rows], axis=0), axis=1).sum())

    for first in range(1, 30):
        for last in range(first + 1, 30):
            turned = [*order[:first], *order[first : last + 1][::-1], *order[last + 1 :]]
            assert length(turned) >= length(order) - 1e-9


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"depth": -1.0}, "must be above 0, at least 0"),
        ({"clear": 0.0}, "must be above 0, at least 0"),
        ({"pecks": 2}, "pecks go deeper and deeper"),
    ],
)
def test_spots_without_sense_are_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(InvalidArgumentError, match=words):
        spots([[0, 0, 0]], [[0, 0, 1]], **options)
    with pytest.raises(InvalidArgumentError, match="at least one each, not 0, 0"):
        spots([], [])
    with pytest.raises(InvalidArgumentError, match="must be finite"):
        spots([[0, 0, np.nan]], [[0, 0, 1]])


@pytest.mark.parametrize(
    ("reader", "text", "words"),
    [
        (
            read_dispense,
            f"ways: [{LINE}]\nbead: {{width: 0.002, height: 0.004}}",
            "6: bead.height: a bead 0.002 m wide",
        ),
        (read_cut, f"cuts: [{LINE}]\nside: left", "give `kerf` in m"),
        (read_cut, f"cuts: [{LINE}]\nkerf: 0.001\nside: up", "'up' is not known"),
        (read_cut, f"cuts: [{LINE}]\nthickness: 0.001", "as wide as the kerf: give `kerf` in m"),
        (
            read_drill,
            f"holes: [{HOLES}]\ndiameter: 0.01\nlength: 0.015\ndrill: {{heading: [1, 0, 0]}}",
            "a hole 0.02 m deep needs a drill that is at least as long, not 0.015 m",
        ),
        (read_dispense, f"ways: [{LINE}]", "the field 'bead' is missing"),
        (read_grind, f"ways: [{LINE}]\nstiffness: 100", "give that, too"),
        (read_grind, f"ways: [{LINE}]\npress: 0.001\ntool: {{standoff: 0.1}}", "leave one of both out"),
        (read_mill, f"cuts: [{LINE}]\ncutter: {{heading: [1, 0, 0]}}", "cuts are of G-code"),
        (read_drill, f"holes: [{HOLES}]\ndiameter: 0.01\ndrill: {{heading: [1, 0, 0]}}", "give both, or neither"),
        (read_mill, "cuts: [{part: plate, gcode: a.nc}]\ncutter: {}", "a cutter plunges along itself"),
        (read_drill, f"holes: [{HOLES}]\ndrill: {{}}", "a drill goes along itself"),
        (read_drill, f"holes: [{LINE}]\ndrill: {{heading: [1, 0, 0]}}", "holes are at spots"),
        (read_drill, f"holes: [{SPOTS}]\ndrill: {{heading: [1, 0, 0]}}", "a hole has a `depth`"),
        (read_drill, f"holes: [{HOLES}]\napproach: 0.01\ndrill: {{heading: [1, 0, 0]}}", "give a longer `approach`"),
        (read_spot_weld, f"spots: [{SPOTS}]\ntongs: {{}}\nweld: {{seconds: 1}}", "tongs go along themselves"),
        (read_spot_weld, f"spots: [{LINE}]\ntongs: {{heading: [1, 0, 0]}}\nweld: {{seconds: 1}}", "give `spots` with"),
        (read_paint, f"ways: [{LINE}]\ngun: {{}}\njet: {{width: 0.1, flow_millilitres: 1}}", "sprays from a distance"),
        (
            read_paint,
            f"ways: [{LINE}]\ngun: {{standoff: 0.0005}}\njet: {{width: 0.1, flow_millilitres: 1}}",
            "opens by 179 degrees, and nozzles do so by 120 at the most: give a greater `standoff`",
        ),
        (read_drill, "holes: [{part: p, spots: {depth: 1}}]\ndrill: {heading: [1, 0, 0]}", "or at `targets`"),
        (
            read_drill,
            "holes: [{part: p, spots: {points: [[0, 0, 0]], depth: 0.01}}]\ndrill: {heading: [1, 0, 0]}",
            "points have a `normal`",
        ),
    ],
)
def test_what_a_file_says_wrong_is_told_with_its_line(reader: Any, text: str, words: str) -> None:  # noqa: ANN401
    with pytest.raises(MalformedFileError, match=words) as refused:
        reader(read(text))
    assert refused.value.metadata["file"] == "work.yaml" and int(refused.value.metadata["line"]) >= 1
