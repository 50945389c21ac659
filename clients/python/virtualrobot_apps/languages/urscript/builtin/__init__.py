"""Functions that come with URScript, by subject; importing a module enters its rows in the table."""

from __future__ import annotations

from importlib import import_module

ROOMS = "arithmetic poses strings flow motion kinematics forces registers outputs setup sockets".split()
"""Modules with functions, in the order of the documentation."""


def load() -> None:
    """Enter all rows."""
    for room in ROOMS:
        import_module(f"virtualrobot_apps.languages.urscript.builtin.{room}")
