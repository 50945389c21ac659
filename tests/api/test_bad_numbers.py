"""Numbers that are not finite: refused wherever they stand in a message; and the world is as it was before."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from google.protobuf.message import Message
from virtualrobot.v1 import geometry_pb2, kernel_pb2, motion_pb2, nodes_pb2, robot_pb2, scene_pb2, view_pb2

from tests.api.asking import IIWA, box, create, joints, load, refusal
from tests.api.moving import READY
from tests.api.reading import pose, unchanged
from tests.api.test_bad_input import JOINT
from tests.kernels import Stubs

NO_LIMIT = {("lower", -math.inf), ("upper", math.inf)}
"""What says of a joint that it has no limit."""


def numbers(message: Message) -> Iterator[tuple[str, Callable[[float], None]]]:
    """Yield, for each number in a message, its name and what sets it."""
    for field, value in message.ListFields():
        if field.message_type is not None and field.message_type.GetOptions().map_entry:
            for key in value:
                yield key, lambda new, value=value, key=key: value.__setitem__(key, new)
        elif field.message_type is not None:
            parts = [value] if isinstance(value, Message) else value
            for part in parts:
                yield from numbers(part)
        elif field.cpp_type == field.CPPTYPE_DOUBLE:
            yield field.name, lambda new, name=field.name: setattr(message, name, new)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_number_that_is_not_finite_is_refused_wherever_it_stands(stepped: Stubs, bad: float) -> None:
    load(stepped, IIWA, "arm")
    place = pose(np.eye(4))
    place.position.x, place.position.y, place.position.z = 0.4, 0.1, 0.6
    material = nodes_pb2.Material(color=geometry_pb2.Color(red=1, green=1, blue=1, alpha=1), reflectance=1, friction=1)
    node = box("a", 1.0, 1.0, 1.0)
    node.figures[0].material.CopyFrom(material)
    node.figures[0].node_t_figure.CopyFrom(place)
    node.part.mass_kilograms = 1.0
    limits = nodes_pb2.JointLimits(lower=-1, upper=1, velocity=1, acceleration=1, jerk=1, effort=1)
    axis = geometry_pb2.Vector3(x=1, y=1, z=1)
    inertial = nodes_pb2.Inertial(mass_kilograms=1, link_t_inertial=place, diagonal=axis, products=axis)
    hinge = nodes_pb2.Joint(name="j", type=nodes_pb2.JOINT_TYPE_REVOLUTE, axis=axis, limits=limits)
    follower = nodes_pb2.Joint(name="m", type=nodes_pb2.JOINT_TYPE_REVOLUTE)
    follower.mimic.CopyFrom(nodes_pb2.Mimic(joint="j", multiplier=1, offset=1))
    new = [
        nodes_pb2.Node(name="r", robot=nodes_pb2.Robot()),
        nodes_pb2.Node(name="r.a", parent="r", link=nodes_pb2.Link(joint=hinge, inertial=inertial)),
        nodes_pb2.Node(name="r.b", parent="r.a", link=nodes_pb2.Link(joint=follower)),
    ]
    goal = motion_pb2.PoseGoal(reference_t_tcp=place)
    line = motion_pb2.Linear(goal=goal, max_velocity_meters_per_second=1, max_acceleration_meters_per_second_squared=1)
    move = motion_pb2.Move(robot="arm", speed_factor=1, linear=line)
    arc = motion_pb2.Circular(goal=goal, max_velocity_meters_per_second=1, max_acceleration_meters_per_second_squared=1)
    arc.center.CopyFrom(motion_pb2.ArcCenter(position=place.position, axis=axis, angle_radians=1))
    through = motion_pb2.Circular(goal=goal, via=axis)
    rounds = [motion_pb2.Move(robot="arm", circular=one) for one in (arc, through)]
    jump = scene_pb2.SetJointPositions(robot="arm", joint_positions={JOINT: 0.5})
    camera = view_pb2.Camera(position=axis, target=place.position, field_of_view_radians=1)
    view = view_pb2.UpdateViewRequest(view=view_pb2.View(camera=camera))
    view.update_mask.paths.append("camera")
    calls: list[tuple[Callable[[Any], object], Message]] = [
        (stepped.scene.Apply, scene_pb2.ApplyRequest(commands=[create(one) for one in (node, *new)])),
        (stepped.scene.Apply, scene_pb2.ApplyRequest(commands=[scene_pb2.Command(set_joint_positions=jump)])),
        (
            stepped.scene.ImportModel,
            scene_pb2.ImportModelRequest(model=scene_pb2.ModelSource(uri=IIWA, parent_t_node=place)),
        ),
        (
            stepped.motion.StartMotion,
            motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=[joints("arm", 1.0, **READY)])),
        ),
        (stepped.motion.StartMotion, motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=[move]))),
        *(
            (stepped.motion.StartMotion, motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=[one])))
            for one in rounds
        ),
        (stepped.robot.SolveForward, robot_pb2.SolveForwardRequest(robot="arm", joint_positions=READY)),
        (stepped.robot.SolveInverse, robot_pb2.SolveInverseRequest(robot="arm", reference_t_tcp=place, seed=READY)),
        (stepped.view.UpdateView, view),
        (stepped.kernel.SetClock, kernel_pb2.SetClockRequest(mode=kernel_pb2.CLOCK_MODE_STEPPED, speed_factor=1)),
    ]
    with unchanged(stepped):
        for call, request in calls:
            for index, (name, _) in enumerate(numbers(request)):
                if (name, bad) in NO_LIMIT:
                    continue
                asked = type(request)()
                asked.CopyFrom(request)
                list(numbers(asked))[index][1](bad)
                refused = refusal(lambda call=call, asked=asked: call(asked))
                assert refused.reason in ("INVALID_ARGUMENT", "LIMIT_EXCEEDED"), (asked, refused)
