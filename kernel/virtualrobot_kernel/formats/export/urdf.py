"""Robot's tree written as URDF text. Format: http://wiki.ros.org/urdf/XML."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]  compiled, and has no types
from numpy.typing import NDArray
from virtualrobot_sdk.xml import Element

from virtualrobot_kernel.formats.export.mesh_files import MeshFiles
from virtualrobot_kernel.formats.export.robot_tree import Mount, RobotTree, TreeLink
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Figure, Mesh, Pose, Sphere
from virtualrobot_kernel.world.structure import Inertial, Joint, JointLimits, JointType

Color = tuple[float, float, float, float]


def write_urdf(tree: RobotTree, files: MeshFiles) -> bytes:
    """Return the URDF file of a robot; meshes go to `files`.

    Numbers are written to the last bit. A material is written wherever it is used, since not all programs look for
    one by its name.
    """
    robot = etree.Element("robot", name=tree.name)
    materials: dict[Color, str] = {}
    for link in tree.links:
        element = etree.SubElement(robot, "link", name=link.name)
        if link.inertial is not None:
            _inertial(element, link.inertial)
        for figure in link.figures:
            if figure.visual:
                _figure(element, "visual", figure, files, materials)
            if figure.collision:
                _figure(element, "collision", figure, files, materials)
    for link in tree.links:
        if link.mount is not None:
            _joint(robot, link, link.mount)
    etree.indent(robot)
    return etree.tostring(robot, xml_declaration=True, encoding="utf-8") + b"\n"


def roll_pitch_yaw(rotation: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return roll, pitch, yaw of R = Rz(yaw) Ry(pitch) Rx(roll), shape (3, 3), in radians.

    Roll is taken from Rz(-yaw) R, so that it makes up for the yaw that is chosen where only their sum or difference
    counts, at a pitch of a quarter turn, and near it.
    """
    yaw = math.atan2(rotation[1, 0], rotation[0, 0])
    cos, sin = math.cos(yaw), math.sin(yaw)
    pitch = math.atan2(-rotation[2, 0], cos * rotation[0, 0] + sin * rotation[1, 0])
    roll = math.atan2(sin * rotation[0, 2] - cos * rotation[1, 2], cos * rotation[1, 1] - sin * rotation[0, 1])
    return roll, pitch, yaw


def _inertial(link: Element, inertial: Inertial) -> None:
    element = etree.SubElement(link, "inertial")
    _origin(element, inertial.link_t_inertial)
    etree.SubElement(element, "mass", value=_number(inertial.mass))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    moments = dict(zip(names, map(_number, (*inertial.diagonal, *inertial.products)), strict=True))
    etree.SubElement(element, "inertia", **moments)


def _figure(link: Element, role: str, figure: Figure, files: MeshFiles, materials: dict[Color, str]) -> None:
    element = etree.SubElement(link, role)
    _origin(element, figure.node_t_figure)
    shape = etree.SubElement(element, "geometry")
    match figure.geometry:
        case Box(size):
            etree.SubElement(shape, "box", size=_numbers(size))
        case Sphere(radius):
            etree.SubElement(shape, "sphere", radius=_number(radius))
        case Cylinder(radius, length):
            etree.SubElement(shape, "cylinder", radius=_number(radius), length=_number(length))
        case Cone() | Capsule() | Mesh() as geometry:
            mesh = etree.SubElement(shape, "mesh", filename=files.path(geometry))
            if isinstance(geometry, Mesh) and geometry.scale != (1.0, 1.0, 1.0):
                mesh.set("scale", _numbers(geometry.scale))
    color = figure.material.color if figure.material else None
    if role == "visual" and color is not None:
        name = materials.setdefault(color, f"material_{len(materials) + 1}")
        etree.SubElement(etree.SubElement(element, "material", name=name), "color", rgba=_numbers(color))


def _joint(robot: Element, link: TreeLink, mount: Mount) -> None:
    joint = mount.joint
    element = etree.SubElement(robot, "joint", name=joint.name, type=joint.type.value[0])
    _origin(element, mount.parent_t_joint)
    etree.SubElement(element, "parent", link=mount.parent)
    etree.SubElement(element, "child", link=link.name)
    if joint.type not in (JointType.FIXED, JointType.FLOATING):
        etree.SubElement(element, "axis", xyz=_numbers(joint.axis))
    if joint.type is not JointType.FIXED:
        _limit(element, joint)
    if joint.mimic is not None:
        mimic = joint.mimic
        numbers = {"multiplier": _number(mimic.multiplier), "offset": _number(mimic.offset)}
        etree.SubElement(element, "mimic", joint=mimic.joint, **numbers)


def _limit(element: Element, joint: Joint) -> None:
    """Write the limits; those that URDF would assume for a floating or planar joint are left out."""
    limits = joint.limits
    rates = {"effort": _number(limits.effort), "velocity": _number(limits.velocity)}
    if joint.type in (JointType.REVOLUTE, JointType.PRISMATIC):
        etree.SubElement(element, "limit", lower=_number(limits.lower), upper=_number(limits.upper), **rates)
    elif joint.type is JointType.CONTINUOUS or limits != JointLimits():
        etree.SubElement(element, "limit", **rates)


def _origin(element: Element, pose: Pose) -> None:
    """Write where something is, unless it is at the origin."""
    if not np.array_equal(pose, np.eye(4)):
        etree.SubElement(element, "origin", xyz=_numbers(pose[:3, 3]), rpy=_numbers(roll_pitch_yaw(pose[:3, :3])))


def _numbers(values: Iterable[float]) -> str:
    return " ".join(map(_number, values))


def _number(value: float) -> str:
    """Return the shortest text that reads back to the same number."""
    return repr(float(value) + 0.0).removesuffix(".0")
