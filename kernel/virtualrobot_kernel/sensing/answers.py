"""Answers of components to a scan, looked at and turned into what comes next, in one pass each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.answers import checked_readings, nonsense
from virtualrobot_sdk.ray_checks import checked_hits
from virtualrobot_sdk.rays import Hits, RayScene, Readings

from virtualrobot_kernel.numeric import scan

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Hits of n rays: distance (m), element, incidence angle (rad) and reflectance, each (n,); as in `TrueHits`."""

    distance: Floats
    element: Integers
    incidence: Floats
    reflectance: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Told:
    """Readings of n beams: distances (m), intensities, valid (1 or 0) and nodes (-1: none), each (n,)."""

    distances: NDArray[np.float32]
    intensities: NDArray[np.float32]
    valid: NDArray[np.uint8]
    nodes: Integers


def seen(answer: object, scene: RayScene, origins: Floats, directions: Floats, reflectance_of: Floats) -> Seen:
    """Return what a ray caster's answer says of n rays; raise ComponentFault, naming the ray, where it makes no sense.

    `origins` and `directions` (n, 3) are the rays, `reflectance_of` (e,) tells of each element.
    """
    n = len(directions)
    if not isinstance(answer, Hits) or not (
        _fits(answer.distance, np.float64, (n,))
        and _fits(answer.element, np.int32, (n,))
        and _fits(answer.normal, np.float64, (n, 3))
    ):
        checked_hits(answer, scene, origins, directions)
        raise nonsense("cast returned arrays of a subclass; they must be plain arrays")
    distance, element = np.ascontiguousarray(answer.distance), np.ascontiguousarray(answer.element)
    incidence, reflectance = np.empty(n), np.empty(n)
    normal = np.ascontiguousarray(answer.normal)
    wrong = scan.looked_at(directions, distance, element, normal, reflectance_of, incidence, reflectance)
    if wrong >= 0:
        checked_hits(answer, scene, origins, directions)  # names it
        raise nonsense(
            f"cast returned nonsense for ray {wrong}: distance {distance[wrong]}, element {element[wrong]}, normal "
            f"{normal[wrong].tolist()}"
        )
    return Seen(distance, element, incidence, reflectance)


def told(answer: object, element: Integers, node_of: Integers) -> Told:
    """Return what a sensor model's answer tells of n beams; raise ComponentFault where it makes no sense.

    `element` (n, k) is what the rays hit, `node_of` (e,) what is told of each element.
    """
    n = len(element)
    if not isinstance(answer, Readings) or not (
        _fits(answer.distance, np.float64, (n,))
        and _fits(answer.intensity, np.float64, (n,))
        and _fits(answer.valid, np.bool_, (n,))
    ):
        checked_readings(answer, n)
        raise nonsense("apply returned arrays of a subclass; they must be plain arrays")
    distances, intensities = np.empty(n, np.float32), np.empty(n, np.float32)
    valid, nodes = np.empty(n, np.uint8), np.empty(n, np.int32)
    said = [np.ascontiguousarray(array) for array in (answer.distance, answer.intensity, answer.valid)]
    if scan.told(*said, element, node_of, distances, intensities, valid, nodes) >= 0:
        checked_readings(answer, n)  # names it
    return Told(distances, intensities, valid, nodes)


def _fits(array: object, dtype: type, shape: tuple[int, ...]) -> bool:
    return type(array) is np.ndarray and array.dtype == dtype and array.shape == shape
