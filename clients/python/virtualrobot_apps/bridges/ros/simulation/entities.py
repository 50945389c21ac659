"""Entities: robots, parts and objects of a world as `simulation_interfaces` knows them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from urllib.parse import parse_qs

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client

from virtualrobot_apps.bridges.ros.frames import world_t_frame
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue, header, matrix_of, pose_of, twist, vector
from virtualrobot_apps.bridges.ros.messages.types import fields, make
from virtualrobot_apps.bridges.ros.messages.values import default
from virtualrobot_apps.bridges.ros.simulation.results import (
    FEATURE_UNSUPPORTED,
    INVALID_POSE,
    NAME_NOT_UNIQUE,
    NAMESPACE_INVALID,
    NO_RESOURCE,
    NOT_FOUND,
    PACKAGE,
    UNSUPPORTED_FORMAT,
    RefusedError,
)

CATEGORIES = {"part": 1, "robot": 2, "object": 5}
"""Categories by kind of node: OBJECT, ROBOT, STATIC_OBJECT; source: simulation_interfaces/msg/EntityCategory."""

_BOX, _CONVEX_HULL, _SPHERE = range(3)
_ANY, _ALL = range(2)
_ENDINGS = {"robot": ".urdf", "sdf": ".sdf", "mujoco": ".xml"}
"""Endings of files by the first element of a text."""

_WORDS = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*")


class Entities:
    """Entities of a kernel's world; each method asks the kernel, and raises RefusedError and VirtualRobotError."""

    def __init__(self, client: Client, *, bare: bool = False) -> None:
        """Know no entity yet; `bare` as in FrameNames."""
        self._client, self._bare = client, bare
        self.spawned: set[str] = set()
        """Names of those that were spawned and not deleted."""

    def kinds(self) -> dict[str, str]:
        """Return the kinds of all entities by name: `robot`, `part` or `object`."""
        return {one.name: one.kind for one in self._client.scene.nodes() if one.kind in CATEGORIES}

    def matching(self, filters: RosValue) -> list[str]:
        """Return the names that pass `EntityFilters`; bounds are compared with boxes along the world's axes."""
        kinds = self.kinds()
        try:
            pattern = re.compile(filters.filter)
        except re.error as error:
            raise RefusedError(NOT_FOUND, f"the filter {filters.filter!r} is no regular expression: {error}") from error
        wanted = {one.category for one in filters.categories}
        found = [
            name
            for name, kind in kinds.items()
            if pattern.search(name) and (not wanted or CATEGORIES[kind] in wanted) and tagged([kind], filters.tags)
        ]
        if not len(filters.bounds.points):
            return found
        region = _region(filters.bounds)
        return [name for name in found if (box := self._world_box(name, kinds[name])) is not None and region(box)]

    def states(self, names: list[str], time: int) -> list[RosValue]:
        """Return where entities are and how fast, as `EntityState` in the world's frame; `time` is in ns."""
        kinds = self.kinds()
        anchors = [self._anchor(name, self._kind(name, kinds)) for name in names]
        if not anchors:
            return []
        poses, twists = self._client.scene.poses(anchors), self._client.scene.twists(*anchors)
        return [
            make(
                f"{PACKAGE}/msg/EntityState",
                header=header(time, "world"),
                pose=pose_of(poses[one]),
                twist=twist(*twists[one].reshape(2, 3).tolist()),
                acceleration=default("geometry_msgs/msg/Accel"),
            )
            for one in anchors
        ]

    def set_state(self, name: str, request: RosValue) -> None:
        """Put an entity somewhere at once; a robot so that its first link is there."""
        kind = self._kind(name)
        if request.set_twist or request.set_acceleration:
            raise RefusedError(FEATURE_UNSUPPORTED, "poses are set; velocities and accelerations follow from forces")
        if not request.set_pose:
            return
        goal = self._in_world(request.state.pose, request.state.header.frame_id)
        scene = self._client.scene
        anchor, parent = self._anchor(name, kind), scene.node(name).parent
        poses = scene.poses([name, anchor, parent])
        world_t_node = goal @ np.linalg.inv(poses[anchor]) @ poses[name]
        scene.set_pose(name, np.linalg.inv(poses[parent]) @ world_t_node)

    def info(self, name: str) -> RosValue:
        """Return an `EntityInfo`: its category, and its kind as a tag."""
        kind = self._kind(name)
        category = make(f"{PACKAGE}/msg/EntityCategory", category=CATEGORIES[kind])
        return make(f"{PACKAGE}/msg/EntityInfo", category=category, description="", tags=[kind])

    def bounds(self, name: str) -> RosValue:
        """Return the `Bounds` about an entity and all below it, a box in its own frame; empty where nothing is."""
        box = self._client.scene.bounds(self._anchor(name, self._kind(name)))
        points = [] if box is None else [vector(*box[1]), vector(*box[0])]
        return make(f"{PACKAGE}/msg/Bounds", type=_BOX, points=points)

    def spawn(self, request: RosValue) -> str:
        """Load a model; return the name that it has got."""
        resource, kinds = getattr(request, "entity_resource", request), self.kinds()  # 1.0 has no field of its own
        name = self._name_for(request, kinds)
        pose = self._in_world(request.initial_pose.pose, request.initial_pose.header.frame_id)
        uri, _, options = resource.uri.partition("?")
        base = (parse_qs(options).get("base") or ["fixed"])[0]
        text = None
        if not uri:
            if not resource.resource_string:
                raise RefusedError(NO_RESOURCE, "'uri' names a model, or 'resource_string' is one")
            text, uri = resource.resource_string, "entity" + _ending(resource.resource_string)
        node = self._client.scene.load(uri, name=name or None, pose=pose, base=base, text=text)
        self.spawned.add(node.name)
        return node.name

    def delete(self, name: str) -> None:
        """Take an entity and all below it out of the world."""
        self._kind(name)
        self._client.scene.remove(name)
        self.spawned.discard(name)

    def delete_spawned(self) -> None:
        """Take away all that were spawned."""
        for name in sorted(self.spawned & set(self.kinds())):
            self._client.scene.remove(name)
        self.spawned.clear()

    def named_poses(self, tags: RosValue) -> list[RosValue]:
        """Return the targets of the world as `NamedPose`; each has the tag `target`."""
        found = self._client.scene.targets() if tagged(["target"], tags) else {}
        poses = self._client.scene.poses([*found]) if found else {}
        return [
            make(f"{PACKAGE}/msg/NamedPose", name=name, description="", tags=["target"], pose=pose_of(poses[name]))
            for name in found
        ]

    def _kind(self, name: str, kinds: Mapping[str, str] | None = None) -> str:
        kinds = self.kinds() if kinds is None else kinds
        if name not in kinds:
            raise RefusedError(NOT_FOUND, f"there is no entity {name!r}; known: {', '.join(kinds) or 'none'}")
        return kinds[name]

    def _anchor(self, name: str, kind: str) -> str:
        """Return the node whose frame is the entity's: of a robot its first link, which a moving base moves."""
        return self._client.robots[name].links[0] if kind == "robot" else name

    def _in_world(self, pose: RosValue, frame: str) -> NDArray[np.float64]:
        """Return `world_t_pose`, 4x4, of a pose in a frame; a quaternion of zeros, as JSON leaves it, turns nothing."""
        try:
            return world_t_frame(self._client, frame, bare=self._bare) @ matrix_of(pose)
        except ValueError as error:
            raise RefusedError(INVALID_POSE, str(error)) from None

    def _name_for(self, request: RosValue, kinds: Mapping[str, str]) -> str:
        """Return the name of what is spawned; empty for that of the model's file."""
        space = request.entity_namespace.strip("/")
        if space and not _WORDS.fullmatch(space):
            raise RefusedError(NAMESPACE_INVALID, f"the namespace {space!r} has other letters than a-z, 0-9, _ and /")
        if space and not request.name:
            raise RefusedError(NAMESPACE_INVALID, "with a namespace an entity needs a name, too")
        name = ".".join(one for one in (space.replace("/", "."), request.name) if one)
        if name not in kinds:
            return name
        if not request.allow_renaming:
            raise RefusedError(NAME_NOT_UNIQUE, f"there is an entity {name!r} already")
        return next(new for number in range(2, len(kinds) + 3) if (new := f"{name}_{number}") not in kinds)

    def _world_box(self, name: str, kind: str) -> NDArray[np.float64] | None:
        """Return the least and greatest x, y, z in the world (2, 3) of an entity; None where it has no shape."""
        anchor = self._anchor(name, kind)
        if (box := self._client.scene.bounds(anchor)) is None:
            return None
        corners = np.array([[box[i, 0], box[j, 1], box[k, 2], 1.0] for i, j, k in product((0, 1), repeat=3)])
        placed = (corners @ self._client.scene.pose(anchor).T)[:, :3]
        return np.array([placed.min(axis=0), placed.max(axis=0)])


def tagged(tags: Sequence[str], wanted: RosValue) -> bool:
    """Return whether these tags pass a `TagsFilter`."""
    told = list(wanted.tags)
    if wanted.filter_mode not in (_ANY, _ALL):
        raise RefusedError(FEATURE_UNSUPPORTED, "'filter_mode' of tags is 0 (any) or 1 (all)")
    return not told or (all if wanted.filter_mode == _ALL else any)(one in tags for one in told)


def _region(bounds: RosValue) -> Callable[[NDArray[np.float64]], bool]:
    """Return a test whether a box (2, 3) in the world overlaps with `Bounds`."""
    points = np.array([[one.x, one.y, one.z] for one in bounds.points])
    if bounds.type not in (_BOX, _SPHERE) or len(points) != 2:
        raise RefusedError(FEATURE_UNSUPPORTED, "'bounds' has two points of a box (type 0) or a sphere (type 2)")
    if bounds.type == _BOX:
        least, greatest = points.min(axis=0), points.max(axis=0)
        return lambda box: bool((box[0] <= greatest).all() and (box[1] >= least).all())
    center, radius = points[0], points[1, 0]
    return lambda box: bool(np.linalg.norm(np.clip(center, box[0], box[1]) - center) <= radius)


def _ending(text: str) -> str:
    """Return the ending of a file with this text, by its first element."""
    found = re.search(r"<([A-Za-z]+)", re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL))
    if found is None or found.group(1) not in _ENDINGS:
        raise RefusedError(UNSUPPORTED_FORMAT, f"'resource_string' begins with one of {', '.join(_ENDINGS)}")
    return _ENDINGS[found.group(1)]


def spawnables(client: Client) -> Iterator[RosValue]:
    """Yield the models that a kernel knows by name, as `Spawnable`."""
    for one in client.models():
        if one.installed or not one.package:
            resource = {"uri": f"model://{one.name}"}
            if not is_first():
                resource = {"entity_resource": make(f"{PACKAGE}/msg/Resource", **resource, resource_string="")}
            bounds = default(f"{PACKAGE}/msg/Bounds")
            yield make(f"{PACKAGE}/msg/Spawnable", **resource, description=one.description, spawn_bounds=bounds)


def is_first() -> bool:
    """Return whether the types are those of version 1.0."""
    return "uri" in fields(f"{PACKAGE}/msg/Spawnable")
