"""Trees of balls hold their triangles, and what they call apart is apart by FCL's distances and NumPy's."""

from __future__ import annotations

import numpy as np
from virtualrobot_kernel.numeric.balls import ball_tree
from virtualrobot_sdk.poses import rotation_matrix

SIZE = 0.01


def triangles_of(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return triangles (count, 3, 3) of a few centimetres, some of them without area, within half a metre."""
    corners = rng.uniform(-0.25, 0.25, (count, 1, 3)) + rng.uniform(-0.05, 0.05, (count, 3, 3))
    corners[::7, 2] = corners[::7, 1]
    return corners


def leaves(tree: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Return the balls (m, 4) at the ends of a tree."""
    return tree[0][tree[1] == 1]


def test_balls_hold_their_triangles_and_the_balls_below(rng: np.random.Generator) -> None:
    for count in (1, 2, 30):
        triangles = triangles_of(rng, count)
        tree = ball_tree(triangles, SIZE)
        balls, skip = tree
        assert skip[0] == len(balls)
        weights = rng.dirichlet(np.ones(3), 300)
        points = (weights[None, :, :, None] * triangles[:, None]).sum(axis=2).reshape(-1, 3)
        ends = leaves(tree)
        away = np.linalg.norm(points[:, None] - ends[None, :, :3], axis=2) - ends[:, 3]
        assert away.min(axis=1).max() < 1e-9, "each point is in a ball at an end"
        assert ends[:, 3].max() <= SIZE * (1.0 + 1e-12)
        for ball in range(len(balls)):
            below = slice(ball + 1, ball + skip[ball])
            inner = balls[below][skip[below] == 1]
            # Those below hold triangles that this one holds; they themselves reach out of it by their own size.
            assert np.all(np.linalg.norm(inner[:, :3] - balls[ball, :3], axis=1) <= balls[ball, 3] + SIZE)


def test_a_turned_figure_has_a_tree_of_the_same_size(rng: np.random.Generator) -> None:
    triangles = triangles_of(rng, 20)
    turned = triangles @ rotation_matrix(rng.normal(size=3)).T
    one, other = ball_tree(triangles, SIZE), ball_tree(turned, SIZE)
    assert 0.5 < len(one[0]) / len(other[0]) < 2.0
