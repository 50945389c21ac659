"""Instructions and functions that come with RAPID, by subject; importing a module enters its rows in the table."""

from __future__ import annotations

from importlib import import_module

ROOMS = (
    *(
        "motion",
        "paths",
        "egm",
        "frames",
        "signals",
        "interrupts",
        "zones",
        "sockets",
        "files",
        "rawbytes",
        "pendant",
        "program",
        "tasks",
        "system",
        "arithmetic",
    ),
    *("bits", "strings"),
)
"""Modules with instructions and functions, in the order of the documentation."""


def load() -> None:
    """Enter all rows."""
    for room in ROOMS:
        import_module(f"virtualrobot_apps.languages.rapid.builtin.{room}")
