"""Measuring: a probe touches points of a part; how far they are off the model, and how the part stands by that."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from virtualrobot import Client, Program, ToolPath
from virtualrobot.errors import UnreachableError

from virtualrobot_apps.cell_io.yaml_file import Item
from virtualrobot_apps.curves.way import Floats, Way
from virtualrobot_apps.processes.along import AlongWays
from virtualrobot_apps.processes.leading import FIELDS, Leading, Led, read_leading
from virtualrobot_apps.processes.switching import Switch, read_switch

SEARCH = 0.01
"""Distance (m) beyond a point of the model up to which a part is looked for, if the file doesn't say."""
TOLD = 1e-6
"""Least singular value, in parts of the greatest one, of a displacement that the points tell."""


@dataclass(frozen=True, slots=True, eq=False)
class Touched:
    """Points of the model (n, 3), the normals (n, 3) out of it, and by how much the part is beyond them (n,), in m."""

    points: list[Floats] = field(default_factory=list)
    normals: list[Floats] = field(default_factory=list)
    beyond: list[float] = field(default_factory=list)


@dataclass(frozen=True, slots=True, eq=False)
class Measure:
    """Measuring as a file describes it; lengths in m.

    Attributes:
        probe: how it is led; its tool centre point is the middle of its ball.
        node: what is touched.
        radius: of the ball.
        search: how far beyond a point of the model the part is looked for.
        switch: the signal that the probe gives where it touches.
        client: of the cell, where rays tell where the part is; None until it is planned.
        touched: what was found so far.
    """

    probe: Leading
    node: str
    radius: float
    search: float
    switch: Switch
    client: Client | None = None
    touched: Touched = field(default_factory=Touched)
    what: str = "point"

    def stretches(self, way: Way, name: str) -> Iterator[tuple[str, Way, Floats, float]]:
        """Yield the way on which the ball comes to where it touches; raises UnreachableError where it doesn't."""
        start, model, normal = way.points[0], way.points[-1], way.outward[0]
        beyond = self._found(start, model, normal)
        self.touched.points.append(model)
        self.touched.normals.append(normal)
        self.touched.beyond.append(beyond)
        ends = np.stack([start + self.radius * normal, model + (beyond + self.radius) * normal])
        yield self.probe.stretch(Way(ends, way.normals[[0, -1]]), name, "give a greater step")

    def along(self, program: Program, path: ToolPath, name: str) -> float:
        """Add the way to a point to a program, with the probe's signal there, and return how long that takes (s)."""
        program.call(path.program, name)
        self.switch.on(program)
        self.switch.stand(program, self.switch.end_seconds)
        self.switch.off(program)
        return path.duration + self.switch.start_seconds + self.switch.end_seconds

    def _found(self, start: Floats, model: Floats, normal: Floats) -> float:
        """Return by how much the part is beyond the model, along the normal, on a line from the start."""
        assert self.client is not None
        clear = float((start - model) @ normal)
        robot, reference = self.probe.robot, self.probe.sources[0].parts[0]
        hits = self.client.rays.cast(
            start, -normal[None], frame=reference, max_range=clear + self.search, ignored=robot
        )
        if not np.isfinite(hits.distances[0]):
            raise UnreachableError(
                f"nothing of {self.node!r} is between {1e3 * clear:.4g} mm before the point and "
                f"{1e3 * self.search:.4g} mm behind it: give a longer `clear` of the spots, or a longer `search`"
            )
        if hits.nodes[0] != self.node:
            raise UnreachableError(f"the probe would touch {hits.nodes[0]!r} there, before {self.node!r}")
        return clear - float(hits.distances[0])


def read_measure(item: Item) -> Measure:
    """Return what a file says; raises MalformedFileError, with file and line, for what it says wrong."""
    known = (*FIELDS, "points", "probe", "node", "radius", "search", "touch")
    fields = item.fields(known, ("robot", "points", "speed", "probe", "node", "radius"))
    probe = read_leading(fields, fields["points"], fields["probe"])
    if probe.heading is None:
        raise fields["probe"].error("a probe goes along itself: give the direction of its x, `heading: [1, 0, 0]`")
    for source, one in zip(probe.sources, fields["points"].items(), strict=True):
        given = one.mapping()
        if "spots" not in given:
            raise one.error("points to measure are spots: give `spots` with points and normal, or targets")
        if "depth" in given["spots"].mapping():
            raise given["spots"].error("a probe stops where it touches: leave `depth` out, and give `search` beside it")
        if source.parts[0] != probe.sources[0].parts[0]:
            raise given["part"].error(f"all points are of one model: {probe.sources[0].parts[0]!r} stands above")
    search = fields["search"].number(1e-5, 0.5) if "search" in fields else SEARCH
    radius = fields["radius"].number(1e-5, 0.1)
    return Measure(probe, fields["node"].text(), radius, search, read_switch(fields.get("touch")))


def _begun(client: Client, item: Item) -> Measure:
    said = read_measure(item)
    client.scene[said.node]
    return replace(said, client=client, touched=Touched())


def _told(_: Client, work: Measure, led: Led) -> tuple[str, ...]:
    found = work.touched
    return report(np.array(found.points), np.array(found.normals), np.array(found.beyond), work.node)


def report(points: Floats, normals: Floats, beyond: Floats, node: str) -> tuple[str, ...]:
    """Return lines about a part: how far its points are beyond the model, and where it stands by that."""
    shift, turn, told = fitted(points, normals, beyond)
    left = (
        beyond - normals @ shift - np.einsum("ni,ni->n", np.cross(np.broadcast_to(turn, points.shape), points), normals)
    )

    def millimetres(values: Floats) -> str:
        return ", ".join(f"{1e3 * value:.3f}" for value in np.atleast_1d(values).tolist())

    size = float(np.sqrt(np.mean(left**2)))
    return (
        f"{len(points)} points of {node} are {1e3 * beyond.min():.3f} to {1e3 * beyond.max():.3f} mm beyond the model, "
        f"{1e3 * beyond.mean():.3f} mm in the mean",
        f"it stands [{millimetres(shift)}] mm and [{', '.join(f'{np.degrees(one):.4f}' for one in turn.tolist())}] "
        f"degrees about x, y, z off the model, which leaves {1e3 * size:.3f} mm (root mean square); the points tell "
        f"{told} of 6 of these",
    )


def fitted(points: Floats, normals: Floats, beyond: Floats) -> tuple[Floats, Floats, int]:
    """Return by how much a part is shifted (3,) in m and turned (3,) in rad against its model, and how much is told.

    The least squares of what is left along the normals of points (n, 3), for displacements so small that turns add up;
    what the points don't tell is 0 or as small as can be. The last one is the number of displacements that they tell.
    """
    middle = points.mean(axis=0)
    size = max(float(np.linalg.norm(points - middle, axis=1).max()), 1e-9)
    # Turns are about the middle, and count as what they move the farthest point, so that both are lengths.
    matrix = np.concatenate([normals, np.cross((points - middle) / size, normals)], axis=1)
    left, values, right = np.linalg.svd(matrix, full_matrices=False)
    there = values > TOLD * values[0]
    found: Floats = right[there].T @ ((left[:, there].T @ beyond) / values[there])
    turn: Floats = found[3:] / size
    shift: Floats = found[:3] - np.asarray(np.cross(turn, middle), np.float64)
    return shift, turn, int(there.sum())


plan = AlongWays(_begun, lambda work: work.probe, _told)
"""The plan of measuring that a file describes."""
