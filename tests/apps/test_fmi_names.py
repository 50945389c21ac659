"""Names of FMI: a state by structured names, and outputs as a command."""

from __future__ import annotations

import math

import pytest
from virtualrobot.errors import InvalidArgumentError
from virtualrobot_apps.fmi.names import command_of, flattened, is_command, part, plain, values_for

STATE = {
    "time": 0.5,
    "robot": {"name": "ugv", "position": [1.0, 2.0, 3.0], "positions": {"base/x": 4.0, "arm": 5.0}},
    "sensors": {"ugv.lidar": {"distances": [1.5, None]}},
    "signals": {"my lamp": True},
}


def test_each_value_of_a_state_has_a_name() -> None:
    found = flattened(STATE | {"m": [[1.0, 2.0], [3.0, 4.0]]})
    assert found["time"] == [0.5]
    assert found["robot.position"] == [1.0, 2.0, 3.0]
    assert [found[f"robot.position[{one}]"] for one in (1, 2, 3)] == [[1.0], [2.0], [3.0]]
    assert (found["robot.positions.'base/x'"], found["robot.positions.arm"]) == ([4.0], [5.0])
    assert found["sensors.ugv.lidar.distances[2]"] == [math.inf]  # no echo
    assert found["signals.'my lamp'"] == [True]
    assert (found["m"], found["m[2,1]"]) == ([1.0, 2.0, 3.0, 4.0], [3.0])


@pytest.mark.parametrize("name", ["lamp", "cell.lamp", "my lamp", "it's", "a\\b", "2nd", ""])
def test_parts_are_read_back(name: str) -> None:
    assert plain(part(name)) == name


def test_inputs_that_are_not_there_are_told() -> None:
    state = flattened(STATE)
    with pytest.raises(InvalidArgumentError, match=r"input 'robot.positin\[1\]'; did you mean 'robot.position\[1\]'\?"):
        values_for("robot.positin[1]", 1, state)
    with pytest.raises(InvalidArgumentError, match="takes 2 values, and the state has 3"):
        values_for("robot.position", 2, state)


def test_outputs_are_a_command() -> None:
    assert command_of({"twist.omega": [0.5], "twist.vx": [0.25]}) == {"twist": [0.25, 0.0, 0.5]}
    assert command_of({"twist[2]": [0.5]}) == {"twist": [0.0, 0.5, 0.0]}
    assert command_of({"twist": [1.0, 2.0, 3.0]}) == {"twist": [1.0, 2.0, 3.0]}
    assert command_of({"velocities.'base/x'": [1.0], "velocities.arm": [2.0], "done": [False], "error": [3.0]}) == {
        "velocities": {"base/x": 1.0, "arm": 2.0},
        "done": False,
    }
    assert command_of({"signals.'my lamp'": [True]}) == {"signals": {"my lamp": True}}
    assert not is_command("error") and not is_command("twist[4]")
    with pytest.raises(InvalidArgumentError, match="a twist has the parts vx, vy, omega, not 'w'"):
        command_of({"twist.w": [1.0]})
