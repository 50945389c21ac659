"""Tables of fields: nothing of a message or of its class is forgotten, and both ways give the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from virtualrobot.v1 import geometry_pb2, nodes_pb2
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.nodes import INERTIAL, LIMITS
from virtualrobot_kernel.messages.robots import ROBOT
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.world.structure import JointLimits


@dataclass(frozen=True)
class Radius:
    """A class that knows one field of a cylinder."""

    radius: float


@dataclass(frozen=True)
class Weight:
    """A class with an attribute that a sphere hasn't."""

    radius: float
    mass: float


def test_a_field_without_an_attribute_is_found() -> None:
    with pytest.raises(TypeError, match=r"Radius has no attribute for Cylinder\.length_meters"):
        Table(Radius, nodes_pb2.Cylinder)
    table = Table(Radius, nodes_pb2.Cylinder, without=["length_meters"])
    assert table.read(nodes_pb2.Cylinder(radius_meters=2.0), "it") == Radius(2.0)


def test_an_attribute_without_a_field_is_found() -> None:
    with pytest.raises(TypeError, match=r"Sphere has no field for Weight\.mass"):
        Table(Weight, nodes_pb2.Sphere)
    assert Table(Weight, nodes_pb2.Sphere, without=["mass"]).read(nodes_pb2.Sphere(), "it", mass=1.0).mass == 1.0


def test_what_is_the_default_is_left_out_where_its_absence_tells_so() -> None:
    message = LIMITS.write(JointLimits())
    assert not message.HasField("lower")
    assert message.velocity == JointLimits().velocity
    assert LIMITS.read(nodes_pb2.JointLimits(), "it") == JointLimits()


def test_a_value_comes_back(rng: np.random.Generator) -> None:
    x, y, z, *w = rng.normal(size=7).tolist()
    message = nodes_pb2.Inertial(mass_kilograms=abs(x), diagonal=geometry_pb2.Vector3(x=x, y=y, z=z))
    message.link_t_inertial.position.x = w[0]
    again = INERTIAL.write(INERTIAL.read(message, "it"))
    assert again == message


@pytest.mark.parametrize(
    ("robot", "said"),
    [
        ({"postures": [{"name": "a"}, {"name": "a"}]}, r"r\.postures\[1\] names 'a' again"),
        ({"groups": [{"joint_names": ["j"]}]}, r"r\.groups\[0\] has no name"),
        ({"actuators": [{"name": "a", "terms": [{"joint": "j"}]}]}, r"r\.actuators\[0\], 'a', needs terms"),
        (
            {"actuators": [{"name": "a", "terms": [{"joint": "j", "ratio": float("nan")}]}]},
            r"r\.actuators\[0\]\.terms\[0\]\.ratio must be a finite number",
        ),
    ],
)
def test_a_refusal_names_the_whole_path(robot: dict[str, object], said: str) -> None:
    with pytest.raises(KernelError, match=said):
        ROBOT.read(nodes_pb2.Robot(**robot), "r")  # pyright: ignore[reportArgumentType]
