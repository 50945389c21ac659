"""The test kit for authors: laws that components must keep, as a pytest class and as a grade.

`KinematicsContract` needs pytest; `virtualrobot grade` (`virtualrobot_sdk.testing.grade`) does not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from virtualrobot_sdk.testing.chains import chain_of, kit_chains

if TYPE_CHECKING:
    from virtualrobot_sdk.testing.contract import KinematicsContract

__all__ = ["KinematicsContract", "chain_of", "kit_chains"]


def __getattr__(name: str) -> object:
    """Import what needs pytest only when it is asked for: who runs a grade may not have it."""
    if name == "KinematicsContract":
        from virtualrobot_sdk.testing.contract import KinematicsContract

        return KinematicsContract
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
