"""Views, changes and grasps: what a decision costs, what views cover, what a comparison finds, and grasps a second.

Rays are met by formula; nothing of a kernel is measured. Times are those of a core.
"""

from __future__ import annotations

import time

import numpy as np
import trimesh
from virtualrobot_apps.seeing.changes.comparing import compare
from virtualrobot_apps.seeing.grasping.antipodal import grasps
from virtualrobot_apps.seeing.grasping.jaw import Jaw
from virtualrobot_apps.seeing.grasping.surface import surface_of_mesh
from virtualrobot_apps.seeing.views.planning import ViewPlanner, views_around
from virtualrobot_apps.seeing.views.voxels import Voxels

from benchmarks.rows import Row, row
from tests.apps.seeing.bodies import BODIES, EDGE, HIGH, LOW, MIDDLE, REACH, covered, look
from tests.apps.seeing.bodies import RAYS as LOOKS
from tests.apps.seeing.box_scanner import Box, rays
from tests.apps.seeing.test_changes import POSE, RAYS, ROOM, again, scanned

SCANS, CUBES = 100, 20
"""Scans of a room in which nothing has changed, and such with a cube more."""
FINE = rays(np.radians(120.0), np.radians(50.0), np.radians(0.2))
"""Rays for cubes up to 6 m away."""
HALF = 0.04
"""Half the edge of a cube (m)."""
DECISION_SECONDS, GRASPS_PER_SECOND = 0.2, 500
"""Budgets."""


def run() -> list[Row]:
    """Measure."""
    rng = np.random.default_rng(1)
    return [*views(rng), *changes(rng), grasping(rng)]


def views(rng: np.random.Generator) -> list[Row]:
    """Return what a decision costs and what eight views leave uncovered."""
    found = {name: covered(boxes, rng) for name, boxes in BODIES.items()}
    worst = max(found, key=lambda name: 1.0 - found[name].chosen)
    name, note = f"left uncovered by 8 views, {worst}", f"the worst of {len(found)}"
    ours, drawn = (np.mean([1.0 - getattr(one, of) for one in found.values()]) for of in ("chosen", "drawn"))
    planner = ViewPlanner(Voxels(LOW, HIGH, EDGE), views_around(MIDDLE, np.array([0.7, 0.9]), 30), LOOKS, REACH)
    times = []
    for view in found[worst].views:
        start = time.process_time()
        planner.next()
        times.append(time.process_time() - start)
        look(planner, view, BODIES[worst])
    return [
        row("next view, median", 1e3 * float(np.median(times)), 1e3 * DECISION_SECONDS, "200 ms", "ms of a core", 1.0),
        row(name, 1.0 - found[worst].chosen, 0.1, "0.1", "of 1", 1.0, note),
        row("left uncovered by 8 views, mean", float(ours), float(drawn), "drawn views", "of 1", None),
    ]


def changes(rng: np.random.Generator) -> list[Row]:
    """Return false alarms in SCANS scans, cubes of 80 mm that are missed, and what a comparison costs."""
    before, alarms, times = scanned(ROOM, POSE, rng), 0, []
    for _ in range(SCANS):
        after = scanned(ROOM, again(rng), rng)
        start = time.process_time()
        alarms += bool(compare(before, after).changes)
        times.append(time.process_time() - start)
    fine, missed, off = scanned(ROOM, POSE, rng, FINE), 0, []
    for _ in range(CUBES):
        place = np.array([*rng.uniform((2.7, 1.1), (6.0, 3.1)), HALF])
        cube: Box = (tuple((place - HALF).tolist()), tuple((place + HALF).tolist()))  # pyright: ignore[reportAssignmentType]
        found = compare(fine, scanned([*ROOM, cube], again(rng), rng, FINE)).changes
        near = [float(np.linalg.norm(one.place - place)) for one in found]
        missed += not near or min(near) > 2.0 * HALF
        off += near[:1]
    note = f"{len(RAYS):,} rays"
    return [
        row(f"false alarms in {SCANS} scans", alarms, 0.5, "none", "scans", 1.0, note),
        row(f"cubes of 80 mm missed of {CUBES} within 6 m", missed, 0.05 * CUBES, "5 %", "cubes", 1.0),
        row("their places are off, median", 1e3 * float(np.median(off)), 1e3 * HALF, "half a cube", "mm", 1.0),
        row("two scans compared, median", float(np.median(times)), 1.0, "1 s", "s of a core", None, note),
    ]


def grasping(rng: np.random.Generator) -> Row:
    """Return what a grasp of a block on a table costs, before inverse kinematics and collision."""
    block = trimesh.creation.box((0.05, 0.12, 0.12))
    table = np.column_stack([rng.uniform(-0.2, 0.2, (4000, 2)), np.full(4000, -0.06)])
    times = []
    for _ in range(10):
        start = time.process_time()
        found = grasps(surface_of_mesh(block.vertices, block.faces, 1500, rng), Jaw(0.08), rng, obstacles=table)
        times.append((time.process_time() - start) / len(found))
    return row("a grasp", 1e3 * float(np.median(times)), 1e3 / GRASPS_PER_SECOND, "500 a second", "ms of a core", 1.0)
