"""Availability of Embree on this machine, tried once by a ray whose answer is known."""

from __future__ import annotations

import functools

import numpy as np

from virtualrobot_sdk.embree.library import EmbreeError, library
from virtualrobot_sdk.embree.top import TopScene
from virtualrobot_sdk.rays import Primitive, Round, Shape, make_shape


@functools.cache
def unavailable() -> str:
    """Return why Embree can't be driven, in words; empty where it can. The first call loads and tries it.

    A library that was built with other limits has packets of other sizes: rays that must meet the second of two
    triangles, a sphere behind it, and nothing, tell.
    """
    try:
        with TopScene() as scene:
            shape = make_shape([[0, 0, 0], [2, 0, 0], [0, 2, 0]], [[0, 1, 2]])
            sphere = Shape(shape.vertices, shape.triangles, "the trial's sphere", Primitive(Round.SPHERE, 1.0))
            poses = np.repeat(np.eye(4)[None], 3, axis=0)
            poses[:, 0, 3] = -9.0, 0.0, 3.0
            scene.place((shape, shape, sphere), poses)
            origins, directions = np.array([[0.5, 0.25, 2.0], [3, 0, 2], [3, 3, 2]]), np.array([[0, 0, -1]] * 3)
            found = scene.cast(origins, directions)
            is_blocked = scene.occluded(origins, directions, np.full(3, 3.0))
    except EmbreeError as error:
        return str(error)
    is_right = (
        np.allclose(found.distance, (2.0, 1.0, np.inf), atol=1e-6)
        and found.element.tolist() == [1, 2, -1]
        and found.triangle.tolist() == [0, -1, -1]
        and np.allclose(found.uv[0], (0.25, 0.125), atol=1e-6)
        and np.allclose(found.normal[:2], (0, 0, 1), atol=1e-6)
        and is_blocked.tolist() == [True, True, False]
    )
    return "" if is_right else f"the library {library().path} answers a ray wrongly: its packets have another layout"
