"""Set-up of the picture: background, grid, camera, and overlays over the world."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
from google.protobuf.field_mask_pb2 import FieldMask
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import color_message, several
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import listed, told
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import view_pb2
from virtualrobot.view import measuring
from virtualrobot.view.ghosts import Ghost, Positions, ghost_message
from virtualrobot.view.measuring import Place
from virtualrobot.view.state import POINT_COLORS, SensorOverlay, ViewState, camera_message


@checked
class ViewSetup:
    """Overlays and camera of every open viewer of one kernel."""

    def __init__(self, services: Services) -> None:
        """Handle the set-up of one kernel's picture."""
        self._services = services

    def read(self) -> ViewState:
        """Return the set-up now."""
        return ViewState.of(self._services.view.GetView(view_pb2.GetViewRequest()).view)

    def watch(self) -> Iterator[ViewState]:
        """Yield the set-up now and after each change."""
        with self._services.view.WatchView(view_pb2.WatchViewRequest()) as stream:
            yield from (ViewState.of(response.view) for response in stream)

    @property
    def viewer_count(self) -> int:
        """Number of browsers that show it now."""
        return self._services.view.GetView(view_pb2.GetViewRequest()).viewer_count

    @property
    def background(self) -> NDArray[np.float64]:
        """The colour behind everything, red, green, blue, 0 to 1; set it to anything that names a colour."""
        return self.read().background

    @background.setter
    def background(self, color: str | ArrayLike) -> None:
        self._update(view_pb2.View(background=color_message(color)), "background")

    @property
    def grid(self) -> bool:
        """True where the grid on the floor is shown."""
        return self.read().grid

    @grid.setter
    def grid(self, shown: bool) -> None:
        self._update(view_pb2.View(grid_hidden=not shown), "grid_hidden")

    @property
    def collisions(self) -> bool:
        """True where nodes that the collision monitor finds to touch are red, and the background rose meanwhile."""
        return self.read().collisions

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
        return self.read().measurements

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
        return self.read().clearances

    @clearances.setter
    def clearances(self, nodes: Mapping[str, tuple[str | Iterable[str], str | Iterable[str]]]) -> None:
        shown = [
            view_pb2.Clearance(name=name, first=several(first), second=several(second))
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
        return self.read().ghosts

    @ghosts.setter
    def ghosts(self, ghosts: Mapping[str, Ghost | tuple[str, Positions]]) -> None:
        shown = [ghost_message(name, one if isinstance(one, Ghost) else Ghost(*one)) for name, one in ghosts.items()]
        self._update(view_pb2.View(ghosts=shown), "ghosts")

    @property
    def sensors(self) -> dict[str, SensorOverlay]:
        """Overlays of sensors, by the sensors' names."""
        return self.read().sensors

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
            color_by: quantity behind both colours, `distance` (nearest violet, farthest red) or `intensity` (0 to 1).
            frustum: cameras: the pyramid that they see.
            image: cameras: the latest picture in it.
        """
        if color_by not in POINT_COLORS:
            raise InvalidArgumentError(f"color_by is {color_by!r}; give {' or '.join(POINT_COLORS)}")
        self._show_sensors({**self.sensors, sensor: SensorOverlay(points, rays, color_by, frustum, image)})

    def hide_sensor(self, *sensors: str) -> None:
        """Show nothing of these sensors; without a name, of none. One that is not shown is none to hide."""
        shown = self.sensors.items()
        self._show_sensors({name: one for name, one in shown if sensors and name not in sensors})

    def _show_sensors(self, overlays: Mapping[str, SensorOverlay]) -> None:
        shown = [
            view_pb2.SensorOverlay(
                sensor=name,
                points=one.points,
                rays=one.rays,
                color_by=POINT_COLORS[one.color_by],
                frustum=one.frustum,
                image=one.image,
            )
            for name, one in overlays.items()
        ]
        self._update(view_pb2.View(sensors=shown), "sensors")

    def set_camera(
        self,
        position: ArrayLike,
        target: ArrayLike = (0.0, 0.0, 0.0),
        field_of_view: float | None = None,
        *,
        node: str = "",
        keeps_direction: bool = False,
    ) -> None:
        """Look from `position` at `target`, meters in the world's frame, or in that of a node, and go along with it.

        Args:
            position: (3,) the eye.
            target: (3,) what it looks at.
            field_of_view: vertical, in radians, 0.9 by default.
            node: what the view goes along with; the world's z stays upwards. By default nothing.
            keeps_direction: doesn't turn with the node: `position` and `target` are from its origin, along the world's
                axes.

        Example:
            >>> client.view.set_camera([1, -1, 0.5], node="arm.gripper", keeps_direction=True)
        """
        camera = camera_message(position, target, field_of_view)
        camera.node, camera.keeps_direction = node, keeps_direction
        self._update(view_pb2.View(camera=camera), "camera")

    def _update(self, view: view_pb2.View, field: str) -> None:
        self._services.view.UpdateView(view_pb2.UpdateViewRequest(view=view, update_mask=FieldMask(paths=[field])))

    def __repr__(self) -> str:
        """Return a line for people."""

        def say() -> str:
            answer = self._services.view.GetView(view_pb2.GetViewRequest())
            shown = {
                "joint axes": answer.view.joint_axes,
                "bounding boxes": answer.view.bounding_boxes,
                "measurements": answer.view.measurements,
                "clearances": answer.view.clearances,
                "ghosts": answer.view.ghosts,
                "sensors": answer.view.sensors,
            }
            overlays = [f"{what} of {len(which)}" for what, which in shown.items() if which]
            return f"{answer.viewer_count} browsers; {listed(overlays, 'no overlays')}"

        return told(type(self).__name__, say)
