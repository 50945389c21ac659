"""SDFormat documents read into scopes, with what they include."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from virtualrobot_sdk.xml import Element, local_name

from virtualrobot_plugins.importers.refusal import refusal
from virtualrobot_plugins.importers.sdf.elements import Notes, Place, child, flag, pose_matrix, text
from virtualrobot_plugins.importers.sdf.scopes import Frame, LinkElement, Scope, at_placement
from virtualrobot_plugins.importers.uris import join_uri
from virtualrobot_plugins.importers.xml import children, parse_xml

MAX_DEPTH = 32
MAX_MODELS = 10_000

_VERSION = re.compile(r"(\d+)\.(\d+)")
_MODEL_DETAILS = (
    *("static", "pose", "link", "joint", "frame", "model", "include"),
    *("self_collide", "allow_auto_disable", "enable_wind", "meta"),
)
_WORLD_DETAILS = ("model", "include", "frame", "gravity", "magnetic_field", "atmosphere")


@dataclass(slots=True)
class Reader:
    """Reads one document and what it includes.

    Attributes:
        uri: of the document.
        files: the files that have come with it.
        notes: takes warnings.
        needed: names of files that are not among `files` yet.
    """

    uri: str
    files: Mapping[str, bytes | None]
    notes: Notes
    needed: dict[str, None] = field(default_factory=dict)
    _models: int = 0

    def document(self, data: bytes) -> Scope:
        """Return the world of a document; models that stand alone are put into an empty one."""
        root, place = self._root(data, self.uri)
        worlds = list(children(root, "world"))
        for world in worlds[1:]:
            self.notes.warn(place, world, f"only the first world is read, not {world.get('name', '')!r}")
        container = worlds[0] if worlds else root
        scope = Scope("", place, container)
        for element in container.iterchildren("{*}*"):
            kind = local_name(element)
            if kind == "frame":
                self._frame(scope, element)
            elif kind == "model":
                self._nest(scope, self._model(element, place, 0, ()), element)
            elif kind == "include":
                self._include(scope, element, 0, ())
            elif kind not in _WORLD_DETAILS:
                self.notes.leave_out(place, element)
        return scope

    def _root(self, data: bytes, uri: str) -> tuple[Element, Place]:
        root = parse_xml(data, uri, ".sdf", "kernel")
        place = Place(uri, (0, 0))
        if local_name(root) == "robot":
            raise place.error(root, "this is URDF: give the file the ending .urdf")
        if local_name(root) not in ("sdf", "gazebo"):
            raise place.error(root, f"the root element is <{local_name(root)}>, expected <sdf>")
        version = _VERSION.fullmatch(root.get("version", "").strip())
        if version is None or version[1] != "1":
            raise place.error(root, f"version={root.get('version', '')!r}: versions 1.0 to 1.12 are read")
        return root, Place(uri, (int(version[1]), int(version[2])))

    def _model(self, element: Element, place: Place, depth: int, includes: tuple[str, ...]) -> Scope:
        self._models += 1
        if depth > MAX_DEPTH:
            raise place.error(element, f"models are nested more than {MAX_DEPTH} deep")
        if self._models > MAX_MODELS:
            raise place.error(element, f"the world has more than {MAX_MODELS} models")
        name = place.name(element)
        place = place.inside(f"model {name!r}")
        scope = Scope(name, place, element, static=flag(place, element, "static"))
        scope.canonical = element.get("canonical_link", "").strip()
        for part in element.iterchildren("{*}*"):
            kind = local_name(part)
            if kind == "link":
                link = place.name(part)
                self._pose(scope, link, part, "")
                scope.links.append(LinkElement(link, part, place))
            elif kind == "joint":
                joint = place.name(part)
                body = text(part, "child")
                self._pose(scope, joint, part, body, attached_to=body)
                scope.joints.append(LinkElement(joint, part, place))
            elif kind == "frame":
                self._frame(scope, part)
            elif kind == "model":
                self._nest(scope, self._model(part, place, depth + 1, includes), part)
            elif kind == "include":
                self._include(scope, part, depth + 1, includes)
            elif kind not in _MODEL_DETAILS:
                self.notes.leave_out(place, part)
        return scope

    def _pose(self, scope: Scope, name: str, element: Element, default: str, attached_to: str = "") -> None:
        """Add the frame of an element by its <pose>, which counts from the frame `default` when it says nothing."""
        pose = child(element, "pose")
        relative_to = default
        if pose is not None and pose.get("relative_to") is not None:
            relative_to = pose.get("relative_to", "").strip()
        elif pose is not None and pose.get("frame", "").strip():
            self.notes.warn(scope.place, pose, "<pose frame> of SDFormat 1.6 was never defined, and is passed over")
        scope.add(name, Frame(relative_to, pose_matrix(scope.place, pose), element, attached_to))

    def _frame(self, scope: Scope, element: Element) -> None:
        body = element.get("attached_to", "").strip()
        self._pose(scope, scope.place.name(element), element, body, attached_to=body)

    def _nest(self, scope: Scope, model: Scope, element: Element) -> None:
        """Add a model to a scope; `element` (a <model> or <include>) says where it goes."""
        pose = child(element, "pose")
        relative_to = "" if pose is None else pose.get("relative_to", "").strip()
        placement = text(element, "placement_frame") or model.element.get("placement_frame", "").strip()
        place = at_placement(pose_matrix(scope.place, pose), model, placement, element)
        name, number = model.name, 2
        while not scope.name and name in scope.frames:  # real worlds have models of one name
            name, number = f"{model.name}_{number}", number + 1
        if name != model.name:
            self.notes.warn(scope.place, element, f"there is a model {model.name!r} already; this one is {name!r}")
        scope.add(name, Frame(relative_to, place, element))
        scope.nested[name] = model

    def _include(self, scope: Scope, element: Element, depth: int, includes: tuple[str, ...]) -> None:
        place = scope.place
        uri = text(element, "uri").replace("\\", "/").rstrip("/")
        if not uri:
            raise place.error(element, "<include> needs a <uri>")
        name = self._included_file(place, element, join_uri(place.uri, uri) if includes else uri)
        if name is None:
            return
        if name in includes:
            raise place.error(element, f"{name} includes itself")
        data = self.files[name]
        if data is None:
            raise place.error(element, f"the included model {name!r} is nowhere", missing=name)
        root, inner = self._root(data, name)
        models = list(children(root, "model"))
        if len(models) != 1:
            raise refusal(name, f"it is included, so it must hold one model, not {len(models)}")
        model = self._model(models[0], inner, depth + 1, (*includes, name))
        model.name = text(element, "name") or model.name
        model.static = flag(place, element, "static", model.static)
        # The <pose> of the include takes the place of the model's own.
        self._nest(scope, model, models[0] if child(element, "pose") is None else element)

    def _included_file(self, place: Place, element: Element, uri: str) -> str | None:
        """Return the name of the included document; None when files are missing, which are asked for then."""
        if re.search(r"\.(sdf|world|xml)$", uri, re.IGNORECASE):
            return self._known(uri)
        config = self._known(f"{uri}/model.config")
        if config is None:
            return None
        data = self.files[config]
        document = "model.sdf" if data is None else self._newest(data, config)
        return self._known(f"{uri}/{document}")

    def _known(self, name: str) -> str | None:
        if name not in self.files:
            self.needed[name] = None
            return None
        return name

    def _newest(self, data: bytes, uri: str) -> str:
        """Return the name of the document with the newest version of the format that a model.config tells."""
        root = parse_xml(data, uri, ".sdf", "kernel")
        found = [
            (_version_of(document), (document.text or "").strip())
            for document in children(root, "sdf")
            if (document.text or "").strip()
        ]
        return max(found, key=lambda entry: entry[0])[1] if found else "model.sdf"


def _version_of(element: Element) -> tuple[int, int]:
    version = _VERSION.fullmatch(element.get("version", "").strip())
    return (0, 0) if version is None else (int(version[1]), int(version[2]))
