"""Programs that are tried before they run: faults that were put in are found at their lines, and nothing else moves."""

from __future__ import annotations

from pathlib import Path

import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.core.trial import Trial
from virtualrobot_apps.languages.rapid.command import rapid
from virtualrobot_apps.languages.rapid.task import RapidTask, load
from virtualrobot_apps.languages.rapid.world import World
from virtualrobot_apps.languages.rapl.command import rapl

pytestmark = pytest.mark.long

HEAD = r"""MODULE Tried
  CONST jointtarget ready := [[0, 0, 0, 0, 60, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget left := [[350, 200, 200], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget right := [[350, -200, 200], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget far := [[900, 0, 200], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST jointtarget beyond := [[0, 0, 0, 0, 170, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  PROC main()
    MoveAbsJ ready, v1000, fine, tool0;
    ConfL \Off;
"""
FIRST = HEAD.count("\n") + 1
"""Line of the first statement after the head."""


def build(client: virtualrobot.Client) -> None:
    """Put an IRB 120 and a low post in front of it into a world, and an input that is off."""
    client.load_robot("model://irb120", name="arm")
    client.scene.add_part("post", virtualrobot.box(0.05, 0.05, 0.25), pose=virtualrobot.pose(0.35, 0.0, 0.125))
    client.signals.create("diShort", False)
    client.signals.create("diReady", False)


def tried(client: virtualrobot.Client, folder: Path, statements: str, longest: float = 20.0) -> Trial:
    """Return the trial of a program in a stepped world, whose statements begin in the line FIRST."""
    file = program(folder, statements)
    world = World(client, "arm")
    task = RapidTask(load([Source(file.read_text(), str(file))], client.signals), world, lambda _: None)
    trial = Trial(client, task, world.queue, longest)
    trial.run(task.run)
    return trial


def program(folder: Path, statements: str) -> Path:
    """Write a program whose statements begin in the line FIRST."""
    file = folder / "tried.mod"
    file.write_text(f"{HEAD}{statements}\n  ENDPROC\nENDMODULE\n")
    return file


ACROSS = "    MoveJ left, v500, fine, tool0;\n    MoveL right, v500, fine, tool0;"
UNDER_AN_INPUT = "    IF TestDI(diShort) THEN\n      MoveL far, v500, fine, tool0;\n    ENDIF"
CASES: list[tuple[str, tuple[int, int, str] | None]] = [
    (ACROSS, (1, 5, "'post'")),
    (ACROSS.replace("fine", "z20"), (1, 5, "'post'")),
    ("    MoveL far, v500, fine, tool0;", (0, 5, "ERR_ROBLIMIT")),
    ("    WaitTime 0.5;\n    MoveAbsJ beyond, v500, fine, tool0;", (1, 5, "ERR_ROBLIMIT")),
    (UNDER_AN_INPUT, None),
    ("    MoveJ left, v500, fine, tool0;\n    WaitDI diReady, 1;", (1, 5, "has not ended after 20 s")),
]
"""Statements, and the fault that they have: the line after the first, the column, and what is told."""


@pytest.mark.parametrize(("statements", "expected"), CASES)
def test_faults_are_found_at_their_lines(
    steps: virtualrobot.Client, tmp_path: Path, statements: str, expected: tuple[int, int, str] | None
) -> None:
    build(steps)
    found = tried(steps, tmp_path, statements).findings
    if expected is None:
        assert found == []
    else:
        line, column, said = expected
        assert found
        assert {(one.line - FIRST, one.column) for one in found} == {(line, column)}, found
        assert all(said in one.message for one in found)


def test_a_fault_under_one_input_is_found_with_that_input(steps: virtualrobot.Client, tmp_path: Path) -> None:
    build(steps)
    steps.signals["diShort"] = True
    (found,) = tried(steps, tmp_path, UNDER_AN_INPUT).findings
    assert (found.line, found.column) == (FIRST + 1, 7)
    assert found.message.startswith("ERR_ROBLIMIT")


def test_times_are_those_of_the_lines(steps: virtualrobot.Client, tmp_path: Path) -> None:
    """WaitTime is 1.5 s, and what is looked at every 10 ms may be that late at both ends."""
    build(steps)
    trial = tried(steps, tmp_path, "    MoveJ left, v500, fine, tool0;\n    WaitTime 1.5;")
    times = {int(place.rpartition(":")[2]) - FIRST: seconds for place, seconds in trial.seconds.items()}
    assert trial.findings == []
    assert times[1] == pytest.approx(1.5, abs=0.03)
    assert times[0] > 0.2


def test_the_command_tries_a_copy_and_leaves_the_world_alone(client: virtualrobot.Client, tmp_path: Path) -> None:
    build(client)
    revision, positions = client.scene.revision, client.robot("arm").positions.tolist()
    file = program(tmp_path, f"{ACROSS}\n{UNDER_AN_INPUT}")
    words = ["check", str(file), "--run", "--set", "diShort=on", "--times", "--address", client.address]
    done = CliRunner().invoke(rapid, words, standalone_mode=False)
    assert done.exception is None, done.output
    assert done.return_value == 1
    faults = [line for line in done.output.splitlines() if line.startswith(f"{file}:")]
    assert all(f"{file}:{FIRST + 1}:5: " in line and "'post'" in line for line in faults[:-1])
    assert faults[-1].startswith(f"{file}:{FIRST + 3}:7: ERR_ROBLIMIT")
    assert f" s  {file}:{FIRST}\n" in done.output
    assert done.output.splitlines()[-1].startswith(f"{len(faults)} faults in a run of ")
    assert client.scene.revision == revision
    assert client.robot("arm").positions.tolist() == positions
    assert client.signals["diShort"] is False


def test_a_program_in_rapl_is_tried_too(client: virtualrobot.Client, tmp_path: Path) -> None:
    client.load_robot("model://a255", name="arm")
    client.scene.add_part("post", virtualrobot.box(0.05, 0.05, 0.3), pose=virtualrobot.pose(0.28, 0.0, 0.15))
    file, locations = tmp_path / "job.rpl", tmp_path / "job.loc"
    locations.write_text("POINT L 200 200 250 0 90 0\nPOINT R 200 -200 250 0 90 0\nPOINT FAR 900 0 200 0 90 0\n")
    file.write_text("10 SPEED 100\n20 MOVE L\n30 MOVE R\n40 FINISH\n50 IFSIG 1 THEN 70\n60 STOP\n70 MOVE FAR\n")
    words = ["check", str(file), "--locations", str(locations), "--run", "--set", "input_1=on"]
    done = CliRunner().invoke(rapl, [*words, "--address", client.address], standalone_mode=False)
    assert done.exception is None, done.output
    faults = [line for line in done.output.splitlines() if line.startswith(f"{file}:")]
    assert len(faults) > 1
    assert all(line.startswith(f"{file}:3:4: ") and "'post'" in line for line in faults[:-1]), done.output
    assert faults[-1].startswith(f"{file}:7:4: line 70: ")
    assert done.return_value == 1
