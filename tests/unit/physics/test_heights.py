"""Meshes that are height fields: found whatever the order of their corners, and none where a hull is right."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_apps.vehicles.walking.terrain import rolling, triangles_of
from virtualrobot_kernel.physics.heights import heights_of

CELL = 0.05


def field(rng: np.random.Generator, rows: int = 12, columns: int = 9) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return heights, and the corners and triangles that they are."""
    heights = rolling(rng, cells=20, cell=CELL)[:rows, :columns]
    return heights, *triangles_of(heights, CELL)


def test_a_grid_is_found_again(rng: np.random.Generator) -> None:
    heights, corners, faces = field(rng)
    found = heights_of(corners + np.array([1.0, 2.0, 3.0]), faces)
    assert found is not None
    assert found.cell == pytest.approx((CELL, CELL))
    assert found.middle == pytest.approx((1.0, 2.0))
    np.testing.assert_allclose(found.heights, heights + 3.0, atol=1e-12)


def test_corners_may_be_in_any_order_single_precision_and_there_for_each_triangle(rng: np.random.Generator) -> None:
    """As an STL file has them."""
    heights, corners, faces = field(rng)
    order = rng.permutation(len(faces))
    loose = corners[faces[order]].reshape(-1, 3).astype(np.float32).astype(float)
    found = heights_of(loose, np.arange(3 * len(faces)).reshape(-1, 3))
    assert found is not None
    assert found.cell == pytest.approx((CELL, CELL), rel=1e-5)
    np.testing.assert_allclose(found.heights, heights, atol=1e-6)


def test_cells_may_be_longer_than_wide_and_all_level() -> None:
    corners, faces = triangles_of(np.zeros((2, 3)), 1.0)
    found = heights_of(corners * [0.1, 0.2, 1.0], faces)
    assert found is not None
    assert found.cell == pytest.approx((0.1, 0.2))
    assert found.heights.shape == (2, 3)


def test_what_is_no_field_is_none(rng: np.random.Generator) -> None:
    _, corners, faces = field(rng)
    uneven, folded = corners.copy(), corners.copy()
    uneven[:, 0] += 0.3 * uneven[:, 0] ** 2
    folded[faces[0, 0], :2] = folded[faces[0, 1], :2]
    turned = corners[:, [2, 0, 1]]
    box = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.2, 0.2) for z in (-0.3, 0.3)])
    triangles = np.array([[a, b, c] for a in range(8) for b in range(a) for c in range(b)])
    for name, told, said in (
        ("a hole", corners, faces[1:]),
        ("upside down", corners, faces[:, ::-1]),
        ("the same half twice", corners, np.concatenate([faces[1:], faces[-1:]])),
        ("uneven", uneven, faces),
        ("folded", folded, faces),
        ("on its edge", turned, faces),
        ("a box", box, triangles),
        ("a triangle", box[:3], triangles[:1]),
        ("nothing", box[:0], triangles[:0]),
    ):
        assert heights_of(told, said) is None, name
