"""Ways that are looked along before they are planned, against what the kernel finds when it leads a tool there."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot import Client
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.processes.command import EXAMPLES, process
from virtualrobot_apps.processes.looking import APART
from virtualrobot_apps.processes.process import FREE, TOUCHES, UNREACHED, Look, look_file

from tests.apps.processes.test_processes_cell import TOP, cell
from tests.kernels import KernelProcess

TEXT = """schema_version: 1
process: tool_path
robot: arm
speed: 0.05
ways: [{part: plate, points: [[%s, %s, 0.012], [%s, %s, 0.012]], normal: [0, 0, 1]}]
tool: {heading: [1, 0, 0]}
tolerance: {rotation: %s}
"""


def looked(client: Client, folder: Path, first: tuple[float, float], last: tuple[float, float], turn: object) -> Look:
    """Return what is seen along a line over the plate, the tool upright."""
    file = folder / "look.yaml"
    file.write_text(TEXT % (*first, *last, turn))
    (found,) = look_file(client, file)
    assert found.name == "way 1" and len(found.at) == len(found.states) == len(found.why) == len(found.points)
    return found


def test_stretches_are_told_by_their_first_reason() -> None:
    at = np.array([0.0, 0.01, 0.02, 0.03, 0.04])
    states = (FREE, TOUCHES, TOUCHES, UNREACHED, UNREACHED)
    why = ("", "a touches b", "a touches b", "1 mm too far", "9 mm too far")
    look = Look("seam 2", np.zeros((5, 3)), at, states, why)
    assert not look.is_free and look.lines() == [
        (TOUCHES, "seam 2: 40.0 mm: from 10 to 20 mm in reach, but not free: a touches b"),
        (UNREACHED, "seam 2: 40.0 mm: from 30 to 40 mm out of reach: 1 mm too far"),
    ]
    free = Look("hole 1", np.zeros((2, 3)), at[:2], (FREE, FREE), ("", ""))
    assert free.is_free and free.lines() == [(FREE, "hole 1: 10.0 mm, reached at 2 places without touching anything")]


@pytest.mark.long
@pytest.mark.parametrize("turn", ["free", 0])
def test_where_reach_ends_the_kernel_leads_no_tool_either(steps: Client, tmp_path: Path, turn: object) -> None:
    """A line outwards, 0.45 to 1.25 m from the base, gone slowly: near its end an arm has to turn its joints fast."""
    cell(steps)
    found = looked(steps, tmp_path, (-0.1, 0.0), (0.7, 0.0), turn)
    first = found.states.index(UNREACHED)
    assert first > 0 and set(found.states[:first]) == {FREE} and set(found.states[first:]) == {UNREACHED}
    np.testing.assert_allclose(found.points[:, 0], 0.45 + found.at, atol=1e-9)
    np.testing.assert_allclose(found.points[:, 2], TOP + 0.002, atol=1e-9)
    points = found.points[: first + 2]
    frames = np.tile(np.diag([1.0, -1.0, -1.0, 1.0]), (len(points), 1, 1))
    frames[:, :3, 3] = points
    tolerance = {"rotation_z": "free"} if turn == "free" else {}
    parts = steps.paths.find_tool_path_parts("arm", frames, 0.001, tolerance=tolerance)
    refused = [one for one in parts if one.path is None]
    assert len(refused) == 1 and abs(refused[0].first - first) <= 1 and found.why[first]


@pytest.mark.long
def test_where_something_stands_it_would_touch(steps: Client, tmp_path: Path) -> None:
    """A nozzle 4 mm in radius passes a post of 40 mm: it touches within 24 mm of the middle, and nowhere else."""
    cell(steps)
    post = virtualrobot.box(0.04, 0.04, 0.05)
    steps.scene.add_object("post", post, pose=virtualrobot.pose(0.45, 0.0, TOP + 0.045))
    found = looked(steps, tmp_path, (-0.1, -0.12), (-0.1, 0.12), "free")
    beside = np.abs(found.points[:, 1])
    for at, state, why in zip(beside.tolist(), found.states, found.why, strict=True):
        if abs(at - 0.024) > 1e-4:
            assert state == (TOUCHES if at < 0.024 else FREE), at
        assert (state == TOUCHES) == ("post" in why and "tool" in why)
    assert np.diff(found.at).max() <= APART + 0.005  # frames are so far apart at the most


@pytest.mark.long
def test_a_tool_that_may_lean_gets_where_an_upright_one_would_touch(steps: Client, tmp_path: Path) -> None:
    """Under an eave over the way a nozzle fits if it leans by 25 degrees to its left, and doesn't upright."""
    cell(steps)
    eave = virtualrobot.box(0.1, 0.3, 0.01)
    steps.scene.add_object("eave", eave, pose=virtualrobot.pose(0.53, 0.0, TOP + 0.06))
    upright = looked(steps, tmp_path, (-0.06, -0.05), (-0.06, 0.05), "free")
    assert set(upright.states) == {TOUCHES}
    file = tmp_path / "look.yaml"
    text = file.read_text().replace("tool: {heading: [1, 0, 0]}\n", "")
    file.write_text(text.replace("{rotation: free}", "{rotation: free, work_degrees: 30}"))
    (leaning,) = look_file(steps, file)
    assert leaning.is_free


@pytest.mark.long
def test_the_command_tells_and_its_exit_code_does(stepped_kernel: KernelProcess, steps: Client, tmp_path: Path) -> None:
    cell(steps)
    looked(steps, tmp_path, (-0.1, -0.1), (-0.1, 0.1), "free")
    file = tmp_path / "look.yaml"
    options = ["look", str(file), "--address", stepped_kernel.address]
    told = CliRunner().invoke(process, options, standalone_mode=False)
    assert told.return_value == 0 and not told.exception, told.output
    assert re.fullmatch(r"way 1: 200.0 mm, reached at \d+ places without touching anything\n", told.output)
    looked(steps, tmp_path, (0.6, 0.0), (0.9, 0.0), "free")
    told = CliRunner().invoke(process, options, standalone_mode=False)
    assert told.return_value == 1 and told.output.startswith("way 1: 300.0 mm: from 0 to 300 mm out of reach: ")
    with pytest.raises(WrongStateError, match="palletize has no ways to look along: plan it"):
        look_file(steps, EXAMPLES / "palletize.yaml")
