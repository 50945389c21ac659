"""Cameras as sensors: pictures of one or two eyes, with the noise of their sensor."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import LimitError
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary
from virtualrobot_kernel.sensing.lenses import Lens, lens_of, size_of
from virtualrobot_kernel.sensing.picture import Picture
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.sensing.render_context import RenderContext
from virtualrobot_kernel.sensing.water import FARTHEST, stretches, through_water
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.sensing import CameraSensor, ImageKind
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node

MOST_BYTES = 240_000_000
"""The most bytes of one reading's pictures: clients take messages of up to 256 MiB."""
BYTES_PER_PIXEL = {ImageKind.COLOR: 3, ImageKind.DEPTH: 4, ImageKind.SEGMENTATION: 4, ImageKind.NORMALS: 12}
DEADLINE_SECONDS = 60.0
"""Longest time of a picture: the first one of large meshes makes their smooth normals and decodes their textures."""


@dataclass(frozen=True, slots=True, eq=False)
class CameraContent:
    """Pictures of a camera.

    Attributes:
        lens: how its rays meet its pictures.
        kinds: the kinds of pictures, in the order of the contract.
        pictures: of its one eye, or of the left and the right one.
        element_names: the nodes that segmentation tells of, by place.
        baseline: between the eyes along x, in meters; 0 where there is one.
    """

    lens: Lens
    kinds: tuple[ImageKind, ...]
    pictures: tuple[Picture, ...]
    element_names: tuple[str, ...]
    baseline: float


class CameraReader:
    """Makes the readings of one camera; owns its scene of rays."""

    history_seconds = 0.0
    deadline_seconds = DEADLINE_SECONDS
    takes_turns = True

    def __init__(self, node: Node, shapes: ShapeLibrary, looks: AppearanceLibrary) -> None:
        """Prepare the rays; raise KernelError where Embree can't be had, LimitError for pictures that are too large."""
        assert isinstance(node.data, CameraSensor)
        self._uid, self._settings = node.uid, node.data
        self._check(self._kinds(None))
        self._lens = lens_of(node.data)
        self._stretches = stretches(self._lens) if node.data.water_attenuation_per_meter else None
        self._eye = RenderContext(shapes, looks, frozenset({node.uid}))

    def read(self, moment: Moment, kinds: object | None = None) -> CameraContent:
        """Return pictures of the kinds asked for, or of those that the camera is set to."""
        wanted = self._kinds(cast("Collection[ImageKind] | None", kinds))
        self._check(wanted)
        snapshot, settings = moment.snapshot, self._settings
        pictures = []
        # Each eye and kind has noise of its own, the same whatever else is asked for.
        draws = iter(moment.rng.spawn(4))
        for side in (0.0, settings.stereo_baseline_meters)[: self._eyes]:
            pose = snapshot.world_t(self._uid).copy()
            pose[:3, 3] += side * pose[:3, 0]
            picture = self._seen(snapshot, pose, wanted)
            pictures.append(_noisy(picture, settings, next(draws), next(draws)))
        nodes = snapshot.structure.nodes
        return CameraContent(
            lens=self._lens,
            kinds=wanted,
            pictures=tuple(pictures),
            element_names=tuple(nodes[uid].name for uid in self._eye.uids),
            baseline=settings.stereo_baseline_meters,
        )

    def _seen(self, snapshot: Snapshot, pose: NDArray[np.float64], wanted: tuple[ImageKind, ...]) -> Picture:
        """Return the picture of one eye, its colours through water where the camera is in some."""
        taken, color = self._settings.water_attenuation_per_meter, self._settings.water_color
        if self._stretches is None or taken is None or ImageKind.COLOR not in wanted:
            return self._eye.see(snapshot, self._lens, pose, wanted)
        picture = self._eye.see(snapshot, self._lens, pose, tuple({*wanted, ImageKind.DEPTH}))
        assert picture.color is not None and picture.depth is not None
        # A pixel that looks nowhere has no distance, and stays black.
        distance = np.minimum(picture.depth, np.float32(FARTHEST)) * self._stretches
        depth = picture.depth if ImageKind.DEPTH in wanted else None
        return replace(picture, color=through_water(picture.color, distance, taken, color), depth=depth)

    def close(self) -> None:
        """Free the scene."""
        self._eye.close()

    @property
    def _eyes(self) -> int:
        return 2 if self._settings.stereo_baseline_meters else 1

    def _kinds(self, asked: Collection[ImageKind] | None) -> tuple[ImageKind, ...]:
        return tuple(kind for kind in ImageKind if kind in (asked or self._settings.images or (ImageKind.COLOR,)))

    def _check(self, kinds: tuple[ImageKind, ...]) -> None:
        """Raise LimitError for pictures that no message can carry."""
        width, height = size_of(self._settings)
        size = width * height * self._eyes * sum(BYTES_PER_PIXEL[kind] for kind in kinds)
        if size > MOST_BYTES:
            raise LimitError(
                f"pictures of {width} x {height} pixels, {self._eyes} eye{'s' * (self._eyes > 1)}, kinds "
                f"{', '.join(kind.name for kind in kinds)} take {size:,} bytes; at most {MOST_BYTES:,} go into one "
                "reading: ask for fewer pixels or kinds",
                bytes=size,
                limit=MOST_BYTES,
            )


def _noisy(
    picture: Picture, settings: CameraSensor, color_rng: np.random.Generator, depth_rng: np.random.Generator
) -> Picture:
    """Return the picture with the sensor's noise: Gaussian, of depth growing with its square."""
    color, depth = picture.color, picture.depth
    if color is not None and settings.color_noise:
        noise: NDArray[np.float32] = color_rng.standard_normal(color.shape, np.float32)
        noise *= np.float32(255.0 * settings.color_noise)
        noise += color
        color = np.clip(np.rint(noise, out=noise), 0.0, 255.0, out=noise).astype(np.uint8)
    if depth is not None and settings.depth_noise_meters:
        noise = depth_rng.standard_normal(depth.shape, np.float32)
        noise *= np.float32(settings.depth_noise_meters)
        # Where there is nothing, nothing is measured.
        noise *= np.where(np.isfinite(depth), depth, np.float32(0.0)) ** 2
        depth = np.maximum(depth + noise, np.float32(0.0))
    return replace(picture, color=color, depth=depth)
