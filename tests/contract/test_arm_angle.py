"""The component `arm_angle` under the test kit."""

from __future__ import annotations

import pytest
from virtualrobot_sdk.testing import KinematicsContract
from virtualrobot_sdk.testing.chains import iiwa


@pytest.mark.long
class TestArmAngle(KinematicsContract):
    component = "arm_angle"
    chains = {"iiwa": iiwa()}  # noqa: RUF012  the class attribute is the kit's interface
