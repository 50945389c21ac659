"""Commands of RAPL-II, by subject; importing a module enters its rows in the table."""

from __future__ import annotations

from importlib import import_module

ROOMS = ("flow", "motion", "locations", "signals", "text")
"""Modules with commands, in the order of the documentation."""


def load() -> None:
    """Enter all rows."""
    for room in ROOMS:
        import_module(f"virtualrobot_apps.languages.rapl.builtin.{room}")
