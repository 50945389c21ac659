"""A viewer with a real browser before it, for all tests of this folder."""

from __future__ import annotations

import io
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Page
from virtualrobot_kernel.collision.clearances import measured
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.pool import ScenePool
from virtualrobot_kernel.collision.report import Touch
from virtualrobot_kernel.drawing.twin_ghosts import twin_ghosts
from virtualrobot_kernel.drawing.view import Camera, ViewSettings, ViewStore
from virtualrobot_kernel.drawing.viewer import Viewer
from virtualrobot_kernel.sensing.coats import Coats
from virtualrobot_kernel.sensing.reading import Reading
from virtualrobot_kernel.world.commands import ClearWorld

from tests.drawing.cell import Cell
from tools.screenshot import find_chromium, opened, picture

WIDTH, HEIGHT = 480, 360

FRONT = Camera((0.0, -4.0, 0.0), (0.0, 0.0, 0.0), 0.9)
"""Looks along +y: x goes right and z up in the picture, and a meter at the target takes 93 pixels."""


class Stage:
    """A cell, its view settings, and the browser that shows it."""

    def __init__(self, cell: Cell, view: ViewStore, viewer: Viewer, page: Page) -> None:
        """Keep what belongs together."""
        self.cell, self.view, self.viewer, self.page = cell, view, viewer, page
        self.readings: dict[int, Reading] = {}
        self.touching: tuple[Touch, ...] = ()
        self.measured: dict[int, np.ndarray] = {}
        self.coats = Coats()

    def pixels(self) -> np.ndarray:
        """Return the picture as (HEIGHT, WIDTH, 3) 8-bit numbers."""
        return np.asarray(Image.open(io.BytesIO(picture(self.page))).convert("RGB"))

    def pixel(self, x: float, z: float) -> np.ndarray:
        """Return the colour at x, z in meters in the plane y = 0, seen by FRONT."""
        scale = 0.5 * HEIGHT / np.tan(0.5 * FRONT.field_of_view) / 4.0
        return self.pixels()[round(0.5 * HEIGHT - z * scale), round(0.5 * WIDTH + x * scale)].astype(int)

    def wait(self, seen: Callable[[], object]) -> None:
        """Return once `seen` is true; fail when it is still not after a long while."""
        deadline = time.monotonic() + 30.0
        while not seen():
            assert time.monotonic() < deadline, f"not seen; see {self.keep()}"
            self.page.wait_for_timeout(100)

    def keep(self) -> str:
        """Write the picture to a file and return its path."""
        with tempfile.NamedTemporaryFile(prefix="viewer-", suffix=".png", delete=False) as file:
            Image.fromarray(self.pixels()).save(file)
        return file.name


@contextmanager
def on_stage(view: ViewStore) -> Iterator[Stage]:
    """Give an empty cell with a viewer and a browser; skip where there is no browser."""
    if find_chromium() is None:
        pytest.skip("no Chromium: install the package chromium to test what the viewer shows")
    cell = Cell()
    shown: list[Stage] = []
    viewer = Viewer(
        lambda: cell.snapshot,
        view,
        cell.meshes,
        readings=lambda: dict(shown[0].readings) if shown else {},
        touching=lambda: shown[0].touching if shown else (),
        clearances=partial(measured, ScenePool(CollisionShapes(cell.meshes))),
        twins=lambda snapshot: twin_ghosts(snapshot, dict(shown[0].measured) if shown else {}),
        coats=lambda: shown[0].coats.get() if shown else {},
    )
    viewer.start()
    try:
        with opened(viewer.url, WIDTH, HEIGHT) as page:
            shown.append(Stage(cell, view, viewer, page))
            yield shown[0]
    finally:
        viewer.close()


@pytest.fixture(scope="module")
def open_stage() -> Iterator[Stage]:
    """Give one viewer and one browser for a module."""
    with on_stage(ViewStore()) as stage:
        yield stage


@pytest.fixture
def stage(open_stage: Stage) -> Stage:
    """Give an empty cell, seen by FRONT before a background of its own colour, without a grid."""
    open_stage.cell.do(ClearWorld())
    open_stage.readings.clear()
    open_stage.touching = ()
    open_stage.measured.clear()
    settings = ViewSettings()
    open_stage.view.update(
        background=(0.2, 0.4, 0.6),
        grid_hidden=True,
        collisions_hidden=False,
        joint_axes=settings.joint_axes,
        bounding_boxes=settings.bounding_boxes,
        sensors=settings.sensors,
        measurements=settings.measurements,
        clearances=settings.clearances,
        ghosts=settings.ghosts,
        camera=Camera(FRONT.position, FRONT.target, FRONT.field_of_view),
    )
    open_stage.wait(lambda: (np.abs(open_stage.pixels().astype(int) - (51, 102, 153)).max(axis=2) <= 2).all())
    return open_stage
