"""The suite for robot drivers: a simulated one keeps it, and each wrong one is found by the law that it breaks."""

from __future__ import annotations

import re

import numpy as np
import pytest
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.robot_drivers import LAWS, DriverFacts, RobotDriverContract
from virtualrobot_sdk.testing.subject import locate
from virtualrobot_sdk.testing.trial import NotTried, Trial, examine

from tests.contract.breaking import broken
from tests.contract.components.robot_drivers import JOINTS

COMPONENTS = "tests.contract.components.robot_drivers"
FACTS = DriverFacts(JOINTS, breaks="cut_cable", stands_at=(0.3, -0.7))

WRONG = {
    "TakesAnyCall": ("life_cycle", r"write is taken in UNCONFIGURED; it must be refused"),
    "RefusesInError": ("refusals", r"after write was refused the state is ERROR; it must be ACTIVE"),
    "OwnOrder": ("order", r"values must have the order of the names"),
    "WritesInOwnOrder": ("order", r"written \[.*\], it is at \[.*\] 1 s later: 'shoulder' is 1"),
    "NoVelocities": ("following", r"the velocities that it tells make \[0, 0\]"),
    "VelocitiesBackwards": ("following", r"velocities that it tells make .*of the way's sign"),
    "Degrees": ("reading", r"it reads \[17\.\d+, -40\.\d+\], and the robot stands at \[0\.3, -0\.7\] rad or m"),
    "Milliseconds": ("reading", r"it must be in seconds"),
    "ClockStands": ("reading", r"is always 1\.000000 s"),
    "Deaf": ("following", r"'\w+' is \S+ off; it may be 0\.001"),
    "GoesOn": ("stopping", r"after it was stopped on its way and activated again it moves from"),
    "NoStop": ("stopping", r"stopped on half of the way from .* it rests past its end at"),
    "KeepsSilent": ("recovery", r"after cut_cable and read the state is ACTIVE; it must be ERROR"),
}


class TestSimulated(RobotDriverContract):
    component = f"{COMPONENTS}:Simulated"
    facts = FACTS


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_one_is_found(name: str, seed: int) -> None:
    law, said = WRONG[name]
    found = broken(RobotDriverContract, f"{COMPONENTS}:{name}", law, seed, FACTS)
    assert re.search(said, found), found


def test_a_real_robot_is_not_moved(seed: int) -> None:
    component = f"{COMPONENTS}:Watched"
    facts = DriverFacts(JOINTS, is_real=True, breaks="cut_cable")
    with Trial(ComponentKind.ROBOT_DRIVER, locate(ComponentKind.ROBOT_DRIVER, component, {}), facts) as trial:
        for name, law in LAWS.items():
            if name in ("life_cycle", "refusals", "reading", "order"):
                assert examine(law, trial, seed).tried > 0
            else:
                with pytest.raises(NotTried, match="a real robot hangs on it"):
                    examine(law, trial, seed)
        assert trial.call("activations") == 0
        trial.call("cleanup")
        trial.call("configure", JOINTS)
        assert np.array_equal(trial.call("read").positions, [0.3, -0.7])
