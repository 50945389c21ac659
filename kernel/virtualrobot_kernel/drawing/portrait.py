"""Small picture of a world that nobody else sees, such as that of a model of the catalogue."""

from __future__ import annotations

from collections.abc import Callable

from virtualrobot_kernel.drawing.framing import Framing
from virtualrobot_kernel.drawing.renderer import Renderer, Sight
from virtualrobot_kernel.drawing.shots import ImageFormat, Shot, packed
from virtualrobot_kernel.drawing.view import ViewSettings
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.shapes.submesh import Meshes
from virtualrobot_kernel.world.state import Snapshot

WIDTH, HEIGHT = 208, 156
"""In pixels: twice as large as pages show it, for fine screens."""

BACKGROUND = (0.90, 0.92, 0.94)

SMALLEST = 0.02
"""Half of the least edge of the box that is framed, in meters: grippers fill the picture, too."""


def portrait(snapshot: Snapshot, meshes: Meshes, check: Callable[[], None]) -> bytes:
    """Return a picture of all that is in a world, a PNG file of WIDTH x HEIGHT pixels.

    Args:
        snapshot: the world.
        meshes: gives the triangles of a mesh.
        check: raises when nobody waits for it any more.

    Raises:
        KernelError: no pictures can be taken.
    """
    painter = Renderer(ShapeLibrary(meshes), AppearanceLibrary(meshes), meshes, lambda snapshot, wanted: {})
    painter.check = check
    sight = Sight(snapshot, ViewSettings(background=BACKGROUND, grid_hidden=True), {})
    try:
        picture = painter.paint(sight, Shot(width=WIDTH, height=HEIGHT, plain=True), Framing(SMALLEST))
        return packed(picture, ImageFormat.PNG, check)
    finally:
        painter.close()
