"""What the tests of the suites share: a wrong component is tried by one law, which must find it."""

from __future__ import annotations

from typing import Any

import pytest
from virtualrobot_sdk.testing.component_contract import ComponentContract
from virtualrobot_sdk.testing.laws import LawBroken
from virtualrobot_sdk.testing.subject import locate
from virtualrobot_sdk.testing.trial import Trial, examine


def broken(contract: type[ComponentContract], component: str, law: str, seed: int, facts: Any = None) -> str:  # noqa: ANN401
    """Return with which words a law says that it is broken."""
    subject = locate(contract.kind, component, {})
    with Trial(contract.kind, subject, contract.facts if facts is None else facts) as trial:
        with pytest.raises(LawBroken) as found:
            examine(contract.laws[law], trial, seed)
    return str(found.value)
