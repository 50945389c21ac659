"""Whether Embree can be had here, tried once by a ray whose answer is known."""

from __future__ import annotations

import functools

import numpy as np

from virtualrobot_sdk.embree.library import EmbreeError, library
from virtualrobot_sdk.embree.top import TopScene
from virtualrobot_sdk.rays import make_shape


@functools.cache
def unavailable() -> str:
    """Return why Embree can't be driven, in words; empty where it can. The first call loads and tries it.

    A library that was built with other limits has packets of other sizes: rays that must meet the second of two
    triangles, and miss both, tell.
    """
    try:
        with TopScene() as scene:
            shape = make_shape([[0, 0, 0], [2, 0, 0], [0, 2, 0]], [[0, 1, 2]])
            poses = np.repeat(np.eye(4)[None], 2, axis=0)
            poses[:, 0, 3] = -9.0, 0.0
            scene.place((shape, shape), poses)
            origins, directions = np.array([[0.5, 0.25, 2.0], [3.0, 3.0, 2.0]]), np.array([[0, 0, -1]] * 2)
            found = scene.cast(origins, directions)
            is_blocked = scene.occluded(origins, directions, np.full(2, 3.0))
    except EmbreeError as error:
        return str(error)
    is_right = (
        np.allclose(found.distance, (2.0, np.inf), atol=1e-6)
        and found.element.tolist() == [1, -1]
        and found.triangle.tolist() == [0, -1]
        and np.allclose(found.uv[0], (0.25, 0.125), atol=1e-6)
        and np.allclose(found.normal[0], (0, 0, 1), atol=1e-6)
        and is_blocked.tolist() == [True, False]
    )
    return "" if is_right else f"the library {library().path} answers a ray wrongly: its packets have another layout"
