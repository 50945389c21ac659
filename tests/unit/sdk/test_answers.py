"""Answers of workers: what they are made of travels, whatever way this Python pickles it; anything else is refused."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_sdk.errors import ComponentFault, FaultKind
from virtualrobot_sdk.kinematics import InverseResult, InverseStatus
from virtualrobot_sdk.worker.answers import Outcome, pack, unpack


@pytest.mark.parametrize("member", [*InverseStatus, *FaultKind])
def test_members_of_enums_travel(member: object) -> None:
    content = pack(Outcome.RESULT, [member])
    assert unpack(content, "a call") == [member]
    assert b"getattr" not in content


def test_a_result_travels(rng: np.random.Generator) -> None:
    solutions = rng.normal(size=(2, 6))
    meant = InverseResult(InverseStatus.SOLVED, solutions, ("up", "down"), 1e-12, 1e-12, 3, 1, "")
    found = unpack(pack(Outcome.RESULT, meant), "a call")
    np.testing.assert_array_equal(found.solutions, solutions)
    assert found._replace(solutions=meant.solutions) == meant


def test_other_classes_do_not_travel() -> None:
    with pytest.raises(ComponentFault, match=r"inverse gave something of the type builtins\.getattr"):
        unpack(pack(Outcome.RESULT, {}.get), "inverse")
