"""Threads of a script that move the robot: one at a time, and how they stop it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.apps.languages.urscript_robot import Played

_FAR = """
        thread far():
          {statement}
        end
        handle = run far()
        sleep(0.6)
"""


@pytest.mark.parametrize("rate", [1.0, 6.0])
def test_a_stop_after_a_killed_move_has_its_own_deceleration(rate: float) -> None:
    played = Played(
        _FAR.format(statement="movej([2, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=1)")
        + f"""
        kill handle
        stopj({rate})
        textmsg("stopped")
        """
    )
    assert played.said == ["stopped"]
    rates = np.diff(played.targets[:, 0], n=2) / 0.002**2
    assert rates.min() == pytest.approx(-rate, rel=1e-3)


def test_a_stop_ends_at_once_a_velocity_that_no_function_is_waiting_for() -> None:
    played = Played(_FAR.format(statement="speedj([0.3, 0, 0, 0, 0, 0], 2)") + 'stopj(2)\n        textmsg("stopped")\n')
    assert played.said == ["stopped"]


@pytest.mark.parametrize(
    "statement", ["stopj(2)", "stopl(1)", "movej([0, -1.57, 1.57, -1.57, -1.57, 0])", "servoj([0, 0, 0, 0, 0, 0])"]
)
@pytest.mark.parametrize(
    "moves", ["movej([2, -1.57, 1.57, -1.57, -1.57, 0])", "while True:\n speedj([0.1, 0, 0, 0, 0, 0], 2, 0.1)\n end"]
)
def test_a_thread_that_moves_the_robot_while_another_one_does_ends_the_script(moves: str, statement: str) -> None:
    played = Played(_FAR.format(statement=moves) + f"{statement}\n")
    assert "Another thread is already controlling the robot: 'far'" in played.said[-1]
    assert played.controller.program is None
    for _ in range(500):
        played.controller.cycle()
    assert not played.controller.moving
