"""Surroundings of the scene: light, floor, background, and a page without controls."""

from __future__ import annotations

import numpy as np
import viser

from virtualrobot_kernel.drawing.alarm import alarmed
from virtualrobot_kernel.drawing.palette import (
    CELL_COLOR,
    CELL_WIDTH,
    FADE_METERS,
    FADE_STRENGTH,
    SECTION_COLOR,
    SECTION_WIDTH,
)
from virtualrobot_kernel.drawing.view import Color, ViewSettings

GRID = "/grid"


class Stage:
    """Owns light, grid and background of one viser server."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Light the scene of `server` and clear its page of what is not the scene."""
        self._server = server
        self._background: Color | None = None
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.set_panel_label("VirtualRobot")
        server.gui.main_panel.minimize()
        _light(server)
        self._grid = _grid(server)

    def show(self, settings: ViewSettings, alarm: bool) -> None:
        """Show grid and background as the settings say, the background rose for an `alarm`."""
        self._grid.visible = not settings.grid_hidden
        background = alarmed(settings.background) if alarm else settings.background
        if background != self._background:
            pixel = np.array([[[round(255 * part) for part in background]]], np.uint8)
            self._server.scene.set_background_image(pixel, format="png")
            self._background = background


def _light(server: viser.ViserServer) -> None:
    """A key light from the upper left, a cool fill from the right, and light from the sky, brighter than the floor's.

    No environment map and no shadow maps: they cost a browser without a graphics card seven eighths of its frames.
    """
    scene = server.scene
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map(None)
    scene.world_axes.visible = False
    scene.add_light_hemisphere("/light/sky", sky_color=(255, 255, 255), ground_color=(140, 136, 130), intensity=1.35)
    scene.add_light_directional("/light/key", color=(255, 250, 242), intensity=2.7, position=(1.5, -2.5, 5.0))
    scene.add_light_directional("/light/fill", color=(225, 235, 255), intensity=0.7, position=(4.0, 3.0, 1.5))


def _grid(server: viser.ViserServer) -> viser.GridHandle:
    return server.scene.add_grid(
        GRID,
        width=20.0,
        height=20.0,
        plane="xy",
        cell_size=0.25,
        cell_thickness=CELL_WIDTH,
        cell_color=CELL_COLOR,
        section_size=1.0,
        section_thickness=SECTION_WIDTH,
        section_color=SECTION_COLOR,
        infinite_grid=True,
        fade_distance=FADE_METERS,
        fade_strength=FADE_STRENGTH,
        fade_from="camera",
    )
