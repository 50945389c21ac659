"""PathService: what finds a way round a wall over TCP, and whether the motion that runs along it touches anything."""

from __future__ import annotations

import threading
import time

import grpc
import numpy as np
import pytest
from virtualrobot.v1 import collision_pb2, geometry_pb2, motion_pb2, nodes_pb2, path_pb2, robot_pb2, scene_pb2

from tests.api.asking import IIWA, PANDA, apply, create, load, refusal
from tests.api.moving import SUCCEEDED, motion
from tests.api.reading import matrix, state, step
from tests.kernels import Stubs
from tests.unit.paths.cells import LEFT, PANDA_LEFT, PANDA_RIGHT, RIGHT

ROBOTS = {"iiwa": (IIWA, LEFT, RIGHT), "panda": (PANDA, PANDA_LEFT, PANDA_RIGHT)}


def slab(name: str, size: tuple[float, float, float], x: float, z: float) -> nodes_pb2.Node:
    return nodes_pb2.Node(
        name=name,
        object=nodes_pb2.SceneObject(),
        parent_t_node=geometry_pb2.Pose(position=geometry_pb2.Vector3(x=x, z=z)),
        figures=[nodes_pb2.Figure(box=nodes_pb2.Box(size=geometry_pb2.Vector3(x=size[0], y=size[1], z=size[2])))],
    )


def joint_goal(positions: dict[str, float]) -> motion_pb2.PointToPoint:
    return motion_pb2.PointToPoint(joints=motion_pb2.JointGoal(joint_positions=positions))


def asked(
    goal: dict[str, float] | motion_pb2.PointToPoint, robot: str = "arm", **fields: object
) -> path_pb2.FindPathRequest:
    target = joint_goal(goal) if isinstance(goal, dict) else goal
    return path_pb2.FindPathRequest(robot=robot, goal=target, **fields)  # pyright: ignore[reportArgumentType]


def found(stubs: Stubs, request: path_pb2.FindPathRequest) -> path_pb2.FoundPath:
    *_, last = stubs.path.FindPath(request, timeout=120)
    return last.path


def put(stubs: Stubs, positions: dict[str, float], robot: str = "arm") -> None:
    there = scene_pb2.SetJointPositions(robot=robot, joint_positions=positions)
    apply(stubs, scene_pb2.Command(set_joint_positions=there))


def cell(stubs: Stubs, kind: str = "iiwa") -> dict[str, float]:
    """Put an arm left of a wall; return where its right is."""
    uri, left, right = ROBOTS[kind]
    load(stubs, uri, "arm")
    apply(stubs, create(slab("wall", (0.6, 0.05, 0.8), x=0.8, z=0.4)))
    put(stubs, left)
    if kind == "panda":
        # Its fingers touch when they are closed, which is no matter of the path.
        put(stubs, {"panda_finger_joint1": 0.03})
    return right


def touching(stubs: Stubs) -> list[tuple[str, str]]:
    pairs = stubs.collision.CheckCollision(collision_pb2.CheckCollisionRequest()).pairs
    return [(pair.first, pair.second) for pair in pairs]


def drive(stubs: Stubs, steps: list[motion_pb2.ProgramStep], ticks: int = 3) -> set[tuple[str, str]]:
    """Run a program tick by tick; return what touched on its way."""
    leave = motion_pb2.DISCONNECT_POLICY_CONTINUE
    id = stubs.motion.StartMotion(
        motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(steps=steps), on_disconnect=leave)
    ).motion.id
    touched = set()
    for _ in range(10_000):
        touched |= set(touching(stubs))
        step(stubs, ticks)
        if motion(stubs, id).phase == SUCCEEDED:
            return touched | set(touching(stubs))
    raise AssertionError("it never ended")


def positions(stubs: Stubs) -> dict[str, float]:
    joints = stubs.robot.GetRobot(robot_pb2.GetRobotRequest(name="arm")).joints
    names = [joint.name for joint in joints]
    return dict(zip(names, state(stubs, "arm").positions, strict=True))


@pytest.mark.parametrize("kind", ["iiwa", "panda"])
@pytest.mark.long
def test_an_arm_comes_round_a_wall_and_touches_nothing_on_its_way(stepped: Stubs, kind: str, seed: int) -> None:
    right = cell(stepped, kind)
    straight = motion_pb2.Move(robot="arm", point_to_point=joint_goal(right))
    assert any("wall" in pair for pair in drive(stepped, [_alone(straight)]))
    put(stepped, ROBOTS[kind][1])
    path = found(stepped, asked(right, seed=seed, time_limit_seconds=60.0))
    assert (
        not path.straight
        and path.length > path.straight_length > 0.0
        and path.planner == path_pb2.PATH_PLANNER_RRT_CONNECT
    )
    assert len(path.spec.steps) == len(path.waypoints) - 1 >= 2 and path.planning_seconds > 0.0
    assert drive(stepped, list(path.spec.steps)) == set()
    reached = positions(stepped)
    assert {name: reached[name] for name in right} == pytest.approx(right)


def _alone(move: motion_pb2.Move) -> motion_pb2.ProgramStep:
    return motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[move]))


@pytest.mark.long
def test_progress_comes_before_the_path_and_the_time_is_kept(stepped: Stubs) -> None:
    """Who uses all the time has told several times how far it is."""
    right = cell(stepped)
    began = time.monotonic()
    responses = list(
        stepped.path.FindPath(asked(right, planner=path_pb2.PATH_PLANNER_RRT_STAR, time_limit_seconds=3.0), timeout=120)
    )
    assert time.monotonic() - began >= 3.0 * 0.6
    *before, last = responses
    assert len(before) >= 3 and not any(one.HasField("path") for one in before)
    assert [one.elapsed_seconds for one in responses] == sorted(one.elapsed_seconds for one in responses)
    assert last.HasField("path") and last.checks > 0 and last.stamp.structure_revision > 0


@pytest.mark.long
def test_the_held_part_goes_along(stepped: Stubs) -> None:
    """A beam on the flange, out of the wall's reach without it: without the beam the straight way is free."""
    load(stepped, IIWA, "arm")
    apply(stepped, create(slab("wall", (0.6, 0.05, 0.2), x=0.8, z=0.1)))
    put(stepped, LEFT)
    assert found(stepped, asked(RIGHT)).straight
    beam = slab("beam", (0.04, 0.04, 0.5), x=0.0, z=0.3)
    beam.parent = "arm.lbr_iiwa_link_7"
    apply(stepped, create(beam))
    before = touching(stepped)
    assert before == []
    path = found(stepped, asked(RIGHT, time_limit_seconds=60.0))
    assert not path.straight
    assert drive(stepped, list(path.spec.steps)) == set()


@pytest.mark.long
def test_a_pose_is_reached_from_elsewhere(stepped: Stubs) -> None:
    """The goal is where the tool centre point is on the right; the start is on the left, where the arm is not."""
    right = cell(stepped)
    put(stepped, right)
    there = state(stepped, "arm").world_t_tcp
    goal = motion_pb2.PointToPoint(pose=motion_pb2.PoseGoal(reference_t_tcp=there))
    start = motion_pb2.JointGoal(joint_positions=LEFT)
    path = found(stepped, asked(goal, start=start, time_limit_seconds=60.0))
    assert not path.straight
    first = dict(zip(path.joint_names, path.waypoints[0].positions, strict=True))
    assert {name: first[name] for name in LEFT} == pytest.approx(LEFT)
    put(stepped, LEFT)
    assert drive(stepped, list(path.spec.steps)) == set()
    reached = state(stepped, "arm").world_t_tcp
    np.testing.assert_allclose(matrix(reached), matrix(there), atol=1e-6)


@pytest.mark.long
def test_equal_seeds_find_equal_paths(stepped: Stubs) -> None:
    right = cell(stepped)
    paths = [found(stepped, asked(right, seed=7, time_limit_seconds=60.0)) for _ in range(2)]
    assert paths[0].waypoints == paths[1].waypoints and paths[0].spec == paths[1].spec


def test_who_goes_away_ends_the_search_and_the_next_one_begins(stepped: Stubs) -> None:
    right = cell(stepped)
    call = stepped.path.FindPath(
        asked(right, planner=path_pb2.PATH_PLANNER_INFORMED_RRT_STAR, time_limit_seconds=600.0)
    )
    assert not next(iter(call)).HasField("path")
    call.cancel()
    assert len(found(stepped, asked(right, time_limit_seconds=60.0)).waypoints) > 1


def test_time_goes_on_while_a_path_is_looked_for(stubs: Stubs) -> None:
    right = cell(stubs)
    call = stubs.path.FindPath(asked(right, planner=path_pb2.PATH_PLANNER_RRT_STAR, time_limit_seconds=600.0))
    ticks, over = [], threading.Event()

    def watch() -> None:
        for response in call:
            ticks.append(response.elapsed_seconds)
            if len(ticks) == 4:
                over.set()
                return

    threading.Thread(target=watch, daemon=True).start()
    moved = stubs.motion.StartMotion(
        motion_pb2.StartMotionRequest(
            spec=motion_pb2.MotionSpec(
                moves=[motion_pb2.Move(robot="arm", point_to_point=joint_goal({"lbr_iiwa_joint_7": 0.1}))]
            ),
            on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE,
        )
    ).motion.id
    *_, last = stubs.motion.WatchMotion(motion_pb2.WatchMotionRequest(id=moved), timeout=60)
    assert last.motion.phase == SUCCEEDED and over.wait(60.0)
    call.cancel()


def test_refusals(stepped: Stubs) -> None:
    right = cell(stepped)

    def refused(request: path_pb2.FindPathRequest) -> tuple[str, str]:
        answer = refusal(lambda: list(stepped.path.FindPath(request, timeout=120)))
        return answer.reason, answer.message

    inside = {**LEFT, "lbr_iiwa_joint_1": 0.0}
    reason, message = refused(asked(inside))
    assert reason == "COLLISION" and "at the goal" in message and "'wall'" in message
    reason, message = refused(asked(right, start=motion_pb2.JointGoal(joint_positions=inside)))
    assert reason == "COLLISION" and "at the start" in message and "'wall'" in message
    assert refused(asked({"lbr_iiwa_joint_2": 3.0}))[0] == "LIMIT_EXCEEDED"
    assert refused(asked({"elbow": 1.0}))[0] == "UNKNOWN_NAME"
    assert refused(asked(right, robot="leg"))[0] == "UNKNOWN_NAME"
    reason, message = refused(asked(right, planner=99))
    assert reason == "INVALID_ARGUMENT" and "PATH_PLANNER_RRT_CONNECT" in message
    far = geometry_pb2.Pose(position=geometry_pb2.Vector3(x=9.0), orientation=geometry_pb2.Quaternion(w=1.0))
    goal = motion_pb2.PointToPoint(pose=motion_pb2.PoseGoal(reference_t_tcp=far))
    assert refused(asked(goal))[0] == "UNREACHABLE"
    assert refused(asked(right, time_limit_seconds=1e4))[0] == "LIMIT_EXCEEDED"
    for metres in (-0.01, 1.5):
        reason, message = refused(asked(right, clearance_meters=metres))
        assert reason == "LIMIT_EXCEEDED" and "clearance_meters must be from 0 to 1" in message
    reason, message = refused(asked(right, clearance_meters=0.5))
    assert reason == "COLLISION" and "is nearer to 'wall' than 0.5 m" in message
    for field, value in (
        ("blend_percent", 51.0),
        ("clearance_meters", float("nan")),
        ("speed_factor", 2.0),
        ("time_limit_seconds", float("nan")),
    ):
        wrong = asked(right)
        setattr(wrong, field, value)
        reason, message = refused(wrong)
        assert reason == "INVALID_ARGUMENT" and field in message
    reason, message = refused(asked(motion_pb2.PointToPoint()))
    assert reason == "INVALID_ARGUMENT" and "goal" in message


def test_no_path_in_time_is_unreachable(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    slabs = ((2.0, 0.05, 3.0), 1.2, 0.0), ((2.0, 0.05, 3.0), -1.2, 0.0), ((0.5, 0.05, 2.0), 0.0, 1.6)
    apply(stepped, *(create(slab(f"wall {place}", *one)) for place, one in enumerate(slabs)))
    put(stepped, LEFT)
    answer = refusal(lambda: list(stepped.path.FindPath(asked(RIGHT, time_limit_seconds=1.0), timeout=120)))
    assert answer.reason == "UNREACHABLE" and answer.code is grpc.StatusCode.OUT_OF_RANGE
    assert int(answer.metadata["states"]) > 0
