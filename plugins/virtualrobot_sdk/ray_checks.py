"""Checks of what ray casters are asked, which each of them makes, and of what they answer."""

from __future__ import annotations

import numpy as np

from virtualrobot_sdk.errors import ArgumentError, ComponentFault, FaultKind
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, Booleans, Hits, RayScene

UNIT = 1e-6
"""Largest error of the length of a direction or a normal from 1."""


def check_rays(scene: RayScene, origins: Floats, directions: Floats, max_range: float) -> None:
    """Raise ArgumentError for what `RayCaster.cast` says that a caster refuses; the message names the bad row."""
    poses = scene.world_t_element
    e = len(scene.shapes)
    if poses.shape != (e, 4, 4):
        raise ArgumentError(f"poses of {e} shapes are {poses.shape}; they must be ({e}, 4, 4)")
    if not np.isfinite(poses).all():
        i = int(np.argwhere(~np.isfinite(poses))[0, 0])
        raise ArgumentError(f"the pose of element {i} is {poses[i].tolist()}; all entries must be finite", element=i)
    if origins.ndim != 2 or origins.shape[1] != 3 or directions.shape != origins.shape:
        raise ArgumentError(f"origins {origins.shape} and directions {directions.shape} must both be (n, 3)")
    for name, vectors in (("origin", origins), ("direction", directions)):
        if not np.isfinite(vectors).all():
            i = int(np.argwhere(~np.isfinite(vectors))[0, 0])
            raise ArgumentError(f"the {name} of ray {i} is {vectors[i].tolist()}; it must be finite", ray=i)
    off = np.abs(np.sqrt(np.einsum("ij,ij->i", directions, directions)) - 1.0)
    if off.max(initial=0.0) > UNIT:
        i = int(off.argmax())
        length = float(np.linalg.norm(directions[i]))
        raise ArgumentError(f"the direction of ray {i} has the length {length:.9g}; it must be 1", ray=i, length=length)
    if not max_range > 0.0:
        raise ArgumentError(f"max_range is {max_range}; it must be above 0", max_range=max_range)


def checked_hits(value: object, scene: RayScene, origins: Floats, directions: Floats) -> Hits:
    """Return what `cast` answered; raise ComponentFault, naming the ray, where it makes no sense.

    Types and shapes are right, what is no miss has a distance, an element of the scene, a unit normal turned to the
    origin and, where the caster tells it, a triangle of the element's shape or -1 on a curved surface.
    """
    if not isinstance(value, Hits):
        raise _nonsense(f"cast returned {type(value).__name__}; it must be Hits")
    n = len(origins)
    _check_array(value.distance, "distance", np.float64, (n,))
    _check_array(value.element, "element", np.int32, (n,))
    _check_array(value.normal, "normal", np.float64, (n, 3))
    if value.triangle is not None:
        _check_array(value.triangle, "triangle", np.int32, (n,))
    is_hit = value.element != NO_ELEMENT
    lengths = np.sqrt(np.einsum("ij,ij->i", value.normal, value.normal))
    # Written so that NaN, which compares as false, counts as wrong.
    wrong: dict[str, Booleans] = {
        "a distance that is NaN or below 0": ~(value.distance >= 0.0),
        "an element that is not there": is_hit & ((value.element < 0) | (value.element >= len(scene.shapes))),
        "a distance without an element, or an element at no distance": np.isfinite(value.distance) != is_hit,
        "a miss with a normal": ~is_hit & ~(lengths == 0.0),
        "a normal that is not of unit length": is_hit & ~(np.abs(lengths - 1.0) <= UNIT),
        "a normal turned away from the ray's origin": is_hit
        & ~(np.einsum("ij,ij->i", value.normal, directions) <= UNIT),
    }
    for what, rows in wrong.items():
        _check_rows(value, origins, directions, what, rows)
    if value.triangle is not None:
        counts = np.array([*(len(shape.triangles) for shape in scene.shapes), 0])
        least = np.array([*(0 if shape.primitive is None else -1 for shape in scene.shapes), -1])
        outside = (value.triangle < least[value.element]) | (value.triangle >= counts[value.element])
        _check_rows(value, origins, directions, "a triangle that is not there", outside)
    return value


def _check_array(value: object, name: str, dtype: type, shape: tuple[int, ...]) -> None:
    if not isinstance(value, np.ndarray) or value.dtype != dtype or value.shape != shape:
        found = f"{value.dtype} {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__
        raise _nonsense(f"{name} is {found}; it must be an array of {np.dtype(dtype).name} {shape}")


def _check_rows(hits: Hits, origins: Floats, directions: Floats, what: str, wrong: Booleans) -> None:
    if wrong.any():
        i = int(wrong.argmax())
        triangle = "" if hits.triangle is None else f", triangle {hits.triangle[i]}"
        raise _nonsense(
            f"the ray from {_words(origins[i])} along {_words(directions[i])} gives {what}: distance "
            f"{hits.distance[i]}, element {hits.element[i]}, normal {_words(hits.normal[i])}{triangle}"
        )


def _words(vector: Floats) -> str:
    return "[" + ", ".join(f"{value:.6g}" for value in vector) + "]"


def _nonsense(reason: str) -> ComponentFault:
    return ComponentFault(FaultKind.NONSENSE, reason)
