"""Effects of processes: a film, chips, and what a kernel pays for a coat that changes ten times a second.

Peers are the budgets; a kernel's cost is its process's time by the wall clock's.
"""

from __future__ import annotations

import threading
import time
from contextlib import suppress

import numpy as np
import psutil
import trimesh
import virtualrobot
from virtualrobot import pose
from virtualrobot.errors import VirtualRobotError
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.view.coats import CoatHandle
from virtualrobot_apps.processes.effects.chips import Cutter, taken_off
from virtualrobot_apps.processes.effects.film import Jet, sprayed

from benchmarks.rows import Row, row

POSES, ROWS = 10_000, 20
STEPS, REPEATS = 1000, 9
SIDE = 224
"""Corners of a coat along an edge: 50,176 of them."""
SECONDS = 10.0
WARM_SECONDS = 5.0
"""A kernel that has just begun loads what it may need."""
HERTZ = 10.0


def run() -> list[Row]:
    """Measure."""
    return [_film(), _chips(), *_coats()]


def _film() -> Row:
    mesh = trimesh.creation.box((1.0, 1.0, 0.02)).subdivide_to_size(0.01, max_iter=20)
    assert isinstance(mesh, trimesh.Trimesh)
    ways = np.linspace(-0.5, 0.5, POSES // ROWS + 1)
    passes = [
        (np.array([pose(x, y, 0.26, roll=np.pi + 0.2) for x in ways]), np.linspace(0.0, 2.5, len(ways)))
        for y in np.linspace(-0.5, 0.5, ROWS)
    ]
    jet = Jet(0.2, 0.25, 2e-6)
    sprayed(mesh, passes[:1], jet)
    started = time.process_time()
    sprayed(mesh, passes, jet)
    name = f"a film with shadows: {len(mesh.faces)} triangles x {POSES} places of a gun"
    return row(name, time.process_time() - started, 2.5, "2.5 s", "s", 1.0)


def _chips() -> Row:
    share = np.linspace(0.0, 1.0, STEPS + 1)
    radius, angle = 0.08 * (0.3 + 0.7 * share), 6.0 * np.pi * share
    places = zip((radius * np.cos(angle)).tolist(), (radius * np.sin(angle)).tolist(), strict=True)
    frames = np.array([pose(x, y, 0.015, roll=np.pi) for x, y in places])
    block = trimesh.creation.box((0.2, 0.2, 0.05))
    taken_off(block, [frames[:2]], Cutter(0.01, 0.03))
    spent = []
    for _ in range(REPEATS):
        started = time.process_time()
        taken_off(block, [frames], Cutter(0.01, 0.03))
        spent.append(1e6 * (time.process_time() - started) / STEPS)
    name = f"chips, a step of {STEPS}, with the volume (median of {REPEATS})"
    return row(name, float(np.median(spent)), 100.0, "100 µs", "µs", 1.0)


def _coats() -> list[Row]:
    x, y = (grid.ravel() for grid in np.meshgrid(np.linspace(-0.5, 0.5, SIDE), np.linspace(-0.5, 0.5, SIDE)))
    corner = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
    halves = [corner, corner + 1, corner + SIDE + 1], [corner, corner + SIDE + 1, corner + SIDE]
    faces = np.concatenate([np.stack(half, axis=1) for half in halves])
    found = []
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        client.scene.add_part("plate", virtualrobot.box(1.0, 1.0, 0.02))
        coat = client.view.add_coat("film", "plate", np.stack([x, y, 0.0102 + 0.0 * x], 1), faces, low=0.0, high=1.0)
        process = psutil.Process(client.info.process_id)
        time.sleep(WARM_SECONDS)
        found.append(_spent("50,176 corners that change at 10 Hz", process, coat, x))
        threading.Thread(target=_watch, args=(client,), daemon=True).start()
        found.append(_spent("the same, watched", process, coat, x))
    return found


def _watch(client: virtualrobot.Client) -> None:
    with suppress(VirtualRobotError):
        for _ in client.view.watch_coats():
            pass


def _spent(name: str, process: psutil.Process, coat: CoatHandle, x: np.ndarray) -> Row:
    def times() -> float:
        now = process.cpu_times()
        return now.user + now.system

    before, begun, count = times(), time.monotonic(), 0
    while (now := time.monotonic() - begun) < SECONDS:
        coat.paint(0.5 + 0.5 * np.sin(20.0 * x + count))
        count += 1
        time.sleep(max(0.0, count / HERTZ - now))
    share = (times() - before) / (time.monotonic() - begun)
    return row(name, 100.0 * share, 5.0, "5% of a core", "%", 1.0, f"{count / SECONDS:.1f} changes a second")
