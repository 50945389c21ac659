"""Signals of programs in RAPID that change by themselves or are compared: pulses, delays, groups, analog ones.

And the command that runs a program with files and answers.
"""

from __future__ import annotations

from pathlib import Path

import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot_apps.languages.rapid.command import rapid
from virtualrobot_apps.languages.rapid.faults import RapidStopped
from virtualrobot_apps.languages.rapid.task import RapidTask
from virtualrobot_apps.languages.rapid.world import World

from tests.apps.languages.rapid import loaded

pytestmark = pytest.mark.long


@pytest.fixture
def world(client: virtualrobot.Client) -> World:
    """Return the world of a program: an IRB 120 and signals of each kind."""
    client.clock.speed_factor = 5.0
    client.load_robot("model://irb120", name="arm")
    for name, value in (("out", False), ("other", False), ("group", 0), ("level", 0.0)):
        client.signals.create(name, value)
    return World(client, "arm")


def prints(world: World, statements: str) -> list[str]:
    """Return what statements of main print."""
    lines: list[str] = []
    program = loaded(f"MODULE Tried\nPROC main()\n{statements}\nENDPROC\nENDMODULE", world.client.signals)
    RapidTask(program, world, lines.append).run()
    return lines


def test_pulses_and_delays_take_their_time_of_the_simulation_while_the_program_goes_on(world: World) -> None:
    """PulseDO without PLength has 0.2 s (3HAC050917, PulseDO)."""
    client = world.client
    changes: list[tuple[float, str, object]] = []
    with client.signals.follow() as watch:
        told = iter(watch)
        next(told)
        lines = prints(
            world,
            r"""
            PulseDO out;
            PulseDO \High \PLength:=0.5, other;
            WaitDO other, 0;
            SetDO \SDelay:=0.3, out, 1;
            TPWrite "" \Num:=DOutput(out);
            WaitDO out, 1;
            TPWrite "" \Num:=DInput(out);
            """,
        )
        while len(changes) < 5:
            change = next(told)
            changes += [(change.stamp.simulation_time, *one) for one in change.values.items()]
    assert lines == ["0", "1"]
    times = {name: [time for time, one, _ in changes if one == name] for name in ("out", "other")}
    tick = client.clock.read().tick_length
    assert times["out"][1] - times["out"][0] == pytest.approx(0.2, abs=1.5 * tick)
    assert times["other"][1] - times["other"][0] == pytest.approx(0.5, abs=1.5 * tick)
    assert times["out"][2] >= times["other"][1] + 0.3 - tick


def test_groups_and_analog_signals_are_compared(world: World) -> None:
    assert prints(
        world,
        r"""
        VAR bool late;
        VAR num value;
        SetGO group, 5;
        SetAO level, 2.5;
        WaitGO group, 5;
        WaitGI group \NOTEQ, 4;
        WaitGI group \GT, 4;
        WaitAI level \GT, 2;
        WaitAO level \LT, 3;
        TPWrite "" \Num:=AInput(level);
        WaitAI level \GT, 3 \MaxTime:=0.1 \TimeFlag:=late \ValueAtTimeout:=value;
        TPWrite ValToStr(late) \Num:=value;
        WaitRob \InPos;
        WaitGO group \LT, 5 \MaxTime:=0.1;
        ERROR
          TPWrite "" \Bool:=ERRNO = ERR_WAIT_MAXTIME;
          TRYNEXT;
        """,
    ) == ["2.5", "TRUE2.5", "TRUE"]


def test_a_pulse_has_bounds(world: World) -> None:
    with pytest.raises(RapidStopped, match=r"a pulse has 0\.001 to 2000 s, not 0"):
        prints(world, r"PulseDO \PLength:=0, out;")


def test_the_command_runs_a_program_with_files_and_answers(world: World, tmp_path: Path) -> None:
    program, folder = tmp_path / "log.mod", tmp_path / "logs"
    folder.mkdir()
    program.write_text(
        r"""
MODULE Log
  PROC main()
    VAR iodev file;
    VAR num many;
    TPReadNum many, "how many?";
    Open "HOME:/day.txt", file \Write;
    Write file, UIAlphaEntry(\Message:="who?") \Num:=many;
    Close file;
    SetDO doReady, 1;
  ENDPROC
ENDMODULE
"""
    )
    options = ["run", str(program), "--address", world.client.address, "--create-signals"]
    given = ["--files", str(folder), "--answer", "3", "--answer", "me:"]
    runner = CliRunner()
    run = runner.invoke(rapid, [*options, *given], standalone_mode=False)
    assert (run.return_value, run.exception) == (0, None)
    assert run.output.splitlines() == ["how many?", "who?"]
    assert (folder / "day.txt").read_text() == "me:3\n"
    assert world.client.signals["doReady"] is True
    # Without a folder it ends at its line; answers come from the standard input then.
    run = runner.invoke(rapid, options, input="3\nme\n", standalone_mode=False)
    assert isinstance(run.exception, RapidStopped)
    assert str(program) + ":7: " in str(run.exception)
    assert "--files FOLDER" in str(run.exception)
