"""Settings of the view: what clients change and every open viewer shows."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.clearances import Clearance
from virtualrobot_kernel.drawing.under_way import UnderWay
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.sensing.measuring import Measurement
from virtualrobot_kernel.sensing.overlays import SensorOverlay
from virtualrobot_kernel.sensing.picture import BACKGROUND, Color
from virtualrobot_kernel.world.listeners import Listeners
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import GREATEST_FIELD, LEAST_DISTANCE, LEAST_FIELD, WORLD_UID

Vector = tuple[float, float, float]

DEFAULT_FIELD_OF_VIEW = 0.9
"""The vertical field of view in radians that is taken where none is given."""


@dataclass(frozen=True, slots=True)
class Camera:
    """Viewpoint of people: eye and target in meters in the frame of a node, vertical field of view in radians.

    `node` is the uid of what it goes along with. One that `keeps_direction` doesn't turn with it: eye and target are
    from the node's origin then, along the world's axes.
    """

    position: Vector = (0.0, 0.0, 0.0)
    target: Vector = (0.0, 0.0, 0.0)
    field_of_view: float = DEFAULT_FIELD_OF_VIEW
    node: int = WORLD_UID
    keeps_direction: bool = False

    def placed(self, snapshot: Snapshot) -> Camera | None:
        """Return the same in the world's frame, as it is in a snapshot; None where its node is gone."""
        if self.node == WORLD_UID:
            return self
        if self.node not in snapshot.structure.nodes:
            return None
        pose = snapshot.world_t(self.node)
        turn = np.eye(3) if self.keeps_direction else pose[:3, :3]
        position, target = (turn @ np.array([self.position, self.target]).T).T + pose[:3, 3]
        return Camera(_three(position), _three(target), self.field_of_view)


def _three(point: NDArray[np.float64]) -> Vector:
    x, y, z = point.tolist()
    return x, y, z


GHOST_COLOR: Color = (0.20, 0.50, 0.95)
GHOST_OPACITY = 0.3
"""Of ghosts that say nothing else."""

MOST_MESSAGES = 20
"""So many messages wait for a browser at most; the newest stay."""

MOST_GHOSTS = 50
"""So many configurations are shown at most, of all ghosts."""


@dataclass(frozen=True, slots=True)
class Ghost:
    """A robot as it would look in some configurations.

    Attributes:
        name: unique among the ghosts of a view.
        robot: the robot's uid.
        rows: (n, nq) all coordinates of the robot.
        color: of everything.
        opacity: above 0 (clear), to 1 (solid).
    """

    name: str
    robot: int
    rows: tuple[tuple[float, ...], ...]
    color: Color = GHOST_COLOR
    opacity: float = GHOST_OPACITY


@dataclass(frozen=True, slots=True)
class ViewSettings:
    """Settings of the view.

    `background` is red, green, blue from 0 to 1, as a screen shows them (sRGB). `joint_axes` holds the uids of robots
    whose joint axes are shown, `bounding_boxes` those of nodes whose boxes are shown; a uid that is gone is passed
    over, and so are a camera, measurements, clearances and ghosts of one and what is shown of one. Without a `camera`
    each viewer frames the scene. What the collision monitor finds to touch is red, and the background rose, unless
    `collisions_hidden`.
    """

    background: Color = BACKGROUND
    grid_hidden: bool = False
    joint_axes: tuple[int, ...] = ()
    bounding_boxes: tuple[int, ...] = ()
    camera: Camera | None = None
    sensors: tuple[SensorOverlay, ...] = ()
    measurements: tuple[Measurement, ...] = ()
    collisions_hidden: bool = False
    clearances: tuple[Clearance, ...] = ()
    ghosts: tuple[Ghost, ...] = ()


Listener = Callable[[ViewSettings], None]


class ViewStore:
    """Holds the view settings; any thread may read, change and listen.

    Attributes:
        under_way: what the kernel is busy with, which the page shows where it takes long.
    """

    def __init__(self, settings: ViewSettings | None = None) -> None:
        """Start with `settings`, or the default ones."""
        self.under_way = UnderWay()
        self._changed = threading.Condition()
        self._settings = checked(settings or ViewSettings())
        self._revision = 0
        self._listeners: Listeners[[ViewSettings]] = Listeners()
        self._messages: deque[str] = deque(maxlen=MOST_MESSAGES)

    def get(self) -> ViewSettings:
        """Return the settings as they are now."""
        return self._settings

    @property
    def revision(self) -> int:
        """Return how many changes there were."""
        return self._revision

    def update(self, **fields: Any) -> ViewSettings:  # noqa: ANN401  each field of ViewSettings has its own type
        """Change the named fields of `ViewSettings`, tell the listeners, and return the new settings.

        Raise KernelError, and change nothing, when a value cannot be drawn.
        """
        with self._changed:
            settings = checked(replace(self._settings, **fields))
            self._settings = settings
            self._revision += 1
            self._changed.notify_all()
        self._listeners.tell(settings)
        return settings

    def reset(self) -> ViewSettings:
        """Set up the picture as at the start, tell the listeners, and return the settings."""
        start = ViewSettings()
        return self.update(**{field: getattr(start, field) for field in start.__slots__})

    def tell(self, messages: Iterable[str]) -> None:
        """Have the viewer show messages, such as warnings about files; without a browser they wait for the first."""
        self._messages.extend(map(str, messages))  # viser sends strings, and nothing that is more than one

    def take_messages(self) -> list[str]:
        """Return the messages that were not shown yet, and forget them."""
        return [self._messages.popleft() for _ in range(len(self._messages))]

    def subscribe(self, listener: Listener) -> Callable[[], None]:
        """Call `listener` with the settings after each change, in the changing thread; return what ends it."""
        return self._listeners.add(listener)

    def wait(self, revision: int, timeout: float) -> tuple[int, ViewSettings]:
        """Return revision and settings once the revision differs from `revision`, or after `timeout` seconds."""
        with self._changed:
            self._changed.wait_for(lambda: self._revision != revision, timeout)
            return self._revision, self._settings


def checked(settings: ViewSettings) -> ViewSettings:
    """Return the settings, or raise KernelError where they cannot be drawn."""
    if not all(0.0 <= part <= 1.0 for part in settings.background):
        raise KernelError(
            f"the background is {settings.background}; red, green and blue go from 0 to 1",
            field="background",
            value=settings.background,
        )
    shown = [overlay.uid for overlay in settings.sensors]
    if len(set(shown)) != len(shown):
        raise KernelError("one sensor is there twice among those that are shown; name each once", field="sensors")
    _check_names([one.name for one in settings.measurements], "measurement")
    _check_names([one.name for one in settings.clearances], "clearance")
    _check_names([one.name for one in settings.ghosts], "ghost")
    _check_ghosts(settings.ghosts)
    if settings.camera is not None:
        check_camera(settings.camera)
    return settings


def _check_names(names: list[str], what: str) -> None:
    known: set[str] = set()
    for name in names:
        if not name.strip():
            raise KernelError(f"a {what} has no name; give it one", field=f"{what}s.name")
        if name in known:
            raise KernelError(
                f"there are two {what}s named {name!r}; give each a name of its own",
                reason=Reason.NAME_TAKEN,
                field=f"{what}s.name",
                name=name,
            )
        known.add(name)


def _check_ghosts(ghosts: tuple[Ghost, ...]) -> None:
    for one in ghosts:
        if not 0.0 < one.opacity <= 1.0:
            raise KernelError(
                f"the ghost {one.name!r} has the opacity {one.opacity}; it is above 0 (clear), to 1 (solid)",
                field=f"ghosts[{one.name!r}].opacity",
                value=one.opacity,
            )
        if not one.rows:
            raise KernelError(
                f"the ghost {one.name!r} has no configuration; give at least one row",
                field=f"ghosts[{one.name!r}].configurations.positions",
            )
    check_ghost_count(sum(len(one.rows) for one in ghosts))


def check_ghost_count(count: int) -> None:
    """Raise KernelError where ghosts would have more configurations in all than are shown."""
    if count > MOST_GHOSTS:
        raise KernelError(
            f"the ghosts have {count} configurations; at most {MOST_GHOSTS} are shown in all, so leave some out",
            field="ghosts",
            count=count,
        )


def check_camera(camera: Camera) -> None:
    """Raise KernelError where nothing can be seen from a camera."""
    if not all(math.isfinite(value) for value in (*camera.position, *camera.target)):
        raise KernelError(
            f"the camera looks from {camera.position} at {camera.target}; all six must be finite meters",
            field="camera",
            value=(camera.position, camera.target),
        )
    if math.dist(camera.position, camera.target) < LEAST_DISTANCE:
        raise KernelError(
            f"the camera is at its own target {camera.target}; move one of them",
            field="camera.position",
            value=camera.position,
        )
    if not LEAST_FIELD <= camera.field_of_view <= GREATEST_FIELD:
        raise KernelError(
            f"the field of view is {camera.field_of_view} rad; it goes from {LEAST_FIELD} to {GREATEST_FIELD} rad",
            field="camera.field_of_view_radians",
            value=camera.field_of_view,
        )
