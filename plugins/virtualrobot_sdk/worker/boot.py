"""Command line by which a process of ours begins in a module of the SDK, and finds what its parent finds."""

from __future__ import annotations

import sys


def command(module: str, *arguments: str) -> list[str]:
    """Return the command that calls `main` of a module, which has `arguments` in `sys.argv` from place 1 on.

    The parent's places come first, then those that the process finds itself: of what was installed after the parent's
    start.
    """
    boot = (
        "import sys; given = sys.argv.pop().split('\\n');"
        "sys.path[:] = [*given, *(place for place in sys.path[1:] if place not in given)];"
        f"from {module} import main; main()"
    )
    return [sys.executable, "-c", boot, *arguments, "\n".join(map(str, sys.path))]
