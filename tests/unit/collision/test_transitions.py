"""From one check to the next, as pure functions: what begins, what ends, and what is tolerated."""

from __future__ import annotations

import numpy as np
from virtualrobot_kernel.collision.allowed import AllowedPairs, Cause, Pair
from virtualrobot_kernel.collision.transitions import Scope, transitions
from virtualrobot_kernel.world.collisions import CollisionMode

ROBOTS = {1: 1, 2: 1, 3: 3, 4: 0, 5: 0}
"""Nodes and their groups: 1 and 2 are of the robot 1, 3 is a robot, 4 and 5 belong to none."""


def scope(*watched: int, bodies: frozenset[int] = frozenset(ROBOTS), allowed: tuple[Pair, ...] = ()) -> Scope:
    pairs = dict.fromkeys(allowed, (Cause.CLIENT, ""))
    # Each node is a rigid body of its own.
    return Scope(
        dict.fromkeys(watched, CollisionMode.STOP), bodies, AllowedPairs(ROBOTS, {uid: uid for uid in ROBOTS}, pairs)
    )


def test_only_watched_robots_are_asked() -> None:
    assert scope(1).asks((1, 2))
    assert scope(1).asks((2, 3))
    assert scope(3).asks((2, 3))
    assert not scope(3).asks((1, 2))
    assert not scope(1, 3).asks((4, 5))
    assert not scope(1, allowed=((1, 4),)).asks((1, 4))
    assert not scope(1, bodies=frozenset({1})).asks((1, 4))
    assert not Scope().asks((1, 4))


def test_what_was_not_asked_before_is_tolerated() -> None:
    assert transitions(scope(1), (), scope(1), [(1, 4)]).begun == {(1, 4): False}
    for before in (Scope(), scope(3), scope(1, bodies=frozenset({1, 2, 3})), scope(1, allowed=((1, 4),))):
        assert transitions(before, (), scope(1), [(1, 4)]).begun == {(1, 4): True}


def test_what_is_not_asked_any_more_ends_without_being_apart() -> None:
    assert transitions(scope(1), [(1, 4)], scope(1), []).ended == {(1, 4): True}
    for now in (Scope(), scope(3), scope(1, bodies=frozenset({1, 2, 3})), scope(1, allowed=((1, 4),))):
        assert transitions(scope(1), [(1, 4)], now, []).ended == {(1, 4): False}


def test_transitions_lead_from_what_touched_to_what_touches(rng: np.random.Generator) -> None:
    """Whatever the checks find: before + begun - ended = found, and nothing begins that was there."""
    pairs = [(one, other) for one in range(1, 6) for other in range(one + 1, 6)]
    for _ in range(100):
        touching, found = ({pair for pair in pairs if rng.random() < 0.4} for _ in range(2))
        changed = transitions(scope(1), touching, scope(3), found)
        assert (touching | changed.begun.keys()) - changed.ended.keys() == found
        assert touching.isdisjoint(changed.begun)
        assert changed.ended.keys() <= touching
