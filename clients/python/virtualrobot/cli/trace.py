"""`virtualrobot trace`: the ways that nodes go, kept in the world as lines."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

import click
import numpy as np

from virtualrobot.cli.names import NODE
from virtualrobot.cli.options import FiniteRange, Target, target_options

if TYPE_CHECKING:
    from virtualrobot.connection import Client

APART_METERS = 0.002
"""Least distance of two points of a trace; the console's page has the same."""
MOST_POINTS = 6000
"""Points that are kept of a trace: the last ones."""
_LOOKED_SECONDS = 0.2

_EXAMPLES = """
\b
Examples:
  virtualrobot trace arm --seconds 5
  virtualrobot trace box gripper --color orange
  virtualrobot remove "trace of arm"
"""


@click.command(epilog=_EXAMPLES)
@click.argument("nodes", type=NODE, nargs=-1, required=True)
@click.option("--seconds", type=FiniteRange(min=0.0, min_open=True), help="Of simulation time [until Ctrl-C].")
@click.option("--color", default="#38bdf8", help="A name such as red, or #rrggbb.")
@target_options
def trace(target: Target, nodes: tuple[str, ...], seconds: float | None, color: str) -> None:
    """Draw the ways that NODES go from now on, of a robot that of its tool centre point, and keep them as lines.

    Each is a node named 'trace of NODE', which everybody sees and scene files have; 'remove' takes it away.
    """
    from virtualrobot.scene.figures import lines

    with target.connect() as client:
        ways = _taken(client, nodes, seconds)
        taken = {node.name for node in client.scene.nodes()}
        for node, points in ways.items():
            if len(points) < 2:
                click.echo(f"{node} has not moved")
                continue
            name = _free(f"trace of {node}", taken)
            client.scene.add_annotation(name, lines(np.array(points), color=color))
            meters = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
            click.echo(f"{name}: {meters:.3f} m")


def _taken(client: Client, nodes: tuple[str, ...], seconds: float | None) -> dict[str, list[tuple[float, ...]]]:
    """Return where nodes were in the world (m), one point after the other; Ctrl-C ends it, too."""
    robots = set(client.robots)
    streams = {f"/robots/{one}/tcp" if one in robots else f"/nodes/{one}/pose": one for one in nodes}
    ways: dict[str, list[tuple[float, ...]]] = {one: [] for one in nodes}
    begin: float | None = None
    with client.streams.watch("/clock", *streams) as watch, suppress(KeyboardInterrupt):
        while True:
            sample = watch.next(_LOOKED_SECONDS)
            if sample is None:
                continue
            begin = sample.time if begin is None else begin
            if seconds is not None and sample.time - begin > seconds + 1e-9:
                break
            if sample.stream in streams:
                way = ways[streams[sample.stream]]
                point = tuple(float(sample.values[axis]) for axis in "xyz")
                if not way or np.linalg.norm(np.subtract(point, way[-1])) >= APART_METERS:
                    way.append(point)
                    del way[:-MOST_POINTS]
    return ways


def _free(name: str, taken: set[str]) -> str:
    """Return the name, with a number behind it while it is taken, and take it."""
    number, free = 2, name
    while free in taken:
        free, number = f"{name} {number}", number + 1
    taken.add(free)
    return free
