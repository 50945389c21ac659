"""Pictures by rays: what a lens sees of elements at their places, by the thread that owns their scene."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.embree import TopScene, Traced
from virtualrobot_sdk.srgb import from_linear, to_linear

from virtualrobot_kernel.drawing.view import ViewSettings
from virtualrobot_kernel.numeric.illumination import toward
from virtualrobot_kernel.numeric.projection import start_rays
from virtualrobot_kernel.numeric.shading import STEPS, measure, shade
from virtualrobot_kernel.sensing.lenses import Lens
from virtualrobot_kernel.sensing.lights import Lights
from virtualrobot_kernel.sensing.looks import Looks
from virtualrobot_kernel.world.sensing import ImageKind

Color = tuple[float, float, float]

BACKGROUND: Color = ViewSettings().background
"""What is seen where nothing is, as sRGB: what the viewer shows."""
LAYERS = 6
"""So many surfaces one behind the other are seen at most, where those in front are translucent."""

_TO_LIGHT = to_linear(np.arange(256) / 255.0).astype(np.float32)
_TO_SCREEN = np.round(255.0 * from_linear(np.arange(STEPS) / (STEPS - 1.0))).astype(np.uint8)


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """What is seen of e elements.

    Attributes:
        world_t_element: (e, 4, 4) where they are, as the scene has them.
        places: (e,) what segmentation says of each.
        looks: what they look like.
        lights: what lights them.
        background: what is behind, sRGB.
    """

    world_t_element: NDArray[np.float64]
    places: NDArray[np.int32]
    looks: Looks
    lights: Lights
    background: Color = BACKGROUND


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """What was asked for of a picture of h x w pixels; None is what was not.

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
    """
    pose = np.ascontiguousarray(world_t_camera, np.float64)
    count = len(lens.directions)
    origins, along = np.empty((count, 3), np.float32), np.empty((count, 3), np.float32)
    start_rays(pose, lens.directions, lens.near, lens.depth_is_z, origins, along)
    traced = scene.cast(origins, along, lens.reach)
    wanted = {kind: count if kind in kinds else 0 for kind in ImageKind}
    depth = np.empty(wanted[ImageKind.DEPTH], np.float32)
    segmentation = np.empty(wanted[ImageKind.SEGMENTATION], np.int32)
    normals = np.empty((wanted[ImageKind.NORMALS], 3), np.float32)
    if len(depth) or len(segmentation) or len(normals):
        measure(
            *(pose, lens.directions, lens.pixels, lens.near, lens.far, lens.depth_is_z),
            *(traced.distance, traced.element, traced.normal, subject.places, depth, segmentation, normals),
        )
    size = lens.height, lens.width
    return Picture(
        color=_color(scene, subject, lens, origins, along, traced) if wanted[ImageKind.COLOR] else None,
        depth=depth.reshape(size) if len(depth) else None,
        segmentation=segmentation.reshape(size) if len(segmentation) else None,
        normals=normals.reshape(*size, 3) if len(normals) else None,
    )


def _color(
    scene: TopScene,
    subject: Subject,
    lens: Lens,
    origins: NDArray[np.float32],
    along: NDArray[np.float32],
    traced: Traced,
) -> NDArray[np.uint8]:
    """Return the colours (h, w, 3): layer after layer, for the rays that go on behind translucent surfaces."""
    count = len(along)
    picture = np.empty((count, 3), np.uint8)
    pixels, slants, carried = lens.pixels, lens.slants, np.empty((0, 5), np.float32)
    background = to_linear(subject.background).astype(np.float32)
    looks, lights = subject.looks, subject.lights
    for layer in range(LAYERS):
        onward, passed = np.empty(len(along), np.int32), np.empty((len(along), 5), np.float32)
        going = shade(
            *(origins, along, pixels, carried, slants, lens.near, lens.far, lens.pixel_angle),
            *(traced.distance, traced.element, traced.triangle, traced.uv, traced.normal),
            *(subject.world_t_element, looks.colors, looks.starts, *looks.surfaces.tables),
            *(lights.table, _shadowed(scene, lights, origins, along, traced), background, _TO_LIGHT, _TO_SCREEN),
            *(layer == LAYERS - 1, picture, onward, passed),
        )
        if not going:
            break
        rows, carried = onward[:going], passed[:going]
        # Behind the surface, by more than single precision can mistake.
        step = traced.distance[rows] + 1e-5 * (1.0 + traced.distance[rows])
        along, pixels, slants = along[rows], pixels[rows], slants[rows]
        origins = np.asarray(origins[rows] + along * step[:, None], np.float32)
        traced = scene.cast(origins, along, lens.reach)
    return picture.reshape(lens.height, lens.width, 3)


def _shadowed(
    scene: TopScene, lights: Lights, origins: NDArray[np.float32], along: NDArray[np.float32], traced: Traced
) -> NDArray[np.bool_]:
    """Return (k, n) where something is between light and surface."""
    count = len(along)
    shadowed = np.zeros((len(lights.table), count), np.bool_)
    starts, towards, until = (
        np.empty((count, 3), np.float32),
        np.empty((count, 3), np.float32),
        np.empty(count, np.float32),
    )
    for light in np.flatnonzero(lights.shadowing).tolist():
        toward(
            *(lights.table, light, origins, along, traced.distance, traced.element, traced.normal),
            *(starts, towards, until),
        )
        shadowed[light] = scene.occluded(starts, towards, until)
    return shadowed
