"""Pictures of snapshots as people see them, without a browser: rays for what is solid, strokes for the rest."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.embree import TopScene, unavailable

from virtualrobot_kernel.collision.clearances import Measure
from virtualrobot_kernel.drawing.additions import overlay_of, with_arrows, with_drawn
from virtualrobot_kernel.drawing.alarm import Touching, alarmed, red_looks, red_nodes, shown
from virtualrobot_kernel.drawing.extent import world_box
from virtualrobot_kernel.drawing.framing import Framing
from virtualrobot_kernel.drawing.library import ShapeLibrary as DrawnShapes
from virtualrobot_kernel.drawing.lighting import FLAT, VIEW
from virtualrobot_kernel.drawing.overlay import draw_over, write_words
from virtualrobot_kernel.drawing.palette import (
    CELL_COLOR,
    CELL_WIDTH,
    FADE_METERS,
    FADE_STRENGTH,
    SECTION_COLOR,
    SECTION_WIDTH,
)
from virtualrobot_kernel.drawing.shots import HEIGHT, WIDTH, Shot
from virtualrobot_kernel.drawing.smoothing import smoothed
from virtualrobot_kernel.drawing.view import Ghost, ViewSettings
from virtualrobot_kernel.drawing.viewpoint import Viewpoint, look_at
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.numeric.strokes import BIAS, draw_floor
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary, Appearances
from virtualrobot_kernel.sensing.coats import Shown, with_coats
from virtualrobot_kernel.sensing.elements import Elements, elements_of
from virtualrobot_kernel.sensing.lenses import Lens, lens_of, pinhole, size_of
from virtualrobot_kernel.sensing.lights import NONE, Lights, lights_of
from virtualrobot_kernel.sensing.picture import BACKGROUND, Color, Subject, render
from virtualrobot_kernel.sensing.reading import Reading
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.shapes.submesh import Meshes
from virtualrobot_kernel.world.sensing import CameraSensor, ImageKind, Intrinsics
from virtualrobot_kernel.world.state import Snapshot

LARGEST_KEPT = 1 << 21
"""A lens takes 20 bytes a pixel; one of more pixels than a film usually has is not kept for the next picture."""

Pose = NDArray[np.float64]
Pixels = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """Subject of a picture: the world, how it is seen, each sensor's latest reading by uid, what touches."""

    snapshot: Snapshot
    settings: ViewSettings
    readings: Mapping[int, Reading]
    touching: Touching = ()


@dataclass(frozen=True, slots=True, eq=False)
class Picked:
    """Hit of a ray through a pixel.

    Attributes:
        uid: the node.
        point: (3,) where, meters in the world's frame.
        normal: (3,) unit normal of the surface in the world's frame, towards the eye.
        distance: from the eye, in meters.
        color: of the surface without light, sRGB from 0 to 1.
    """

    uid: int
    point: NDArray[np.float64]
    normal: NDArray[np.float64]
    distance: float
    color: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """Cache of what is made of a world's elements and of coats, until they change; `sensed` are those of the world."""

    key: tuple[int, bool, tuple[int, ...], tuple[Ghost, ...]]
    sensed: Elements
    coats: Shown
    elements: Elements
    looks: Appearances


class Renderer:
    """Takes pictures; owned by one thread, which alone may call it, and which closes it."""

    def __init__(self, shapes: ShapeLibrary, looks: AppearanceLibrary, meshes: Meshes, clearances: Measure) -> None:
        """See figures by `shapes` and their looks by `looks`; raise KernelError without Embree.

        `looks` knows the meshes of `with_arrows`; `meshes` gives the triangles of all others. `clearances` measures
        least distances.
        """
        reason = unavailable()
        if reason:
            raise KernelError(f"no pictures can be taken: {reason}", reason=Reason.WRONG_STATE, cause=reason)
        self._shapes, self._looks, self._clearances = shapes, looks, clearances
        self._arrows, self._drawn = ShapeLibrary(with_arrows(meshes)), DrawnShapes(meshes)
        self.check: Callable[[], None] = lambda: None
        """Asked again and again while a picture is taken; raises when nobody waits for it any more."""
        self._scene = TopScene()
        self._last: _Seen | None = None
        self._lens: tuple[object, Lens] | None = None

    def close(self) -> None:
        """Free what rays are cast in."""
        self._scene.close()

    def paint(self, sight: Sight, shot: Shot, framing: Framing) -> Pixels:
        """Return a picture (h, w, 3), sRGB.

        A camera of the scene sees what it sees at work, with what is drawn for people over it; elsewhere there is the
        grid on the floor, light and background are the view's, and what touches and may not is red.
        """
        snapshot, settings = sight.snapshot, sight.settings
        touching = () if shot.plain else shown(settings, sight.touching)
        seen = self._look(snapshot, settings, shot)
        viewpoint = self._viewpoint(snapshot, settings, shot, framing, seen)
        lights, background = lights_of(snapshot), BACKGROUND
        if not shot.sensor:
            background = alarmed(settings.background) if touching else settings.background
            lights = VIEW if lights is NONE else lights
            if touching:
                seen = replace(seen, looks=red_looks(seen.looks, seen.elements.uids, red_nodes(touching)))
        world_t_element = np.ascontiguousarray(seen.elements.world_t_element(snapshot.world_t_node))
        self._scene.place(seen.elements.shapes, world_t_element)
        subject = self._subject(seen, world_t_element, lights, background)
        lens, pose = viewpoint.lens, viewpoint.world_t_camera
        picture, depth = self._taken(subject, lens, pose)
        if not shot.sensor:
            picture = smoothed(picture, lens, lambda fine: self._color(subject, fine, pose))
        elif shot.plain:
            return picture
        canvas = picture.astype(np.float32)
        if not shot.sensor and not settings.grid_hidden:
            _floor(canvas, depth, lens, pose)
        if shot.plain:
            return _rounded(canvas)
        # A camera does not look through its own pyramid.
        others = tuple(one for one in settings.sensors if one.uid != shot.sensor)
        wanted = settings.clearances
        clearances = self._clearances(snapshot, wanted) if wanted else {}
        overlay = overlay_of(
            snapshot, replace(settings, sensors=others), seen.sensed, sight.readings, touching, clearances
        )
        draw_over(canvas, depth, viewpoint, overlay)
        picture = _rounded(canvas)
        write_words(picture, viewpoint, overlay.words)
        return picture

    def pick(self, snapshot: Snapshot, settings: ViewSettings, shot: Shot, column: float, row: float) -> Picked | None:
        """Return what is under a pixel of a shot, whose middle is (column, row), or None where there is nothing."""
        shot = replace(shot, plain=True)
        seen = self._look(snapshot, settings, shot)
        viewpoint = self._viewpoint(snapshot, settings, shot, Framing(), seen)
        along = viewpoint.ray(column, row)
        if not np.isfinite(along).all():
            return None
        lens, pose = viewpoint.lens, viewpoint.world_t_camera
        world_t_element = np.ascontiguousarray(seen.elements.world_t_element(snapshot.world_t_node))
        self._scene.place(seen.elements.shapes, world_t_element)
        slant = along[2] if lens.depth_is_z else 1.0
        start = lens.near / slant
        direction = pose[:3, :3] @ along
        origin = pose[:3, 3] + start * direction
        traced = self._scene.cast(origin[None], direction[None], (lens.far - lens.near) / slant)
        if traced.element[0] < 0:
            return None
        far = float(traced.distance[0])
        normal = traced.normal[0].astype(np.float64)
        subject = self._subject(seen, world_t_element, FLAT, (0.0, 0.0, 0.0))
        red, green, blue = (self._color(subject, lens.narrowed(along[None]), pose)[0, 0] / 255.0).tolist()
        return Picked(
            uid=int(seen.elements.uids[traced.element[0]]),
            point=origin + far * direction,
            normal=normal if normal @ direction <= 0.0 else -normal,
            distance=start + far,
            color=(red, green, blue),
        )

    def _look(self, snapshot: Snapshot, settings: ViewSettings, shot: Shot) -> _Seen:
        """Return what there is to see; it is made anew only where it has changed since the last picture."""
        axes, ghosts = ((), ()) if shot.plain else (settings.joint_axes, settings.ghosts)
        key = shot.sensor, shot.plain, axes, ghosts
        before = self._last if self._last is not None and self._last.key == key else None
        unseen = frozenset((shot.sensor,) if shot.sensor else ())
        sensed = elements_of(snapshot, self._shapes, before.sensed if before else None, unseen)
        coats = self._looks.coats.get()
        if before is not None and before.sensed is sensed and before.coats is coats:
            return before
        coated = with_coats(sensed, snapshot, coats, unseen)
        shown = coated if shot.plain else with_drawn(coated, snapshot, settings, self._arrows, self._drawn)
        self._last = _Seen(key, sensed, coats, shown, self._looks.of(shown))
        self._arrows.keep({figure.geometry for figure in shown.figures})
        return self._last

    def _viewpoint(
        self, snapshot: Snapshot, settings: ViewSettings, shot: Shot, framing: Framing, seen: _Seen
    ) -> Viewpoint:
        if shot.sensor:
            sensor = _sized(_sensor(snapshot, shot.sensor), shot.width, shot.height)
            return Viewpoint(self._kept(sensor, lambda: lens_of(sensor)), snapshot.world_t(shot.sensor))
        width, height = shot.width or WIDTH, shot.height or HEIGHT
        asked = shot.camera or settings.camera
        camera = asked.placed(snapshot) if asked else None
        if camera is None:
            camera = framing.camera(world_box(seen.sensed, snapshot.world_t_node), width / height)
        field = camera.field_of_view
        lens = self._kept((width, height, field), lambda: pinhole(width, height, field))
        return Viewpoint(lens, look_at(camera.position, camera.target))

    def _kept(self, key: object, made: Callable[[], Lens]) -> Lens:
        """Return the lens of `key`: the last one where it is that one's."""
        if self._lens is None or self._lens[0] != key:
            self._lens = None  # the old one need not be in memory beside the new one
            lens = made()
            if len(lens.directions) > LARGEST_KEPT:
                return lens
            self._lens = key, lens
        return self._lens[1]

    def _subject(self, seen: _Seen, world_t_element: Pose, lights: Lights, background: Color) -> Subject:
        return Subject(world_t_element, seen.elements.node_of, seen.looks, lights, background)

    def _color(self, subject: Subject, lens: Lens, pose: Pose) -> Pixels:
        color = render(self._scene, subject, lens, pose, (ImageKind.COLOR,), self.check).color
        assert color is not None  # it was asked for
        return color

    def _taken(self, subject: Subject, lens: Lens, pose: Pose) -> tuple[Pixels, NDArray[np.float32]]:
        """Return colours (h, w, 3) and depth (h, w) in meters."""
        taken = render(self._scene, subject, lens, pose, (ImageKind.COLOR, ImageKind.DEPTH), self.check)
        assert taken.color is not None and taken.depth is not None  # they were asked for
        return taken.color, taken.depth


def _sensor(snapshot: Snapshot, uid: int) -> CameraSensor:
    node = snapshot.structure.nodes.get(uid)
    if node is None or not isinstance(node.data, CameraSensor):
        raise KernelError(
            "the camera of this picture has been removed; look from another one", reason=Reason.UNKNOWN_NAME, uid=uid
        )
    return node.data


def _sized(sensor: CameraSensor, width: int, height: int) -> CameraSensor:
    """Return a camera with a picture of another size that sees the same from left to right; 0 means its own size."""
    if not width and not height:
        return sensor
    own = size_of(sensor)
    size = width or own[0], height or own[1]
    eye = sensor.intrinsics
    if eye is not None:
        across, down = size[0] / own[0], size[1] / own[1]
        eye = Intrinsics(across * eye.fx, down * eye.fy, across * (eye.cx + 0.5) - 0.5, down * (eye.cy + 0.5) - 0.5)
    return replace(sensor, width=size[0], height=size[1], intrinsics=eye)


def _floor(canvas: NDArray[np.float32], depth: NDArray[np.float32], lens: Lens, pose: Pose) -> None:
    assert lens.intrinsics is not None  # the view's lens is a pinhole
    eye = lens.intrinsics
    draw_floor(
        *(canvas, depth, np.array([eye.fx, eye.fy, eye.cx, eye.cy]), pose),
        *(np.array([CELL_COLOR, SECTION_COLOR], np.float64), np.array([CELL_WIDTH, SECTION_WIDTH])),
        *(FADE_METERS, FADE_STRENGTH, BIAS),
    )


def _rounded(canvas: NDArray[np.float32]) -> Pixels:
    return np.rint(canvas).astype(np.uint8)
