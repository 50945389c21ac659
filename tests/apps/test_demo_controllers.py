"""`virtualrobot demo controllers`: programs of others work one cell, and a box stops the robot in whose way it is."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.demos.controllers import command, run

from tests.apps.test_demo_command import started_demo


@pytest.mark.long
@pytest.mark.timeout(600)
def test_three_programs_work_and_the_robot_before_the_box_is_stopped() -> None:
    with started_demo("controllers", "--headless") as process:
        output, _ = process.communicate(timeout=570)
    assert process.returncode == 0, output
    work, _, boxed = output.partition("a box is put in the way of the turner\n")
    turned = [f"turner: {angle} degrees: there" for angle in (30, -30, 0)]
    both = ["packer: part 1 is packed", "packer: part 2 is packed", "feeder: 2 parts are fed"]
    said = [line for line in work.splitlines() if re.match("turner: |feeder: |packer: ", line)]
    assert sorted(said) == sorted(turned + both), output
    assert [line for line in boxed.splitlines() if line.startswith("turner: ")] == [
        "turner: the robot's program has ended on the way to 30 degrees"
    ], output
    assert sorted(line for line in boxed.splitlines() if re.match("feeder: |packer: ", line)) == sorted(both), output
    assert re.search(r"^the log of the turner's controller has .*turner\.mod:26: .* would touch 'box'", boxed, re.M), (
        output
    )
    assert "the log of the feeder's controller has no error\n" in boxed, output
    assert "the packer's controller says: Safetystatus: NORMAL\n" in boxed, output


def test_a_program_that_fails_ends_those_that_may_wait_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "packer.py").write_text("import sys; sys.exit('the script is not running')")
    (tmp_path / "feeder.py").write_text("import time; print('begun', flush=True); time.sleep(1e6)")
    monkeypatch.setattr(run, "PROGRAMS", tmp_path)
    with pytest.raises(WrongStateError, match="the program of the packer has failed with code 1: see its words"):
        run.work({"packer": [], "feeder": []})
    assert "packer: the script is not running" in capfd.readouterr().out


def test_what_the_programs_need_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "find_spec", lambda name: None)
    done = CliRunner().invoke(command.controllers, ["--headless"])
    assert done.exit_code == 2
    assert "pip install ur_rtde abb-robot-client 'virtualrobot[console]'" in done.output
