"""Efforts of robots in a world against pinocchio, formulas of textbooks, and the law of energy."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports]  a path file makes it importable
import pytest
from virtualrobot_kernel.errors import KernelError, LimitError, Reason, UnknownNameError
from virtualrobot_kernel.planning.bodies import bodies_of
from virtualrobot_kernel.planning.dynamics import MOST_SAMPLES, Dynamics, run, solve_inverse_dynamics
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import (
    Inertial,
    Joint,
    JointLimits,
    JointType,
    Kind,
    LinkData,
    NodeSpec,
    PartData,
    ToolData,
)

from tests.unit.planning.dynamics_cases import (
    FILES,
    pin_inertia,
    random_inertial,
    random_tree,
    robot_and_reference,
    snapshot_of,
    with_masses,
)
from tests.unit.world.builders import random_pose, shifted

SAMPLES = 50
POINT = MappingProxyType({"diagonal": (0.0, 0.0, 0.0), "products": (0.0, 0.0, 0.0)})


def solve(snapshot: Snapshot, robot: str, *arguments: object, **named: object) -> Dynamics:
    node = snapshot.structure.node(robot, Kind.ROBOT)
    return solve_inverse_dynamics(snapshot, node, *arguments, **named)  # pyright: ignore[reportArgumentType]


def free(snapshot: Snapshot, robot: str, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Return the efforts at postures that need not be within limits."""
    node = snapshot.structure.node(robot, Kind.ROBOT)
    gravity = snapshot.world_t(node.uid)[:3, :3].T @ [0.0, 0.0, -9.81]
    return run(bodies_of(snapshot, node), gravity, q, v, a)[0]


@pytest.mark.long
@pytest.mark.parametrize("name", FILES)
def test_efforts_agree_with_pinocchio(rng: np.random.Generator, name: str) -> None:
    """On the same file; the base is turned at random, so that gravity comes from anywhere."""
    base = random_pose(rng)
    nodes, reference = robot_and_reference(name, base)
    if name == "puma560":
        nodes, reference = with_masses(nodes, reference, rng)
    snapshot = snapshot_of(nodes)
    q, v, a = rng.normal(size=(3, SAMPLES, len(reference.joints)))
    ours = free(snapshot, "arm", q, v, a)
    theirs = [reference.efforts(*sample) for sample in zip(q, v, a, strict=True)]
    assert np.abs(ours).max() > 0.1
    np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", ["iiwa", "a1"])
def test_the_base_s_wrench_agrees_with_pinocchio(rng: np.random.Generator, name: str) -> None:
    """Pinocchio's robot floats, and is told to stand still: what moves its base is the wrench that holds it."""
    base = random_pose(rng)
    nodes, reference = robot_and_reference(name, base)
    snapshot = snapshot_of(nodes)
    model = pinocchio.buildModelFromUrdf(str(FILES[name]), pinocchio.JointModelFreeFlyer())
    data = model.createData()
    v, a = rng.normal(size=(2, len(reference.joints)))
    found = solve(snapshot, "arm", velocities=v[None], accelerations=a[None])
    theirs = pinocchio.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
    theirs[0][:7] = pinocchio.SE3ToXYZQUAT(pinocchio.SE3(base[:3, :3], base[:3, 3]))
    for joint, speed, slope in zip(reference.joints, v, a, strict=True):
        place = model.joints[model.getJointId(joint)].idx_v
        theirs[1][place], theirs[2][place] = speed, slope
    np.testing.assert_allclose(found.base_wrenches[0], pinocchio.rnea(model, data, *theirs)[:6], rtol=1e-9, atol=1e-9)


def test_tool_and_parts_weigh(rng: np.random.Generator) -> None:
    """Against pinocchio with the same masses appended to the last joint."""
    base, flange_t_tool, tool_t_part, tool_t_point = (random_pose(rng) for _ in range(4))
    nodes, reference = robot_and_reference("iiwa", base)
    flange = nodes[-1].name
    tool, part = random_inertial(rng), random_inertial(rng)
    payload = [
        NodeSpec("adapter", Kind.ADAPTER, flange, flange_t_tool),
        NodeSpec("tool", Kind.TOOL, "adapter", data=ToolData(inertial=tool)),
        NodeSpec("part", Kind.PART, "tool", tool_t_part, data=PartData(part.mass, part)),
        NodeSpec("point", Kind.PART, "tool", tool_t_point, data=PartData(1.5)),
    ]
    joint = reference.model.njoints - 1
    point = Inertial(1.5, np.eye(4), **POINT)
    for inertial, tool_t in ((tool, np.eye(4)), (part, tool_t_part), (point, tool_t_point)):
        reference.model.appendBodyToJoint(joint, *pin_inertia(inertial, flange_t_tool @ tool_t))
    with_payload = replace(reference, data=reference.model.createData())
    q, v, a = rng.normal(size=(3, SAMPLES, 7))
    snapshot = snapshot_of([*nodes, *payload])
    theirs = [with_payload.efforts(*sample) for sample in zip(q, v, a, strict=True)]
    np.testing.assert_allclose(free(snapshot, "arm", q, v, a), theirs, rtol=1e-9, atol=1e-9)
    found = solve(snapshot, "arm")
    assert found.payload == pytest.approx(tool.mass + part.mass + 1.5, rel=1e-12)
    assert found.warnings == ("the part 'point' of 1.5 kg counts as a point at its origin",)


def test_a_robot_on_the_flange_is_carried_as_it_stands(rng: np.random.Generator) -> None:
    """The same masses fixed to the flange where the gripper's links are."""
    nodes, _ = robot_and_reference("iiwa", np.eye(4))
    flange, finger_inertial = nodes[-1].name, random_inertial(rng)
    axis, place = (0.0, 1.0, 0.0), random_pose(rng)
    gripper = [
        NodeSpec("gripper", Kind.ROBOT, flange, place),
        NodeSpec(
            "gripper.f", Kind.LINK, "gripper", data=LinkData(Joint("f", JointType.PRISMATIC, axis), finger_inertial)
        ),
    ]
    opened = np.zeros(8)
    opened[7] = 0.05
    lump = NodeSpec("lump", Kind.TOOL, flange, place @ shifted(y=0.05), data=ToolData(inertial=finger_inertial))
    q, v, a = rng.normal(size=(3, SAMPLES, 7))
    carried = snapshot_of([*nodes, *gripper], opened)
    np.testing.assert_allclose(
        free(carried, "arm", q, v, a), free(snapshot_of([*nodes, lump]), "arm", q, v, a), rtol=1e-12, atol=1e-12
    )
    assert solve(carried, "arm").payload == finger_inertial.mass


def two_links(lengths: tuple[float, float], masses: tuple[float, float], effort: float = 0.0) -> tuple[NodeSpec, ...]:
    """Return an arm in the x-z plane of point masses at the ends of its links; positive angles lift."""
    nodes = [NodeSpec("arm", Kind.ROBOT)]
    limits = JointLimits(-3.0, 3.0, effort=effort)
    for i in range(2):
        place = shifted(x=lengths[0] if i else 0.0)
        joint = Joint(f"j{i}", JointType.REVOLUTE, (0.0, -1.0, 0.0), limits)
        inertial = Inertial(masses[i], shifted(x=lengths[i]), **POINT)
        nodes.append(NodeSpec(f"arm.{i}", Kind.LINK, nodes[-1].name, place, data=LinkData(joint, inertial)))
    return tuple(nodes)


def test_two_links_by_formula(rng: np.random.Generator) -> None:
    """J. Craig, Introduction to Robotics, 3rd edition 2005, equation 6.58, with its gravity along -y."""
    (l1, l2), (m1, m2), g = rng.uniform(0.2, 1.0, 2), rng.uniform(0.5, 5.0, 2), 9.81
    snapshot = snapshot_of(two_links((l1, l2), (m1, m2)))
    q, v, a = rng.uniform(-2.0, 2.0, (3, SAMPLES, 2))
    found = solve(snapshot, "arm", ("j0", "j1"), q, v, a)
    (q1, q2), (v1, v2), (a1, a2) = q.T, v.T, a.T
    s2, c2, c12 = np.sin(q2), np.cos(q2), np.cos(q1 + q2)
    first = (
        m2 * l2**2 * (a1 + a2)
        + m2 * l1 * l2 * c2 * (2 * a1 + a2)
        + (m1 + m2) * l1**2 * a1
        - m2 * l1 * l2 * s2 * v2**2
        - 2 * m2 * l1 * l2 * s2 * v1 * v2
    )
    second = m2 * l1 * l2 * c2 * a1 + m2 * l1 * l2 * s2 * v1**2 + m2 * l2**2 * (a1 + a2)
    weight = np.array([m2 * l2 * g * c12 + (m1 + m2) * l1 * g * np.cos(q1), m2 * l2 * g * c12]).T
    np.testing.assert_allclose(found.gravity_efforts, weight, atol=1e-11)
    np.testing.assert_allclose(found.efforts, np.array([first, second]).T + weight, atol=1e-11)
    other = solve(snapshot, "arm", ("j1", "j0"), q[:, ::-1], v[:, ::-1], a[:, ::-1])
    np.testing.assert_array_equal(other.efforts, found.efforts[:, ::-1])


def test_power_is_the_change_of_energy(rng: np.random.Generator) -> None:
    """The sum of effort times velocity against d/dt (kinetic + potential energy) of a tree that moves by sines.

    Velocities of the links are finite differences of the forward pass: nothing here is ours but that pass.
    """
    snapshot = snapshot_of(random_tree(rng))
    structure = snapshot.structure
    links = [node for node in structure.nodes.values() if isinstance(node.data, LinkData)]
    amplitude, frequency, phase = rng.uniform(0.3, 1.0, (3, structure.q_count))
    h = 1e-4

    def poses(t: float) -> np.ndarray:
        q = amplitude * np.sin(frequency * t + phase)
        world = world_poses(structure, replace(snapshot.state, q=q))
        inertials = [node.data.inertial for node in links if isinstance(node.data, LinkData)]
        return np.array(
            [world[structure.rows[n.uid]] @ i.link_t_inertial for n, i in zip(links, inertials, strict=True) if i]
        )

    def energy(t: float) -> float:
        before, now, after = poses(t - h), poses(t), poses(t + h)
        total = 0.0
        for node, a, b, c in zip(links, before, now, after, strict=True):
            assert isinstance(node.data, LinkData) and node.data.inertial
            inertial, speed = node.data.inertial, (c - a) / (2 * h)
            (xx, yy, zz), (xy, xz, yz) = inertial.diagonal, inertial.products
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            skew = b[:3, :3].T @ speed[:3, :3]
            turn = np.array([skew[2, 1] - skew[1, 2], skew[0, 2] - skew[2, 0], skew[1, 0] - skew[0, 1]]) / 2
            velocity = speed[:3, 3]
            total += inertial.mass * (velocity @ velocity / 2 + 9.81 * b[2, 3]) + turn @ tensor @ turn / 2
        return float(total)

    step = 1e-3
    for t in rng.uniform(0.0, 5.0, 10):
        angle = frequency * t + phase
        q, v, a = (
            amplitude * np.sin(angle),
            amplitude * frequency * np.cos(angle),
            -amplitude * frequency**2 * np.sin(angle),
        )
        power = float(free(snapshot, "tree", q[None], v[None], a[None])[0] @ v)
        # Fourth order, so that the step's own error is far below the tolerance.
        change = (8 * (energy(t + step) - energy(t - step)) - energy(t + 2 * step) + energy(t - 2 * step)) / (12 * step)
        assert power == pytest.approx(change, rel=1e-5, abs=1e-4)


def test_the_first_effort_above_its_limit_is_named() -> None:
    """Point masses of 1 kg at 0.5 m and 1 m: 9.81 * 1.5 N m at the shoulder when the arm lies level, 0 upright."""
    snapshot = snapshot_of(two_links((0.5, 0.5), (1.0, 1.0), effort=10.0))
    quarter = np.pi / 2
    path = np.array([[quarter, 0.0], [quarter / 2, 0.0], [0.0, 0.0]])
    found = solve(snapshot, "arm", (), path)
    first = found.first_violation
    assert first is not None
    assert (first.joint, first.sample, first.limit) == ("j0", 1, 10.0)
    assert first.effort == pytest.approx(9.81 * 1.5 * np.cos(np.pi / 4), rel=1e-12)
    assert solve(snapshot, "arm", (), path[:1]).first_violation is None
    unknown = snapshot_of(two_links((0.5, 0.5), (1.0, 1.0)))
    assert solve(unknown, "arm", (), path).first_violation is None, "a limit of 0 is unknown"


def test_a_robot_without_masses_is_told_so() -> None:
    nodes = two_links((0.5, 0.5), (1.0, 0.0))
    found = solve(snapshot_of(nodes), "arm")
    assert found.warnings == ("the link 'arm.1' and what is fixed to it have no mass",)
    np.testing.assert_allclose(found.efforts, [[9.81 * 0.5, 0.0]])
    part = NodeSpec("box", Kind.PART, "arm.1", data=PartData())
    assert (
        "the part 'box' has no mass; give it mass_kilograms or an inertial"
        in solve(snapshot_of([*nodes, part]), "arm").warnings
    )


def test_what_makes_no_sense_is_refused() -> None:
    snapshot = snapshot_of(two_links((0.5, 0.5), (1.0, 1.0)))
    here = np.zeros((3, 2))
    wrong = here.copy()
    wrong[2, 1] = np.nan
    cases = [
        ({"velocities": wrong}, r"velocities\[2, 1\] is nan; give a finite number"),
        ({"accelerations": wrong + np.inf}, r"accelerations\[0, 0\] is inf"),
        ({"positions": np.zeros((3, 3))}, r"positions must have the shape \(n, 2\).*not \(3, 3\)"),
        ({"positions": np.zeros((0, 2))}, r"positions must have the shape \(n, 2\)"),
        ({"positions": here, "velocities": here[:2]}, "velocities has 2 samples and positions 3"),
        ({"velocities": here + 1e200}, "so great that its efforts are no finite numbers"),
        ({"joint_names": ("j0", "j0")}, "the joint 'j0' of 'arm' is named twice"),
    ]
    for arguments, message in cases:
        with pytest.raises(KernelError, match=message):
            solve(snapshot, "arm", **arguments)
    with pytest.raises(UnknownNameError, match="there are 'j0', 'j1'"):
        solve(snapshot, "arm", ("j0", "j3"))
    with pytest.raises(LimitError, match="the joint 'j1' of 'arm' cannot be at 4 rad"):
        solve(snapshot, "arm", (), here + np.array([0.0, 4.0]))
    with pytest.raises(KernelError, match="at most 100000 at a time") as refused:
        solve(snapshot, "arm", (), np.zeros((MOST_SAMPLES + 1, 2)))
    assert refused.value.reason is Reason.TOO_LARGE
    with pytest.raises(KernelError, match="has no joint that turns or slides"):
        solve(snapshot_of([NodeSpec("table", Kind.ROBOT)]), "table")
