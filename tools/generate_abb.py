"""Write the table of the emulated ABB controller's resources from the code: `python tools/generate_abb.py [file]`."""

from __future__ import annotations

import sys
from pathlib import Path

from virtualrobot_apps.emulators.abb.refused import RETURN_CODES
from virtualrobot_apps.emulators.abb.resources import ROOMS
from virtualrobot_apps.emulators.abb.subscriptions import SUBSCRIBABLE
from virtualrobot_apps.emulators.abb.table import RESOURCES, Resource

PAGE = Path(__file__).resolve().parent.parent / "docs" / "abb-resources.md"

HEAD = """<!-- Written by tools/generate_abb.py from the code; run it again instead of changing this page. -->
# Robot Web Services: what works

Each resource that the [emulated ABB controller](abb.md) has, by method, path and action (`?action=`). What is in braces
is a name; `{path*}` takes slashes, too.
"""


def row(one: Resource) -> str:
    """Return the row of a resource."""
    action = f"`{one.action}`" if one.action else ""
    return f"| {one.method} | `{one.template}` | {action} | {one.text} |"


def page() -> str:
    """Return the page."""
    lines = [HEAD.rstrip()]
    for room in ROOMS:
        title = (room.__doc__ or "").rstrip(".")
        rows = [row(one) for one in RESOURCES if one.run.__module__ == room.__name__]
        lines += ["", f"## {title}", "", "| method | path | action | does |", "|---|---|---|---|", *rows]
    watched = [f"| `{uri}` | {(make.__doc__ or '').rstrip('.')} |" for uri, make in SUBSCRIBABLE.items()]
    lines += [
        "",
        "## Subscriptions",
        "",
        "`POST /subscription` with what a client wants to be told of; `PUT` and `DELETE`",
    ]
    lines += ["`/subscription/{number}` add to it and end it, and so does closing its WebSocket `/poll/{number}`.", ""]
    lines += ["| resource | tells |", "|---|---|", *watched]
    codes = [f"| {code} | `{name}` |" for name, code in RETURN_CODES.items()]
    lines += ["", "## Return codes", "", "| code | name |", "|---|---|", *codes]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    (Path(sys.argv[1]) if len(sys.argv) > 1 else PAGE).write_text(page(), "utf-8")
