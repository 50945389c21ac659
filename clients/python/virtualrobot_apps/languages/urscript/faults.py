"""Faults of a running script, which end it."""

from __future__ import annotations


class ScriptFault(Exception):
    """Fault that ends a script; its message says what can't be done, and why."""


class ScriptHalted(Exception):
    """The script has said `halt`: it is over, with all its threads."""
