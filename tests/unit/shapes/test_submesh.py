"""Vertices that agree in every value are made one, and only these: as a comparison of all with all has it."""

from __future__ import annotations

from unittest import mock

import numpy as np
import pytest
from virtualrobot_kernel.shapes import submesh
from virtualrobot_kernel.shapes.submesh import Submesh, frozen, merged

from tests.tiers import Draws


def drawn(rng: np.random.Generator, repeats: bool) -> Submesh:
    """Return a submesh of a few values, so that vertices repeat, or of many, so that none does."""
    count = int(rng.integers(1, 60))
    choose = (
        (lambda width: rng.integers(-1, 2, (count, width)) * 0.5)
        if repeats
        else (lambda w: rng.normal(size=(count, w)))
    )
    normals, uv, colors = rng.random(3) < 0.5
    return Submesh(
        frozen(choose(3) * rng.choice([-1.0, 1.0]), np.float32),  # 0.0 and -0.0 are one
        frozen(rng.integers(0, count, (count, 3)), np.int32),
        frozen(choose(3), np.float32) if normals else None,
        None,
        frozen(rng.integers(0, 2, (count, 4)), np.uint8) if colors else None,
        frozen(choose(2), np.float32) if uv else None,
    )


def rows_of(part: Submesh) -> np.ndarray:
    arrays = (part.vertices, part.normals, part.uv, part.vertex_colors)
    return np.hstack([array.astype(np.float64) + 0.0 for array in arrays if array is not None])


@pytest.mark.parametrize("repeats", [True, False])
def test_each_vertex_is_there_once_and_triangles_stay(rng: np.random.Generator, draws: Draws, repeats: bool) -> None:
    for _ in range(draws(200)):
        part = drawn(rng, repeats)
        found = merged(part)
        assert len({tuple(row) for row in rows_of(found).tolist()}) == len(found.vertices)
        np.testing.assert_array_equal(rows_of(found)[found.faces], rows_of(part)[part.faces])
        with mock.patch.object(submesh, "_all_differ", return_value=False):
            slow = merged(part)
        for name in ("vertices", "faces", "normals", "uv", "vertex_colors"):
            np.testing.assert_array_equal(getattr(found, name), getattr(slow, name))


def test_equal_hashes_do_not_make_different_vertices_one(rng: np.random.Generator) -> None:
    part = drawn(rng, repeats=False)
    with mock.patch.object(submesh, "_all_differ", return_value=False):
        assert merged(part) is part
