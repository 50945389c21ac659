"""Threads with scenes of their own over shapes that they share; and that casting lets other threads run."""

from __future__ import annotations

import gc
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from virtualrobot_sdk.embree import TopScene
from virtualrobot_sdk.embree import leaves as leaves_module
from virtualrobot_sdk.embree.leaves import leaf_of, leaves_in_use
from virtualrobot_sdk.rays import Primitive, Round, Shape, make_shape
from virtualrobot_sdk.testing.ray_truth import plane, sphere

DOWN = np.repeat([[0.0, 0.0, -1.0]], 64, axis=0)
BALL = 0.25


def pool() -> list[Shape]:
    """Return plates, and balls in between: what a ray from above meets is known by height."""
    ball = Primitive(Round.SPHERE, BALL)
    return [plane(2.0 + 0.1 * i) for i in range(6)] + [
        make_shape([[9, 9, 9 + i], [8, 9, 9], [9, 8, 9]], [[0, 1, 2]], ball) for i in range(4)
    ]


def test_threads_share_shapes_that_come_and_go(seed: int) -> None:
    gc.collect()
    before = leaves_in_use()
    shapes = pool()

    def work(number: int) -> int:
        rng = np.random.default_rng([seed, number])
        origins = np.column_stack([rng.uniform(-0.05, 0.05, (64, 2)), np.full(64, 10.0)])
        scene, cast = TopScene(), 0
        for step in range(150):
            chosen = [shapes[i] for i in rng.integers(len(shapes), size=rng.integers(0, 8))]
            heights = rng.permutation(8)[: len(chosen)].astype(float)
            poses = np.repeat(np.eye(4)[None], len(chosen), axis=0)
            poses[:, 2, 3] = heights
            scene.place(chosen, poses)
            found = scene.cast(origins, DOWN)
            if chosen:
                top = int(heights.argmax())
                beside = np.hypot(origins[:, 0], origins[:, 1])
                height = heights[top] + (np.sqrt(BALL**2 - beside**2) if chosen[top].primitive else 0.0)
                assert (found.element == top).all()
                np.testing.assert_allclose(found.distance, 10.0 - height, atol=1e-5)
                assert scene.occluded(origins, DOWN, found.distance + 0.01).all()
            else:
                assert (found.element == -1).all()
            cast += 1
            if step % 20 == 19:
                scene.close()
                scene = TopScene()
        scene.close()
        return cast

    with ThreadPoolExecutor(4) as threads:
        assert list(threads.map(work, range(4))) == [150] * 4
    assert leaves_in_use() == before


def test_what_several_threads_ask_for_is_built_once(monkeypatch, seed: int) -> None:  # noqa: ANN001
    shape = make_shape(sphere(1.0, 5).vertices * (1.0 + seed / 2**33), sphere(1.0, 5).triangles)
    built = []

    class Counted(leaves_module.Leaf):
        def __init__(self, shape: Shape) -> None:
            built.append(shape.key)
            super().__init__(shape)

    monkeypatch.setattr(leaves_module, "Leaf", Counted)
    barrier = threading.Barrier(4)

    def ask(_: int) -> object:
        barrier.wait()
        return leaf_of(shape)

    with ThreadPoolExecutor(4) as threads:
        found = list(threads.map(ask, range(4)))
    assert built == [shape.key]
    assert len({id(leaf) for leaf in found}) == 1


def test_casting_lets_other_threads_run() -> None:
    """With so long an interval between switches, another thread runs only while the one that casts has let go."""
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(200_000, 3)).astype(np.float32)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    turns = [0]
    counted = []
    with TopScene() as scene:
        scene.place((sphere(1.0, 4),), np.eye(4)[None])

        def cast() -> None:
            start = turns[0]
            scene.cast(np.zeros((1, 3), np.float32), directions)
            counted.append(turns[0] - start)

        interval = sys.getswitchinterval()
        sys.setswitchinterval(100.0)
        try:
            thread = threading.Thread(target=cast)
            thread.start()
            while thread.is_alive():
                turns[0] += 1
                time.sleep(0)
        finally:
            sys.setswitchinterval(interval)
    assert counted[0] > 10
