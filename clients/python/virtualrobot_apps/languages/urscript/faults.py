"""Faults of a running script, which end it."""

from __future__ import annotations


class ScriptFault(Exception):
    """What a script can't do; its message says what, and why."""


class ScriptHalted(Exception):
    """The script has said `halt`: it is over, with all its threads."""
