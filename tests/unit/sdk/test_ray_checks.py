"""What ray casters are asked and answer is looked at: what makes no sense is refused with the ray and the numbers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from virtualrobot_sdk.errors import ArgumentError, ComponentFault, FaultKind
from virtualrobot_sdk.ray_checks import check_rays, checked_hits
from virtualrobot_sdk.rays import Hits, Primitive, RayScene, Round
from virtualrobot_sdk.testing.ray_curves import revolved
from virtualrobot_sdk.testing.ray_truth import box

SCENE = RayScene((box(np.ones(3)), revolved(Primitive(Round.SPHERE, 0.5), 8)), np.tile(np.eye(4), (2, 1, 1)))
ORIGINS, DIRECTIONS = np.zeros((3, 3)), np.tile([0.0, 0.0, 1.0], (3, 1))
TRUE = Hits(
    np.array([0.5, np.inf, 0.5]),
    np.array([0, -1, 1], np.int32),
    np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
    np.array([11, -1, -1], np.int32),
)


def changed(array: np.ndarray, place: int | tuple[int, ...], value: float) -> np.ndarray:
    copy = array.copy()
    copy[place] = value
    return copy


@pytest.mark.parametrize(
    ("arguments", "said", "metadata"),
    [
        (
            {"directions": changed(DIRECTIONS, (1, 2), 0.0)},
            "the direction of ray 1 has the length 0; it must be 1",
            {"ray": "1", "length": "0.0"},
        ),
        (
            {"directions": changed(DIRECTIONS, (2, 0), np.nan)},
            "the direction of ray 2 is [nan, 0.0, 1.0]",
            {"ray": "2"},
        ),
        ({"origins": changed(ORIGINS, (0, 1), np.inf)}, "the origin of ray 0 is [0.0, inf, 0.0]", {"ray": "0"}),
        ({"origins": ORIGINS[:2]}, "origins (2, 3) and directions (3, 3) must both be (n, 3)", {}),
        ({"max_range": -1.0}, "max_range is -1.0; it must be above 0", {"max_range": "-1.0"}),
        ({"max_range": np.nan}, "max_range is nan; it must be above 0", {"max_range": "nan"}),
        (
            {"scene": replace(SCENE, world_t_element=SCENE.world_t_element[:1])},
            "poses of 2 shapes are (1, 4, 4); they must be (2, 4, 4)",
            {},
        ),
        (
            {"scene": replace(SCENE, world_t_element=changed(SCENE.world_t_element, (1, 0, 3), np.nan))},
            "the pose of element 1 is ",
            {"element": "1"},
        ),
    ],
)
def test_what_makes_no_sense_is_refused(arguments: dict[str, Any], said: str, metadata: dict[str, str]) -> None:
    right = {"scene": SCENE, "origins": ORIGINS, "directions": DIRECTIONS, "max_range": 10.0}
    check_rays(**right)
    with pytest.raises(ArgumentError) as refused:
        check_rays(**{**right, **arguments})
    assert said in str(refused.value)
    assert refused.value.metadata == metadata


def test_what_makes_sense_passes() -> None:
    assert checked_hits(TRUE, SCENE, ORIGINS, DIRECTIONS) is TRUE
    silent = replace(TRUE, triangle=None)
    assert checked_hits(silent, SCENE, ORIGINS, DIRECTIONS) is silent
    faceted = replace(TRUE, triangle=changed(TRUE.triangle, 2, 3))  # type: ignore[arg-type]
    assert checked_hits(faceted, SCENE, ORIGINS, DIRECTIONS) is faceted
    nothing = Hits(np.zeros(0), np.zeros(0, np.int32), np.zeros((0, 3)), np.zeros(0, np.int32))
    assert checked_hits(nothing, RayScene((), np.zeros((0, 4, 4))), ORIGINS[:0], DIRECTIONS[:0]) is nothing


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ([1.0, 2.0], "cast returned list; it must be Hits"),
        (replace(TRUE, distance=TRUE.distance[:2]), "distance is float64 (2,); it must be an array of float64 (3,)"),
        (
            replace(TRUE, element=TRUE.element.astype(np.int64)),
            "element is int64 (3,); it must be an array of int32 (3,)",
        ),
        (replace(TRUE, normal=None), "normal is NoneType; it must be an array of float64 (3, 3)"),
        (replace(TRUE, distance=changed(TRUE.distance, 0, np.nan)), "gives a distance that is NaN or below 0"),
        (replace(TRUE, distance=changed(TRUE.distance, 0, -0.5)), "gives a distance that is NaN or below 0"),
        (replace(TRUE, element=changed(TRUE.element, 0, 2)), "gives an element that is not there"),
        (replace(TRUE, element=changed(TRUE.element, 0, -2)), "gives an element that is not there"),
        (replace(TRUE, element=changed(TRUE.element, 0, -1)), "gives a distance without an element"),
        (replace(TRUE, normal=changed(TRUE.normal, (1, 0), 1.0)), "gives a miss with a normal"),
        (replace(TRUE, normal=changed(TRUE.normal, (0, 2), -0.9)), "gives a normal that is not of unit length"),
        (replace(TRUE, normal=changed(TRUE.normal, (0, 2), np.nan)), "gives a normal that is not of unit length"),
        (replace(TRUE, normal=-TRUE.normal), "gives a normal turned away from the ray's origin"),
        (replace(TRUE, triangle=np.array([12, -1, -1], np.int32)), "triangle 12"),
        (replace(TRUE, triangle=np.array([-1, -1, -1], np.int32)), "gives a triangle that is not there"),
        (replace(TRUE, triangle=np.array([0, 0, -1], np.int32)), "gives a triangle that is not there"),
    ],
)
def test_nonsense_is_a_fault(answer: object, said: str) -> None:
    with pytest.raises(ComponentFault) as fault:
        checked_hits(answer, SCENE, ORIGINS, DIRECTIONS)
    assert fault.value.kind is FaultKind.NONSENSE
    assert said in fault.value.reason
