"""Rays against Embree alone, PyBullet and MuJoCo: a spinning scan of 28,800 rays among 200 objects and a moving arm.

Each scan poses the arm's eight links anew and casts, on one core. Ours is the component `embree` as the kernel calls
it: arguments checked, and element, triangle and unit normal in the world told for each ray. A reading is all that the
thread of a range sensor does: cast, look at what the component answered, ask the model `laser`, and say of each beam
distance, strength and element. Embree alone leaves its hits in packets that nobody reads.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.sensing.range_reader import RangeReader
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.sensing import RangeSensor, Spinning
from virtualrobot_kernel.world.structure import Kind
from virtualrobot_plugins.ray_casters.embree import EmbreeCaster
from virtualrobot_sdk.rays import RayScene

from benchmarks.bare_embree import BareEmbree
from benchmarks.ray_cell import MAX_RANGE, SENSOR, RayCell, ray_cell, spinning
from benchmarks.ray_peers import Bullet, Mujoco
from benchmarks.ray_world import ray_world, snapshots
from benchmarks.rows import Row, row

ROUNDS, SLOW_ROUNDS, WARM = 40, 5, 3
BUDGET = 1.25
"""At least 0.8 times as many rays as Embree alone."""
Scan = Callable[[int], object]
"""Poses the arm as in the round that is given, and scans."""


def run() -> list[Row]:
    """Measure."""
    cell, directions = ray_cell(), spinning()
    bare, bullet, mujoco, caster = BareEmbree(cell, directions), Bullet(cell), Mujoco(cell), EmbreeCaster()
    origins = np.broadcast_to(SENSOR, directions.shape)

    def embree(number: int) -> None:
        bare.move(cell.moved(0.1 * number), cell.first_link)
        bare.cast(SENSOR, MAX_RANGE)

    def component(number: int) -> np.ndarray:
        scene = RayScene(cell.shapes, cell.moved(0.1 * number))
        return caster.cast(scene, origins, directions, MAX_RANGE).distance

    def pybullet(number: int) -> np.ndarray:
        bullet.move(cell.moved(0.1 * number), cell.first_link)
        return bullet.cast(SENSOR, directions, MAX_RANGE)

    def multi_ray(number: int) -> np.ndarray:
        mujoco.move(cell.moved(0.1 * number), cell.first_link)
        return mujoco.cast(SENSOR, directions, MAX_RANGE)

    ours, theirs = in_turn(component, embree, ROUNDS)
    rows = [
        row(
            f"28,800 rays, {cell.triangles:,} triangles in 208 elements",
            *(1e3 * ours, 1e3 * theirs, "Embree alone", "ms", BUDGET),
            f"{len(directions) / ours / 1e6:.1f} million rays a second",
        )
    ]
    reading, again = in_turn(laser_readings(cell), embree, ROUNDS)
    rows.append(row("a reading of these by the model laser", 1e3 * reading, 1e3 * again, "Embree alone", "ms", BUDGET))
    for name, peer in (("PyBullet", pybullet), ("MuJoCo", multi_ray)):
        same = np.isclose(component(0), peer(0), rtol=0.0, atol=1e-3)  # those that both miss are the same
        mine, others = in_turn(component, peer, SLOW_ROUNDS)
        note = f"{same.mean():.2%} of its distances within 1 mm of ours"
        rows.append(row("28,800 rays", 1e3 * mine, 1e3 * others, name, "ms", 1.0, note))
    bullet.close()
    return rows


def laser_readings(cell: RayCell) -> Scan:
    """Return what makes readings of a spinning head with the kernel's own reader."""
    elevations = tuple(np.radians(np.linspace(-15.0, 15.0, 16)).tolist())
    settings = RangeSensor(pattern=Spinning(1800, elevations), max_range_meters=MAX_RANGE, sensor_model="laser")
    place = np.eye(4)
    place[:3, 3] = SENSOR
    world = ray_world(cell, settings, Kind.RANGE_SENSOR, place)
    worlds = snapshots(world, cell, ROUNDS + WARM)
    node = world.snapshot.structure.node("sensor")
    reader = RangeReader(node, Catalog(), ShapeLibrary(world.meshes), {})
    return lambda number: reader.read(Moment(worlds[number], (), number + 1, np.random.default_rng(number)))


def in_turn(ours: Scan, peer: Scan, rounds: int) -> tuple[float, float]:
    """Return the median time of both in seconds, measured in turn so that the machine's moods meet both."""
    times = np.empty((rounds + WARM, 2))
    for number in range(rounds + WARM):
        for column, scan in enumerate((ours, peer)):
            start = time.perf_counter()
            scan(number)
            times[number, column] = time.perf_counter() - start
    ours_median, peer_median = np.median(times[WARM:], axis=0)
    return float(ours_median), float(peer_median)
