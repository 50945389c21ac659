"""Programs in RAPL-II for tests: what is wrong in them, and what they show."""

from __future__ import annotations

import textwrap

import pytest
from virtualrobot_apps.languages.core.diagnostics import ProgramError
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapl.program import Loaded, load
from virtualrobot_apps.languages.rapl.task import RaplTask

LOCATIONS = """
; x, y, z in mm, then yaw, pitch and roll in degrees
POINT A 300, 0, 175, 0, 90, 0
POINT B 200, 150, 250, 0, 90, 0
POINT #C 6857, 14606, -22776, -2184, 762
"""


def source(text: str, name: str) -> Source:
    """Return a text as a source of this name."""
    return Source(textwrap.dedent(text).strip("\n") + "\n", name)


def loaded(text: str, locations: str = LOCATIONS, **more: str) -> Loaded:
    """Return the program of a text, called MAIN, with others by name."""
    others = [source(other, f"{name}.rpl") for name, other in more.items()]
    return load([source(text, "main.rpl"), *others], source(locations, "main.loc"))


def shown(text: str, locations: str = LOCATIONS, **more: str) -> list[str]:
    """Return the lines that a program without a robot shows."""
    lines: list[str] = []
    RaplTask(loaded(text, locations, **more), write=lines.append).run()
    return lines


def faults(text: str, locations: str = LOCATIONS, **more: str) -> list[str]:
    """Return the faults of a program as `line:column: message`."""
    with pytest.raises(ProgramError) as caught:
        loaded(text, locations, **more)
    return [str(one).removeprefix("main.rpl:") for one in caught.value.diagnostics]
