"""Data of robots alone: messages to frozen values and back."""

from __future__ import annotations

from virtualrobot.v1 import nodes_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import (
    BY_NAME,
    FINITE,
    NOT_NEGATIVE,
    POSITIVE,
    EnumTable,
    OrDefault,
    Pair,
    distinct,
    named,
)
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.world.craft_data import Craft, CraftDrive, Water
from virtualrobot_kernel.world.groups import Group
from virtualrobot_kernel.world.motors import JointMotor, MotorMode
from virtualrobot_kernel.world.structure import Actuator, JointGroup, LinkPair, RobotData


def _check_actuator(actuator: Actuator, what: str) -> None:
    if not actuator.terms or not all(ratio for _, ratio in actuator.terms):
        raise KernelError(f"{what}, {actuator.name!r}, needs terms with ratios other than 0", field=what)
    lower, upper = actuator.lower, actuator.upper
    if lower > upper:
        raise KernelError(
            f"the limits of {what}, {actuator.name!r}, are {lower:g} to {upper:g}; the lower one first", field=what
        )


POSTURES = named(nodes_pb2.NamedPosture, "joint_positions", BY_NAME)
RATIOS = named(nodes_pb2.ActuatorTerm, "ratio", key="joint")
TERMS = Pair(
    lambda given, what: tuple(RATIOS.read(given, what).items()), lambda terms: RATIOS.write(dict(terms)), whole=True
)
GROUPS = distinct(Table(JointGroup, nodes_pb2.JointGroup))
ACTUATORS = distinct(
    Table(Actuator, nodes_pb2.Actuator, terms=TERMS, lower=FINITE, upper=FINITE, check=_check_actuator)
)
WATER = Table(Water, nodes_pb2.Water, density=OrDefault(POSITIVE))
CRAFT = Table(
    Craft, nodes_pb2.Craft, drives=Table(CraftDrive, nodes_pb2.CraftDrive, ratio=OrDefault(FINITE)), water=WATER
)
MOTOR = Table(
    JointMotor,
    nodes_pb2.JointMotor,
    mode=EnumTable(MotorMode, nodes_pb2.MotorMode),
    numbers=NOT_NEGATIVE,
)
ROBOT = Table(
    RobotData,
    nodes_pb2.Robot,
    postures=POSTURES,
    groups=GROUPS,
    allowed_collisions=Table(LinkPair, nodes_pb2.LinkPair),
    actuators=ACTUATORS,
    craft=CRAFT,
    motors=MOTOR,
    payload_kilograms=NOT_NEGATIVE,
    without=("joint_names",),
)


def _check_selection(group: Group, what: str) -> None:
    if group.name and group.is_ad_hoc:
        raise KernelError(
            f"{what} names the group {group.name!r} and links, {group.base!r} and {group.tip!r}; give the name or the "
            "links",
            field=what,
        )


_SELECTION = Table(
    Group, nodes_pb2.GroupSelection, names={"base": "base_link", "tip": "tip_link"}, check=_check_selection
)
group_selection, selection_message = _SELECTION.read, _SELECTION.write
