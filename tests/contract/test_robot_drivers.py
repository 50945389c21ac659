"""The suite for robot drivers: computed ones of all paces keep it, and each wrong one is found by the law it breaks."""

from __future__ import annotations

import dataclasses
import re

import pytest
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.robot_drivers import LAWS, DriverFacts, RobotDriverContract
from virtualrobot_sdk.testing.subject import locate
from virtualrobot_sdk.testing.trial import NotTried, Trial, examine

from tests.contract.breaking import broken
from tests.contract.components.robot_drivers import START

HERE = "tests.contract.components.robot_drivers"
# The robot waits long for a busy machine, and settles as soon as it is there.
FACTS = DriverFacts(
    joints=2,
    moves=True,
    settle_seconds=5.0,
    stands_at=START,
    breaks=f"{HERE}:cut",
    silences=f"{HERE}:silence",
    mends=f"{HERE}:mend",
    complains=f"{HERE}:meet",
    words="joint 1 met something",
)
WATCHED = ("connecting", "readings", "silence", "ending", "complaints", "recovery")
"""Laws that are tried of a robot that may not be moved."""

WRONG = {
    "WrongCount": ("connecting", r"joints is 3; the robot has 2"),
    "NoRate": ("connecting", r"rate is 0\.0; it must be cycles a second, above 0"),
    "OtherEachTime": ("connecting", r"connected again, it tells .*serial='2'"),
    "Degrees": ("readings", r"it reads \[17\.\d+, -40\.\d+\], and the robot stands at \[0\.3, -0\.7\] rad or m"),
    "Milliseconds": ("readings", r"they must be in seconds"),
    "ClockStands": ("readings", r"of 10 readings, .* 0 have a new stamp"),
    "SpeaksNaN": ("readings", r"positions are \[0\.3, nan\]; they must be finite"),
    "TooManyInputs": ("readings", r"inputs are 0b100; the controller has 2"),
    "KeepsSilent": ("silence", r"the controller is silent, and read goes on"),
    "NeverRuns": ("holding", r"after begin no reading has Mode\.RUNNING for 0\.2 s; they have READY, NORMAL"),
    "KeepsRunning": ("holding", r"after end the robot still follows: its readings have Mode\.RUNNING"),
    "WritesInOwnOrder": ("holding", r"after begin, .* it moves from \[0\.3, -0\.7\] to"),
    "Deaf": ("following", r"sent \[.*\], it is at \[0\.3, -0\.7\] 0\.2 s later: joint \d is \S+ off; it may be 0\.001"),
    "NoVelocities": ("following", r"the velocities that it tells make \[0, 0\]"),
    "VelocitiesBackwards": ("following", r"velocities that it tells make .*of the way's sign"),
    "JobsElsewhere": ("jobs", r"run to \[.*\], it is at .* off; it may be 0\.001"),
    "CountsTwice": ("jobs", r"`done` of point 1 is 2"),
    "NoStop": ("stopping", r"stopped on the way from .*, it rests at"),
    "JobsNoStop": ("stopping", r"stopped on the way from .*, it rests at"),
    "GoesOn": ("stopping", r"after begin, stop it moves from"),
    "StopComplains": ("ending", r"stop of a robot that was not begun complains: there is nothing to stop"),
    "OwnWords": ("complaints", r"it says 'error 17'; the controller says 'joint 1 met something'"),
    "BeginsAnyway": ("complaints", r"met something', and begin is taken; it must raise DriverFault"),
    "ResetsNothing": ("complaints", r"after reset begin still complains: LB1"),
    "NeverAgain": ("recovery", r"connect complains: socket is closed"),
}


@pytest.mark.long
class TestHostPaced(RobotDriverContract):
    component = f"{HERE}/remote"
    facts = dataclasses.replace(FACTS, nobody={"host": "robot.example"})


class TestJobs(RobotDriverContract):
    component = f"{HERE}:JobsSimulated"
    facts = dataclasses.replace(FACTS, complains=f"{HERE}:press", words="button", heals=f"{HERE}:mend")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] * (i % 6 > 0)) for i, name in enumerate(WRONG)]
)
def test_a_wrong_one_is_found(name: str, seed: int) -> None:
    law, said = WRONG[name]
    facts = dataclasses.replace(FACTS, settle_seconds=0.2) if name in ("NeverRuns", "Deaf") else FACTS
    found = broken(RobotDriverContract, f"{HERE}:{name}", law, seed, facts)
    assert re.search(said, found), found


def test_one_that_keeps_to_itself_where_nobody_answers_is_found(seed: int) -> None:
    facts = dataclasses.replace(FACTS, nobody={"host": "robot.example"})
    found = broken(RobotDriverContract, f"{HERE}/anonymous", "unreachable", seed, facts)
    assert "connect complains 'timed out'; it must say where nobody answers, of {'host': 'robot.example'}" in found


def test_a_robot_that_may_not_be_moved_is_not_begun(seed: int) -> None:
    facts = dataclasses.replace(FACTS, moves=False)
    subject = locate(ComponentKind.ROBOT_DRIVER, f"{HERE}:Watched", {})
    with Trial(ComponentKind.ROBOT_DRIVER, subject, facts) as trial:
        for name, law in LAWS.items():
            if name in WATCHED:
                assert examine(law, trial, seed).tried > 0
            else:
                with pytest.raises(NotTried, match=r"may not be moved|does not say `nobody`"):
                    examine(law, trial, seed)
        assert trial.call("begun") == 0
