"""RobotService: what robots are made of, where they are, forward and inverse kinematics."""

from __future__ import annotations

from xml.etree import ElementTree

import grpc
import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports]  a path file makes it importable
import pytest
from google.protobuf.field_mask_pb2 import FieldMask
from virtualrobot.v1 import nodes_pb2, robot_pb2, scene_pb2

from tests.api.asking import IIWA, PANDA, apply, create, joints, load, refusal, start
from tests.api.reading import matrices, matrix, pose, random_matrix, state, step, unchanged, values
from tests.api.test_scene import remove, update
from tests.kernels import Stubs

STATES, WATCH = robot_pb2.GetRobotStatesRequest, robot_pb2.WatchRobotStatesRequest
ARMS = {"iiwa": IIWA, "panda": PANDA}


def robot(stubs: Stubs, name: str) -> robot_pb2.GetRobotResponse:
    return stubs.robot.GetRobot(robot_pb2.GetRobotRequest(name=name))


def put(stubs: Stubs, name: str, positions: dict[str, float]) -> None:
    jump = scene_pb2.SetJointPositions(robot=name, joint_positions=positions)
    apply(stubs, scene_pb2.Command(set_joint_positions=jump))


def drawn(stubs: Stubs, name: str, rng: np.random.Generator) -> dict[str, float]:
    """Return joints of a robot drawn uniformly within limits."""
    told = robot(stubs, name).joints
    return {joint.name: float(rng.uniform(joint.limits.lower, joint.limits.upper)) for joint in told}


def forward(stubs: Stubs, name: str, positions: dict[str, float]) -> robot_pb2.SolveForwardResponse:
    return stubs.robot.SolveForward(robot_pb2.SolveForwardRequest(robot=name, joint_positions=positions))


def inverse(stubs: Stubs, name: str, goal: np.ndarray, **fields: object) -> robot_pb2.SolveInverseResponse:
    request = robot_pb2.SolveInverseRequest(robot=name, reference_t_tcp=pose(goal), **fields)  # pyright: ignore[reportArgumentType]
    return stubs.robot.SolveInverse(request)


def test_a_robot_is_told_whole(stepped: Stubs) -> None:
    """The Panda's numbers are those of its URDF; acceleration and jerk are the documented default rates."""
    uid = load(stepped, PANDA, "arm").created[0].uid
    hand = nodes_pb2.Node(name="hand", parent="arm.panda_hand", tool=nodes_pb2.Tool())
    postures = [nodes_pb2.NamedPosture(name="home", joint_positions={"panda_joint4": -1.5})]
    apply(
        stepped, create(hand), update("arm", "robot", robot=nodes_pb2.Robot(flange="arm.panda_hand", postures=postures))
    )
    told = robot(stepped, "arm")
    arm = [f"panda_joint{i}" for i in range(1, 8)]
    assert [joint.name for joint in told.joints] == [*arm, "panda_finger_joint1"], "the second finger mimics"
    assert (told.uid, list(told.chain_joints), told.flange) == (uid, arm, "arm.panda_hand")
    assert (told.kinematics, list(told.tools), told.robot.postures[0].name) == ("chain", ["hand"], "home")
    assert (told.links[0], len(told.links)) == ("arm.panda_link0", len(ElementTree.parse(PANDA).findall("link")))
    fourth, finger = told.joints[3].limits, told.joints[7]
    assert (fourth.lower, fourth.upper, fourth.velocity) == (-3.1416, 0.0, 2.175)
    assert fourth.acceleration == pytest.approx(4 * 2.175)
    assert fourth.jerk == pytest.approx(40 * 2.175)
    assert (finger.type, finger.coordinate_count, finger.velocity_count) == (nodes_pb2.JOINT_TYPE_PRISMATIC, 1, 1)


def test_states_by_name_and_mask(stepped: Stubs) -> None:
    load(stepped, IIWA, "a")
    load(stepped, PANDA, "b")
    assert [one.name for one in stepped.robot.GetRobotStates(STATES()).robots] == ["a", "b"]
    mask = FieldMask(paths=["positions", "name"])
    (b,) = stepped.robot.GetRobotStates(STATES(names=["b"], read_mask=mask)).robots
    assert (b.name, len(b.positions), len(b.velocities), b.HasField("world_t_tcp")) == ("b", 8, 0, False)
    refused = refusal(lambda: stepped.robot.GetRobotStates(STATES(read_mask=FieldMask(paths=["position"]))))
    assert "did you mean 'positions'" in refused.message
    for call in (lambda: robot(stepped, "c"), lambda: stepped.robot.GetRobotStates(STATES(names=["c"]))):
        assert (refusal(call).code, refusal(call).reason) == (grpc.StatusCode.NOT_FOUND, "UNKNOWN_NAME")


def test_a_watch_tells_all_then_what_changed(stepped: Stubs, rng: np.random.Generator) -> None:
    load(stepped, IIWA, "a")
    load(stepped, PANDA, "b")
    watch = stepped.robot.WatchRobotStates(WATCH(max_rate_hertz=250))
    assert [one.name for one in next(watch).robots] == ["a", "b"]
    start(stepped, joints("b", panda_joint1=0.5))
    assert [(one.name, len(one.motion_ids)) for one in next(watch).robots] == [("b", 1)]
    step(stepped, 3)
    assert [one.name for one in next(watch).robots] == ["b"]
    step(stepped, 2000)
    assert next(watch).robots[0].positions[0] == pytest.approx(0.5)
    step(stepped, 5)  # nothing moves: nothing is told
    tool = nodes_pb2.Node(name="tool", parent="a.lbr_iiwa_link_7", tool=nodes_pb2.Tool())
    changes = [
        (create(tool), "tool", "tool"),
        (update("tool", "parent_t_node", parent_t_node=pose(random_matrix(rng))), "tool", "tool"),
        (update("tool", "name", name="grip"), "tool", "grip"),
        (update("a", "parent_t_node", parent_t_node=pose(random_matrix(rng))), "tool", "grip"),
        (scene_pb2.Command(set_speed_factor=scene_pb2.SetSpeedFactor(robot="a", factor=0.5)), "speed_factor", 0.5),
        (remove("grip"), "tool", ""),
    ]
    for command, field, value in changes:
        apply(stepped, command)
        told = next(watch).robots
        assert [(one.name, getattr(one, field)) for one in told] == [("a", value)], command
        assert told[0] == state(stepped, "a")
    apply(stepped, update("a", "name", name="c"))
    renamed = next(watch)
    assert ([one.name for one in renamed.robots], list(renamed.removed_names)) == (["c"], ["a"])
    apply(stepped, remove("b"))
    gone = next(watch)
    assert (list(gone.robots), list(gone.removed_names)) == ([], ["b"])
    watch.cancel()


@pytest.mark.parametrize("name", ARMS)
def test_forward_agrees_with_pinocchio(stepped: Stubs, rng: np.random.Generator, name: str) -> None:
    """The other engine is pinocchio, on the same URDF."""
    base = random_matrix(rng)
    load(stepped, ARMS[name], name, parent_t_node=pose(base))
    model = pinocchio.buildModelFromUrdf(ARMS[name])
    data = model.createData()
    before = state(stepped, name)
    for _ in range(20):
        positions = drawn(stepped, name, rng)
        q = pinocchio.neutral(model)
        for joint, value in positions.items():
            q[model.joints[model.getJointId(joint)].idx_q] = value
        if name == "panda":  # pinocchio knows no mimic joints
            q[-1] = positions["panda_finger_joint1"]
        pinocchio.framesForwardKinematics(model, data, q)
        told = forward(stepped, name, positions)
        frames = dict(zip(told.links, matrices(told.world_t_link), strict=True))
        for link, frame in frames.items():
            other = data.oMf[model.getFrameId(link.removeprefix(f"{name}."))].homogeneous
            assert np.abs(frame - base @ other).max() < 1e-9
        assert np.abs(matrix(told.world_t_tcp) - frames[robot(stepped, name).flange]).max() < 1e-12
    assert state(stepped, name) == before, "nothing moves"


@pytest.mark.parametrize("name", ARMS)
def test_inverse_closes_forward(stepped: Stubs, rng: np.random.Generator, name: str) -> None:
    load(stepped, ARMS[name], name, parent_t_node=pose(random_matrix(rng)))
    limits = {joint.name: joint.limits for joint in robot(stepped, name).joints}
    for _ in range(20):
        goal = matrix(forward(stepped, name, drawn(stepped, name, rng)).world_t_tcp)
        answer = inverse(stepped, name, goal)
        assert answer.status == robot_pb2.INVERSE_STATUS_SOLVED, answer.explanation
        for solution in values(answer.solutions):
            positions = dict(zip(answer.joint_names, solution.tolist(), strict=True))
            assert all(limits[j].lower <= value <= limits[j].upper for j, value in positions.items())
            reached = matrix(forward(stepped, name, positions).world_t_tcp)
            off = np.linalg.inv(goal) @ reached
            assert np.linalg.norm(off[:3, 3]) < 1e-3, "the budget: 1 mm"
            assert np.arccos(np.clip((np.trace(off[:3, :3]) - 1) / 2, -1, 1)) < np.radians(0.1)


def test_the_nearest_solution_to_the_seed_comes_first(stepped: Stubs, rng: np.random.Generator) -> None:
    load(stepped, IIWA, "arm")
    for _ in range(20):
        positions = drawn(stepped, "arm", rng)
        goal = matrix(forward(stepped, "arm", positions).world_t_tcp)
        first = values(inverse(stepped, "arm", goal, seed=positions).solutions)[0]
        assert np.abs(first - list(positions.values())).max() < 1e-6, "a seed that solves is the solution"


def test_a_goal_in_another_frame(stepped: Stubs, rng: np.random.Generator) -> None:
    table = random_matrix(rng)
    apply(stepped, create(nodes_pb2.Node(name="table", object=nodes_pb2.SceneObject(), parent_t_node=pose(table))))
    load(stepped, IIWA, "arm")
    positions = drawn(stepped, "arm", rng)
    goal = np.linalg.inv(table) @ matrix(forward(stepped, "arm", positions).world_t_tcp)
    first = values(inverse(stepped, "arm", goal, reference="table", seed=positions).solutions)[0]
    assert np.abs(first - list(positions.values())).max() < 1e-6


def test_an_unreachable_pose_is_explained(stepped: Stubs) -> None:
    """The iiwa's flange (14 R820, link 7 of the URDF) is 1.261 m above its base when stretched: 4 m is too far."""
    load(stepped, IIWA, "arm")
    goal = np.eye(4)
    goal[:3, 3] = 4.0, 0.0, 0.5
    answer = inverse(stepped, "arm", goal)
    assert (answer.status, list(answer.solutions.shape)) == (robot_pb2.INVERSE_STATUS_UNREACHABLE, [0, 7])
    assert 4.0 - 1.3 < answer.position_error_meters < 4.0 + 1.3
    assert answer.explanation


def test_what_cannot_be_solved_is_refused(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    with unchanged(stepped):
        outside = refusal(lambda: forward(stepped, "arm", {"lbr_iiwa_joint_2": 2.5}))
        assert (outside.code, outside.reason) == (grpc.StatusCode.OUT_OF_RANGE, "LIMIT_EXCEEDED")
        assert outside.metadata["joint"] == "lbr_iiwa_joint_2"
        assert float(outside.metadata["upper"]) == pytest.approx(2.0943951023932)
        assert refusal(lambda: forward(stepped, "arm", {"joint_2": 0.0})).reason == "UNKNOWN_NAME"
        assert refusal(lambda: inverse(stepped, "arm", np.eye(4), seed={"joint_2": 0.0})).reason == "UNKNOWN_NAME"
        assert refusal(lambda: inverse(stepped, "arm", np.eye(4), reference="nobody")).reason == "UNKNOWN_NAME"
        assert refusal(lambda: inverse(stepped, "nobody", np.eye(4))).reason == "UNKNOWN_NAME"
