"""The contract suite for physics engines: motion against formulas, forces that add up, and bits that come again."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.physics_contacts import (
    carrying,
    heights,
    momentum,
    pushing,
    restitution,
    shapes,
    stack,
)
from virtualrobot_sdk.testing.physics_joints import couplings, limits, motors, wrenches
from virtualrobot_sdk.testing.physics_manners import cost, determinism, divergence, forgetting, refusals
from virtualrobot_sdk.testing.physics_motion import free_fall, mixing, pendulum, rolling, sliding
from virtualrobot_sdk.testing.physics_scenes import EngineFacts as EngineFacts
from virtualrobot_sdk.testing.trial import Law

LAWS: Mapping[str, Law] = MappingProxyType(
    {
        law.__name__: law
        for law in (
            *(free_fall, sliding, mixing, rolling, pendulum, stack, shapes, heights, restitution, momentum, pushing),
            *(carrying, motors, couplings, limits, wrenches, forgetting, determinism, refusals, divergence, cost),
        )
    }
)
"""Laws of all physics engines, by name, in the order in which they are tried."""


class PhysicsEngineContract(ComponentContract):
    """Contract of all physics engines; subclass it in a test file.

    class TestMyEngine(PhysicsEngineContract):
        component = "my_package/my_engine"
        facts = EngineFacts(mixing="geometric mean")
    """

    kind = ComponentKind.PHYSICS_ENGINE
    laws = LAWS
    facts: ClassVar[EngineFacts] = EngineFacts()
