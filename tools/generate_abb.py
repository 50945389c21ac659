"""Write the table of the emulated ABB controller's resources from the code: `python tools/generate_abb.py [file]`."""

from __future__ import annotations

import sys
from pathlib import Path

from virtualrobot_apps.emulators.abb.refused import RETURN_CODES
from virtualrobot_apps.emulators.abb.resources import ROOMS
from virtualrobot_apps.emulators.abb.subscriptions import SECOND, SUBSCRIBABLE
from virtualrobot_apps.emulators.abb.table import RESOURCES, Form, Resource

PAGE = Path(__file__).resolve().parent.parent / "docs" / "abb-resources.md"

HEAD = """<!-- Written by tools/generate_abb.py from the code; run it again instead of changing this page. -->
# Robot Web Services: what works

Each resource that the [emulated ABB controller](abb.md) has, by method, and path in versions 1.0 and 2.0. What is in
braces is a name; `{path*}` takes slashes, too.
"""


def row(one: Resource) -> str:
    """Return the row of a resource."""
    same = one.first is not None and one.second is not None and _told(one.first) == _told(one.second)
    return f"| {one.method} | {_told(one.first)} | {'the same' if same else _told(one.second)} | {one.text} |"


def _told(form: Form | None) -> str:
    if form is None:
        return "not there"
    return f"`{form.template}{f'?action={form.action}' if form.action else ''}`"


def page() -> str:
    """Return the page."""
    lines = [HEAD.rstrip()]
    for room in ROOMS:
        title = (room.__doc__ or "").rstrip(".")
        rows = [row(one) for one in RESOURCES if one.run.__module__ == room.__name__]
        lines += ["", f"## {title}", "", "| method | 1.0 | 2.0 | does |", "|---|---|---|---|", *rows]
    watched = [
        f"| `{uri}` | {f'`{SECOND[uri]}`' if uri in SECOND else 'the same'} | {(make.__doc__ or '').rstrip('.')} |"
        for uri, make in SUBSCRIBABLE.items()
    ]
    lines += [
        "",
        "## Subscriptions",
        "",
        "`POST /subscription` with what a client wants to be told of; `PUT` and `DELETE`",
    ]
    lines += ["`/subscription/{number}` add to it and end it, and so does closing its WebSocket `/poll/{number}`.", ""]
    lines += ["| 1.0 | 2.0 | tells |", "|---|---|---|", *watched]
    codes = [f"| {code} | `{name}` |" for name, code in RETURN_CODES.items()]
    lines += ["", "## Return codes", "", "| code | name |", "|---|---|", *codes]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    (Path(sys.argv[1]) if len(sys.argv) > 1 else PAGE).write_text(page(), "utf-8")
