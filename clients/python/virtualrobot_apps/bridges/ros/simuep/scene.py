"""Scene files of SimUEP-Robotics as scene files of a kernel, with the topics that they name.

The document (A Robotics Framework for Planning the Offshore Robotizing Using Virtual Reality Techniques, OTC Brasil
2013) shows the element `robots` (figure 3), and names the others and their properties in words (section 3D Scene
Description); their attributes are spelled here as those of the figure are. Positions are in meters, rotations are roll,
pitch and yaw in radians, as in the URDF of its table 2, and z goes up.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import virtualrobot
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import quaternion_of

from virtualrobot_apps.bridges.ros.simuep.elements import Element, read_elements

SERVICES = ("draw3DLines", "enableSensor", "cameraInfo")
ACTUATORS = ("joint", "pose")
SENSORS = ("joint", "collision", "proximity", "laser", "camera")
LIGHTS = {"point": "LIGHT_KIND_POINT", "spot": "LIGHT_KIND_SPOT", "directional": "LIGHT_KIND_DIRECTIONAL"}
SHADOWS = ("none", "hard", "soft")
ENGINE = "mujoco"
"""Component that moves parts by forces, where a scene has some with a mass."""

_PARTS = ("displaySettings", "physicsSettings", "observer", "lights", "envObjects", "robots")
_TICK_SECONDS = 0.004
_MOST_SUBSTEPS = 1000
_ZERO, _ONE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class NamedTopic:
    """A topic of one robot.

    Attributes:
        kind: of ACTUATORS or SENSORS.
        name: its own, without the prefix and the robot.
        sensor: name of the laser or camera; empty for other kinds.
        place: where the file says it.
    """

    kind: str
    name: str
    sensor: str
    place: Element


@dataclass(frozen=True)
class RobotTopics:
    """Topics of a robot: what it hears (`joint`, `pose`) and what it tells."""

    robot: str
    actuators: Sequence[NamedTopic] = ()
    sensors: Sequence[NamedTopic] = ()


@dataclass
class SimuepScene:
    """Contents of a scene file.

    Attributes:
        scene: the message SceneFile in protobuf's JSON mapping.
        prefix: first part of all topics and services.
        services: names of services by their kinds.
        robots: topics of each robot.
        observer: pose of the eyes (4x4), which look along x; None where the file doesn't say it.
        left_out: in words, with lines, what has no place in a kernel's world.
    """

    scene: dict[str, Any] = field(default_factory=dict)
    prefix: str = ""
    services: dict[str, str] = field(default_factory=dict)
    robots: list[RobotTopics] = field(default_factory=list)
    observer: NDArray[np.float64] | None = None
    left_out: list[str] = field(default_factory=list)


def read_scene(file: Path) -> SimuepScene:
    """Return what a scene file says; the files that it names count from its folder.

    Raises:
        MissingFileError: when the file can't be read.
        MalformedFileError: for anything in it that is wrong, with its line.
    """
    return scene_of(read_elements(file))


def scene_of(root: Element) -> SimuepScene:
    """Return what the root element of a scene file says; raises MalformedFileError as `read_scene` does."""
    parts = [root] if root.tag == "robots" else root.children  # figure 3 of the document is a file, too
    if root.tag != "robots":
        root.check(("name", "version"), _PARTS)
    found = SimuepScene({"schema_version": 1, "nodes": [], "models": []})
    substeps = 0
    for part in parts:
        match part.tag:
            case "displaySettings":
                found.left_out.append(f"{part.file}:{part.line}: <displaySettings> is for walls and headsets")
            case "physicsSettings":
                substeps = _physics(part, found)
            case "observer":
                found.observer = _observer(part)
            case "lights":
                part.check((), ("light",))
                found.scene["nodes"] += [_light(one, number) for number, one in enumerate(part.all("light"), 1)]
            case "envObjects":
                part.check((), ("envObject",))
                for one in part.all("envObject"):
                    found.scene["nodes"].append(_object(one))
            case _:
                _robots(part, found)
    if any(one.get("part", {}).get("dynamic") for one in found.scene["nodes"]):
        found.scene.setdefault("physics", {})["engine"] = ENGINE
        if substeps:
            found.scene["physics"]["substeps"] = substeps
    return found


def _physics(one: Element, found: SimuepScene) -> int:
    """Take gravity; return how many steps of the engine make a tick."""
    one.check(("updateFrequency", "gravity"))
    found.scene["physics"] = {"gravity": _vector(one.vector("gravity", (0.0, 0.0, -9.81)))}
    frequency = one.number("updateFrequency", 0.0, 0.0)
    return min(max(1, round(frequency * _TICK_SECONDS)), _MOST_SUBSTEPS) if frequency else 0


def _observer(one: Element) -> NDArray[np.float64]:
    one.check(("height", "speed"), ("transform",))
    one.number("speed", 0.0, 0.0)  # viewers have speeds of their own
    pose = _transform(one)
    pose[2, 3] += one.number("height", 0.0)
    return pose


def _light(one: Element, number: int) -> dict[str, Any]:
    one.check(("name", "type", "color", "intensity", "angle", "shadow"), ("transform",))
    kind = one.one_of("type", LIGHTS, "point")
    light: dict[str, Any] = {"kind": LIGHTS[kind], "color": _color(one, "color", _ONE)}
    if intensity := one.number("intensity", 0.0, 0.0):
        light["intensity"] = intensity
    if "angle" in one.attributes:
        if kind != "spot":
            raise one.error("'angle' is that of a spot, from edge to edge")
        light["cone_angle_radians"] = one.number("angle", 1.0, 0.0) / 2.0
    if one.one_of("shadow", SHADOWS, "hard") == "none":
        light["shadowless"] = True
    # The document's Unity shines along z, as the kernel does.
    return {"name": one.attributes.get("name") or f"light {number}", **_placed(_transform(one)), "light": light}


def _object(one: Element) -> dict[str, Any]:
    one.check(("name",), ("transform", "boundingBox", "mesh", "physics", "material"))
    box, mesh, material = one.child("boundingBox"), one.child("mesh"), _material(one.child("material"))
    scale = _scale(one)
    figures: list[dict[str, Any]] = []
    if mesh is not None:
        mesh.check(("fileName",))
        figures.append({"mesh": {"uri": mesh.text("fileName"), "scale": _vector(scale)}, **material})
    if box is not None:
        box.check(("center", "size"))
        size = np.multiply(box.vector("size", _ONE), np.abs(scale))
        if not (size > 0.0).all():
            raise box.error(f"'size' has edges above 0, not {size.tolist()}")
        center = {"position": _vector(np.multiply(box.vector("center", _ZERO), scale))}
        figures.append({"box": {"size": _vector(size)}, "node_t_figure": center, **material})
        if mesh is not None:  # as in the document's engine the mesh is seen, and its box collides
            figures[0]["roles"], figures[1]["roles"] = ["FIGURE_ROLE_VISUAL"], ["FIGURE_ROLE_COLLISION"]
    if not figures:
        raise one.error("it needs a <mesh> or a <boundingBox>")
    node = {"name": one.text("name"), **_placed(_transform(one)), "figures": figures}
    physics = one.child("physics")
    if physics is None:
        return node | {"object": {}}
    physics.check(("mass", "inertia"))
    mass = physics.number("mass", 0.0, 0.0)
    if not mass:
        return node | {"object": {}}
    part: dict[str, Any] = {"mass_kilograms": mass, "dynamic": True}
    if "inertia" in physics.attributes:
        matrix = np.reshape(physics.vector("inertia", (0.0,) * 9), (3, 3))
        if not np.array_equal(matrix, matrix.T) or np.linalg.eigvalsh(matrix)[0] <= 0.0:
            raise physics.error("'inertia' is a symmetric matrix row by row (kg m^2), whose moments are above 0")
        products = _vector((matrix[0, 1], matrix[0, 2], matrix[1, 2]))
        inertial = {"mass_kilograms": mass, "diagonal": _vector(np.diagonal(matrix)), "products": products}
        part["inertial"] = inertial
    return node | {"part": part}


def _material(one: Element | None) -> dict[str, Any]:
    if one is None:
        return {}
    one.check(("color", "friction", "bounciness"))
    found: dict[str, Any] = {}
    if "color" in one.attributes:
        found["color"] = _color(one, "color", _ONE)
    if "friction" in one.attributes:
        found["friction"] = one.number("friction", 0.5, 0.0)
    if "bounciness" in one.attributes:
        found["restitution"] = one.number("bounciness", 0.0, 0.0)
        if found["restitution"] > 1.0:
            raise one.error(f"'bounciness' is 0 to 1, not {found['restitution']:g}")
    return {"material": found}


def _robots(part: Element, found: SimuepScene) -> None:
    part.check(("prefix",), ("services", "robot"))
    found.prefix = part.attributes.get("prefix", found.prefix)
    services = part.child("services")
    if services is not None:
        services.check((), SERVICES)
        for one in services.children:
            one.check(("name",))
            if one.tag in found.services:
                raise one.error("the service stands here twice")
            found.services[one.tag] = one.text("name")
    for robot in part.all("robot"):
        robot.check(("name",), ("urdf", "transform", "actuators", "sensors"))
        name, urdf = robot.text("name"), robot.child("urdf")
        if urdf is None:
            raise robot.error("the element <urdf> is missing")
        urdf.check(("fileName",))
        if _scale(robot) != _ONE:
            raise robot.error("'scale' of a robot is 1 1 1 here: its URDF tells its sizes")
        found.scene["models"].append({"uri": urdf.text("fileName"), "name": name, **_placed(_transform(robot))})
        topics = RobotTopics(
            name,
            tuple(_topics(robot.child("actuators"), ACTUATORS, found)),
            tuple(_topics(robot.child("sensors"), SENSORS, found)),
        )
        found.robots.append(topics)
        sensors = robot.child("sensors")
        for one in sensors.children if sensors else ():
            if one.tag in ("collision", "proximity"):
                found.scene["nodes"].append(_feeling(name, one))


def _topics(part: Element | None, known: Sequence[str], found: SimuepScene) -> Iterator[NamedTopic]:
    if part is None:
        return
    part.check((), known)
    seen: set[tuple[str, str]] = set()
    for one in part.children:
        more = {"proximity": ("range",), "collision": ("precision",)}.get(one.tag, ())
        one.check(("name",) if one.tag in ("laser", "camera") else (), ("topicName", *more))
        sensor = one.text("name") if one.tag in ("laser", "camera") else ""
        if (one.tag, sensor) in seen:
            raise one.error("it stands here twice")
        seen.add((one.tag, sensor))
        if precision := one.child("precision"):
            precision.check(("mode", "defaultValue"))
            words = "<precision> of a collision sensor: points are exact here, up to 64 of a pair"
            found.left_out.append(f"{precision.file}:{precision.line}: {words}")
        topic = one.child("topicName")
        if topic is None:
            raise one.error("the element <topicName> is missing")
        topic.check(("name",))
        yield NamedTopic(one.tag, topic.text("name"), sensor, topic)


def _feeling(robot: str, one: Element) -> dict[str, Any]:
    """Return the contact sensor of a robot: near things for `proximity`, points that touch for `collision`."""
    sensor: dict[str, Any] = {"watched": robot}
    if one.tag == "proximity":
        reach = one.child("range")
        if reach is None:
            raise one.error("the element <range> is missing")
        reach.check(("value",))
        reach.text("value")
        sensor["range_meters"] = reach.number("value", 0.0, 0.0)
    return {"name": feeling_name(robot, one.tag), "parent": robot, "contact_sensor": sensor}


def feeling_name(robot: str, kind: str) -> str:
    """Return the name of a robot's contact sensor."""
    return f"{robot}.{kind}"


def _transform(one: Element) -> NDArray[np.float64]:
    """Return the pose of an element, 4x4; without a transform it is at the origin."""
    found = one.child("transform")
    if found is None:
        return np.eye(4)
    found.check(("position", "rotation", "scale"))
    try:
        return virtualrobot.pose(*found.vector("position", _ZERO), *found.vector("rotation", _ZERO))
    except InvalidArgumentError as error:
        raise found.error(str(error)) from error


def _scale(one: Element) -> tuple[float, ...]:
    found = one.child("transform")
    scale = _ONE if found is None else found.vector("scale", _ONE)
    if found is not None and 0.0 in scale:
        raise found.error("'scale' has three factors other than 0")
    return scale


def _placed(pose: NDArray[np.float64]) -> dict[str, Any]:
    x, y, z, w = quaternion_of(pose)
    turned = {"x": float(x), "y": float(y), "z": float(z), "w": float(w)}
    return {"parent_t_node": {"position": _vector(pose[:3, 3]), "orientation": turned}}


def _vector(values: Sequence[float] | NDArray[np.float64]) -> dict[str, float]:
    return dict(zip("xyz", map(float, values), strict=True))


def _color(one: Element, name: str, default: tuple[float, ...]) -> dict[str, float]:
    parts = one.vector(name, default)
    if not all(0.0 <= part <= 1.0 for part in parts):
        raise one.error(f"{name!r} has red, green and blue in parts of 0 to 1")
    return dict(zip(("red", "green", "blue"), parts, strict=True))
