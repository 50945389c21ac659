"""Write the table of URScript's functions from the code: `python tools/generate_urscript.py [file]`."""

from __future__ import annotations

import sys
from pathlib import Path

from virtualrobot_apps.languages.urscript import builtin
from virtualrobot_apps.languages.urscript.table import BUILTINS, Builtin, lacking_names

PAGE = Path(__file__).resolve().parent.parent / "docs" / "urscript-functions.md"

HEAD = """<!-- Written by tools/generate_urscript.py from the code; run it again instead of changing this page. -->
# URScript: what works

Each function of [URScript](urscript.md) that works here, with its parameters; one with a value may be left out. `none`
is no value. A function that waits gives its thread's turn away.
"""


def row(one: Builtin) -> str:
    """Return the row of a function."""
    return f"| `{one.name}({one.signature})` | {one.text} | {'yes' if one.waits else ''} |"


def page() -> str:
    """Return the page."""
    builtin.load()
    lines = [HEAD.rstrip()]
    for room in builtin.ROOMS:
        rows = sorted((one for one in BUILTINS.values() if one.room == room), key=lambda one: one.name)
        lines += ["", f"## {room.capitalize()}", "", "| | does | waits |", "|---|---|---|", *map(row, rows)]
    lines += ["", "## Refused by name", "", "A script may have them; where it calls one it ends, with words:", ""]
    lines += [f"{', '.join(f'`{name}`' for name in sorted(lacking_names()))}."]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    (Path(sys.argv[1]) if len(sys.argv) > 1 else PAGE).write_text(page(), "utf-8")
