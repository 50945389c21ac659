"""Numbers that no physical cell has are refused with the name of their field, wherever they are given."""

from __future__ import annotations

import math

import pytest
from virtualrobot.v1 import geometry_pb2, nodes_pb2, scene_pb2
from virtualrobot_kernel.api.convert.commands import world_commands
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.nodes import node_spec
from virtualrobot_kernel.world.structure import RobotData

V = geometry_pb2.Vector3
POINT = geometry_pb2.NumericArray(type=geometry_pb2.NUMERIC_TYPE_FLOAT64, shape=[1, 3], data=bytes(24))


def shape(**geometry: object) -> nodes_pb2.Node:
    """Return an object with one figure."""
    return nodes_pb2.Node(name="n", object=nodes_pb2.SceneObject(), figures=[nodes_pb2.Figure(**geometry)])  # pyright: ignore[reportArgumentType]


def limited(**limits: float) -> nodes_pb2.Node:
    """Return a link whose joint has these limits."""
    joint = nodes_pb2.Joint(name="j", type=nodes_pb2.JOINT_TYPE_PRISMATIC, limits=nodes_pb2.JointLimits(**limits))  # pyright: ignore[reportArgumentType]
    return nodes_pb2.Node(name="n", link=nodes_pb2.Link(joint=joint))


@pytest.mark.parametrize(
    ("node", "field"),
    [
        (nodes_pb2.Node(name="n", part=nodes_pb2.Part(mass_kilograms=-1.0)), "mass_kilograms"),
        (nodes_pb2.Node(name="n", part=nodes_pb2.Part(mass_kilograms=math.nan)), "mass_kilograms"),
        (nodes_pb2.Node(name="n", link=nodes_pb2.Link(inertial=nodes_pb2.Inertial(mass_kilograms=-1.0))), "mass"),
        (limited(effort=-1.0), "n.link.joint.limits.effort"),
        (limited(lower=math.inf), "n.link.joint.limits are"),
        (limited(upper=-math.inf), "n.link.joint.limits are"),
        (limited(lower=math.nan), "n.link.joint.limits are"),
        (shape(sphere=nodes_pb2.Sphere(radius_meters=1e308)), "radius_meters"),
        (shape(sphere=nodes_pb2.Sphere(radius_meters=-1.0)), "radius_meters"),
        (shape(box=nodes_pb2.Box(size=V(x=1.0, y=1.0))), "size.z"),
        (shape(points=nodes_pb2.Points(positions=POINT, size_meters=-1.0)), "size_meters"),
        (shape(frame=nodes_pb2.Frame(length_meters=-1.0)), "length_meters"),
        (
            nodes_pb2.Node(
                name="n", object=nodes_pb2.SceneObject(), parent_t_node=geometry_pb2.Pose(position=V(x=1e308))
            ),
            "parent_t_node.position",
        ),
    ],
)
def test_impossible_numbers_of_nodes_are_refused(node: nodes_pb2.Node, field: str) -> None:
    with pytest.raises(KernelError, match=field):
        node_spec(node)


def test_a_pick_has_no_negative_reach() -> None:
    pick = scene_pb2.Command(pick_part=scene_pb2.PickPart(robot="r", max_distance_meters=-1.0))
    with pytest.raises(KernelError, match="max_distance_meters"):
        world_commands([pick])


def test_joints_of_a_posture_come_in_one_order() -> None:
    """Protobuf iterates over maps in an order that differs from process to process; the journal must not."""
    names = [f"joint_{i}" for i in range(50)]
    posture = nodes_pb2.NamedPosture(name="home", joint_positions=dict.fromkeys(reversed(names), 0.0))
    data = node_spec(nodes_pb2.Node(name="r", robot=nodes_pb2.Robot(postures=[posture]))).data
    assert isinstance(data, RobotData)
    assert list(data.postures["home"]) == sorted(names)
