"""MeetViewers: people in the room tell each other where their heads are."""

from __future__ import annotations

import queue
from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot.v1 import geometry_pb2, view_pb2

from tests.api.asking import refusal
from tests.api.reading import matrix, pose, random_matrix
from tests.kernels import Stubs
from tests.waiting import until


class Guest:
    """A person whose stream is open until they leave."""

    def __init__(self, stubs: Stubs) -> None:
        """Look on, with no head yet."""
        self._said: queue.SimpleQueue[view_pb2.MeetViewersRequest | None] = queue.SimpleQueue()
        self._answers = stubs.view.MeetViewers(iter(self._said.get, None))

    def be(self, head: geometry_pb2.Pose | None, scale: float = 0.0) -> None:
        """Tell where the head is; None for a person without one."""
        self._said.put(view_pb2.MeetViewersRequest(world_t_head=head, scale=scale))

    def seen(self) -> list[view_pb2.Viewer]:
        """Return whom the next answer tells of."""
        return list(next(self._answers).viewers)

    def end_requests(self) -> None:
        """Send nothing more, and go on looking."""
        self._said.put(None)

    def leave(self) -> None:
        """End the call."""
        self._answers.cancel()
        self.end_requests()


@pytest.fixture
def guests(stepped: Stubs) -> Iterator[list[Guest]]:
    made = [Guest(stepped) for _ in range(3)]
    yield made
    for guest in made:
        guest.leave()


def test_each_is_told_of_the_others(guests: list[Guest], rng: np.random.Generator) -> None:
    one, other, beside = guests
    for guest in guests:
        assert guest.seen() == []
    here, there = random_matrix(rng), random_matrix(rng)
    one.be(pose(here))
    (seen,) = other.seen()
    assert (seen.scale, seen.id != "", "127.0.0.1" in seen.name) == (1.0, True, True)
    np.testing.assert_allclose(matrix(seen.world_t_head), here, atol=1e-12)
    other.be(pose(there), scale=5.0)
    (met,) = one.seen()
    assert met.id != seen.id and met.scale == 5.0
    np.testing.assert_allclose(matrix(met.world_t_head), there, atol=1e-12)
    while len(both := beside.seen()) < 2:
        pass
    assert [head.id for head in both] == [seen.id, met.id]

    one.be(pose(there))
    (moved,) = other.seen()
    assert moved.id == seen.id
    np.testing.assert_allclose(matrix(moved.world_t_head), there, atol=1e-12)
    other.leave()
    assert one.seen() == []
    one.end_requests()
    until(lambda: beside.seen() == [])


def test_what_is_no_head_is_refused(guests: list[Guest]) -> None:
    one, other, beside = guests
    for guest in guests:
        assert guest.seen() == []
    one.be(geometry_pb2.Pose(position=geometry_pb2.Vector3(x=float("nan"))))
    assert refusal(one.seen).reason == "INVALID_ARGUMENT"
    other.be(geometry_pb2.Pose(), scale=-1.0)
    refused = refusal(other.seen)
    assert refused.reason == "INVALID_ARGUMENT" and "scale is -1; valid: above 0" in refused.message
    beside.be(geometry_pb2.Pose())  # those who are right are not hurt


def test_twenty_headsets_see_all_others_and_the_65th_is_told_why_not(stepped: Stubs) -> None:
    people = [Guest(stepped) for _ in range(65)]
    try:
        for person in people[:64]:
            person.seen()
            person.be(geometry_pb2.Pose())
        until(lambda: len(people[64].seen()) == 64)
        until(lambda: len(people[19].seen()) == 63)
        people[64].be(geometry_pb2.Pose())
        refused = refusal(lambda: [people[64].seen() for _ in range(3)])
        assert (refused.reason, "64 people are in the room" in refused.message) == ("TOO_LARGE", True)
    finally:
        for person in people:
            person.leave()
