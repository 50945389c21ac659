"""Write the table of RAPID's instructions and functions from the code: `python tools/generate_rapid.py [file]`."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

from virtualrobot_apps.languages.rapid import builtin
from virtualrobot_apps.languages.rapid.predefined import ERRORS, NUMBERS, OTHER_ERRORS, SPEEDS, ZONES
from virtualrobot_apps.languages.rapid.table import BUILTINS, Builtin, lacking_names
from virtualrobot_apps.languages.rapid.types import ALIASES, ATOMIC, RECORDS, SIGNALS

PAGE = Path(__file__).resolve().parent.parent / "docs" / "rapid-instructions.md"

HEAD = """<!-- Written by tools/generate_rapid.py from the code; run it again instead of changing this page. -->
# RAPID: what works

Each instruction and function that works here, as [RAPID](rapid.md) declares it: an optional argument has a backslash,
`|` stands between those of which one may be given. "Not yet" are arguments that a controller takes and the check
refuses by name.
"""


def row(one: Builtin) -> str:
    """Return the row of an instruction or function."""
    result = f"{one.result} " if one.result else ""
    signature = one.signature.replace("|", "\\|")
    call = f"`{result}{one.name}({signature})`" if one.result else f"`{' '.join([one.name, signature]).strip()}`"
    lacking = " ".join(f"`\\{name}`" for name in sorted(one.lacking))
    return f"| {call} | {one.text} | {lacking} |"


def page() -> str:
    """Return the page."""
    builtin.load()
    lines = [HEAD.rstrip()]
    for room in builtin.ROOMS:
        rows = sorted((one for one in BUILTINS.values() if one.room == room), key=lambda one: one.name.lower())
        title = room.upper() if room == "egm" else room.capitalize()
        lines += ["", f"## {title}", "", "| | does | not yet |", "|---|---|---|", *map(row, rows)]
    records = [
        f"| `{name}` | {', '.join(f'`{kind} {part}`' for kind, part in parts)} |" for name, parts in RECORDS.items()
    ]
    lines += ["", "## Types", "", f"Atomic: {_listed(ATOMIC)}. Signals: {_listed(SIGNALS)}."]
    lines += [f"Other names: {', '.join(f'`{name}` is a `{of}`' for name, of in sorted(ALIASES.items()))}."]
    lines += ["", "| record | components |", "|---|---|", *records]
    lines += ["", "## Data that are there", ""]
    lines += [f"- Speeds: {_listed(f'v{one}' for one in SPEEDS)} and `vmax`, in mm/s; all turn at 500 degrees/s."]
    lines += [
        f"- Zones: `fine` and {_listed(f'z{one}' for one in ZONES)}; the number is the radius in mm, of `z0` 0.3 mm."
    ]
    lines += ["- `tool0`, `wobj0`, `load0`, `pi`, `WAIT_MAX`, `high`, `low`, `reg1` to `reg5`, `clock1`, `ERRNO`."]
    lines += ["- `EOF`, `EOF_NUM`, `EOF_BIN`, `stEmpty`, `STR_DIGIT`, `STR_UPPER`, `STR_LOWER`, `STR_WHITE`."]
    lines += [f"- Numbers: {_listed(NUMBERS)}."]
    lines += [f"- Errors: {_listed(ERRORS)}; `LONG_JMP_ALL_ERR` stands for all of them."]
    lines += [f"- Errors that never come here, for which handlers may look: {_listed(OTHER_ERRORS)}."]
    lines += ["", "## Refused by name", "", "The check tells of each that it can't be used here yet:", ""]
    lines += [f"{_listed(lacking_names().values())}."]
    return "\n".join(lines) + "\n"


def _listed(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


if __name__ == "__main__":
    (Path(sys.argv[1]) if len(sys.argv) > 1 else PAGE).write_text(page(), "utf-8")
