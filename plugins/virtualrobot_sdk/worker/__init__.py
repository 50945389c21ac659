"""A process in which one plugin's components run, so that a hang or a crash of theirs costs nothing else.

`Worker` is what the kernel and the test kit use; `child` is what runs in the process. They talk through two pipes, in
frames of a length, a number and a pickle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from virtualrobot_sdk.worker.description import ComponentDescription, Description
    from virtualrobot_sdk.worker.parent import Worker, close_all

__all__ = ["ComponentDescription", "Description", "Worker", "close_all"]


def __getattr__(name: str) -> object:
    """Import the parent's side when it is asked for: the child, which imports this too, starts faster without it."""
    if name in ("Worker", "close_all"):
        from virtualrobot_sdk.worker import parent

        return getattr(parent, name)
    if name in __all__:
        from virtualrobot_sdk.worker import description

        return getattr(description, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
