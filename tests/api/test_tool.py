"""Tools, their states and points, adapters; parts that are picked and placed."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot.v1 import motion_pb2, nodes_pb2, scene_pb2

from tests.api.asking import IIWA, PANDA, apply, box, create, joints, load, refusal, start
from tests.api.moving import READY, RUNNING, SUCCEEDED, finished, linear, motion
from tests.api.reading import matrix, pose, random_matrix, scene, state, step, unchanged
from tests.api.test_robot import drawn, forward, inverse, put, robot
from tests.api.test_scene import attach, remove, update
from tests.kernels import Stubs

FLANGE = "arm.lbr_iiwa_link_7"
OPEN, CLOSED = {"panda_finger_joint1": 0.04}, {"panda_finger_joint1": 0.01}


def tool(name: str, parent: str, place: np.ndarray | None = None, **points: np.ndarray) -> nodes_pb2.Node:
    told = [nodes_pb2.ToolCenterPoint(name=point, tool_t_tcp=pose(frame)) for point, frame in points.items()]
    node = nodes_pb2.Node(name=name, parent=parent, tool=nodes_pb2.Tool(tool_center_points=told))
    if place is not None:
        node.parent_t_node.CopyFrom(pose(place))
    return node


def select(robot: str, tool: str = "", point: str = "") -> scene_pb2.Command:
    return scene_pb2.Command(select_tool=scene_pb2.SelectTool(robot=robot, tool=tool, tool_center_point=point))


def pick(robot: str, part: str = "", distance: float = 0.0) -> scene_pb2.Command:
    return scene_pb2.Command(pick_part=scene_pb2.PickPart(robot=robot, part=part, max_distance_meters=distance))


def place(robot: str, part: str = "", parent: str = "") -> scene_pb2.Command:
    return scene_pb2.Command(place_part=scene_pb2.PlacePart(robot=robot, part=part, parent=parent))


def near(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.abs(a - b).max() < 1e-12)


def tcp(stubs: Stubs) -> np.ndarray:
    return matrix(state(stubs, "arm").world_t_tcp)


def test_the_tool_and_its_point_are_what_moves(stepped: Stubs, rng: np.random.Generator) -> None:
    """The law of frames: world_t_tcp = world_t_flange flange_t_adapter adapter_t_tool tool_t_tcp."""
    load(stepped, IIWA, "arm", parent_t_node=pose(random_matrix(rng)))
    put(stepped, "arm", drawn(stepped, "arm", rng))
    assert near(tcp(stepped), scene(stepped, FLANGE)[FLANGE]), "without a tool the flange"
    mount, between, one, two = (random_matrix(rng, 0.2) for _ in range(4))
    adapter = nodes_pb2.Node(name="adapter", parent=FLANGE, adapter=nodes_pb2.Adapter(), parent_t_node=pose(mount))
    apply(stepped, create(adapter), create(tool("gun", "adapter", between, one=one, two=two)))
    flange = scene(stepped, FLANGE)[FLANGE]
    now = state(stepped, "arm")
    assert (now.tool, now.tool_center_point) == ("gun", "one"), "the first tool and its first point are chosen"
    assert near(tcp(stepped), flange @ mount @ between @ one)
    apply(stepped, select("arm", "gun", "two"))
    assert near(tcp(stepped), flange @ mount @ between @ two)
    apply(stepped, select("arm"))
    assert near(tcp(stepped), flange)
    apply(stepped, create(tool("other", FLANGE)), select("arm", "other"))
    assert near(tcp(stepped), flange), "a tool without points has one at its own frame"
    assert list(robot(stepped, "arm").tools) == ["gun", "other"]


def test_lines_and_inverse_are_of_the_chosen_point(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    put(stepped, "arm", READY)
    offset = np.eye(4)
    offset[:3, 3] = 0.05, 0.0, 0.2
    apply(stepped, create(tool("gun", FLANGE, None, tip=offset)))
    goal = tcp(stepped)
    goal[2, 3] += 0.05
    solution = np.frombuffer(inverse(stepped, "arm", goal).solutions.data).reshape(-1, 7)[0]
    names = [joint.name for joint in robot(stepped, "arm").joints]
    reached = matrix(forward(stepped, "arm", dict(zip(names, solution.tolist(), strict=True))).world_t_tcp)
    assert np.abs(reached - goal).max() < 1e-3
    finished(stepped, start(stepped, linear("arm", goal)).id)
    assert np.abs(tcp(stepped) - goal).max() < 1e-5


def test_tools_come_and_go(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    load(stepped, IIWA, "other")
    apply(stepped, create(tool("gun", FLANGE)), create(tool("hook", "other.lbr_iiwa_link_7")))
    with unchanged(stepped):
        refused = refusal(lambda: apply(stepped, select("arm", "hook")))
        assert (refused.reason, refused.metadata["valid"]) == ("UNKNOWN_NAME", "gun")
        assert refusal(lambda: apply(stepped, select("arm", "gun", "tipp"))).reason == "UNKNOWN_NAME"
        assert refusal(lambda: apply(stepped, select("arm", "", "tcp"))).reason == "INVALID_ARGUMENT"
    apply(stepped, attach("gun", "other.lbr_iiwa_link_7"))
    assert (state(stepped, "arm").tool, list(robot(stepped, "other").tools)) == ("", ["gun", "hook"])
    apply(stepped, remove("hook"))
    assert state(stepped, "other").tool == ""


def hand(stubs: Stubs) -> None:
    """Load a Panda whose hand is a tool with the states open and closed."""
    load(stubs, PANDA, "arm")
    states = [nodes_pb2.ToolState(name=n, joint_positions=q) for n, q in (("open", OPEN), ("closed", CLOSED))]
    node = nodes_pb2.Node(name="hand", parent="arm.panda_hand", tool=nodes_pb2.Tool(states=states))
    apply(stubs, create(node))


def finger(stubs: Stubs) -> float:
    return state(stubs, "arm").positions[7]


def to_state(name: str, tool: str = "") -> motion_pb2.Move:
    return motion_pb2.Move(robot="arm", tool_state=motion_pb2.ToolStateMove(tool=tool, state=name))


def test_fingers_move_while_the_arm_moves(stepped: Stubs) -> None:
    hand(stepped)
    assert (finger(stepped), state(stepped, "arm").tool_states["hand"]) == (0.04, "open"), "the first state"
    arm = start(stepped, joints("arm", 0.2, panda_joint1=1.0))
    step(stepped, 30)
    closing = start(stepped, to_state("closed"))
    step(stepped)
    assert state(stepped, "arm").tool_states["hand"] == "open", "until the fingers are there"
    assert finished(stepped, closing.id).phase == SUCCEEDED
    assert (finger(stepped), state(stepped, "arm").tool_states["hand"]) == (pytest.approx(0.01, abs=1e-12), "closed")
    assert finished(stepped, arm.id).phase == SUCCEEDED
    left, right = (scene(stepped)[f"arm.panda_{side}finger"] for side in ("left", "right"))
    assert np.linalg.norm(left[:3, 3] - right[:3, 3]) == pytest.approx(0.02), "the second finger mimics the first"


def test_states_may_be_set_at_once(stepped: Stubs) -> None:
    hand(stepped)
    at_once = scene_pb2.Command(set_tool_state=scene_pb2.SetToolState(tool="hand", state="closed"))
    apply(stepped, at_once)
    assert (finger(stepped), state(stepped, "arm").tool_states["hand"]) == (0.01, "closed")
    opening = start(stepped, to_state("open", "hand"))
    with unchanged(stepped):
        assert refusal(lambda: apply(stepped, at_once)).reason == "ROBOT_BUSY"
        assert refusal(lambda: start(stepped, to_state("closed"))).reason == "ROBOT_BUSY"
        assert refusal(lambda: start(stepped, to_state("clsoed"))).reason == "UNKNOWN_NAME"
        assert refusal(lambda: start(stepped, to_state("closed", "nothing"))).reason == "UNKNOWN_NAME"
    assert motion(stepped, opening.id).phase == RUNNING


def test_states_show_figures(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    figures = [nodes_pb2.Figure(sphere=nodes_pb2.Sphere(radius_meters=0.1), tool_state=name) for name in ("on", "off")]
    states = [nodes_pb2.ToolState(name=name) for name in ("on", "off")]
    lamp = nodes_pb2.Node(name="lamp", parent=FLANGE, figures=figures, tool=nodes_pb2.Tool(states=states))
    apply(stepped, create(lamp))
    apply(stepped, scene_pb2.Command(set_tool_state=scene_pb2.SetToolState(tool="lamp", state="off")))
    assert state(stepped, "arm").tool_states["lamp"] == "off"
    assert finished(stepped, start(stepped, to_state("on")).id).phase == SUCCEEDED, "no joint moves"
    assert state(stepped, "arm").tool_states["lamp"] == "on"
    figures[0].tool_state = "onn"
    wrong = nodes_pb2.Node(name="w", parent=FLANGE, figures=figures, tool=nodes_pb2.Tool(states=states))
    with unchanged(stepped):
        refused = refusal(lambda: apply(stepped, create(wrong)))
        again = refusal(lambda: apply(stepped, update("lamp", "figures", figures=figures)))
    assert again.reason == refused.reason
    assert (refused.reason, "did you mean 'on'" in refused.message) == ("UNKNOWN_NAME", True)


def test_a_picked_part_goes_along_and_stays_where_it_is_placed(stepped: Stubs, rng: np.random.Generator) -> None:
    load(stepped, IIWA, "arm")
    put(stepped, "arm", READY)
    apply(stepped, create(tool("gun", FLANGE)))
    at = tcp(stepped)[:3, 3] + [0.0, 0.0, 0.05]
    apply(stepped, create(box("far", *(at + 0.1))), create(box("near", *at)), create(box("table", z=-0.1)))
    before = scene(stepped)
    apply(stepped, pick("arm"))
    parents = {node.name: node.parent for node in stepped.scene.GetScene(scene_pb2.GetSceneRequest()).nodes}
    assert (parents["near"], parents["far"]) == ("gun", "world"), "the nearest part is picked"
    assert near(scene(stepped)["near"], before["near"])
    grip = np.linalg.inv(tcp(stepped)) @ before["near"]
    ask = start(stepped, joints("arm", 0.5, **drawn(stepped, "arm", rng)))
    for _ in range(10):
        step(stepped, 10)
        assert np.abs(np.linalg.inv(tcp(stepped)) @ scene(stepped)["near"] - grip).max() < 1e-12
    assert finished(stepped, ask.id).phase == SUCCEEDED
    carried = scene(stepped)["near"]
    apply(stepped, place("arm", parent="table"))
    assert near(scene(stepped)["near"], carried)
    put(stepped, "arm", READY)
    assert near(scene(stepped)["near"], carried), "it stays when the arm leaves"
