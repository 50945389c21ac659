"""Structure of the world: a tree of frozen nodes, and the flat forest that one compiled pass walks.

A node's row is its place in every per-node array. Rows follow the order of uids, which is that of creation; a removal
closes the gap.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import UnknownNameError
from virtualrobot_kernel.world.about import About
from virtualrobot_kernel.world.craft_data import Craft
from virtualrobot_kernel.world.figures import Figure, Pose, identity
from virtualrobot_kernel.world.motors import JointMotor
from virtualrobot_kernel.world.sensing import CameraSensor, ContactSensor, Light, MotionSensor, RangeSensor

WORLD_UID = 1
WORLD_NAME = "world"
AUTOMATIC_KINEMATICS = ""
"""Kinematics of a robot that names no component: one is chosen by its geometry, and a saved scene keeps it open."""


class Kind(Enum):
    """Kind of a node; the value is its word in error messages."""

    WORLD = "world"
    OBJECT = "object"
    PART = "part"
    ROBOT = "robot"
    LINK = "link"
    ADAPTER = "adapter"
    TOOL = "tool"
    ANNOTATION = "annotation"
    RANGE_SENSOR = "range_sensor"
    CAMERA_SENSOR = "camera_sensor"
    CONTACT_SENSOR = "contact_sensor"
    MOTION_SENSOR = "motion_sensor"
    LIGHT = "light"
    TARGET = "target"
    VIEWPOINT = "viewpoint"


FOR_PEOPLE = frozenset({Kind.ANNOTATION, Kind.TARGET, Kind.VIEWPOINT})
"""Kinds of nodes whose figures people alone see: no sensor does, and nothing collides with them."""


class JointType(Enum):
    """Type of a joint, as in URDF; the value is (name, code of the compiled pass, coordinates, count of velocities).

    Coordinates are named by what follows the joint's name.
    """

    FIXED = ("fixed", 0, (), 0)
    REVOLUTE = ("revolute", 1, ("",), 1)
    CONTINUOUS = ("continuous", 1, ("",), 1)
    PRISMATIC = ("prismatic", 2, ("",), 1)
    FLOATING = ("floating", 3, ("/x", "/y", "/z", "/qx", "/qy", "/qz", "/qw"), 6)
    PLANAR = ("planar", 4, ("/x", "/y", "/theta"), 3)

    @property
    def code(self) -> int:
        """Return the code that the compiled pass knows."""
        return self.value[1]

    @property
    def coordinate_count(self) -> int:
        """Return the count of coordinates (nq)."""
        return len(self.value[2])

    @property
    def velocity_count(self) -> int:
        """Return the count of velocities (nv)."""
        return self.value[3]


COUNTS = {kind.code: kind.coordinate_count for kind in JointType}
"""Count of coordinates by the code of the compiled pass."""


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Limits of a joint: radians or meters, per second, s^2, s^3; effort in N m or N.

    Infinite positions mean no limit; an effort of 0 means unknown. Speed, acceleration and jerk are always positive.
    """

    lower: float = -np.inf
    upper: float = np.inf
    velocity: float = 2.0
    acceleration: float = 8.0
    jerk: float = 80.0
    effort: float = 0.0


@dataclass(frozen=True, slots=True)
class Mimic:
    """Mimic joint: position = multiplier * position of `joint` + offset."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Joint:
    """Joint before a link; `axis` is a unit vector in the joint's frame."""

    name: str
    type: JointType = JointType.FIXED
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    limits: JointLimits = JointLimits()
    mimic: Mimic | None = None

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Return the names of its coordinates: its own, or of several `base/x` and so on."""
        return tuple(self.name + suffix for suffix in self.type.value[2])


@dataclass(frozen=True, slots=True, eq=False)
class Inertial:
    """Inertial of a link, tool or part: its mass in kg, and how it is spread.

    `link_t_inertial` is the pose of the inertial frame in the node's; its origin is the centre of mass. The inertia is
    (xx, yy, zz) and (xy, xz, yz) in kg m^2 in that frame.
    """

    mass: float
    link_t_inertial: Pose = field(default_factory=identity)
    diagonal: tuple[float, float, float] = (0.0, 0.0, 0.0)
    products: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class PartData:
    """Data of a part; a mass of 0 kg means unknown, and `inertial` (of the same mass) is its distribution.

    One that is `dynamic` moves by forces wherever the world has an engine for them, unless what it hangs on moves it.
    """

    mass: float = 0.0
    inertial: Inertial | None = None
    dynamic: bool = False


@dataclass(frozen=True, slots=True)
class JointGroup:
    """Joints of a robot with a common name; between `base_link` and `tip_link` (as in LinkPair), where given, a chain.

    Such a group needs no `joint_names`. `kinematics` is the component that solves it, and what its settings are.
    """

    name: str
    joint_names: tuple[str, ...] = ()
    base_link: str = ""
    tip_link: str = ""
    kinematics: str = AUTOMATIC_KINEMATICS
    kinematics_settings: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class LinkPair:
    """Pair of a robot's links that may touch, by their names without the robot's, and the reason."""

    first: str
    second: str
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Actuator:
    """Actuator of a robot: its position is `offset` and the sum of ratio times joint, in a unit of its own.

    `terms` are (joint, ratio), the ratio in that unit per radian or meter.
    """

    name: str
    terms: tuple[tuple[str, float], ...]
    offset: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf


@dataclass(frozen=True, slots=True)
class RobotData:
    """Data of a robot; an empty flange means the last link before the robot branches into moving parts.

    `kinematics_settings` are plain values as JSON has them; the component `kinematics` says what they may be. One
    that is `dynamic` moves by forces wherever the world has an engine for them: its base by what pushes it, its joints
    by `motors`, each the usual one where it is not named. Without `payload_kilograms` nobody has told how much it may
    carry.
    """

    flange: str = ""
    kinematics: str = AUTOMATIC_KINEMATICS
    postures: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    source: str = ""
    kinematics_settings: Mapping[str, Any] = field(default_factory=dict)
    groups: tuple[JointGroup, ...] = ()
    allowed_collisions: tuple[LinkPair, ...] = ()
    actuators: tuple[Actuator, ...] = ()
    craft: Craft | None = None
    dynamic: bool = False
    motors: tuple[JointMotor, ...] = ()
    payload_kilograms: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class LinkData:
    """Data of a link."""

    joint: Joint
    inertial: Inertial | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ToolWidth:
    """Width of a tool's opening in meters, and the joint positions there, radians or meters by name."""

    width: float
    joint_positions: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class ToolData:
    """Data of a tool: poses `tool_t_tcp` by name and joint positions by state; the first ones are the default.

    Without `inertial` the mass is unknown. `widths` rise; a tool that does not open has none.
    """

    tool_center_points: Mapping[str, Pose] = field(default_factory=lambda: {"tcp": identity()})
    states: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    inertial: Inertial | None = None
    widths: tuple[ToolWidth, ...] = ()


@dataclass(frozen=True, slots=True)
class TargetData:
    """Data of a target: the robot that it was taught with and its joint positions then; all empty: by nobody.

    `tool` and `tool_center_point` are what the robot worked with, for people.
    """

    robot: str = ""
    tool: str = ""
    tool_center_point: str = ""
    joint_positions: Mapping[str, float] = field(default_factory=dict)


LEAST_FIELD, GREATEST_FIELD = 0.01, 3.0
"""Fields of view of people, in radians."""
LEAST_DISTANCE = 1e-6
"""Least distance of an eye from what it looks at, in meters."""


@dataclass(frozen=True, slots=True)
class ViewpointData:
    """Data of a viewpoint: how far ahead (m) along z is what is looked at, and the vertical field of view (rad)."""

    distance: float = 1.0
    field_of_view: float = 0.9


NodeData = (
    PartData
    | RobotData
    | LinkData
    | ToolData
    | RangeSensor
    | CameraSensor
    | ContactSensor
    | MotionSensor
    | Light
    | TargetData
    | ViewpointData
    | None
)


@dataclass(frozen=True, slots=True, eq=False)
class NodeSpec:
    """Node to create, as importers and clients give it. `running`: a sensor that runs from the start."""

    name: str
    kind: Kind
    parent: str = WORLD_NAME
    parent_t_node: Pose = field(default_factory=identity)
    hidden: bool = False
    figures: tuple[Figure, ...] = ()
    data: NodeData = None
    running: bool = False
    about: About | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """Element of the tree; its pose is state. `parent` is a uid; 0 for the root. `about` is None for nothing said."""

    uid: int
    name: str
    kind: Kind
    parent: int
    hidden: bool = False
    figures: tuple[Figure, ...] = ()
    data: NodeData = None
    about: About | None = None

    @property
    def is_moved(self) -> bool:
        """True for a link that a joint moves against its parent."""
        return isinstance(self.data, LinkData) and self.data.joint.type is not JointType.FIXED


class Coordinate(NamedTuple):
    """Coordinate that can be moved by itself: a joint, or one of the coordinates of a planar or floating joint.

    joint: the joint, or the one of a single coordinate that it is like, such as the prismatic joint `base/x`. place:
    which of the robot's joints it is of. q, v: where it is among all coordinates and velocities; the components of a
    quaternion have the angular velocity about x, y and z, and -1 for w.
    """

    joint: Joint
    place: int
    q: int
    v: int


@dataclass(frozen=True, slots=True, eq=False)
class RobotIndex:
    """Places of a robot's joints in the arrays; joints in the order of creation, mimic and fixed ones left out.

    `flange` is the uid of the node that tools are mounted on; `links` are uids. `coordinates` are all by name.
    """

    uid: int
    flange: int
    links: tuple[int, ...]
    joints: tuple[Joint, ...]
    q_start: tuple[int, ...]
    v_start: tuple[int, ...]
    coordinates: Mapping[str, Coordinate] = field(init=False)
    q_slice: slice = field(init=False)
    """Places of the robot's coordinates in q; they lie side by side."""
    v_slice: slice = field(init=False)
    """Places of its velocities in v."""

    def __post_init__(self) -> None:
        """Name the coordinates; where a joint is called as another one's coordinate, the name is the joint's."""
        q = sum(joint.type.coordinate_count for joint in self.joints)
        v = sum(joint.type.velocity_count for joint in self.joints)
        object.__setattr__(self, "q_slice", slice(self.q_start[0], self.q_start[0] + q) if q else slice(0, 0))
        object.__setattr__(self, "v_slice", slice(self.v_start[0], self.v_start[0] + v) if v else slice(0, 0))
        found = [one for place in range(len(self.joints)) for one in self._coordinates_of(place)]
        whole = [one for one in found if one.joint is self.joints[one.place]]
        object.__setattr__(self, "coordinates", {one.joint.name: one for one in (*found, *whole)})

    def _coordinates_of(self, place: int) -> Iterator[Coordinate]:
        joint, q, v = self.joints[place], self.q_start[place], self.v_start[place]
        if joint.type.coordinate_count == 1:
            yield Coordinate(joint, place, q, v)
            return
        limits = replace(joint.limits, lower=-math.inf, upper=math.inf)
        for at, name in enumerate(joint.coordinate_names):
            kind = JointType.PRISMATIC if name[-2:] in ("/x", "/y", "/z") else JointType.CONTINUOUS
            yield Coordinate(Joint(name, kind, limits=limits), place, q + at, v + at if at < 6 else -1)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Return the names of the joints that can be moved."""
        return tuple(joint.name for joint in self.joints)

    def joint_of(self, coordinate: str) -> str:
        """Return the name of the joint that a coordinate is of."""
        return self.joints[self.coordinates[coordinate].place].name

    def coordinates_of(self, joints: Collection[str]) -> tuple[str, ...]:
        """Return the names of the coordinates of some joints, in the robot's order."""
        return tuple(name for joint in self.joints if joint.name in joints for name in joint.coordinate_names)


@dataclass(frozen=True, slots=True, eq=False)
class Forest:
    """Tree as flat arrays, a row for each node (see `numeric.forest.forward_forest`)."""

    order: NDArray[np.int32]
    parent: NDArray[np.int32]
    joint_type: NDArray[np.int8]
    axis: NDArray[np.float64]
    q_index: NDArray[np.int32]
    multiplier: NDArray[np.float64]
    offset: NDArray[np.float64]


def robots_of_tool(nodes: Mapping[int, Node], tool: int) -> Iterator[int]:
    """Yield the robots (uids) whose tool it is: the nearest above it, its owner, and on as far as it is fixed to them.

    What no joint moves against a robot's own frame is a tool of what that robot hangs on, too: so the tool of a gripper
    at an arm's flange is the arm's, and the tool of an arm is not that of the rail below.
    """
    at, moved = nodes.get(nodes[tool].parent), False
    while at is not None:
        if at.kind is Kind.ROBOT:
            yield at.uid
            if moved:
                return
        moved = moved or at.is_moved
        at = nodes.get(at.parent)


@dataclass(frozen=True, slots=True, eq=False)
class Structure:
    """Nodes of the world and their indexes; build it with `index.build`, never by hand."""

    nodes: Mapping[int, Node]
    next_uid: int
    revision: int
    uid_by_name: Mapping[str, int]
    rows: Mapping[int, int]
    children: Mapping[int, tuple[int, ...]]
    robots: Mapping[int, RobotIndex]
    tools: Mapping[int, tuple[int, ...]]
    forest: Forest
    q_count: int
    v_count: int

    def coordinates_at(self, row: int) -> range:
        """Return the places in q of the joint of a row of the forest; a mimic joint has those of the one it mimics."""
        start = int(self.forest.q_index[row])
        return range(start, start + COUNTS[int(self.forest.joint_type[row])])

    @property
    def figures(self) -> Iterator[Figure]:
        """Return the figures of all nodes, in their order."""
        return (figure for node in self.nodes.values() for figure in node.figures)

    def node(self, name: str, kind: Kind | None = None) -> Node:
        """Return the node called `name` (empty: the world); raise UnknownNameError when there is none of that kind."""
        uid = self.uid_by_name.get(name or WORLD_NAME)
        node = self.nodes[uid] if uid is not None else None
        if node is None or (kind is not None and node.kind is not kind):
            valid = (n.name for n in self.nodes.values() if kind is None or n.kind is kind)
            raise UnknownNameError(kind.value if kind else "node", name, valid)
        return node

    def robot(self, name: str) -> tuple[Node, RobotIndex]:
        """Return the robot called `name` and its index; raise UnknownNameError when there is none."""
        node = self.node(name, Kind.ROBOT)
        return node, self.robots[node.uid]

    def ancestors(self, uid: int) -> Iterator[Node]:
        """Yield the node and the nodes above it, up to the root."""
        while uid:
            node = self.nodes[uid]
            yield node
            uid = node.parent

    def below(self, uid: int) -> Iterator[Node]:
        """Yield the node and all nodes below it, parents first."""
        stack = [uid]
        while stack:
            at = stack.pop()
            yield self.nodes[at]
            stack.extend(reversed(self.children.get(at, ())))

    def robot_of(self, uid: int) -> Node | None:
        """Return the nearest robot at or above the node, or None."""
        return next((node for node in self.ancestors(uid) if node.kind is Kind.ROBOT), None)

    def tools_of(self, robot: int) -> tuple[Node, ...]:
        """Return the tools mounted on a robot, in the order of creation; those of its grippers are among them."""
        return tuple(self.nodes[uid] for uid in self.tools.get(robot, ()))

    def own_tools_of(self, robot: int) -> tuple[Node, ...]:
        """Return the tools of a robot whose states name its own joints."""
        return tuple(tool for tool in self.tools_of(robot) if next(robots_of_tool(self.nodes, tool.uid)) == robot)

    def grippers_of(self, robot: int) -> set[int]:
        """Return the robots (uids) that hang on a robot as its tools do: grippers, and what they are changed by."""
        found: set[int] = set()
        for tool in self.tools.get(robot, ()):
            above = [*robots_of_tool(self.nodes, tool)]
            found.update(above[: above.index(robot)])
        return found

    def with_holders(self, robots: Iterable[int]) -> tuple[int, ...]:
        """Return robots (uids), and after them those that they are grippers of."""
        own = tuple(dict.fromkeys(robots))
        holders: list[int] = []
        for robot in own:
            for tool in self.tools.get(robot, ()):
                above = [*robots_of_tool(self.nodes, tool)]
                holders += above[above.index(robot) + 1 :]
        return tuple(dict.fromkeys((*own, *holders)))
