"""Scene files over the wire: saved and loaded again, here or bundled in a fresh kernel, the world is the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from google.protobuf.message import Message
from virtualrobot.v1 import collision_pb2, geometry_pb2, nodes_pb2, robot_pb2, scene_pb2, signal_pb2

from tests.api.asking import IIWA, MODELS, PANDA, apply, box, create, load, refusal
from tests.api.reading import array, matrices, matrix, pose, random_matrix, unchanged
from tests.api.test_asset import download
from tests.api.test_motion import slowed
from tests.api.test_robot import drawn, put
from tests.api.test_scene import attach, update
from tests.api.test_signal import signals
from tests.api.test_tool import pick, select, tool
from tests.kernels import StartKernel, Stubs

LOAD, SAVE = scene_pb2.LoadSceneRequest, scene_pb2.SaveSceneRequest


def cell(stubs: Stubs, rng: np.random.Generator) -> None:
    """Build a cell of all that a scene file keeps, with random numbers."""
    load(stubs, IIWA, "kuka", parent_t_node=pose(random_matrix(rng)))
    load(stubs, PANDA, "panda", parent_t_node=pose(random_matrix(rng)))
    load(stubs, str(MODELS / "r2d2.urdf"), "droid", base_joint=nodes_pb2.JOINT_TYPE_FLOATING)
    load(stubs, str(MODELS / "kuka_iiwa/meshes/link_0.stl"), "on", scale=geometry_pb2.Vector3(x=1, y=-2, z=0.5))
    states = [
        nodes_pb2.ToolState(name=n, joint_positions={"panda_finger_joint1": q}) for n, q in (("open", 0.04), ("5", 0.0))
    ]
    hand = nodes_pb2.Node(name="hand", parent="panda.panda_hand", tool=nodes_pb2.Tool(states=states))
    home = nodes_pb2.NamedPosture(
        name="home", joint_positions={f"lbr_iiwa_joint_{i}": rng.uniform(-1, 1) for i in (1, 2)}
    )
    material = nodes_pb2.Material(color=geometry_pb2.Color(red=0.1, alpha=0.5), reflectance=0.0, friction=0.9)
    figures = [
        nodes_pb2.Figure(points=nodes_pb2.Points(positions=array(rng.normal(size=(5, 3))), size_meters=0.02)),
        nodes_pb2.Figure(lines=nodes_pb2.Lines(segments=array(rng.normal(size=(4, 2, 3))))),
        nodes_pb2.Figure(frame=nodes_pb2.Frame(), node_t_figure=pose(random_matrix(rng))),
        nodes_pb2.Figure(label=nodes_pb2.Label(text="two\nlines: # & ü")),
        nodes_pb2.Figure(
            capsule=nodes_pb2.Capsule(radius_meters=0.1, length_meters=0.3),
            material=material,
            roles=[nodes_pb2.FIGURE_ROLE_VISUAL],
        ),
    ]
    apply(
        stubs,
        update("kuka", "robot", robot=nodes_pb2.Robot(postures=[home], flange="kuka.lbr_iiwa_link_7")),
        create(nodes_pb2.Node(name="adapter", parent="kuka.lbr_iiwa_link_7", adapter=nodes_pb2.Adapter())),
        create(tool("gun", "adapter", random_matrix(rng, 0.1), a=random_matrix(rng), b=random_matrix(rng))),
        create(hand),
        select("kuka", "gun", "b"),
        create(box("carried", x=0.5)),
        create(box("5", y=rng.uniform(), parent="carried")),
        create(nodes_pb2.Node(name="note", annotation=nodes_pb2.Annotation(), figures=figures, hidden=True)),
        pick("kuka", "carried", 9.0),
        scene_pb2.Command(set_tool_state=scene_pb2.SetToolState(tool="hand", state="5")),
    )
    for name in ("kuka", "panda"):
        put(stubs, name, drawn(stubs, name, rng))
    slowed(stubs, 0.25)
    slowed(stubs, 0.5, "panda")
    signals(stubs, "start", "yes", value=True, description="a: button")
    signals(stubs, "stop")


def told(stubs: Stubs) -> tuple[dict[str, Message], dict[str, np.ndarray]]:
    """Return all that was set up by name, without uids and meshes' names, and all poses by what they are of."""
    answer = stubs.scene.GetScene(scene_pb2.GetSceneRequest())
    messages: dict[str, Message] = {}
    poses: dict[str, np.ndarray] = {}
    for node, world_t_node in zip(answer.nodes, matrices(answer.world_t_node), strict=True):
        poses[f"world_t {node.name}"] = world_t_node
        poses[f"parent_t {node.name}"] = matrix(node.parent_t_node)
        for place, figure in enumerate(node.figures):
            poses[f"{node.name} {place}"] = matrix(figure.node_t_figure)
            figure.ClearField("node_t_figure")
            if figure.HasField("mesh"):
                figure.mesh.ClearField("uri")
        for place, point in enumerate(node.tool.tool_center_points):
            poses[f"{node.name} tcp {place}"] = matrix(point.tool_t_tcp)
            point.ClearField("tool_t_tcp")
        if node.HasField("link"):
            poses[f"inertial {node.name}"] = matrix(node.link.inertial.link_t_inertial)
            node.link.inertial.ClearField("link_t_inertial")
        node.ClearField("uid")
        node.ClearField("parent_t_node")
        messages[f"node {node.name}"] = node
    for state in stubs.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest()).robots:
        poses[f"tcp {state.name}"] = matrix(state.world_t_tcp)
        poses[f"q {state.name}"] = np.array(state.positions)
        state.ClearField("world_t_tcp")
        state.ClearField("positions")
        messages[f"state {state.name}"] = state
    for signal in stubs.signal.GetSignals(signal_pb2.GetSignalsRequest()).signals:
        messages[f"signal {signal.name}"] = signal
    return messages, poses


def assert_equal(a: tuple[dict, dict], b: tuple[dict, dict]) -> None:
    assert a[0].keys() == b[0].keys()
    for name, message in a[0].items():
        assert message == b[0][name]
    assert a[1].keys() == b[1].keys()
    for name, frame in a[1].items():
        assert np.abs(frame - b[1][name]).max(initial=0.0) < 1e-12, name


def test_save_and_load_give_the_same_world(stepped: Stubs, rng: np.random.Generator) -> None:
    cell(stepped, rng)
    before = told(stepped)
    saved = stepped.scene.SaveScene(SAVE())
    assert not saved.files
    stepped.scene.LoadScene(LOAD(text=saved.text))
    assert_equal(told(stepped), before)
    assert stepped.scene.SaveScene(SAVE()).text == saved.text, "the text is the same to the last letter"


@pytest.mark.long
def test_a_bundle_travels_to_a_kernel_that_knows_nothing(
    stepped: Stubs, start_kernel: StartKernel, tmp_path: Path, rng: np.random.Generator
) -> None:
    cell(stepped, rng)
    before = told(stepped)
    saved = stepped.scene.SaveScene(SAVE(bundle=True))
    assert str(MODELS) not in "".join(line for line in saved.text.splitlines() if "source:" not in line)
    for file in saved.files:
        path = tmp_path / file.uri
        assert tmp_path in path.resolve().parents
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"".join(download(stepped, file.sha256)))
    (tmp_path / "scene.yaml").write_text(saved.text, "utf-8")
    fresh = start_kernel("--stepped", str(tmp_path / "scene.yaml"))
    stubs = fresh.stubs()
    assert_equal(told(stubs), before)
    stubs.scene.LoadScene(LOAD(text=saved.text, uri=str(tmp_path / "scene.yaml")))
    assert_equal(told(stubs), before)
    stubs.channel.close()
    assert fresh.end() == 0


def test_a_robot_without_a_chosen_tool_stays_without(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    apply(stepped, create(tool("gun", "arm.lbr_iiwa_link_7")), select("arm"))
    before = told(stepped)
    stepped.scene.LoadScene(LOAD(text=stepped.scene.SaveScene(SAVE()).text))
    assert_equal(told(stepped), before)


def test_add_keeps_what_is_there(stepped: Stubs) -> None:
    apply(stepped, create(box("a")))
    text = "schema_version: 1\nnodes:\n- name: b\n  parent: a\n  object: {}\nsignals:\n- name: s\n"
    assert [one.name for one in stepped.scene.LoadScene(LOAD(text=text, add=True)).created] == ["b"]
    with unchanged(stepped):
        assert refusal(lambda: stepped.scene.LoadScene(LOAD(text=text, add=True))).reason == "NAME_TAKEN"
        assert refusal(lambda: stepped.scene.LoadScene(LOAD(text=text))).reason == "UNKNOWN_NAME", "a goes first"


@pytest.mark.parametrize("name", ["on", "5", "1.0", "null", "yes", "~", "a: b", "#", "ü", "[x]"])
def test_words_stay_words(stepped: Stubs, name: str) -> None:
    """In YAML 1.1 some of these are truth values, numbers or nothing."""
    apply(stepped, create(box(name)))
    signals(stepped, name)
    stepped.scene.LoadScene(LOAD(text=stepped.scene.SaveScene(SAVE()).text))
    nodes = stepped.scene.GetScene(scene_pb2.GetSceneRequest()).nodes
    assert [node.name for node in nodes] == ["world", name]


def test_what_hangs_on_a_link_is_after_the_links_though_it_was_made_before(stepped: Stubs) -> None:
    apply(stepped, create(box("early")))
    load(stepped, PANDA, "arm")
    apply(stepped, create(tool("cup", "arm.panda_link7")), attach("early", "arm.panda_link0"))
    saved = stepped.scene.SaveScene(SAVE()).text
    stepped.scene.LoadScene(LOAD(text=saved))
    assert stepped.scene.SaveScene(SAVE()).text == saved


def test_what_names_nodes_is_in_their_order_whenever_they_were_made(stepped: Stubs) -> None:
    """Loaded nodes have new uids, in the order of the file: saved in that of uids, the next file would be another."""
    apply(stepped, create(box("a")), create(box("b")), create(box("c", parent="a")))
    for first, second, built in (("c", "b", True), ("b", "c", False), ("a", "b", False)):
        pair = nodes_pb2.NodePair(first=first, second=second, reason="so", built=built)
        apply(stepped, scene_pb2.Command(set_allowed_pairs=collision_pb2.SetAllowedPairs(allow=[pair])))
    paddings = [collision_pb2.NodePadding(node=name, padding_meters=0.01) for name in ("b", "c")]
    settings = collision_pb2.SetCollisionSettings(paddings=paddings)
    apply(stepped, scene_pb2.Command(set_collision_settings=settings))
    saved = stepped.scene.SaveScene(SAVE()).text
    stepped.scene.LoadScene(LOAD(text=saved))
    assert stepped.scene.SaveScene(SAVE()).text == saved
