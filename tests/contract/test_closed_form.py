"""The component `closed_form` under the test kit: it returns all solutions within limits."""

from __future__ import annotations

import pytest
from virtualrobot_sdk.testing import KinematicsContract
from virtualrobot_sdk.testing.chains import puma560, ur5


class TestClosedForm(KinematicsContract):
    component = "closed_form"
    chains = {"puma560": puma560()}  # noqa: RUF012  the class attribute is the kit's interface
    complete = True


@pytest.mark.long
class TestOtherArms(KinematicsContract):
    component = "closed_form"
    chains = {"ur5": ur5(3.0), "ur5_without_limits": ur5(float("inf"))}  # noqa: RUF012
    complete = True
