"""Programs that are tried before they run: faults that were put in are found at their lines, and nothing else moves."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import astuple
from pathlib import Path

import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot_apps.languages.core import trial
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.core.trial import Trial
from virtualrobot_apps.languages.rapid.command import rapid
from virtualrobot_apps.languages.rapid.task import RapidTask, load
from virtualrobot_apps.languages.rapid.world import World
from virtualrobot_apps.languages.rapl.command import rapl

from tests.apps.languages.seeded_faults import FIRST, FREE, SEEDED, UNDER_AN_INPUT, Seeded, build, program

pytestmark = pytest.mark.long

ACROSS = SEEDED[0].statements


def tried(client: virtualrobot.Client, file: Path, longest: float = 8.0, still: float = 60.0) -> Trial:
    """Return the trial of a program in a stepped world."""
    world = World(client, "arm")
    task = RapidTask(load([Source(file.read_text(), str(file))], client.signals), world, lambda _: None)
    run = Trial(client, {task: world}, longest, still)
    run.run(task.run)
    return run


@pytest.fixture
def lent_world(steps: virtualrobot.Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have commands copy the world into a stepped kernel that runs already, and not into one that they start."""

    @contextmanager
    def copied(live: virtualrobot.Client) -> Iterator[virtualrobot.Client]:
        live.scene.save(tmp_path / "world.yaml", bundle=True)
        steps.scene.load_scene(tmp_path / "world.yaml")
        yield steps

    monkeypatch.setattr(trial, "copied_world", copied)


@pytest.mark.parametrize("seeded", SEEDED, ids=lambda one: one.name)
def test_seeded_faults_are_found_at_their_lines(steps: virtualrobot.Client, tmp_path: Path, seeded: Seeded) -> None:
    build(steps)
    if seeded.on:
        steps.signals[seeded.on] = True
    found = tried(steps, program(tmp_path, seeded.statements)).findings
    assert found
    assert {astuple(one)[:3] for one in found} == {(str(tmp_path / "tried.mod"), FIRST + seeded.line, seeded.column)}, (
        found
    )
    assert all(seeded.said in one.message for one in found), found


@pytest.mark.parametrize("statements", [FREE, UNDER_AN_INPUT], ids=["free", "under an input that is off"])
def test_what_is_right_has_no_fault(steps: virtualrobot.Client, tmp_path: Path, statements: str) -> None:
    build(steps)
    assert tried(steps, program(tmp_path, statements)).findings == []


def test_a_program_that_computes_for_ever_is_given_up(steps: virtualrobot.Client, tmp_path: Path) -> None:
    build(steps)
    file = tmp_path / "endless.mod"
    file.write_text(
        "MODULE Endless\n  PROC main()\n    WHILE TRUE DO\n      Incr reg1;\n    ENDWHILE\n  ENDPROC\nENDMODULE\n"
    )
    (found,) = tried(steps, file, still=0.5).findings
    assert found.line in (3, 4)
    assert found.message == "the program has let no time pass for 0.5 s of the wall clock"


BEATS = r"""MODULE Beats
  VAR intnum beat;
  VAR intnum rise;
  VAR intnum other;
  VAR num beats := 0;
  PERS pos place := [0, 0, 0];
  PROC main()
    place := [0, 0, 0];
    CONNECT other WITH on_place;
    IPers place, other;
    CONNECT beat WITH on_beat;
    ITimer 0.1, beat;
    CONNECT rise WITH on_rise;
    ISignalDO diReady, 1, rise;
    SetDO \SDelay:=0.55, diReady, 1;
    WaitTime 1.01;
    place.y := 2;
    WaitTime 0.02;
    place.y := 2;
    WaitTime 0.02;
    TPWrite "beats" \Num:=beats;
  ENDPROC
  TRAP on_beat
    Incr beats;
  ENDTRAP
  TRAP on_place
    TPWrite "place" \Num:=place.y;
  ENDTRAP
  TRAP on_rise
    TPWrite "rise" \Num:=beats;
  ENDTRAP
ENDMODULE
"""


def test_interrupts_come_at_their_times_in_each_run(steps: virtualrobot.Client) -> None:
    build(steps)
    program = load([Source(BEATS)], steps.signals)
    for _ in range(2):
        lines: list[str] = []
        world = World(steps, "arm")
        task = RapidTask(program, world, lines.append)
        steps.signals["diReady"] = False
        Trial(steps, {task: world}, 10.0).run(task.run)
        assert lines == ["rise5", "place2", "beats10"]


def test_times_are_those_of_the_lines(steps: virtualrobot.Client, tmp_path: Path) -> None:
    """WaitTime is 1.5 s, and what is looked at every 10 ms may be that late at both ends."""
    build(steps)
    run = tried(steps, program(tmp_path, "    MoveJ left, v500, fine, tool0;\n    WaitTime 1.5;"))
    times = {int(place.rpartition(":")[2]) - FIRST: seconds for place, seconds in run.seconds.items()}
    assert run.findings == []
    assert times[1] == pytest.approx(1.5, abs=0.03)
    assert times[0] > 0.2


ASIDE = r"""    WaitRob \InPos;
    CONNECT soon WITH away;
    ITimer \Single, SECONDS, soon;
    MoveJ left, v300, fine, tool0;
    MoveL right, v200, fine, tool0;
  ENDPROC
  VAR intnum soon;
  TRAP away
    StopMove;
    StorePath;
    MoveL Offs(CRobT(), 0, 0, 20), v500, fine, tool0;
    MoveL Offs(CRobT(), 0, 0, -20), v500, fine, tool0;
    RestoPath;
    StartMove;
  ENDTRAP
  PROC nothing_else()"""


@pytest.mark.parametrize("after", ["0.5", "2.0"])
def test_a_path_that_was_put_aside_keeps_its_lines(steps: virtualrobot.Client, tmp_path: Path, after: str) -> None:
    """The timer comes in the first move or in the second; without it the same faults are told at the same line."""
    found, seconds = [], []
    for statements in (ASIDE.replace("ITimer", "!"), ASIDE.replace("SECONDS", after)):
        steps.scene.clear()
        build(steps)
        run = tried(steps, program(tmp_path, statements))
        found.append({(one.line - FIRST, one.message.split(" at ")[0]) for one in run.findings})
        seconds.append({int(place.rpartition(":")[2]) - FIRST: time for place, time in run.seconds.items()})
    assert found[0] == found[1] != set()
    assert {line for line, _ in found[0]} == {4}
    assert seconds[1].get(13, 0.0) < 0.05
    assert all(seconds[1][line] == pytest.approx(seconds[0][line], rel=0.3) for line in (3, 4)), seconds


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


SIDES = r"""MODULE Side
  CONST jointtarget begin := [[0, 0, 0, 0, 60, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST jointtarget end := [[SIDE30, 0, 0, 0, 60, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget far := [[900, 0, 200], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  PERS tasks both{2} := [["T_L"], ["T_R"]];
  VAR syncident on;
  VAR syncident off;
  PERS num count := 0;
  PROC main()
    MoveAbsJ begin, v1000, fine, tool0;
    SyncMoveOn on, both;
    MoveAbsJ end \ID:=10, v500, fine, tool0;
    SyncMoveOff off;
    WaitUntil count >= 5;
    LAST
  ENDPROC
ENDMODULE
"""
COUNTS = """MODULE Counts
  PERS num count;
  PROC main()
    count := count + 1;
    WaitTime 0.2;
  ENDPROC
ENDMODULE
"""


@pytest.mark.usefixtures("lent_world")
def test_several_tasks_are_tried_together(client: virtualrobot.Client, tmp_path: Path) -> None:
    """Both arms make one step together, a static task counts beside, and the fault of one is told at its line."""
    for name, y in (("left", 0.5), ("right", -0.5)):
        client.load_robot("model://irb120", name=name, pose=virtualrobot.pose(0.0, y, 0.0))
    files = {name: tmp_path / f"{name}.mod" for name in ("left", "right", "counts")}
    files["left"].write_text(SIDES.replace("SIDE", "").replace("LAST", "WaitTime 3;"))
    files["right"].write_text(SIDES.replace("SIDE", "-").replace("LAST", "MoveL far, v500, fine, tool0;"))
    files["counts"].write_text(COUNTS)
    words = ["check", "--task", f"T_L@left={files['left']}", "--task", f"T_R@right={files['right']}"]
    words += ["--static", f"T_COUNT={files['counts']}", "--run", "--times", "--address", client.address]
    outputs = []
    for _ in range(2):
        done = CliRunner().invoke(rapid, words, standalone_mode=False)
        assert done.exception is None, done.output
        assert done.return_value == 1
        outputs.append(done.output)
    assert outputs[0] == outputs[1]
    (fault,) = [line for line in outputs[0].splitlines() if "ERR_ROBLIMIT" in line]
    assert fault.startswith(f"{files['right']}:15:5: ERR_ROBLIMIT")
    assert outputs[0].splitlines()[-1].startswith("1 fault in a run of ")


@pytest.mark.usefixtures("lent_world")
def test_a_program_in_rapl_is_tried_too(client: virtualrobot.Client, tmp_path: Path) -> None:
    client.load_robot("model://a255", name="arm")
    client.scene.add_part("post", virtualrobot.box(0.05, 0.05, 0.3), pose=virtualrobot.pose(0.2, -0.2, 0.15))
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
