"""URDF read into nodes: the robot first, then its links, parents before children, then its sensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from virtualrobot_sdk.xml import Element, line_of, local_name

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats.files import File
from virtualrobot_kernel.formats.urdf_elements import (
    Palette,
    Place,
    inertial,
    numbers,
    origin,
    primitive,
    text_attribute,
)
from virtualrobot_kernel.formats.urdf_joints import UrdfJoint, read_joints, tree_order
from virtualrobot_kernel.formats.urdf_sensors import read_sensors
from virtualrobot_kernel.formats.urdf_transmissions import read_transmissions
from virtualrobot_kernel.formats.xml import FileWarning, children, malformed, parse_xml, place_in, xacro_in
from virtualrobot_kernel.world.consistency import MOST_NODES
from virtualrobot_kernel.world.figures import Figure, Geometry, Material, Mesh, identity
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, LinkData, NodeSpec, RobotData

BASE_JOINTS = (JointType.FIXED, JointType.FLOATING, JointType.PLANAR)
"""Joint types allowed between a robot and its root link."""

FindMesh = Callable[[str, str, tuple[float, float, float], bool], Mesh]
"""(name, key of the file that names it, scale, whether its own look is seen) -> the mesh, parsed once to test it."""


@dataclass(frozen=True, slots=True)
class UrdfModel:
    """Content of a URDF file: nodes named `robot`, `robot.link` and `robot.sensor`, counts and oddities.

    `name` is the robot's in the world, `own_name` the one that the file gives it.
    """

    name: str
    own_name: str
    nodes: tuple[NodeSpec, ...]
    mesh_count: int
    warnings: tuple[FileWarning, ...]


@dataclass(slots=True)
class _Reader:
    """Reader of one file, with what it has counted and warned of so far."""

    uri: str
    find_mesh: FindMesh
    palette: Palette
    warnings: list[FileWarning]
    mesh_count: int = 0

    def link_figures(self, name: str, link: Element) -> tuple[Figure, ...]:
        """Return the shapes of a link in the order of the file."""
        elements = link.iterchildren("visual", "collision")
        figures = (self._figure(Place(self.uri, f"link {name!r}", self.warnings), element) for element in elements)
        return tuple(figure for figure in figures if figure is not None)

    def _figure(self, place: Place, element: Element) -> Figure | None:
        """Return the shape of a <visual> or <collision>, or None for one without extent."""
        visual = local_name(element) == "visual"
        geometry = element.find("geometry")
        shapes = [] if geometry is None else list(geometry)
        if not shapes:
            raise place.error(element, f"<{local_name(element)}> needs a <geometry> with a shape")
        color = self.palette.color_of(place, element) if visual else None
        shape = self._geometry(place, shapes[0], visual and color is None)
        if shape is None:
            message = f"this <{local_name(shapes[0])}> has no extent and is left out"
            place.warn(shapes[0], message)
            return None
        return Figure(
            shape,
            origin(place, element),
            None if color is None else Material(color),
            visual=visual,
            collision=not visual,
        )

    def _geometry(self, place: Place, shape: Element, look: bool) -> Geometry | None:
        if local_name(shape) != "mesh":
            return primitive(place, shape)
        filename = text_attribute(place, shape, "filename")
        x, y, z = numbers(place, shape, "scale", 3, (1.0, 1.0, 1.0))
        if 0.0 in (x, y, z):
            raise place.error(shape, f"scale {x:g} {y:g} {z:g}: no factor may be 0")
        try:
            mesh = self.find_mesh(filename, self.uri, (x, y, z), look)
        except KernelError as error:
            raise error.at(place_in(self.uri, line_of(shape), place.path)) from error
        self.mesh_count += 1
        return mesh


def read_urdf(
    file: File, find_mesh: FindMesh, choose_name: Callable[[str], str], base_joint: JointType = JointType.FIXED
) -> UrdfModel:
    """Return the robot that a URDF file describes.

    The robot is called what `choose_name` makes of the name in the file. Its root link hangs below it by a joint of
    type `base_joint` (one of BASE_JOINTS).

    Raises:
        MalformedFileError: naming file, line and element, for whatever is no URDF.
        MissingFileError: for a mesh that is nowhere, naming each place that was tried.
    """
    root = parse_xml(file.data, file.key)
    _refuse_xacro(file.key, root)
    if local_name(root) != "robot":
        raise malformed(file.key, line_of(root), f"the root element is <{local_name(root)}>, expected <robot>")
    warnings: list[FileWarning] = []
    palette = Palette(file.key, warnings)
    for element in [*children(root, "material"), *root.iterfind("link/visual/material")]:
        palette.learn(element)
    reader = _Reader(file.key, find_mesh, palette, warnings)
    links: dict[str, Element] = {}
    for element in children(root, "link"):
        name = text_attribute(Place(file.key, "link"), element, "name")
        if name in links:
            taken = f"the name is taken by the link on line {line_of(links[name])}"
            raise malformed(file.key, line_of(element), taken, f"link {name!r}")
        links[name] = element
    if len(links) >= MOST_NODES:
        told = f"{place_in(file.key, None)}: the robot has {len(links)} links; a world has at most {MOST_NODES} nodes"
        raise KernelError(told, reason=Reason.TOO_LARGE, limit=MOST_NODES)
    if not links:
        raise malformed(file.key, line_of(root), "the robot has no link")
    joints = read_joints(file.key, root, warnings)
    order = tree_order(file.key, {name: line_of(element) for name, element in links.items()}, joints)
    own_name = root.get("name", "").strip()
    robot = choose_name(own_name)
    base = Joint(_free_name("base", joints), base_joint, axis=(0.0, 0.0, 1.0))
    actuators = read_transmissions(file.key, root, [joint.joint for joint in joints], warnings)
    nodes = [NodeSpec(robot, Kind.ROBOT, data=RobotData(source=file.key, actuators=actuators))]
    for name, joint in order:
        nodes.append(_link_node(reader, robot, name, links[name], joint, base))
    child_of = {joint.joint.name: joint.child for joint in joints}
    nodes += read_sensors(file.key, root, robot, list(links), child_of, warnings)
    return UrdfModel(robot, own_name, tuple(nodes), reader.mesh_count, tuple(warnings))


def _link_node(
    reader: _Reader, robot: str, name: str, link: Element, before: UrdfJoint | None, base: Joint
) -> NodeSpec:
    return NodeSpec(
        f"{robot}.{name}",
        Kind.LINK,
        robot if before is None else f"{robot}.{before.parent}",
        identity() if before is None else before.parent_t_joint,
        figures=reader.link_figures(name, link),
        data=LinkData(
            base if before is None else before.joint,
            inertial(Place(reader.uri, f"link {name!r}", reader.warnings), link),
        ),
    )


def _free_name(name: str, joints: Sequence[UrdfJoint]) -> str:
    """Return `name`, with underscores behind it while a joint has that name."""
    taken = {joint.joint.name for joint in joints}
    while name in taken:
        name += "_"
    return name


def _refuse_xacro(uri: str, root: Element) -> None:
    found = xacro_in(root)
    if found is not None:
        element, what = found
        raise malformed(
            uri,
            line_of(element),
            f"{what} is xacro, and no importer for xacro is there: expand the file first "
            "(xacro model.xacro > model.urdf)",
        )
