"""Trees of balls hold their triangles, and what they call apart is apart by FCL's distances and NumPy's."""

from __future__ import annotations

import fcl
import numpy as np
from virtualrobot_kernel.collision.tessellation import box_triangles
from virtualrobot_kernel.numeric.balls import ball_tree, tree_and_box, two_trees
from virtualrobot_sdk.poses import rotation_matrix

from tests.tiers import Draws

SIZE = 0.01


def triangles_of(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return triangles (count, 3, 3) of a few centimetres, some of them without area, within half a metre."""
    corners = rng.uniform(-0.25, 0.25, (count, 1, 3)) + rng.uniform(-0.05, 0.05, (count, 3, 3))
    corners[::7, 2] = corners[::7, 1]
    return corners


def leaves(tree: np.ndarray) -> np.ndarray:
    """Return the rows (m, 11) at the ends of a tree."""
    return tree[tree[:, 5] >= 0.0]


def test_balls_hold_their_triangles_and_the_balls_below(rng: np.random.Generator) -> None:
    for count in (1, 2, 30):
        triangles = triangles_of(rng, count)
        tree = ball_tree(triangles, SIZE)
        skip = tree[:, 4].astype(int)
        assert skip[0] == len(tree)
        weights = rng.dirichlet(np.ones(3), 300)
        points = (weights[None, :, :, None] * triangles[:, None]).sum(axis=2)
        ends = leaves(tree)
        assert ends[:, 3].max() <= SIZE * (1.0 + 1e-12)
        for triangle, own in enumerate(points):
            parts = ends[ends[:, 5] == triangle]
            away = np.linalg.norm(own[:, None] - parts[None, :, :3], axis=2) - parts[:, 3]
            along = np.einsum("kpi,pi->kp", own[:, None] - parts[None, :, :3], parts[:, 6:9]) - parts[:, 9]
            held = np.maximum(away, np.abs(along) - parts[:, 10])
            assert held.min(axis=1).max() < 1e-9, "each point is in a ball and a slab at an end"
        for ball in range(len(tree)):
            inner = leaves(tree[ball : ball + skip[ball]])
            # Those below hold triangles that this one holds; they themselves reach out of it by their own size.
            assert np.all(np.linalg.norm(inner[:, :3] - tree[ball, :3], axis=1) <= tree[ball, 3] + SIZE)
            beside = (inner[:, :3] - tree[ball, :3]) @ tree[ball, 6:9] - tree[ball, 9]
            assert np.all(np.abs(beside) <= tree[ball, 10] + SIZE)


def test_a_turned_figure_has_a_tree_of_the_same_size(rng: np.random.Generator) -> None:
    triangles = triangles_of(rng, 20)
    turned = triangles @ rotation_matrix(rng.normal(size=3)).T
    one, other = ball_tree(triangles, SIZE), ball_tree(turned, SIZE)
    assert 0.5 < len(one) / len(other) < 2.0


def model_of(triangles: np.ndarray) -> fcl.CollisionObject:
    """Return triangles (n, 3, 3) as FCL has them."""
    model = fcl.BVHModel()
    model.beginModel(3 * len(triangles), len(triangles))
    model.addSubModel(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
    model.endModel()
    return fcl.CollisionObject(model, fcl.Transform())


def test_trees_are_apart_by_what_fcl_measures(rng: np.random.Generator, draws: Draws) -> None:
    told = 0
    for _ in range(draws(100)):
        one, other = triangles_of(rng, int(rng.integers(1, 6))), triangles_of(rng, int(rng.integers(1, 6)))
        other_t_one = np.column_stack([rotation_matrix(rng.normal(size=3)), rng.uniform(-0.4, 0.4, 3)])
        moved = one @ other_t_one[:, :3].T + other_t_one[:, 3]
        distance = fcl.distance(model_of(moved), model_of(other), fcl.DistanceRequest(), fcl.DistanceResult())
        trees = ball_tree(one, SIZE), one, ball_tree(other, SIZE), other
        room = np.full(2, -1), np.empty((512, 2), np.int64), np.empty((2, 3, 3)), np.empty((2, 3))
        assert not two_trees(*trees, other_t_one, max(distance, 0.0) + 1e-6, 1e9, *room)
        if distance > 1e-5:
            told += 1
            assert two_trees(*trees, other_t_one, distance - 1e-6, 1e9, *room)
    assert told


def test_a_tree_is_apart_from_a_box_by_what_fcl_measures(rng: np.random.Generator, draws: Draws) -> None:
    told, margin = 0, 0.02
    for _ in range(draws(100)):
        one, half = triangles_of(rng, int(rng.integers(1, 6))), rng.uniform(0.05, 0.3, (1, 3))
        box_t_one = np.column_stack([rotation_matrix(rng.normal(size=3)), rng.uniform(-0.8, 0.8, 3)])
        model, box = model_of(one @ box_t_one[:, :3].T + box_t_one[:, 3]), fcl.Box(*(2.0 * half[0]))
        corners, faces = box_triangles((*(2.0 * half[0]),))
        inside = fcl.collide(
            model, fcl.CollisionObject(box, fcl.Transform()), fcl.CollisionRequest(), fcl.CollisionResult()
        )
        surface = model_of(corners[faces])
        distance = 0.0 if inside else fcl.distance(model, surface, fcl.DistanceRequest(), fcl.DistanceResult())
        apart = tree_and_box(ball_tree(one, SIZE), one, box_t_one, half, 0, margin, np.empty((3, 3)))
        if apart:
            assert distance > margin - 1e-6
        else:
            assert distance <= np.sqrt(3.0) * margin + 1e-6, "a box grown to each side reaches so far at its corners"
        told += apart
    assert told
