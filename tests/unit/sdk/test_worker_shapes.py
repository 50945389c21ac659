"""Shapes travel to a worker once, and are the right ones whatever happens in between."""

from __future__ import annotations

import operator
import threading
from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot_sdk.errors import ArgumentError, FaultKind
from virtualrobot_sdk.rays import Primitive, RayScene, Round, Shape
from virtualrobot_sdk.testing.ray_curves import revolved
from virtualrobot_sdk.testing.ray_truth import box, sphere
from virtualrobot_sdk.worker import Worker, sent
from virtualrobot_sdk.worker.kept import Kept
from virtualrobot_sdk.worker.sent import Sent

from tests.unit.sdk.worker_helpers import CASES, call, fault_of


def scene_of(*shapes: Shape) -> RayScene:
    return RayScene(shapes, np.tile(np.eye(4), (len(shapes), 1, 1)))


def boxes(rng: np.random.Generator, count: int) -> list[Shape]:
    return [box(rng.uniform(0.5, 2.0, 3)) for _ in range(count)]


@pytest.fixture
def worker() -> Iterator[Worker]:
    with Worker("rays") as it:
        it.make_from(CASES)
        yield it


def asked(worker: Worker, *scenes: RayScene) -> list[int]:
    """Return which objects the worker has for the shapes of scenes, once it is checked that they are the right ones."""
    answer = call(worker, "shapes", *scenes)
    assert isinstance(answer, list)
    shapes = [shape for scene in scenes for shape in scene.shapes]
    for shape, (_, writeable, key, total, primitive) in zip(shapes, answer, strict=True):
        assert (writeable, key, primitive) == (False, shape.key, shape.primitive)
        assert total == float(shape.vertices[shape.triangles].sum())
    return [one[0] for one in answer]


def test_a_worker_keeps_the_shapes_that_it_got(worker: Worker, rng: np.random.Generator) -> None:
    one, two = boxes(rng, 2)
    round_one = revolved(Primitive(Round.CONE, 0.5, 1.0), 8)
    first = asked(worker, scene_of(one, two, one, round_one))
    assert first[0] == first[2]
    assert len(set(first)) == 3
    again = Shape(one.vertices.copy(), one.triangles.copy(), one.key)
    assert asked(worker, scene_of(again), scene_of(round_one, two)) == [first[0], first[3], first[1]]


def test_what_was_sent_once_takes_only_its_key(rng: np.random.Generator) -> None:
    sending, large = Sent(), sphere(1.0, 6)
    before = len(sending.pack(("call", 1.0, scene_of(large, *boxes(rng, 3)))))
    assert before > large.vertices.nbytes + large.triangles.nbytes
    assert len(sending.pack(("call", 1.0, scene_of(*boxes(rng, 1), large)))) < 3000


def test_a_fault_leaves_no_doubt_about_shapes(worker: Worker, rng: np.random.Generator) -> None:
    scene, other = scene_of(*boxes(rng, 2)), scene_of(*boxes(rng, 2))
    asked(worker, scene)
    fault = fault_of(worker, "fail_with", other)
    assert (fault.kind, "2 shapes are too many" in fault.reason) == (FaultKind.RAISED, True)
    asked(worker, other, scene)
    with pytest.raises(ArgumentError):
        call(worker, "refuse")
    asked(worker, scene, other)


def test_a_question_that_is_not_read_to_its_end_costs_no_shape(worker: Worker, rng: np.random.Generator) -> None:
    """What is in the middle cannot be read, and so the worker never comes to the shapes behind it."""
    before, behind = scene_of(*boxes(rng, 1)), scene_of(*boxes(rng, 1))
    fault = fault_of(worker, "shapes", before, OnlyHere(), behind)
    assert fault.kind is FaultKind.RAISED
    asked(worker, behind, before)


def test_a_question_that_cannot_be_asked_costs_no_shape(worker: Worker, rng: np.random.Generator) -> None:
    scene, other = scene_of(*boxes(rng, 2)), scene_of(*boxes(rng, 1))
    asked(worker, scene)
    with pytest.raises(TypeError):
        call(worker, "shapes", other, threading.Lock())
    asked(worker, other, scene)


def test_shapes_by_turns_are_right_and_take_bounded_room(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    shapes = boxes(rng, 12)
    size = shapes[0].vertices.nbytes + shapes[0].triangles.nbytes
    monkeypatch.setattr(sent, "MOST_UNUSED_BYTES", 3 * size)
    sending, keeping = Sent(), Kept()
    for _ in range(300):
        chosen = [shapes[i] for i in rng.integers(len(shapes), size=rng.integers(1, 4))]
        (found,) = keeping.unpack(sending.pack((scene_of(*chosen),)))
        for shape, one in zip(chosen, found.shapes, strict=True):
            assert one.key == shape.key
            np.testing.assert_array_equal(one.vertices, shape.vertices)
        # Those of this question, 3 more that may come back, and what is forgotten with the next question.
        assert len(keeping._shapes) <= 3 + 3 + 3


def test_those_unused_for_longest_are_forgotten(rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch) -> None:
    shapes = boxes(rng, 4)
    size = shapes[0].vertices.nbytes + shapes[0].triangles.nbytes
    monkeypatch.setattr(sent, "MOST_UNUSED_BYTES", 2 * size)
    sending, keeping = Sent(), Kept()
    first = {}
    for shape in (*shapes, shapes[2], shapes[1], shapes[0]):
        (scene,) = keeping.unpack(sending.pack((scene_of(shape),)))
        first.setdefault(shape.key, scene.shapes[0])
        kept = scene.shapes[0] is first[shape.key]
        assert kept == (shape is not shapes[0] or len(first) < 4), "only the first one was unused for too long"


class OnlyHere:
    """Something that no other process can read."""

    def __reduce__(self) -> tuple[object, ...]:
        """Let whoever reads it divide by zero."""
        return operator.truediv, (1, 0)
