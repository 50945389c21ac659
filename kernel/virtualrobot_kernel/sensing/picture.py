"""Pictures by rays: what a lens sees of elements at their places, by the thread that owns their scene."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.embree import TopScene, Traced
from virtualrobot_sdk.srgb import to_linear

from virtualrobot_kernel.numeric.illumination import toward
from virtualrobot_kernel.numeric.projection import start_rays
from virtualrobot_kernel.numeric.shading import measure, shade
from virtualrobot_kernel.sensing.appearance import Appearances
from virtualrobot_kernel.sensing.lenses import Lens
from virtualrobot_kernel.sensing.lights import Lights
from virtualrobot_kernel.sensing.textures import TO_LIGHT, TO_SCREEN
from virtualrobot_kernel.world.sensing import ImageKind

Color = tuple[float, float, float]

BACKGROUND: Color = (0.90, 0.92, 0.94)
"""Colour of what is seen where nothing is, as sRGB: the viewer shows the same."""
BAND = 32768
"""So many rays are traced and shaded at a time: measured, their arrays stay in the processor's cache, and are not had
anew from the system for each picture. Smaller ones ask for the interpreter more often than they gain."""
LAYERS = 24
"""So many surfaces one behind the other are seen at most, where those in front are translucent."""


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """Elements (e) as they are seen.

    Attributes:
        world_t_element: (e, 4, 4) where they are, as the scene has them.
        places: (e,) what segmentation says of each.
        looks: what they look like.
        lights: what lights them.
        background: what is behind, sRGB.
    """

    world_t_element: NDArray[np.float64]
    places: NDArray[np.int32]
    looks: Appearances
    lights: Lights
    background: Color = BACKGROUND


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """Images of h x w pixels; None is what was not asked for.

    Attributes:
        color: (h, w, 3) sRGB.
        depth: (h, w) meters along z, for a fisheye and a spherical lens along the ray; inf where there is nothing.
        segmentation: (h, w) the place of the element that is seen; -1 where there is nothing.
        normals: (h, w, 3) unit normals of the surfaces in the camera's frame, turned to it; 0 where there is nothing.
    """

    color: NDArray[np.uint8] | None
    depth: NDArray[np.float32] | None
    segmentation: NDArray[np.int32] | None
    normals: NDArray[np.float32] | None


def render(
    scene: TopScene,
    subject: Subject,
    lens: Lens,
    world_t_camera: NDArray[np.float64],
    kinds: Collection[ImageKind],
    check: Callable[[], None] = lambda: None,
) -> Picture:
    """Return what a lens at `world_t_camera` (4, 4: z forward, x right, y down) sees of a scene.

    Depth, segmentation and normals are of the first surface, be it translucent or not. Compiled code does all that is
    long, without the GIL.

    Args:
        scene: has the elements of `subject` at their places; the caller's thread owns it.
        subject: what is seen.
        lens: whose rays are cast.
        world_t_camera: where it is.
        kinds: which pictures to take.
        check: called before each band; what it raises ends the picture.
    """
    pose = np.ascontiguousarray(world_t_camera, np.float64)
    count = len(lens.directions)
    sizes = {kind: count if kind in kinds else 0 for kind in ImageKind}
    color = np.empty((sizes[ImageKind.COLOR], 3), np.uint8)
    depth = np.empty(sizes[ImageKind.DEPTH], np.float32)
    segmentation = np.empty(sizes[ImageKind.SEGMENTATION], np.int32)
    normals = np.empty((sizes[ImageKind.NORMALS], 3), np.float32)
    paint = _Paint(scene, subject, lens, color)
    for first in range(0, count, BAND):
        check()
        band = slice(first, first + BAND)
        directions, pixels, slants = lens.directions[band], lens.pixels[band], lens.slants[band]
        origins, along = np.empty_like(directions), np.empty_like(directions)
        start_rays(pose, directions, lens.near, lens.depth_is_z, origins, along)
        traced = scene.cast(origins, along, lens.reach)
        if len(depth) or len(segmentation) or len(normals):
            measure(
                *(pose, directions, pixels, lens.near, lens.far, lens.depth_is_z),
                *(traced.distance, traced.element, traced.normal, subject.places, depth, segmentation, normals),
            )
        if len(color):
            paint(_Rays(origins, along, pixels, slants), traced)
    size = lens.height, lens.width
    return Picture(
        color=color.reshape(*size, 3) if len(color) else None,
        depth=depth.reshape(size) if len(depth) else None,
        segmentation=segmentation.reshape(size) if len(segmentation) else None,
        normals=normals.reshape(*size, 3) if len(normals) else None,
    )


class _Rays(NamedTuple):
    """Origins and directions of n rays, in the world; their pixels and slants as the lens has them."""

    origins: NDArray[np.float32]
    along: NDArray[np.float32]
    pixels: NDArray[np.int32]
    slants: NDArray[np.float32]


class _Paint:
    """Writes the colours of rays to a picture (h * w, 3), band by band."""

    def __init__(self, scene: TopScene, subject: Subject, lens: Lens, picture: NDArray[np.uint8]) -> None:
        """Prepare what is the same for all bands."""
        looks = subject.looks
        self._scene, self._lens, self._lights, self._picture = scene, lens, subject.lights, picture
        self._looks = (subject.world_t_element, looks.colors, looks.starts, *looks.surfaces.tables)
        self._background = to_linear(subject.background).astype(np.float32)
        count = min(BAND, len(picture))
        self._onward, self._passed = np.empty(count, np.int32), np.empty((count, 5), np.float32)

    def __call__(self, rays: _Rays, traced: Traced) -> None:
        """Paint layer after layer, for those rays that go on behind translucent surfaces."""
        carried, lens = np.empty((0, 5), np.float32), self._lens
        for layer in range(LAYERS):
            going = shade(
                *(rays.origins, rays.along, rays.pixels, carried, rays.slants, lens.near, lens.far, lens.pixel_angle),
                *(traced.distance, traced.element, traced.triangle, traced.uv, traced.normal, *self._looks),
                *(self._lights.table, self._shadowed(rays, traced), self._background, TO_LIGHT, TO_SCREEN),
                *(layer == LAYERS - 1, self._picture, self._onward, self._passed),
            )
            if not going:
                return
            rows, carried = self._onward[:going], self._passed[:going].copy()
            # Behind the surface, by more than single precision can mistake.
            step = traced.distance[rows] + 1e-5 * (1.0 + traced.distance[rows])
            along = rays.along[rows]
            origins = np.asarray(rays.origins[rows] + along * step[:, None], np.float32)
            rays = _Rays(origins, along, rays.pixels[rows], rays.slants[rows])
            traced = self._scene.cast(origins, along, lens.reach)

    def _shadowed(self, rays: _Rays, traced: Traced) -> NDArray[np.bool_]:
        """Return (k, n) where something is between light and surface."""
        lights, count = self._lights, len(rays.along)
        shadowed = np.zeros((len(lights.table), count), np.bool_)
        for light in np.flatnonzero(lights.shadowing).tolist():
            starts, towards = np.empty((count, 3), np.float32), np.empty((count, 3), np.float32)
            until = np.empty(count, np.float32)
            toward(
                *(lights.table, light, rays.origins, rays.along, traced.distance, traced.element, traced.normal),
                *(starts, towards, until),
            )
            shadowed[light] = self._scene.occluded(starts, towards, until)
        return shadowed
