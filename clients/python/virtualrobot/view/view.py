"""The picture: taken, filmed, measured in, and with figures of its own."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, PoseLike, Text, checked
from virtualrobot._wire.messages import several
from virtualrobot._wire.services import Services
from virtualrobot.errors import WrongStateError
from virtualrobot.scene import figures
from virtualrobot.scene.node import Node
from virtualrobot.scene.scene import Scene
from virtualrobot.scene.viewpoint import Viewpoint
from virtualrobot.sensors.cameras import looking_at
from virtualrobot.v1 import kernel_pb2, view_pb2
from virtualrobot.view import film, measuring, pictures
from virtualrobot.view.coats import CoatHandle, color_map_of, set_coat, watch_coats
from virtualrobot.view.measuring import Measure, Place
from virtualrobot.view.pictures import Camera, Picked, Picture, Recording, Size
from virtualrobot.view.setup import ViewSetup

Vector = NDArray[np.float64]


@checked
class View(ViewSetup):
    """Picture in every open viewer of one kernel.

    Example:
        >>> client.view.background = "white"
        >>> path = client.view.add_lines([[0, 0, 0], [1, 0, 1]], color="red")
        >>> path.remove()
    """

    def __init__(self, services: Services, scene: Scene) -> None:
        """Handle the picture of one kernel."""
        super().__init__(services)
        self._scene = scene

    def eye_and_target(self) -> tuple[Vector, Vector] | None:
        """Return from where the view looks now and at what, (3,) each, meters in the world's frame.

        None means that nobody has set it: it frames the world.
        """
        now = self.read()
        if not (now.camera_position - now.camera_target).any():
            return None
        pose = self._scene.pose(now.camera_node or "world")
        turn = np.eye(3) if now.camera_keeps_direction else pose[:3, :3]
        eye, target = (turn @ point + pose[:3, 3] for point in (now.camera_position, now.camera_target))
        return eye, target

    def follow(self, node: str, *, turns: bool = False) -> None:
        """Have the view go along with a node, in every open viewer, pictures and films; with "world" it stays.

        It looks from where it does now. One that `turns` does so with the node, as a camera that is mounted on it.

        Raises:
            WrongStateError: nobody has set the view: it frames the world.
        """
        eye, target = self._set_view()
        pose = self._scene.pose(node)
        turn = pose[:3, :3] if turns else np.eye(3)
        eye, target = (turn.T @ (point - pose[:3, 3]) for point in (eye, target))
        self.set_camera(eye, target, self.read().field_of_view, node=node, keeps_direction=not turns)

    def save(self, name: str) -> Viewpoint:
        """Save from where the view looks as a viewpoint of the scene; one of this name looks from there then.

        While the view turns with a node, the viewpoint hangs on that node. Scene files and undo have it as other nodes.

        Raises:
            WrongStateError: nobody has set the view: it frames the world.
            NameTakenError: another node has this name.
        """
        eye, target = self._set_view()
        now, known = self.read(), self._scene.viewpoints()
        parent = "world" if now.camera_keeps_direction else now.camera_node or "world"
        if parent in known:
            parent = known[parent].parent
        pose = np.linalg.inv(self._scene.pose(parent)) @ looking_at(eye, target)
        distance = float(np.linalg.norm(target - eye))
        with self._scene.batch() as batch:
            if name in known:
                batch.attach(name, parent, pose)
                batch.set_viewpoint(name, distance, now.field_of_view)
            else:
                batch.add_viewpoint(name, pose=pose, parent=parent, distance=distance, field_of_view=now.field_of_view)
        return self._scene.viewpoint(name)

    def _set_view(self) -> tuple[Vector, Vector]:
        found = self.eye_and_target()
        if found is None:
            raise WrongStateError("the view frames the world; set it first, by set_camera or look_from")
        return found

    def look_from(self, viewpoint: str) -> None:
        """Look from a viewpoint of the scene, in every open viewer, and go along with it where it moves.

        Example:
            >>> client.view.save("front")
            >>> client.view.look_from("front")
        """
        saved = self._scene.viewpoint(viewpoint)
        self.set_camera([0.0, 0.0, 0.0], [0.0, 0.0, saved.distance], saved.field_of_view, node=saved.name)

    def measure(self, first: Place, second: Place) -> Measure:
        """Return how far two points are apart now.

        Example:
            >>> client.view.measure(("world", [0, 0, 0]), ("iiwa.lbr_iiwa_link_7", [0, 0, 0])).distance
            1.261
        """
        return measuring.measure(self._services, first, second)

    def watch_measure(self, first: Place, second: Place, max_rate: float | None = None) -> Iterator[Measure]:
        """Yield how far two points are apart now and whenever that changes, at most `max_rate` (30) times a second."""
        return measuring.watch_measure(self._services, first, second, max_rate)

    def capture(
        self,
        camera: Camera | None = None,
        *,
        size: Size | None = None,
        format: str = "png",
        plain: bool = False,
    ) -> Picture:
        """Return a picture of the world as it is now; it needs no browser.

        Args:
            camera: the point of view: (eye, target) or (eye, target, field of view), meters in the world's frame
                and radians; or the name of a camera or a viewpoint of the scene. Without one it is the view's, which
                frames the world until it is set.
            size: width and height in pixels, at most 4096 each; by default 1280 and 720, or the camera's own.
            format: `png`, `jpeg`, or `raw` for `pixels`.
            plain: leaves out annotations, bounding boxes, joint axes, measurements, ghosts, what is shown of sensors
                and of collisions.

        Example:
            >>> client.view.capture(([2, -2, 1.5], [0, 0, 0.5])).save("cell.png")
            >>> client.view.capture("wrist camera", format="raw").pixels.shape
            (480, 640, 3)
        """
        return pictures.capture(self._services, camera, size, format, plain)

    def capture_model(self, name: str) -> Picture:
        """Return a small picture of a known model that is installed, a PNG file; it is taken once and kept.

        Example:
            >>> client.view.capture_model("ur10e").save("ur10e.png")
        """
        return pictures.capture_model(self._services, name)

    def record(
        self,
        camera: Camera | None = None,
        *,
        size: Size | None = None,
        format: str = "jpeg",
        plain: bool = False,
        rate: float = 25.0,
        duration: float | None = None,
    ) -> Recording:
        """Return pictures at equal steps of simulation time, none left out, however long each takes to be drawn.

        Args:
            camera: as in `capture`, so also `size`, `format` and `plain`.
            size: as above.
            format: as above.
            plain: as above.
            rate: pictures a second of simulation time, at most one a tick.
            duration: simulation time (s); by default until the recording is cancelled.

        Raises:
            TooLargeError: from the iterator, when drawing is too far behind.

        Example:
            >>> with client.view.record(duration=2.0) as recording:
            ...     times = [picture.simulation_time for picture in recording]
        """
        return pictures.record(self._services, camera, size, format, plain, rate, duration)

    def film(
        self,
        path: str | Path,
        camera: Camera | None = None,
        *,
        duration: float | None = None,
        size: Size | None = None,
        plain: bool = False,
        rate: float = 25.0,
        told: Callable[[Picture], None] | None = None,
    ) -> int:
        """Film so much simulation time, and return how many pictures there are; arguments are those of `record`.

        `path` ends with .mp4 or .gif; `told` is called for each picture. It needs the package `av`
        (`pip install 'virtualrobot[video]'`). Ctrl-C leaves a film of what is drawn.

        Example:
            >>> client.view.film("cell.mp4", duration=10.0)
            250
        """
        with film.FilmFile(path, rate) as file, self._filming(camera, size, plain, rate, duration) as recording:
            return film.write(recording, file, told)

    def start_film(
        self,
        path: str | Path,
        camera: Camera | None = None,
        *,
        size: Size | None = None,
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
        return film.FilmThread(file, self._filming(camera, size, plain, rate, None), now, told)

    def _filming(
        self, camera: Camera | None, size: Size | None, plain: bool, rate: float, duration: float | None
    ) -> Recording:
        return self.record(camera, size=size, format="raw", plain=plain, rate=rate, duration=duration)

    def pick(self, column: float, row: float, camera: Camera | None = None, *, size: Size | None = None) -> Picked:
        """Return what is under a pixel of a picture that `capture` takes with this camera and size.

        The middle of the upper left pixel is (0, 0).

        Example:
            >>> found = client.view.pick(640, 360)
            >>> found.node, found.distance
            ('iiwa.lbr_iiwa_link_3', 2.14)
        """
        return pictures.pick(self._services, column, row, camera, size)

    def add_points(
        self,
        positions: ArrayLike,
        *,
        color: str | ArrayLike | None = None,
        colors: ArrayLike | None = None,
        size: float | None = None,
        name: str | None = None,
        pose: PoseLike | None = None,
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
        width: float | None = None,
        name: str | None = None,
        pose: PoseLike | None = None,
        parent: str = "world",
    ) -> Node:
        """Show line segments (n, 2, 3), or a line through points (n, 3), in meters; options as in `add_points`."""
        return self._add("lines", name, figures.lines(segments, color=color, width=width), pose, parent)

    def add_frame(
        self,
        pose: PoseLike | None = None,
        *,
        length: float | None = None,
        name: str | None = None,
        parent: str = "world",
    ) -> Node:
        """Show a frame, x red, y green, z blue, at `pose` (`parent_t_node`); `length` is 0.1 m by default."""
        return self._add("frame", name, figures.frame(length), pose, parent)

    def add_label(
        self, text: Text, pose: PoseLike | None = None, *, name: str | None = None, parent: str = "world"
    ) -> Node:
        """Show words at `pose` (`parent_t_node`)."""
        return self._add("label", name, figures.label(text), pose, parent)

    def add_coat(
        self,
        name: str,
        node: str,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        low: float,
        high: float,
        unit: str = "",
        title: str = "",
        color_map: str = "viridis",
    ) -> CoatHandle:
        """Put triangles on a node that are coloured by a quantity at each corner, in place of a coat of the same name.

        It is empty until it is painted. Pages, pictures and cameras show it; it touches nothing, and is neither saved
        nor undone.

        Args:
            name: unique among the coats.
            node: the node that it goes along with.
            vertices: (n, 3) meters in the node's frame, best 0.2 mm out of the surface that it lies on.
            faces: (m, 3) rows of these, counter-clockwise seen from outside.
            low: the quantity that has the first colour.
            high: that which has the last one.
            unit: of the quantity, for the legend.
            title: of the legend; by default the name.
            color_map: `viridis`, `turbo` or `heat`.

        Example:
            >>> film = client.view.add_coat("film", "hood", vertices, faces, low=0, high=50, unit="µm")
            >>> film.paint(thickness)
        """
        colors = color_map_of(color_map)
        coat = view_pb2.Coat(name=name, node=node, color_map=colors, low=low, high=high, unit=unit, title=title)
        return set_coat(self._services, coat, vertices, faces)

    def watch_coats(self) -> Iterator[dict[str, NDArray[np.uint8]]]:
        """Yield the bytes of all coats by name, now and after changes, at most ten times a second.

        0 is where there is nothing, 1 the lowest quantity of the legend, and 255 the highest.
        """
        return watch_coats(self._services)

    def remove_coats(self, names: str | Iterable[str] = ()) -> None:
        """Take coats away; without names all."""
        self._services.view.RemoveCoats(view_pb2.RemoveCoatsRequest(names=several(names)))

    def _add(self, kind: str, name: str | None, figure: figures.Figures, pose: PoseLike | None, parent: str) -> Node:
        return self._scene.add_annotation(name or f"{kind}-{uuid.uuid4().hex[:8]}", figure, pose=pose, parent=parent)

    def _repr_html_(self) -> str:
        """Return the live picture for notebooks: the viewer's page, to be turned and come nearer in."""
        from html import escape

        url = self._services.kernel.GetInfo(kernel_pb2.GetInfoRequest()).viewer_url
        if not url:
            return "<p>This kernel has no viewer: start it without <code>--headless</code>.</p>"
        return f'<iframe src="{escape(url)}" title="Live view" width="100%" height="480" style="border: 0"></iframe>'
