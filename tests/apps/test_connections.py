"""Connections in a real kernel: to the tick in steps, without a lost pulse in real time, with a gripper and a belt."""

from __future__ import annotations

import re
import threading
from pathlib import Path

import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.errors import MalformedFileError, WrongStateError
from virtualrobot_apps.cell_io.yaml_file import parse
from virtualrobot_apps.connections.command import connections as command
from virtualrobot_apps.connections.file import ConnectionFile, connections_of
from virtualrobot_apps.connections.runner import Connections

from tests.kernels import KernelProcess

LOGIC = """
schema_version: 1
signals:
- {name: start}
- {name: part}
- {name: motor}
- {name: parts, type: integer}
connections:
  motor: {delay_on: {input: start, seconds: 0.04}}
  parts: {count: {up: part}}
"""

CELL = """
schema_version: 1
signals:
- {name: eye, description: A part is there.}
- {name: reset}
- {name: run belt}
- {name: belt moving}
- {name: grip}
- {name: gripped}
- {name: speed, type: number, value: 0.2, unit: m/s}
connections:
  run belt: {not: eye}
  grip: {set_reset: {set: {delay_on: {input: {not: belt moving}, seconds: 0.1}}, reset: reset}}
tools:
- {robot: hand, signal: grip, "on": closed, "off": open, done: gripped}
belts:
- {robot: conveyor, joint: belt, signal: run belt, velocity: speed, moving: belt moving}
"""


def file_of(text: str) -> ConnectionFile:
    """Return the file of a text."""
    return connections_of(parse(text, "cell-io.yaml"))


def test_steps_are_exact_to_the_tick(steps: virtualrobot.Client) -> None:
    with Connections(steps, file_of(LOGIC)) as running:
        steps.signals["start"] = True
        running.step(10)
        assert not steps.signals["motor"], "the change is seen at the first tick, and ten ticks are 0.04 s"
        running.step(1)
        assert steps.signals["motor"]
        steps.signals["start"] = False
        running.step(1)
        assert not steps.signals["motor"]


def test_no_pulse_is_lost_in_real_time(client: virtualrobot.Client) -> None:
    """A hundred pulses without a pause between their edges are a hundred."""
    said: list[str] = []
    with Connections(client, file_of(LOGIC), said.append) as running:
        ended = threading.Event()
        thread = threading.Thread(target=running.run, args=(ended.is_set,))
        thread.start()
        for _ in range(100):
            client.signals["part"] = True
            client.signals["part"] = False
        client.signals["start"] = True
        client.signals.wait_for("parts", 100, timeout=60)
        client.signals.wait_for("motor", timeout=60)
        ended.set()
        thread.join()
    assert said == []


def test_who_sets_what_is_driven_is_told_once(client: virtualrobot.Client) -> None:
    said: list[str] = []
    with Connections(client, file_of(LOGIC), said.append) as running:
        client.signals["parts"] = 7
        running.run(lambda: bool(said))
    assert said == ["'parts' is driven by cell-io.yaml, and somebody else has set it to 7"]


def test_a_signal_that_goes_ends_it(client: virtualrobot.Client) -> None:
    with Connections(client, file_of(LOGIC)) as running:
        del client.signals["part"]
        with pytest.raises(WrongStateError, match="are gone: 'part'"):
            running.run()


def test_a_fault_changes_nothing(client: virtualrobot.Client) -> None:
    with pytest.raises(MalformedFileError, match=r"no signal 'strat'; did you mean 'start'\?"):
        Connections(client, file_of(LOGIC.replace("input: start", "input: strat")))
    assert dict(client.signals) == {}


@pytest.mark.long
def test_a_gripper_and_a_belt_are_driven_by_signals(steps: virtualrobot.Client) -> None:
    steps.load_robot("model://parallel_gripper", name="hand")
    steps.load_robot("model://conveyor", name="conveyor")
    with pytest.raises(MalformedFileError, match="has no state 'shut'; it has"):
        Connections(steps, file_of(CELL.replace('"on": closed', '"on": shut')))
    hand, conveyor = steps.robot("hand"), steps.robot("conveyor")
    with Connections(steps, file_of(CELL)) as running:
        running.step(250)
        assert steps.signals["belt moving"] and not steps.signals["grip"]
        assert conveyor.state.velocities[0] == pytest.approx(0.2)
        steps.signals["speed"] = 0.1
        running.step(600)
        assert conveyor.state.velocities[0] == pytest.approx(0.1), "the speed is a signal, too"
        steps.signals["eye"] = True
        running.step(600)
        assert not steps.signals["belt moving"]
        assert (hand.tool().state, steps.signals["gripped"]) == ("closed", True)
        steps.signals.set({"reset": True, "eye": False})
        running.step(500)
        assert (hand.tool().state, steps.signals["gripped"], steps.signals["belt moving"]) == ("open", False, True)
    steps.clock.step(250)
    assert conveyor.state.velocities[0] == 0.0, "who ends leaves no belt running"


def test_the_command_checks_and_steps(
    steps: virtualrobot.Client, stepped_kernel: KernelProcess, tmp_path: Path
) -> None:
    file = tmp_path / "cell-io.yaml"
    file.write_text(LOGIC, "utf-8")
    at = ["--address", stepped_kernel.address]
    checked = CliRunner().invoke(command, [str(file), "--check", *at])
    assert (checked.exit_code, dict(steps.signals)) == (0, {}), checked.output
    assert checked.output.endswith("cell-io.yaml fits: 2 connections; it drives 2 signals\n")
    steps.load_robot("model://conveyor", name="conveyor")
    belts_alone = CELL[: CELL.index("tools:")] + CELL[CELL.index("belts:") :]
    for wrong, said in (
        (belts_alone.replace("joint: belt", "joint: bellt"), r"yaml:\d+: .*'conveyor' has no joint 'bellt'; it has"),
        (CELL, r"yaml:\d+: .*no robot named 'hand'"),
    ):
        file.write_text(wrong, "utf-8")
        refused = CliRunner().invoke(command, [str(file), "--check", *at])
        assert re.search(said, str(refused.exception)), refused.exception
    assert dict(steps.signals) == {}
    file.write_text(LOGIC, "utf-8")
    before = steps.clock.read().stamp.tick
    done = CliRunner().invoke(command, [str(file), "--steps", "5", *at])
    assert (done.exit_code, steps.clock.read().stamp.tick) == (0, before + 5), done.output
