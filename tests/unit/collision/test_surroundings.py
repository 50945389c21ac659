"""Surroundings that a check has used, and what of them is another one later: carts, blocks and loads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.collision.surroundings import Surroundings, surroundings_of
from virtualrobot_kernel.world.commands import Command, SetJointPositions, UpdateNode
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Inertial, Kind, PartData

from tests.unit.collision.carts import block, cart
from tests.unit.collision.worlds import after, pictured, world
from tests.unit.world.builders import shifted


@pytest.fixture(scope="module")
def seen() -> Snapshot:
    """Return a cart with a load, another cart, and a part that nobody carries."""
    load = block("load", 0.5, kind=Kind.PART, parent="cart.ball")
    return world(cart("cart"), cart("other", y=3.0), load, block("box", 5.0, kind=Kind.PART))


@pytest.fixture
def around(seen: Snapshot) -> Surroundings:
    return surroundings_of(seen, [(seen.structure.uid_by_name["cart"], "x")])


def found(around: Surroundings, now: Snapshot) -> list[tuple[str, str]]:
    return [(one.node, one.aspect) for one in around.differences(now)]


@pytest.mark.parametrize(
    ("command", "told"),
    [
        (UpdateNode("load", data=PartData(2.0)), [("load", "LOAD")]),
        (UpdateNode("load", data=PartData(2.0, Inertial(2.0, shifted(x=0.1)))), [("load", "LOAD")]),
        (UpdateNode("box", data=PartData(2.0)), []),
        (UpdateNode("box", parent_t_node=shifted(x=6.0)), [("box", "PLACE")]),
        (UpdateNode("box", new_name="crate"), []),
        (SetJointPositions("other", {"x": 0.5}), [("other.ball", "POSITION")]),
        (SetJointPositions("cart", {"x": 0.5}), []),
    ],
)
def test_what_is_another_one(
    around: Surroundings, seen: Snapshot, command: Command, told: list[tuple[str, str]]
) -> None:
    assert found(around, seen) == []
    assert found(around, after(seen, command)) == told


def test_a_load_that_was_known_is_another_one_or_gone(seen: Snapshot) -> None:
    known = after(seen, UpdateNode("load", data=PartData(2.0, Inertial(2.0))))
    around = surroundings_of(known, [(seen.structure.uid_by_name["cart"], "x")])
    assert found(around, after(known, UpdateNode("load", data=PartData(2.0, Inertial(2.0))))) == []
    heavier = after(known, UpdateNode("load", data=PartData(3.0, Inertial(3.0))))
    (told,) = around.differences(heavier)
    assert told.words == "its mass, or where that is has changed of 'load'"
    assert found(around, after(known, UpdateNode("load", data=PartData()))) == [("load", "LOAD")]


def test_where_things_are_that_move_does_not_count(around: Surroundings, seen: Snapshot) -> None:
    later = after(seen, SetJointPositions("other", {"x": 0.5}), UpdateNode("box", parent_t_node=shifted(x=6.0)))
    place = later.structure.robots[later.structure.uid_by_name["other"]].coordinates["x"]
    moving = later.state.v.copy()
    moving[place.v] = 0.1
    box = later.structure.uid_by_name["box"]
    for state, told in (
        (later.state, [("other.ball", "POSITION"), ("box", "PLACE")]),
        (replace(later.state, v=moving), [("box", "PLACE")]),
        (replace(later.state, v=moving, twists={box: np.full(6, 0.1)}), []),
    ):
        assert sorted(found(around, pictured(later.structure, state))) == sorted(told)
