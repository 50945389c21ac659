"""What a sensor model answers is looked at: what makes no sense is a fault with the numbers."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from virtualrobot_sdk.answers import MOST_BEAM_RAYS, checked_beam, checked_readings
from virtualrobot_sdk.errors import ComponentFault, FaultKind
from virtualrobot_sdk.rays import Readings

WRONG_TYPES: Any = Readings  # takes arrays of other types too
ONES, YES = np.ones(3), np.ones(3, np.bool_)
AXIS = np.array([[1.0, 0.0, 0.0]])


def test_what_makes_sense_is_copied() -> None:
    beam, readings = AXIS.copy(), Readings(np.array([1.0, np.inf, 0.0]), ONES.copy(), np.array([True, False, True]))
    kept_beam, kept = checked_beam(beam), checked_readings(readings, 3)
    for array in (beam, readings.distance, readings.intensity, readings.valid):
        array[...] = 0
    np.testing.assert_array_equal(kept_beam, AXIS)
    np.testing.assert_array_equal(kept.distance, [1.0, np.inf, 0.0])
    np.testing.assert_array_equal(kept.intensity, ONES)
    np.testing.assert_array_equal(kept.valid, [True, False, True])


@pytest.mark.parametrize(
    ("beam", "said"),
    [
        (None, "beam returned None; it must be a float64 array"),
        (AXIS.astype(np.float32), "beam returned an array of float32"),
        (AXIS[0], r"shape \(3,\); it must be \(k, 3\) with k from 1 to 4096"),
        (np.tile(AXIS, (MOST_BEAM_RAYS + 1, 1)), r"shape \(4097, 3\)"),
        (AXIS * np.nan, r"beam returned nan at \[0, 0\]"),
        (AXIS * 1.001, r"ray 0 as \[1\.001, 0\.0, 0\.0\]; it must have unit length"),
        (np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), r"ray 1 as \[0\.0, 1\.0, 0\.0\]; it must have x above 0"),
    ],
)
def test_a_beam_that_makes_no_sense_is_a_fault(beam: object, said: str) -> None:
    with pytest.raises(ComponentFault) as found:
        checked_beam(beam)
    assert found.value.kind is FaultKind.NONSENSE
    assert re.search(said, str(found.value)), str(found.value)


@pytest.mark.parametrize(
    ("readings", "said"),
    [
        ((ONES, ONES, YES), "apply returned a tuple; it must be Readings"),
        (WRONG_TYPES(ONES.astype(np.float32), ONES, YES), "an array of float32; it must be a float64 array"),
        (WRONG_TYPES(ONES, ONES, ONES), "apply returned an array of float64 as valid; it must be an array of bool"),
        (Readings(np.ones((3, 1)), ONES, YES), r"distance of shape \(3, 1\); it must be \(3,\), one for each beam"),
        (Readings(ONES, ONES[:2], YES), r"intensity of shape \(2,\)"),
        (Readings(ONES, ONES, YES[:0]), r"valid of shape \(0,\)"),
        (Readings(np.array([1.0, np.nan, 1.0]), ONES, ~YES), "distance that is NaN or negative: beam 1 reads nan m"),
        (Readings(np.array([1.0, 1.0, -0.1]), ONES, ~YES), r"NaN or negative: beam 2 reads -0\.1 m"),
        (Readings(np.array([np.inf, 1.0, 1.0]), ONES, YES), "valid distance that is not finite: beam 0 reads inf m"),
        (Readings(ONES, np.array([0.0, 1.0, 1.1]), YES), r"intensity that is not from 0 to 1: .* intensity 1\.1"),
        (Readings(ONES, np.array([np.nan, 1.0, 1.0]), YES), "intensity that is not from 0 to 1"),
    ],
)
def test_readings_that_make_no_sense_are_a_fault(readings: object, said: str) -> None:
    with pytest.raises(ComponentFault) as found:
        checked_readings(readings, 3)
    assert found.value.kind is FaultKind.NONSENSE
    assert re.search(said, str(found.value)), str(found.value)
