"""Demos of processes as robots' own code: what is read back from RAPID, KRL and URScript is the same path to 1e-6."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot import Client, Program, Robot
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix, pose
from virtualrobot_apps.demos.processes import CELLS
from virtualrobot_apps.demos.processes.command import DEMOS
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid.recording import recorded
from virtualrobot_apps.languages.rapid.task import load
from virtualrobot_apps.languages.writers import krl, rapid, urscript
from virtualrobot_apps.languages.writers.resolve import robot_program
from virtualrobot_apps.languages.writers.statements import Line, PointToPoint, RobotProgram, SetSignal, Value
from virtualrobot_apps.languages.writers.words import Language
from virtualrobot_apps.processes.process import plan_file

from tests.apps.languages.controllers import read_krl

pytestmark = pytest.mark.long

SAME = 1e-6
"""Meters, and parts of a rotation."""
BESIDE = 5e-5
"""Distance (m) that lines are beside the path at the most."""

OTHERS = {"girth", "tandem", "tend", "stack"}
"""Demos of two arms, of a machine, and of a tool that holds: no tool of one arm goes along ways there."""


@pytest.mark.parametrize("name", [name for name in DEMOS if name not in OTHERS])
def test_a_process_is_the_same_path_in_the_code_of_controllers(steps: Client, name: str) -> None:
    steps.scene.load_scene(CELLS / f"{DEMOS[name][0]}.yaml")
    arm = steps.robot("arm")
    program = plan_file(steps, CELLS / f"{name}.yaml").program
    wanted = resolved(steps, arm, program)
    there = moves(wanted)
    _lines_are_on_the_path(steps, program, there)

    text = rapid.write(wanted, Language({}))
    again = recorded(steps, "arm", load([Source(text, "work.mod")], steps.signals))
    for mine, (kind, goal, speed) in zip(there, read_steps(again), strict=True):
        assert kind == ("linear" if isinstance(mine, Line) else "point_to_point")
        np.testing.assert_allclose(goal, mine.goal.joints if goal.ndim == 1 else mine.goal.base_t_tcp, atol=SAME)
        if isinstance(mine, Line):
            assert speed == pytest.approx(mine.speed, abs=SAME)
    set_ = [one["set_signal"] for one in json.loads(again.text)["steps"] if "set_signal" in one]
    assert [(one["signal"], *one["value"].values()) for one in set_] == switched(wanted)

    digital = all(isinstance(value, bool) for _, value in switched(wanted))
    signals = sorted({signal for signal, _ in switched(wanted)})
    kind = "OUT" if digital else "ANOUT"
    outputs = {signal: f"${kind}[{number}]" for number, signal in enumerate(signals, 1)}
    read = read_krl(krl.write(wanted, Language(outputs)))
    gone = [one for one in read.steps if one[0] in ("PTP", "LIN")]
    for mine, (kind, (goal,), speed, *_) in zip(there, gone, strict=True):
        if isinstance(mine, Line):
            assert kind == "LIN" and speed == pytest.approx(mine.speed, abs=SAME)
            np.testing.assert_allclose(goal, mine.goal.base_t_tcp, atol=SAME)
        else:
            assert kind == "PTP"
            np.testing.assert_allclose(goal, mine.goal.joints, atol=SAME)
    told = [(one[1], one[2] == "TRUE" if digital else float(one[2])) for one in read.steps if one[0] == "set"]
    assert told == [(outputs[signal], value) for signal, value in switched(wanted)]

    outputs = {signal: f"standard_out[{number}]" for number, signal in enumerate(signals)}
    if not digital:  # a spindle's speed, which is no digital signal
        with pytest.raises(InvalidArgumentError, match=r"a digital signal of 1200.* can't be said in URScript"):
            urscript.write(wanted, Language(outputs))
        return
    script = urscript.write(wanted, Language(outputs))
    for mine, (kind, goal) in zip(there, read_script(script), strict=True):
        assert kind == ("movel" if isinstance(mine, Line) else "movej")
        same = mine.goal.base_t_tcp if isinstance(mine, Line) else mine.goal.joints
        np.testing.assert_allclose(goal, same, atol=SAME)
    outs = re.findall(r"set_standard_digital_out\((\d+), (True|False)\)", script)
    assert [(signals[int(number)], value == "True") for number, value in outs] == switched(wanted)


def test_two_arms_in_one_step_are_refused_by_name(steps: Client) -> None:
    steps.scene.load_scene(CELLS / "pair.yaml")
    program = plan_file(steps, CELLS / "girth.yaml").program
    with pytest.raises(InvalidArgumentError, match=r"it moves 'right', and the program is for 'left'"):
        resolved(steps, steps.robot("left"), program)


def resolved(client: Client, arm: Robot, program: Program) -> RobotProgram:
    return robot_program(client, program, arm, "work")


def moves(program: RobotProgram) -> list[PointToPoint | Line]:
    """Return the moves of a program; no process has arcs."""
    return [one for _, one in program.statements if isinstance(one, PointToPoint | Line)]


def switched(program: RobotProgram) -> list[tuple[str, Value]]:
    """Return the signals that a program sets, in its order, and to what."""
    return [(one.signal, one.value) for _, one in program.statements if isinstance(one, SetSignal)]


def read_steps(program: Program) -> list[tuple[str, Matrix, float]]:
    """Return the moves of a program's text: their kind, joints (6,) or poses (4, 4) from the base, and speed (m/s)."""
    found: list[tuple[str, Matrix, float]] = []
    for step in json.loads(program.text)["steps"]:
        if "move" not in step:
            continue
        (move,) = step["move"]["moves"]
        (kind,) = {"linear", "point_to_point"} & move.keys()
        goal = move[kind]["goal"] if kind == "linear" else move[kind].get("pose")
        if goal is None:
            joints = move[kind]["joints"]["joint_positions"]
            values = np.array([joints[name] for name in sorted(joints)])
        else:
            assert goal["reference"] == "arm"
            place, turn = goal["reference_t_tcp"]["position"], goal["reference_t_tcp"]["orientation"]
            values = pose(*(place.get(axis, 0.0) for axis in "xyz"))
            values[:3, :3] = Rotation.from_quat([turn.get(axis, 0.0) for axis in "xyzw"]).as_matrix()
        found.append((kind, values, move[kind].get("max_velocity_meters_per_second", 0.0)))
    return found


def read_script(text: str) -> list[tuple[str, Matrix]]:
    """Return the moves of a script: their words, and joints (6,) or poses (4, 4) in the frame of the base."""
    found: list[tuple[str, Matrix]] = []
    for word, numbers in re.findall(r"(move[jl])\(p?\[(.*?)\]", text):
        values = np.array([float(one) for one in numbers.split(",")])
        assert values.shape == (6,)
        if word == "movel":
            place = pose(*values[:3].tolist())
            place[:3, :3] = Rotation.from_rotvec(values[3:]).as_matrix()
            values = place
        found.append((word, values))
    return found


def _lines_are_on_the_path(client: Client, program: Program, there: list[PointToPoint | Line]) -> None:
    """Assert that the tool passes the end of each move, and how far it is beside the lines in between."""
    world_t_base = client.scene["arm"].pose
    seconds = program.plan(sample_time=1.0).duration
    # Of a longer one an answer holds every other tick.
    goes = program.plan(sample_time=None if seconds < 50.0 else 0.008).robots["arm"].world_t_tcp[:, :3, 3]
    steps, row, lines, begin = np.diff(goes, axis=0), 0, 0, goes[0]
    lengths = np.maximum(np.einsum("ni,ni->n", steps, steps), 1e-18)
    for move in there:
        if isinstance(move, PointToPoint) and move.zone is not None:
            continue  # its corner is cut off
        end = (world_t_base @ move.goal.base_t_tcp)[:3, 3]
        share = np.clip(np.einsum("ni,ni->n", end - goes[row:-1], steps[row:]) / lengths[row:], 0.0, 1.0)
        off = np.linalg.norm(goes[row:-1] + share[:, None] * steps[row:] - end, axis=1)
        assert off.min() < SAME, f"the tool passes {end} {1e3 * off.min():.3g} mm beside"
        first, row = row, row + int((off < SAME).argmax())
        if isinstance(move, Line) and row > first + 1:
            between, along = goes[first + 1 : row] - begin, end - begin
            share = np.clip(between @ along / (along @ along), 0.0, 1.0)
            assert np.linalg.norm(between - share[:, None] * along, axis=1).max() < BESIDE + SAME
            lines += 1
        begin = end
    assert lines > 5
