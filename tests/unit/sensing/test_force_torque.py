"""Force and torque against formulas at rest and in free fall, and against pinocchio on moving arms."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.planning.dynamics import solve_inverse_dynamics
from virtualrobot_kernel.sensing.motion_content import WrenchContent
from virtualrobot_kernel.sensing.motion_reader import MotionReader
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.world.commands import AttachNode, CreateNodes
from virtualrobot_kernel.world.sensing import ForceTorqueSensor, MotionSensor, NoiseModel
from virtualrobot_kernel.world.structure import JointType, Kind, LinkData, NodeSpec, PartData, ToolData

from tests.unit.planning.dynamics_cases import pin_inertia, random_inertial, robot_and_reference
from tests.unit.sensing.moments import moment_at, snapshot_at
from tests.unit.world.builders import TICK, Change, after, empty, random_pose, shifted

pinocchio: Any = import_module("pinocchio")  # it has no types

G = 9.81


def sensor(parent: str, place: np.ndarray | None = None, noise: NoiseModel | None = None) -> NodeSpec:
    settings = ForceTorqueSensor(noise or NoiseModel(), noise or NoiseModel())
    return NodeSpec(
        "wrist", Kind.MOTION_SENSOR, parent, np.eye(4) if place is None else place, data=MotionSensor(settings)
    )


def read(change: Change, tick: int = 10, **motion: object) -> WrenchContent:
    moment = moment_at(change, tick, **motion)  # pyright: ignore[reportArgumentType]
    told = MotionReader(moment.snapshot, change.structure.node("wrist")).read(moment)
    assert isinstance(told, WrenchContent)
    return told


def loaded(rng: np.random.Generator, parent_t_sensor: np.ndarray) -> tuple[Change, list[tuple[float, np.ndarray]]]:
    """Return a holder with a sensor and a load; and its masses with their centres in the holder's frame."""
    tool, part = random_inertial(rng), random_inertial(rng)
    holder_t_tool, tool_t_part, tool_t_point = random_pose(rng), random_pose(rng), random_pose(rng)
    nodes = (
        NodeSpec("holder", Kind.PART, data=PartData(50.0)),  # what the sensor is fixed to is no load
        sensor("holder", parent_t_sensor),
        NodeSpec("tool", Kind.TOOL, "holder", holder_t_tool, data=ToolData(inertial=tool)),
        NodeSpec("part", Kind.PART, "tool", tool_t_part, data=PartData(part.mass, part)),
        NodeSpec("point", Kind.PART, "tool", tool_t_point, data=PartData(1.5)),
        NodeSpec("unknown", Kind.PART, "tool", tool_t_point),
    )
    masses = [
        (tool.mass, (holder_t_tool @ tool.link_t_inertial)[:3, 3]),
        (part.mass, (holder_t_tool @ tool_t_part @ part.link_t_inertial)[:3, 3]),
        (1.5, (holder_t_tool @ tool_t_point)[:3, 3]),
    ]
    return after(empty(), CreateNodes(nodes)), masses


def test_at_rest_it_is_the_weight(rng: np.random.Generator) -> None:
    """The sum of m g, and of (c - o) x m g, turned into the sensor's frame."""
    place, world_t_holder = random_pose(rng), random_pose(rng)
    change, masses = loaded(rng, place)
    told = read(change, ways={"holder": lambda _: world_t_holder})
    world_t_sensor = world_t_holder @ place
    weights = [(mass * np.array([0, 0, -G]), (world_t_holder @ [*centre, 1.0])[:3]) for mass, centre in masses]
    force = sum(weight for weight, _ in weights)
    torque = sum(np.cross(centre - world_t_sensor[:3, 3], weight) for weight, centre in weights)
    np.testing.assert_allclose(told.force, world_t_sensor[:3, :3].T @ force, atol=1e-9)
    np.testing.assert_allclose(told.torque, world_t_sensor[:3, :3].T @ torque, atol=1e-8)


def test_in_free_fall_nothing_weighs(rng: np.random.Generator) -> None:
    change, _ = loaded(rng, random_pose(rng))
    told = read(change, ways={"holder": lambda time: shifted(z=-0.5 * G * time**2)})
    np.testing.assert_allclose(told.force, 0.0, atol=1e-6)
    np.testing.assert_allclose(told.torque, 0.0, atol=1e-6)


def test_what_hangs_on_the_sensor_itself_is_its_load() -> None:
    nodes = (
        NodeSpec("flange", Kind.OBJECT),
        sensor("flange"),
        NodeSpec("beside", Kind.PART, "flange", data=PartData(3.0)),
        NodeSpec("below", Kind.PART, "wrist", shifted(x=0.1), data=PartData(2.0)),
    )
    change = after(empty(), CreateNodes(nodes))
    np.testing.assert_allclose(read(change).force, (0, 0, -2 * G), atol=1e-9)
    np.testing.assert_allclose(read(change).torque, (0, 0.2 * G, 0), atol=1e-9)
    picked = after(change, AttachNode("beside", "wrist"))
    np.testing.assert_allclose(read(picked).force, (0, 0, -5 * G), atol=1e-9)
    alone = after(change, AttachNode("below", "world"))
    np.testing.assert_allclose(read(alone).force, (0, 0, -3 * G), atol=1e-9)


def test_the_link_behind_the_joint_counts_where_that_is_said() -> None:
    """As sensors in joints have it: 4 kg of the link, 3 kg on it, and 2 kg on the sensor."""
    settings = ForceTorqueSensor(include_parent=True)
    nodes = (
        NodeSpec("link", Kind.PART, data=PartData(4.0)),
        NodeSpec("wrist", Kind.MOTION_SENSOR, "link", data=MotionSensor(settings)),
        NodeSpec("beside", Kind.PART, "link", data=PartData(3.0)),
        NodeSpec("below", Kind.PART, "wrist", shifted(x=0.1), data=PartData(2.0)),
    )
    told = read(after(empty(), CreateNodes(nodes)))
    np.testing.assert_allclose(told.force, (0, 0, -9 * G), atol=1e-9)
    np.testing.assert_allclose(told.torque, (0, 0.2 * G, 0), atol=1e-9)


def test_without_a_load_it_tells_nothing_but_its_noise() -> None:
    change = after(empty(), CreateNodes((NodeSpec("flange", Kind.OBJECT), sensor("flange"))))
    np.testing.assert_array_equal(read(change).force, 0.0)
    np.testing.assert_array_equal(read(change).torque, 0.0)
    noisy = CreateNodes((NodeSpec("flange", Kind.OBJECT), sensor("flange", noise=NoiseModel(50.0, range=1.0))))
    assert np.abs(read(after(empty(), noisy)).force).max() == 1.0


@pytest.mark.parametrize("name", ["panda", "iiwa"])
def test_a_moving_arm_agrees_with_pinocchio(rng: np.random.Generator, name: str) -> None:
    """A tool alone below the last joint: the force that pinocchio says goes through that joint, with the other sign.

    The difference of second order is off by (w dt)^2 / 12 of each part of the motion, so at a quarter of the tick a
    sixteenth of the error is left.
    """
    base, flange_t_tool = random_pose(rng), random_pose(rng)
    nodes, reference = robot_and_reference(name, base)
    tool = random_inertial(rng, 2.0)
    mounted = NodeSpec("tool", Kind.TOOL, nodes[-1].name, flange_t_tool, data=ToolData(inertial=tool))
    change = after(empty(), CreateNodes((*nodes, sensor(nodes[-1].name), mounted)))
    count = change.structure.q_count
    amplitude, rate, phase = rng.uniform(0.2, 0.5, count), rng.uniform(0.5, 2.0, count), rng.uniform(0, 6, count)

    def q(time: float) -> np.ndarray:
        return amplitude * np.sin(rate * time + phase)

    def truth(time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return force and torque on the tool's frame, by pinocchio's motion of the frame that the tool is fixed to."""
        model, data = reference.model, reference.data
        v, a = amplitude * rate * np.cos(rate * time + phase), -amplitude * rate**2 * np.sin(rate * time + phase)
        theirs = pinocchio.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
        for joint, *values in zip(reference.joints, q(time), v, a, strict=True):
            at = model.joints[model.getJointId(joint)]
            theirs[0][at.idx_q], theirs[1][at.idx_v], theirs[2][at.idx_v] = values
        pinocchio.forwardKinematics(model, data, *theirs)
        frame = model.getFrameId(nodes[-1].name.partition(".")[2])
        speed = pinocchio.getFrameVelocity(model, data, frame)
        slope = pinocchio.getFrameAcceleration(model, data, frame)
        pinocchio.updateFramePlacement(model, data, frame)
        gravity = pinocchio.Motion(data.oMf[frame].rotation.T @ model.gravity.linear, np.zeros(3))
        body, place = pin_inertia(tool, flange_t_tool)
        body = place.act(body)
        wrench = body * (slope - gravity) + speed.cross(body * speed)
        return -wrench.linear, -wrench.angular

    errors = []
    for tick_seconds in (TICK, TICK / 4):
        tick = 1 + round(0.4 / tick_seconds)
        told = read(change, tick, q=q, tick_seconds=tick_seconds)
        force, torque = truth((tick - 1) * tick_seconds)
        errors.append(max(np.abs(told.force - force).max(), np.abs(told.torque - torque).max()))
    assert errors[1] < min(1e-3, errors[0] / 12)


def test_in_each_joint_of_a_moving_arm_it_is_the_joints_torque(rng: np.random.Generator) -> None:
    """Links, tool and part together, against the recursive Newton-Euler algorithm: a joint holds its load."""
    nodes, _ = robot_and_reference("iiwa", random_pose(rng))
    links = [spec for spec in nodes if isinstance(spec.data, LinkData) and spec.data.joint.type is not JointType.FIXED]
    tool, part = random_inertial(rng, 2.0), random_inertial(rng, 1.0)
    load = (
        NodeSpec("tool", Kind.TOOL, nodes[-1].name, random_pose(rng), data=ToolData(inertial=tool)),
        NodeSpec("part", Kind.PART, "tool", random_pose(rng), data=PartData(part.mass, part)),
    )
    change = after(empty(), CreateNodes((*nodes, *load)))
    amplitude, rate, phase = (rng.uniform(0.2, 1.5, 7) for _ in range(3))
    tick_seconds = TICK / 4  # for the sake of the error of differences, see above
    time = 99 * tick_seconds
    q, v = amplitude * np.sin(rate * time + phase), amplitude * rate * np.cos(rate * time + phase)
    a = -amplitude * rate**2 * np.sin(rate * time + phase)
    motion = {"q": lambda time: amplitude * np.sin(rate * time + phase), "tick_seconds": tick_seconds}
    moment = moment_at(change, 100, **motion)
    robot = change.structure.node("arm")
    efforts = solve_inverse_dynamics(moment.history[-1], robot, (), q[None], v[None], a[None]).efforts[0]
    for spec, effort in zip(links, efforts, strict=True):
        assert isinstance(spec.data, LinkData)
        settings = MotionSensor(ForceTorqueSensor(include_parent=True))
        node = NodeSpec("wrist", Kind.MOTION_SENSOR, spec.name, data=settings)
        told = read(after(change, CreateNodes((node,))), 100, **motion)
        assert -told.torque @ spec.data.joint.axis == pytest.approx(effort, abs=1e-3)
    assert np.abs(efforts).max() > 1.0


def test_a_part_that_is_new_is_at_rest(rng: np.random.Generator) -> None:
    """Made in the tick of the reading: where it was before, nobody knows."""
    change = after(empty(), CreateNodes((NodeSpec("flange", Kind.OBJECT), sensor("flange"))))
    longer = after(change, CreateNodes((NodeSpec("part", Kind.PART, "flange", data=PartData(2.0)),)))
    history = tuple(snapshot_at(change, tick) for tick in (8, 9))
    now = snapshot_at(longer, 10)
    told = MotionReader(now, longer.structure.node("wrist")).read(Moment(now, history, 1, rng))
    assert isinstance(told, WrenchContent)
    np.testing.assert_allclose(told.force, (0, 0, -2 * G), atol=1e-9)
