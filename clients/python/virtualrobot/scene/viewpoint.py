"""Viewpoints: views of people, saved in the scene under names."""

from __future__ import annotations

from virtualrobot.scene.node import Node


class Viewpoint(Node):
    """Viewpoint of the scene by its name, a node like others: it is renamed, attached and removed as they are.

    Its pose is that of the eye, which looks along z, and moves along with its parent.
    """

    @property
    def distance(self) -> float:
        """Distance from the eye to what is looked at, in meters."""
        return self._message.viewpoint.distance_meters or 1.0

    @property
    def field_of_view(self) -> float:
        """The vertical field of view in radians."""
        return self._message.viewpoint.field_of_view_radians or 0.9

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Viewpoint {self.name!r} in {self.parent!r}>"
