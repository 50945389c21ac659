"""Models and worlds as trees of named frames (SDFormat 1.7 and later, "Pose frame semantics"; older rules too)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from virtualrobot_sdk.poses import inverse
from virtualrobot_sdk.xml import Element

from virtualrobot_plugins.importers.sdf.elements import Matrix, Place

MODEL_FRAME = "__model__"


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame: where it is, in which other frame, and the body that it is fixed to ("" for the scope's own)."""

    relative_to: str
    pose: Matrix
    element: Element
    attached_to: str = ""


@dataclass(frozen=True, slots=True)
class LinkElement:
    """A link: its name, its element and where it was read."""

    name: str
    element: Element
    place: Place


@dataclass(slots=True)
class Scope:
    """A model or a world, in which names hold.

    Attributes:
        name: of the model; empty for a world.
        place: of the model in its file, for errors.
        element: of the model.
        frames: links, joints, frames and nested models by name.
        links: of the model itself.
        joints: of the model itself, by name.
        nested: models inside, by name.
        static: true where nothing in it moves.
        canonical: the link that the model's own frame is fixed to, when the file names one.
    """

    name: str
    place: Place
    element: Element
    frames: dict[str, Frame] = field(default_factory=dict)
    links: list[LinkElement] = field(default_factory=list)
    joints: list[LinkElement] = field(default_factory=list)
    nested: dict[str, Scope] = field(default_factory=dict)
    static: bool = False
    canonical: str = ""

    def add(self, name: str, frame: Frame) -> None:
        """Add a frame; a name that is taken is refused (SDFormat: names of siblings differ)."""
        if name in self.frames:
            first = self.frames[name].element.sourceline
            raise self.place.error(frame.element, f"the name {name!r} is taken; first on line {first}")
        self.frames[name] = frame

    def scope_t(self, name: str, element: Element, _trail: tuple[str, ...] = ()) -> Matrix:
        """Return where the frame `name` (`a::b` in a nested model) is in this scope; `element` is who asks."""
        if name in ("", MODEL_FRAME) or (name == "world" and not self.name):
            return np.eye(4)
        if name in _trail:
            raise self.place.error(element, f"poses relative to each other form a loop: {' → '.join((*_trail, name))}")
        frame = self.frames.get(name)
        if frame is not None:
            return self.scope_t(frame.relative_to, frame.element, (*_trail, name)) @ frame.pose
        first, separator, rest = name.partition("::")
        if separator and first in self.nested:
            inner = self.nested[first].scope_t(rest, element)
            return self.scope_t(first, element, (*_trail, name)) @ inner
        known = ", ".join(self.frames) or "none"
        raise self.place.error(element, f"there is no frame {name!r}; known: {known}")

    def link_of(self, name: str, element: Element, _trail: tuple[str, ...] = ()) -> str:
        """Return the link (`a::b` in a nested model) that the frame `name` is fixed to."""
        if name in _trail:
            raise self.place.error(element, f"frames attached to each other form a loop: {' → '.join((*_trail, name))}")
        trail = (*_trail, name)
        if name in ("", MODEL_FRAME):
            return self._canonical_link(element)
        if any(link.name == name for link in self.links):
            return name
        if name in self.nested:
            return f"{name}::{self.nested[name].link_of('', element)}"
        if name in self.frames:
            return self.link_of(self.frames[name].attached_to, self.frames[name].element, trail)
        first, separator, rest = name.partition("::")
        if separator and first in self.nested:
            return f"{first}::{self.nested[first].link_of(rest, element)}"
        known = ", ".join(link.name for link in self.links) or "none"
        raise self.place.error(element, f"there is no link or frame {name!r}; links: {known}")

    def _canonical_link(self, element: Element) -> str:
        if self.canonical:
            return self.link_of(self.canonical, self.element)
        if self.links:
            return self.links[0].name
        for name, model in self.nested.items():
            return f"{name}::{model.link_of('', element)}"
        raise self.place.error(element, f"the model {self.name!r} has no link")

    def all_links(self, prefix: str = "", scope_t: Matrix | None = None) -> Iterator[tuple[str, LinkElement, Matrix]]:
        """Yield full name, element and pose of all links, those of nested models too."""
        here = np.eye(4) if scope_t is None else scope_t
        for link in self.links:
            yield prefix + link.name, link, here @ self.scope_t(link.name, link.element)
        for name, model in self.nested.items():
            inner = here @ self.scope_t(name, model.element)
            yield from model.all_links(f"{prefix}{name}::", inner)

    def all_joints(self, prefix: str = "", scope_t: Matrix | None = None) -> Iterator[tuple[str, Scope, Matrix]]:
        """Yield, for this model and each nested one, the prefix of its names, itself and its pose."""
        here = np.eye(4) if scope_t is None else scope_t
        yield prefix, self, here
        for name, model in self.nested.items():
            inner = here @ self.scope_t(name, model.element)
            yield from model.all_joints(f"{prefix}{name}::", inner)


def at_placement(pose: Matrix, model: Scope, placement_frame: str, element: Element) -> Matrix:
    """Return the pose of a model whose frame `placement_frame` shall be at `pose`."""
    return pose @ inverse(model.scope_t(placement_frame, element)) if placement_frame else pose
