"""Answers of engines: what makes sense is taken, and what does not is told with the engine's name."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.physics.answers import Answers
from virtualrobot_sdk.physics import Body, BodyJoint, PhysicsModel, Stepped, TouchingBodies

BODIES = (Body("ball", joint=BodyJoint.FREE), Body("door", joint=BodyJoint.REVOLUTE))
ANSWERS = Answers("tests", PhysicsModel(BODIES))
RIGHT = Stepped(
    np.array([1.0, 2.0, 3.0, 0.0, 0.6, 0.0, 0.8, 0.5]),
    np.zeros(7),
    TouchingBodies(np.array([[0, 1]]), np.zeros((1, 3)), np.zeros((1, 3)), np.zeros((1, 3))),
    np.zeros(1),
)


def with_value(array: np.ndarray, at: int, value: float) -> np.ndarray:
    array = array.copy()
    array[at] = value
    return array


def test_what_makes_sense_is_taken() -> None:
    taken = ANSWERS.checked(replace(RIGHT, v=np.zeros(7, np.float32)))
    np.testing.assert_array_equal(taken.q, RIGHT.q)
    assert taken.v.dtype == np.float64


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (None, "step returned NoneType"),
        (replace(RIGHT, q=RIGHT.q.astype(object)), r"q is an array \(8,\) of object"),
        (replace(RIGHT, q=RIGHT.q.astype(complex)), r"q is an array \(8,\) of complex128"),
        (replace(RIGHT, v=np.zeros(6)), r"v is an array \(6,\) of float64; it must be a float64 array \(7,\)"),
        (replace(RIGHT, v=[0.0] * 7), "v is list"),
        (replace(RIGHT, q=with_value(RIGHT.q, 7, np.nan)), r"q\[7\] is nan"),
        (replace(RIGHT, q=with_value(RIGHT.q, 0, 1e300)), r"q\[0\] is 1e\+300; all must be finite, and at most 1e\+09"),
        (replace(RIGHT, q=with_value(RIGHT.q, 6, 5.0)), "the quaternion of 'ball' must have length 1, not 5.03"),
        (replace(RIGHT, efforts=np.zeros(2)), r"efforts is an array \(2,\)"),
        (replace(RIGHT, efforts=np.array([np.inf])), r"efforts\[0\] is inf"),
        (replace(RIGHT, contacts=None), "contacts must be TouchingBodies of 2 bodies"),
        (replace(RIGHT, contacts=replace(RIGHT.contacts, bodies=np.array([[0, 2]]))), "contacts must be"),
        (replace(RIGHT, contacts=replace(RIGHT.contacts, forces=np.full((1, 3), np.nan))), "contacts must be"),
        (replace(RIGHT, contacts=replace(RIGHT.contacts, forces=np.zeros((1, 3), object))), "contacts must be"),
    ],
)
def test_what_does_not_is_told(wrong: Any, said: str) -> None:  # noqa: ANN401 whatever an engine may answer
    with pytest.raises(KernelError, match=f"what the physics engine 'tests' answers is nonsense: {said}"):
        ANSWERS.checked(wrong)
