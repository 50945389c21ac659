"""The bundled kinematics under the test kit."""

from __future__ import annotations

import pytest
from virtualrobot_sdk.denavit_hartenberg import plain
from virtualrobot_sdk.testing import KinematicsContract
from virtualrobot_sdk.testing.chains import PALLETIZER, PUMA560, kit_chains, palletizer, puma560

KIT = kit_chains()
FEW = {name: KIT.pop(name) for name in ("iiwa", "palletizer")}


class TestChain(KinematicsContract):
    component = "chain"
    chains = FEW


@pytest.mark.long
class TestOtherChains(KinematicsContract):
    component = "chain"
    chains = KIT


class TestDhStandard(KinematicsContract):
    component = "dh"
    settings = plain(PUMA560)
    chains = {"puma560": puma560()}  # noqa: RUF012  the class attribute is the kit's interface


@pytest.mark.long
class TestDhModified(KinematicsContract):
    component = "dh"
    settings = plain(PALLETIZER)
    chains = {"palletizer": palletizer()}  # noqa: RUF012
