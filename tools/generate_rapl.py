"""Write the table of RAPL-II's commands from the code: `python tools/generate_rapl.py [file]`."""

from __future__ import annotations

import sys
from pathlib import Path

from virtualrobot_apps.languages.rapl import builtin
from virtualrobot_apps.languages.rapl.expressions import FUNCTIONS
from virtualrobot_apps.languages.rapl.table import COMMANDS, REFUSED, Command

PAGE = Path(__file__).resolve().parent.parent / "docs" / "rapl-commands.md"

HEAD = """<!-- Written by tools/generate_rapl.py from the code; run it again instead of changing this page. -->
# RAPL-II: what works

Each command that works here, with its arguments as [RAPL-II](rapl.md) takes them. Words in capitals are typed as they
stand, `|` is between those of which one is typed, brackets hold what may be left out, and dots follow what may be
repeated, with commas between.
"""


def row(one: Command) -> str:
    """Return the row of a command."""
    call = f"{one.name} {one.form}".strip().replace("|", "\\|")
    return f"| `{call}` | {one.text} |"


def page() -> str:
    """Return the page."""
    builtin.load()
    lines = [HEAD.rstrip()]
    for room in builtin.ROOMS:
        rows = sorted((one for one in COMMANDS.values() if one.room == room), key=lambda one: one.name)
        lines += ["", f"## {room.capitalize()}", "", "| | does |", "|---|---|", *map(row, rows)]
    functions = ", ".join(f"`{name}`" for name in FUNCTIONS)
    lines += ["", "## Functions", "", f"In expressions, with angles in radians: {functions}."]
    lines += ["", "## Refused by name", "", "| | because |", "|---|---|"]
    lines += [f"| {', '.join(f'`{name}`' for name in names)} | {reason} |" for reason, names in REFUSED.items()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    (Path(sys.argv[1]) if len(sys.argv) > 1 else PAGE).write_text(page(), "utf-8")
