"""Schema of what the journal keeps: every version of every class that was ever written, in `history/schema.json`.

    python tools/freeze_classes.py

adds classes and versions that are new. What is there never changes, since folders have it: a test compares.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from virtualrobot_kernel.history.classes import MIGRATIONS, world_codec

FILE = Path(__file__).resolve().parent.parent / "kernel/virtualrobot_kernel/history/schema.json"

Frozen = dict[str, dict[str, list[str]]]
"""Fields of each class, or members of an enum, by tag and version."""


def frozen() -> Frozen:
    """Return what the file says."""
    return json.loads(FILE.read_text()) if FILE.exists() else {}


def faults(
    known: Frozen, now: Mapping[str, tuple[int, list[str]]], migrations: Mapping[tuple[str, int], object]
) -> list[str]:
    """Return what is wrong with the classes as they are now, a sentence each that says what would be right."""
    found = []
    for tag, versions in known.items():
        if tag not in now:
            found.append(f"{tag!r} is gone, and journals have it: keep the name in TAGS, or a class that reads it")
            continue
        version, fields = now[tag]
        before = versions.get(str(version))
        if before is None:
            continue
        is_enum = not any(": " in one for one in (*before, *fields))
        if is_enum and not set(before) <= set(fields):
            gone = ", ".join(sorted(set(before) - set(fields)))
            found.append(f"{tag!r} has lost {gone}, and journals have it: members of an enum are only added")
        if not is_enum and before != fields:
            found.append(
                f"{tag!r} has other fields than its version {version} had: give it version {version + 1} in VERSIONS "
                f"and, in MIGRATIONS, what makes these of version {version}"
            )
    for tag, (version, _) in now.items():
        found += [
            f"nothing in MIGRATIONS makes version {one + 1} of {tag!r} of version {one}"
            for one in range(1, version)
            if (tag, one) not in migrations
        ]
    return found


def main() -> None:
    """Write what is new into the file; end with what is wrong."""
    known, now = frozen(), world_codec().schema()
    if found := faults(known, now, MIGRATIONS):
        raise SystemExit("\n".join(found))
    for tag, (version, fields) in now.items():
        known.setdefault(tag, {})[str(version)] = fields
    FILE.write_text(json.dumps(known, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    main()
