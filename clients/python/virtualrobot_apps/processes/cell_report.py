"""Report of a cell and a process in it, as one HTML page or as PDF: cycle, reach, clearances, devices, measures."""

from __future__ import annotations

import html
import json
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from virtualrobot import Client, MotionCheck, MotionPlan, Program
from virtualrobot.errors import WrongStateError

from virtualrobot_apps.page import html_table, page_head
from virtualrobot_apps.processes.process import PlannedProcess

BROWSERS = "chromium", "chromium-browser", "google-chrome", "google-chrome-stable"
"""Programs that print pages as PDF, in the order in which they are looked for."""
LOOKED_AT = 60
"""Number of places of a motion, evenly in time, at which clearances are measured."""
NEAR = 0.2
"""Distance (m) up to which clearances are told."""
PAIRS = 15
"""Number of pairs that are told at most, the nearest ones."""
SECONDS = 120.0
"""Time (s) after which a browser that prints is given up."""


def cell_report(client: Client, title: str, made: PlannedProcess, found: MotionCheck) -> str:
    """Return the page about a process that is planned in the cell as it is, and what its check has found."""
    plan = made.program.plan()
    return "\n".join([page_head(title), *_sections(client, made, found, plan), "</html>"])


def write_report(page: str, file: Path) -> None:
    """Write a page to a file: as PDF where its name ends so, else as HTML.

    Raises WrongStateError where no browser is there that prints it, and OSError where the file can't be written.
    """
    if file.suffix.lower() != ".pdf":
        file.write_text(page, "utf-8")
        return
    browser = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if browser is None:
        raise WrongStateError(
            f"a PDF is printed by a browser, one of {', '.join(BROWSERS)}: install one, or write .html"
        )
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "report.html"
        source.write_text(page, "utf-8")
        options = [
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-pdf-header-footer",
            f"--user-data-dir={folder}/own",
        ]
        printed = subprocess.run(
            [browser, *options, f"--print-to-pdf={file.resolve()}", source.as_uri()],
            capture_output=True,
            text=True,
            timeout=SECONDS,
            check=False,
        )
    if printed.returncode or not file.is_file():
        last = (printed.stderr.strip().splitlines() or ["it says nothing"])[-1]
        raise WrongStateError(f"{browser} could not print {file}: {last}")


def _sections(client: Client, made: PlannedProcess, found: MotionCheck, plan: MotionPlan) -> Iterator[str]:
    broken = found.first_violation
    verdict = "It keeps all limits and touches nothing." if broken is None else f"It can't be: {broken.message}"
    yield f"<p>{html.escape(verdict)}</p>"
    yield "<h2>Process</h2>"
    yield f"<ul>{''.join(f'<li>{html.escape(line)}</li>' for line in made.measures)}</ul>"
    yield f"<h2>Cycle: {plan.duration:.2f} s</h2>"
    yield html_table(("step", "", "s", "way of the tool, m"), list(_cycle(made.program, plan)))
    yield "<h2>Reach</h2>"
    yield html_table(
        ("joint", "least", "most", "of its limits", "left to the nearer one", "greatest speed, % of its limit"),
        list(_reach(client, plan)),
    )
    yield f"<h2>Clearances up to {1e3 * NEAR:g} mm</h2>"
    yield html_table(("between", "and", "mm", "at, s"), _clearances(client, plan))
    yield "<h2>Devices</h2>"
    yield html_table(("", "kind"), list(_devices(client)))


def _cycle(program: Program, plan: MotionPlan) -> Iterator[tuple[str, ...]]:
    steps = json.loads(program.text).get("steps", [])
    for number in np.unique(plan.steps).tolist():
        rows = np.flatnonzero(plan.steps == number)
        rows = np.arange(max(rows[0] - 1, 0), rows[-1] + 1)
        ways = [_length(robot.world_t_tcp[rows]) for robot in plan.robots.values()]
        said = _step_name(steps[number]) if number < len(steps) else ""
        yield str(number), said, f"{plan.times[rows[-1]] - plan.times[rows[0]]:.2f}", f"{max(ways, default=0.0):.3f}"


def _step_name(step: dict[str, object]) -> str:
    kind = next((name for name, value in step.items() if isinstance(value, dict)), next(iter(step), ""))
    given = step.get(kind)
    name = given.get("name", given.get("program", "")) if isinstance(given, dict) else ""
    return f"{kind} {name}".strip()


def _length(poses: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1).sum())


def _reach(client: Client, plan: MotionPlan) -> Iterator[tuple[str, ...]]:
    for name, robot in plan.robots.items():
        limits = client.robot(name).limits
        for column, joint in enumerate(robot.joint_names):
            one, values = limits[joint], robot.positions[:, column]
            least, most = float(values.min()), float(values.max())
            left = min(least - one.lower, one.upper - most)
            speed = 100.0 * float(np.abs(robot.velocities[:, column]).max()) / one.velocity
            span = f"{one.lower:.3f} to {one.upper:.3f}"
            yield f"{name} {joint}", f"{least:.3f}", f"{most:.3f}", span, f"{left:.3f}", f"{speed:.0f}"


def _clearances(client: Client, plan: MotionPlan) -> list[tuple[str, ...]]:
    nearest: dict[tuple[str, str], tuple[float, float]] = {}
    rows = np.unique(np.linspace(0, len(plan.times) - 1, LOOKED_AT).astype(int))
    for row in rows.tolist():
        there = {
            name: dict(zip(robot.joint_names, robot.positions[row].tolist(), strict=True))
            for name, robot in plan.robots.items()
        }
        for one in client.collisions.distances(*plan.robots, max_distance=NEAR, configurations=there):
            pair = one.first, one.second
            nearest[pair] = min(nearest.get(pair, (np.inf, 0.0)), (one.distance, float(plan.times[row])))
    told = sorted((distance, time, pair) for pair, (distance, time) in nearest.items())[:PAIRS]
    return [(*pair, f"{1e3 * distance:.1f}", f"{time:.2f}") for distance, time, pair in told]


def _devices(client: Client) -> Iterator[tuple[str, str]]:
    for node in client.scene.nodes():
        if node.kind not in ("world", "link", "frame", "target", "object"):
            yield node.name, node.kind
    for name, value in client.signals.items():
        yield name, f"signal, {value}"
