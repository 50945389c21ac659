"""Contacts of many configurations at once are those of one after the other, down to which pair is told."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.collision import arm_contacts
from virtualrobot_kernel.collision.arm_contacts import ArmContacts
from virtualrobot_kernel.planning.robots import arm_of
from virtualrobot_kernel.world.structure import Kind

from tests.tiers import Draws, every_fifth
from tests.unit.collision.test_certain import crowded
from tests.unit.collision.worlds import scene_of


@pytest.mark.parametrize("kind", every_fifth(["xarm", "iiwa", "panda"]))
def test_they_are_those_of_each(
    kind: str, rng: np.random.Generator, draws: Draws, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Among boxes, balls, capsules, cylinders and cones, with fingers that move together; there is too little room."""
    snapshot = crowded(kind, rng)
    arm = arm_of(snapshot, snapshot.structure.node(kind, Kind.ROBOT))
    chain, count = arm.serial(), draws(400)
    monkeypatch.setattr(arm_contacts, "_ROOM", 5)
    monkeypatch.setattr(arm_contacts, "_AT_ONCE", 150)
    contacts, alone = (ArmContacts(scene_of(snapshot), snapshot, arm.q_index) for _ in range(2))
    lower, upper = np.maximum(chain.lower, -np.pi), np.minimum(chain.upper, np.pi)
    configurations = rng.uniform(lower, upper, (count, len(lower)))
    found = contacts.contacts(configurations)
    assert found == [alone.contact(q) for q in configurations]
    assert 0 < sum(pair is None for pair in found) < count
    # Everything is where it was: one after the other it says the same, and of none there is nothing to say.
    assert found == [contacts.contact(q) for q in configurations]
    assert contacts.standing() == alone.standing()
    assert contacts.contacts(configurations[:0]) == []
