"""`make bench`: measures everything against its named peer in the same run, prints the tables, writes RESULTS.md.

`python -m benchmarks.run tick rpc` measures only those and writes nothing, with `--write` theirs alone.
"""

from __future__ import annotations

import os
import platform
import re
import sys
import traceback
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

from benchmarks.rows import Row

RESULTS = Path(__file__).resolve().parent / "RESULTS.md"
SUITES = (
    *("rpc", "tick", "setpoints", "kinematics", "closed_form", "arm_angle", "dynamics", "planning", "paths"),
    "tool_paths",
    *("components", "loading", "rays", "scans", "cameras", "collision"),
    *(
        "collision_batch",
        "collision_motions",
        "collision_monitor",
        "collision_guard",
        "physics",
        "viewer",
        "startup",
        "shell",
    ),
    *(
        "memory",
        "soak",
        "faults",
        "recordings",
        "history",
        "journal",
        "replay",
        "cell_io",
        "ros",
        "ros_loads",
        "ros_dds",
    ),
    *("driver_ticks", "drivers", "driver_ur", "console", "pages", "room", "rapid", "code_page", "web_services"),
    *("studies", "navigation", "seeing", "bins", "effects"),
)
PACKAGES = (
    *("numpy", "numba", "grpcio", "protobuf", "viser", "ruckig", "toppra", "pin", "pytracik"),
    *("mcap", "foxglove-sdk", "embreex", "python-fcl", "ompl", "coal", "pybullet", "mujoco-core", "vtk", "ur_rtde"),
)
HEADER = ("what", "ours", "peer", "peer's name", "unit", "ratio", "budget", "")


def cells(row: Row) -> tuple[str, ...]:
    """Return a row as text."""
    if row["ours"] is None or row["peer"] is None:
        return (row["name"], "", "", row["peer_name"], "", "", "", "")
    ratio, budget = row["ratio"], row["budget"]
    verdict = "" if budget is None or ratio is None else "kept" if ratio <= budget else "MISSED"
    return (
        row["name"] + (f" ({note})" if (note := row.get("note")) else ""),
        f"{row['ours']:.4g}",
        f"{row['peer']:.4g}",
        row["peer_name"],
        row["unit"],
        "" if ratio is None else f"{ratio:.3g}",
        "" if budget is None else f"{budget:.3g}",
        verdict,
    )


def table(rows: Sequence[Row]) -> str:
    """Return the rows as a Markdown table, its columns aligned."""
    lines = [HEADER, *map(cells, rows)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(HEADER))]
    text = [
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) + " |" for line in lines
    ]
    return "\n".join([text[0], "|" + "|".join("-" * (width + 2) for width in widths) + "|", *text[1:]])


def machine() -> str:
    """Return what was measured on."""
    packages = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    system = f"{os.cpu_count()} cores, {platform.machine()}, {platform.system()}"
    return f"{system}, Python {platform.python_version()}, {packages}"


def kept_parts() -> dict[str, str]:
    """Return the parts of RESULTS.md by suite, as they are."""
    text = RESULTS.read_text() if RESULTS.exists() else ""
    _, *parts = re.split(r"^## (\w+)\n", text, flags=re.MULTILINE)
    return dict(zip(parts[::2], parts[1::2], strict=True))


def write(measured: Mapping[str, str]) -> None:
    """Replace the parts of RESULTS.md that were measured; the others keep their date."""
    parts = {**kept_parts(), **{name: f"\n{datetime.now(UTC).date()}\n\n{text}" for name, text in measured.items()}}
    introduction = (
        f"# Benchmarks\n\nMeasured by `make bench`: {machine()}.\n\n"
        "Each ratio is ours over the peer's in the same run; smaller is better. Absolute times belong to the machine. "
        "Each part says when it was measured.\n\n"
    )
    # What was last in the file ends with one line break, what had something after it with two.
    texts = [f"## {name}\n{parts[name].rstrip()}\n" for name in SUITES if name in parts]
    RESULTS.write_text(introduction + "\n".join(texts))
    print(f"written to {RESULTS.name}")


def main(arguments: Sequence[str]) -> int:
    """Measure the named suites, or all.

    Returns:
        1 when a budget is missed or a suite failed, after all others; 2 for a name that no suite has.
    """
    suites = [argument for argument in arguments if argument != "--write"]
    if unknown := [name for name in suites if name not in SUITES]:
        print(f"there is no benchmark {', '.join(unknown)}; there are {', '.join(SUITES)}", file=sys.stderr)
        return 2
    measured: dict[str, str] = {}
    missed = 0
    for name in suites or SUITES:
        print(f"measuring {name} ...", flush=True)
        try:
            rows = import_module(f"benchmarks.{name}").run()
        except Exception:
            traceback.print_exc()
            missed += 1
            continue
        missed += sum(line[-1] == "MISSED" for line in map(cells, rows))
        measured[name] = table(rows)
        print(measured[name], flush=True)
    if measured and (not suites or "--write" in arguments):
        write(measured)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
