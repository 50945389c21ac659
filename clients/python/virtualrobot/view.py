"""The picture: camera, background, grid, and auxiliary figures."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np
from google.protobuf.field_mask_pb2 import FieldMask
from numpy.typing import ArrayLike, NDArray

from virtualrobot import figures, film, measuring, pictures
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.ghosts import Ghost, Positions, ghost_message, ghost_of
from virtualrobot.measuring import Measure, Place
from virtualrobot.node import Node
from virtualrobot.pictures import Camera, Picked, Picture, Recording
from virtualrobot.scene import Scene
from virtualrobot.services import Services
from virtualrobot.v1 import kernel_pb2, view_pb2
from virtualrobot.wire import color_message, vector_message

_POINT_COLORS = {"distance": view_pb2.POINT_COLOR_DISTANCE, "intensity": view_pb2.POINT_COLOR_INTENSITY}


class View:
    """What every open viewer of one kernel shows.

    Example:
        >>> client.view.background = "white"
        >>> path = client.view.add_lines([[0, 0, 0], [1, 0, 1]], color="red")
        >>> path.remove()
    """

    def __init__(self, services: Services, scene: Scene) -> None:
        """Handle the picture of one kernel."""
        self._services = services
        self._scene = scene

    def read(self) -> view_pb2.View:
        """Return the set-up as the contract describes it."""
        return self._services.view.GetView(view_pb2.GetViewRequest()).view

    def watch(self) -> Iterator[view_pb2.View]:
        """Yield the set-up now and after each change."""
        with self._services.view.WatchView(view_pb2.WatchViewRequest()) as stream:
            yield from (response.view for response in stream)

    @property
    def viewer_count(self) -> int:
        """How many browsers show it now."""
        return self._services.view.GetView(view_pb2.GetViewRequest()).viewer_count

    @property
    def background(self) -> NDArray[np.float64]:
        """The colour behind everything, red, green, blue, 0 to 1; set it to anything that names a colour."""
        color = self.read().background
        return np.array([color.red, color.green, color.blue])

    @background.setter
    def background(self, color: str | ArrayLike) -> None:
        self._update(view_pb2.View(background=color_message(color)), "background")

    @property
    def grid(self) -> bool:
        """Whether the grid on the floor is shown."""
        return not self.read().grid_hidden

    @grid.setter
    def grid(self, shown: bool) -> None:
        self._update(view_pb2.View(grid_hidden=not shown), "grid_hidden")

    @property
    def collisions(self) -> bool:
        """Whether what the collision monitor finds to touch is red, and the background rose while it does."""
        return not self.read().collisions_hidden

    @collisions.setter
    def collisions(self, shown: bool) -> None:
        self._update(view_pb2.View(collisions_hidden=not shown), "collisions_hidden")

    @property
    def joint_axes(self) -> list[str]:
        """The robots whose joint axes are shown."""
        return list(self.read().joint_axes)

    @joint_axes.setter
    def joint_axes(self, robots: Iterable[str]) -> None:
        self._update(view_pb2.View(joint_axes=list(robots)), "joint_axes")

    @property
    def bounding_boxes(self) -> list[str]:
        """The nodes whose bounding boxes are shown."""
        return list(self.read().bounding_boxes)

    @bounding_boxes.setter
    def bounding_boxes(self, nodes: Iterable[str]) -> None:
        self._update(view_pb2.View(bounding_boxes=list(nodes)), "bounding_boxes")

    @property
    def measurements(self) -> dict[str, tuple[Place, Place]]:
        """The distances that are shown, by name; set it to show others.

        A distance is between two points that move with nodes: a node's name (empty: the world) and meters in its frame.

        Example:
            >>> client.view.measurements = {"gap": (("table", [0, 0, 0.7]), ("iiwa.lbr_iiwa_link_7", [0, 0, 0]))}
        """
        return {
            one.name: (
                (one.first.node, measuring.vector_of(one.first.point)),
                (one.second.node, measuring.vector_of(one.second.point)),
            )
            for one in self.read().measurements
        }

    @measurements.setter
    def measurements(self, places: Mapping[str, tuple[Place, Place]]) -> None:
        shown = [
            view_pb2.Measurement(
                name=name, first=measuring.place_message(first), second=measuring.place_message(second)
            )
            for name, (first, second) in places.items()
        ]
        self._update(view_pb2.View(measurements=shown), "measurements")

    @property
    def clearances(self) -> dict[str, tuple[list[str], list[str]]]:
        """The least distances that are shown between what can collide, by name; set it to show others.

        Each is from some nodes (a name, or several) to others; none of these means everything else. Each node counts
        with all below it, and the line goes from surface to surface, wherever they are nearest.

        Example:
            >>> client.view.clearances = {"gap": ("arm", "box"), "all around": ("arm", [])}
        """
        return {one.name: (list(one.first), list(one.second)) for one in self.read().clearances}

    @clearances.setter
    def clearances(self, nodes: Mapping[str, tuple[str | Iterable[str], str | Iterable[str]]]) -> None:
        def names(given: str | Iterable[str]) -> list[str]:
            return [given] if isinstance(given, str) else list(given)

        shown = [
            view_pb2.Clearance(name=name, first=names(first), second=names(second))
            for name, (first, second) in nodes.items()
        ]
        self._update(view_pb2.View(clearances=shown), "clearances")

    @property
    def ghosts(self) -> dict[str, Ghost]:
        """Robots that are shown, translucent, where they are not, by name; set it to show others.

        Each is a `Ghost`, or (robot, positions) of one; of many positions 20 are shown, picked out evenly.

        Example:
            >>> client.view.ghosts = {"path": ("arm", client.paths.find("arm", goal))}
            >>> client.view.ghosts = {}
        """
        return {one.name: ghost_of(one) for one in self.read().ghosts}

    @ghosts.setter
    def ghosts(self, ghosts: Mapping[str, Ghost | tuple[str, Positions]]) -> None:
        shown = [ghost_message(name, one if isinstance(one, Ghost) else Ghost(*one)) for name, one in ghosts.items()]
        self._update(view_pb2.View(ghosts=shown), "ghosts")

    @property
    def sensors(self) -> dict[str, view_pb2.SensorOverlay]:
        """What is shown of sensors, by their names."""
        return {one.sensor: one for one in self.read().sensors}

    def show_sensor(
        self,
        sensor: str,
        *,
        points: bool = True,
        rays: bool = False,
        color_by: str = "distance",
        frustum: bool = True,
        image: bool = True,
    ) -> None:
        """Show what a sensor says, in every open viewer; what was shown of it before is replaced.

        Args:
            sensor: its name; what says nothing about its kind is passed over.
            points: range sensors: the echoes as points.
            rays: range sensors: the beams as lines.
            color_by: what both are coloured by, `distance` (nearest violet, farthest red) or `intensity` (0 to 1).
            frustum: cameras: the pyramid that they see.
            image: cameras: the latest picture in it.
        """
        if color_by not in _POINT_COLORS:
            raise InvalidArgumentError(f"color_by is {color_by!r}; give {' or '.join(_POINT_COLORS)}")
        overlay = view_pb2.SensorOverlay(
            sensor=sensor, points=points, rays=rays, color_by=_POINT_COLORS[color_by], frustum=frustum, image=image
        )
        self._show_sensors([*(one for name, one in self.sensors.items() if name != sensor), overlay])

    def hide_sensor(self, *sensors: str) -> None:
        """Show nothing of these sensors; without a name, of none. One that is not shown is none to hide."""
        self._show_sensors([one for name, one in self.sensors.items() if sensors and name not in sensors])

    def _show_sensors(self, overlays: list[view_pb2.SensorOverlay]) -> None:
        self._update(view_pb2.View(sensors=overlays), "sensors")

    def measure(self, first: Place, second: Place) -> Measure:
        """Return how far two points are apart now.

        Example:
            >>> client.view.measure(("world", [0, 0, 0]), ("iiwa.lbr_iiwa_link_7", [0, 0, 0])).distance
            1.261
        """
        return measuring.measure(self._services, first, second)

    def watch_measure(self, first: Place, second: Place, max_rate: float = 0.0) -> Iterator[Measure]:
        """Yield how far two points are apart now and whenever the world changes, `max_rate` (0: 30) times a second."""
        return measuring.watch_measure(self._services, first, second, max_rate)

    def capture(
        self,
        camera: Camera | None = None,
        *,
        size: tuple[int, int] = (0, 0),
        format: str = "png",
        plain: bool = False,
    ) -> Picture:
        """Return a picture of the world as it is now; it needs no browser.

        Args:
            camera: where it is taken from: (eye, target) or (eye, target, field of view), meters in the world's frame
                and radians; or the name of a camera of the scene. Without one it is the view's, which frames the world
                until it is set.
            size: width and height in pixels, at most 4096 each; 0 means 1280 and 720, or the camera's own.
            format: `png`, `jpeg`, or `raw` for `pixels`.
            plain: leaves out annotations, bounding boxes, joint axes, measurements, ghosts, what is shown of sensors
                and of collisions.

        Example:
            >>> client.view.capture(([2, -2, 1.5], [0, 0, 0.5])).save("cell.png")
            >>> client.view.capture("wrist camera", format="raw").pixels.shape
            (480, 640, 3)
        """
        return pictures.capture(self._services, camera, size, format, plain)

    def record(
        self,
        camera: Camera | None = None,
        *,
        size: tuple[int, int] = (0, 0),
        format: str = "jpeg",
        plain: bool = False,
        rate: float = 25.0,
        seconds: float = 0.0,
    ) -> Recording:
        """Return pictures at equal steps of simulation time, none left out, however long each takes to be drawn.

        Args:
            camera: as in `capture`, so also `size`, `format` and `plain`.
            size: as above.
            format: as above.
            plain: as above.
            rate: pictures a second of simulation time, at most one a tick.
            seconds: for how much simulation time; 0 means until the recording is cancelled.

        Raises:
            TooLargeError: from the iterator, when drawing is too far behind.

        Example:
            >>> with client.view.record(seconds=2.0) as recording:
            ...     times = [picture.simulation_time for picture in recording]
        """
        return pictures.record(self._services, camera, size, format, plain, rate, seconds)

    def film(
        self,
        path: str | Path,
        camera: Camera | None = None,
        *,
        seconds: float = 0.0,
        size: tuple[int, int] = (0, 0),
        plain: bool = False,
        rate: float = 25.0,
        told: Callable[[Picture], None] | None = None,
    ) -> int:
        """Film so much simulation time, and return how many pictures there are; arguments are those of `record`.

        `path` ends with .mp4 or .gif; `told` is called for each picture. It needs the package `av`
        (`pip install 'virtualrobot[video]'`). Ctrl-C leaves a film of what is drawn.

        Example:
            >>> client.view.film("cell.mp4", seconds=10.0)
            250
        """
        with film.FilmFile(path, rate) as file, self._filming(camera, size, plain, rate, seconds) as recording:
            return film.write(recording, file, told)

    def start_film(
        self,
        path: str | Path,
        camera: Camera | None = None,
        *,
        size: tuple[int, int] = (0, 0),
        plain: bool = False,
        rate: float = 25.0,
        told: Callable[[Picture], None] | None = None,
    ) -> film.FilmThread:
        """Begin to film while the program goes on; the end of the block draws the rest and closes the file.

        The arguments are those of `film`. Without a block, `finish()` does the same, and tells how many there are.

        Example:
            >>> with client.view.start_film("move.mp4"):
            ...     robot.move_joints(goal)
        """

        def now() -> float:
            response = self._services.kernel.GetClock(kernel_pb2.GetClockRequest())
            return response.stamp.simulation_time_seconds

        file = film.FilmFile(path, rate)
        return film.FilmThread(file, self._filming(camera, size, plain, rate, 0.0), now, told)

    def _filming(
        self, camera: Camera | None, size: tuple[int, int], plain: bool, rate: float, seconds: float
    ) -> Recording:
        return self.record(camera, size=size, format="raw", plain=plain, rate=rate, seconds=seconds)

    def pick(
        self, column: float, row: float, camera: Camera | None = None, *, size: tuple[int, int] = (0, 0)
    ) -> Picked:
        """Return what is under a pixel of a picture that `capture` takes with this camera and size.

        The middle of the upper left pixel is (0, 0).

        Example:
            >>> found = client.view.pick(640, 360)
            >>> found.node, found.distance
            ('iiwa.lbr_iiwa_link_3', 2.14)
        """
        return pictures.pick(self._services, column, row, camera, size)

    def set_camera(self, position: ArrayLike, target: ArrayLike = (0.0, 0.0, 0.0), field_of_view: float = 0.0) -> None:
        """Look from `position` at `target`, meters in the world's frame; `field_of_view` in radians, 0 means 0.9."""
        camera = view_pb2.Camera(
            position=vector_message(position, "the camera's position"),
            target=vector_message(target, "the camera's target"),
            field_of_view_radians=field_of_view,
        )
        self._update(view_pb2.View(camera=camera), "camera")

    def add_points(
        self,
        positions: ArrayLike,
        *,
        color: str | ArrayLike | None = None,
        colors: ArrayLike | None = None,
        size: float = 0.0,
        name: str = "",
        pose: ArrayLike | None = None,
        parent: str = "world",
    ) -> Node:
        """Show points (n, 3) in meters, with one colour or `colors` (n, 3), 0 to 255; `remove()` takes them away.

        They stand at `pose` (`parent_t_node`) on the node `parent` and go with it. Without `name` they get one.
        """
        return self._add("points", name, figures.points(positions, color=color, colors=colors, size=size), pose, parent)

    def add_lines(
        self,
        segments: ArrayLike,
        *,
        color: str | ArrayLike | None = None,
        width_pixels: float = 0.0,
        name: str = "",
        pose: ArrayLike | None = None,
        parent: str = "world",
    ) -> Node:
        """Show line segments (n, 2, 3), or a line through points (n, 3), in meters; options as in `add_points`."""
        return self._add("lines", name, figures.lines(segments, color=color, width_pixels=width_pixels), pose, parent)

    def add_frame(
        self, pose: ArrayLike | None = None, *, length: float = 0.0, name: str = "", parent: str = "world"
    ) -> Node:
        """Show a frame, x red, y green, z blue, at `pose` (`parent_t_node`); `length` 0 means 0.1 m."""
        return self._add("frame", name, figures.frame(length), pose, parent)

    def add_label(self, text: str, pose: ArrayLike | None = None, *, name: str = "", parent: str = "world") -> Node:
        """Show words at `pose` (`parent_t_node`)."""
        return self._add("label", name, figures.label(text), pose, parent)

    def _add(self, kind: str, name: str, figure: figures.Figures, pose: ArrayLike | None, parent: str) -> Node:
        return self._scene.add_annotation(name or f"{kind}-{uuid.uuid4().hex[:8]}", figure, pose=pose, parent=parent)

    def _update(self, view: view_pb2.View, field: str) -> None:
        self._services.view.UpdateView(view_pb2.UpdateViewRequest(view=view, mask=FieldMask(paths=[field])))
