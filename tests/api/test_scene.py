"""SceneService: changes as one whole, reading parts of the tree, names, uids, parents."""

from __future__ import annotations

from typing import Any

import grpc
import numpy as np
import pytest
from google.protobuf.field_mask_pb2 import FieldMask
from virtualrobot._wire.signal_values import value_message
from virtualrobot.v1 import (
    collision_pb2,
    geometry_pb2,
    nodes_pb2,
    robot_pb2,
    scene_pb2,
    sensing_pb2,
    sensor_pb2,
    signal_pb2,
)

from tests.api.asking import IIWA, apply, box, create, load, refusal
from tests.api.reading import matrices, matrix, pose, random_matrix, scene, unchanged
from tests.kernels import KernelProcess, Stubs

GET = scene_pb2.GetSceneRequest


def remove(name: str) -> scene_pb2.Command:
    return scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name=name))


def attach(name: str, parent: str = "", parent_t_node: np.ndarray | None = None) -> scene_pb2.Command:
    command = scene_pb2.AttachNode(name=name, parent=parent)
    if parent_t_node is not None:
        command.parent_t_node.CopyFrom(pose(parent_t_node))
    return scene_pb2.Command(attach_node=command)


def update(name: str, /, *mask: str, **fields: Any) -> scene_pb2.Command:  # noqa: ANN401 fields of Node
    node = nodes_pb2.Node(**fields)
    return scene_pb2.Command(update_node=scene_pb2.UpdateNode(name=name, node=node, update_mask=FieldMask(paths=mask)))


def revision(stubs: Stubs) -> int:
    return stubs.scene.GetScene(GET()).stamp.structure_revision


def test_a_batch_is_applied_as_one_change(stepped: Stubs) -> None:
    before = revision(stepped)
    signal = scene_pb2.Command(
        create_signal=scene_pb2.CreateSignal(signal=signal_pb2.Signal(name="s", value=value_message(True)))
    )
    answer = apply(stepped, create(box("a")), create(box("b", parent="a")), signal, attach("b"))
    assert [created.name for created in answer.created] == ["a", "b"]
    assert answer.stamp.structure_revision == before + 1
    assert answer.stamp.structure_revision == revision(stepped)


def test_one_refused_command_leaves_nothing_of_the_batch(stepped: Stubs) -> None:
    apply(stepped, create(box("a")))
    with unchanged(stepped):
        refused = refusal(lambda: apply(stepped, create(box("b")), create(box("c")), attach("b", "a"), remove("d")))
    assert refused.reason == "UNKNOWN_NAME"
    assert refused.metadata["command_index"] == "3"
    assert refused.metadata["name"] == "d"
    assert apply(stepped, create(box("b"))).created[0].name == "b"


def test_a_batch_sets_collisions_pairs_kinematics_and_sensors_together(stepped: Stubs) -> None:
    Command = scene_pb2.Command
    load(stepped, IIWA, "arm")
    eye = nodes_pb2.Node(name="eye", range_sensor=sensing_pb2.RangeSensor())
    pair = nodes_pb2.NodePair(first="arm", second="box", reason="it stands there")
    commands = [
        create(box("box", x=9.0)),
        create(eye),
        Command(set_collision_settings=collision_pb2.SetCollisionSettings(mode=collision_pb2.COLLISION_MODE_STOP)),
        Command(set_allowed_pairs=collision_pb2.SetAllowedPairs(allow=[pair])),
        Command(set_kinematics=robot_pb2.KinematicsChoice(robot="arm", kinematics="chain")),
        Command(start_sensors=sensor_pb2.StartSensors(sensors=["eye"])),
    ]
    with unchanged(stepped):
        assert refusal(lambda: apply(stepped, *commands, remove("nobody"))).metadata["command_index"] == "6"
        wrong = Command(set_kinematics=robot_pb2.KinematicsChoice(robot="arm", kinematics="chian"))
        assert refusal(lambda: apply(stepped, *commands, wrong)).metadata["nearest"] == "chain"
    apply(stepped, *commands)
    collision = stepped.collision.GetCollisionSettings(collision_pb2.GetCollisionSettingsRequest())
    assert collision.settings.mode == collision_pb2.COLLISION_MODE_STOP
    assert "it stands there" in stepped.scene.SaveScene(scene_pb2.SaveSceneRequest()).text
    assert stepped.robot.GetRobot(robot_pb2.GetRobotRequest(name="arm")).kinematics == "chain"
    running = sensor_pb2.SENSOR_STATE_RUNNING
    assert [one.state for one in stepped.sensor.ListSensors(sensor_pb2.ListSensorsRequest()).sensors] == [running]
    apply(stepped, Command(stop_sensors=sensor_pb2.StopSensors()))
    assert stepped.sensor.ListSensors(sensor_pb2.ListSensorsRequest()).sensors[0].state != running


def test_a_repeated_request_is_done_once(stepped: Stubs) -> None:
    model = scene_pb2.ModelSource(uri=IIWA)
    asked = scene_pb2.ImportModelRequest(model=model, request_id="a7")
    both = [stepped.scene.ImportModel.future(asked) for _ in range(2)]
    first = both[0].result()
    assert both[1].result() == first and stepped.scene.ImportModel(asked) == first
    batch = scene_pb2.ApplyRequest(commands=[create(box("box"))], request_id="a9")
    done = stepped.scene.Apply(batch)
    with unchanged(stepped):
        assert stepped.scene.Apply(batch) == done
        other = scene_pb2.ApplyRequest(commands=[create(box("other"))], request_id="a9")
        assert "belongs to another request" in refusal(lambda: stepped.scene.Apply(other)).message
        other.request_id = "x" * 201
        assert "200 characters" in refusal(lambda: stepped.scene.Apply(other)).message
    loaded = scene_pb2.LoadSceneRequest(
        text="schema_version: 1\nnodes: [{name: mug, object: {}}]", add=True, request_id="b1"
    )
    assert stepped.scene.LoadScene(loaded) == stepped.scene.LoadScene(loaded)
    wrong = scene_pb2.ApplyRequest(commands=[remove("ghost")], request_id="a8")
    assert refusal(lambda: stepped.scene.Apply(wrong)).reason == "UNKNOWN_NAME"
    apply(stepped, create(box("ghost")))
    assert stepped.scene.Apply(wrong).stamp.structure_revision, "what was refused may be tried again"


def test_a_stale_revision_is_refused_and_says_which_holds(stepped: Stubs) -> None:
    seen = revision(stepped)
    apply(stepped, create(box("a")))
    request = scene_pb2.ApplyRequest(commands=[create(box("b"))], expected_structure_revision=seen)
    with unchanged(stepped):
        refused = refusal(lambda: stepped.scene.Apply(request))
    assert (refused.code, refused.reason) == (grpc.StatusCode.ABORTED, "STALE_REVISION")
    assert (refused.metadata["revision"], refused.metadata["expected_structure_revision"]) == (str(seen + 1), str(seen))
    request.expected_structure_revision = seen + 1
    assert stepped.scene.Apply(request).stamp.structure_revision == seen + 2


def test_an_update_changes_what_its_mask_names(stepped: Stubs, rng: np.random.Generator) -> None:
    uid = apply(stepped, create(box("a", x=1.0)), create(box("b", parent="a"))).created[0].uid
    place = random_matrix(rng)
    apply(stepped, update("a", "hidden", name="ignored", hidden=True, parent_t_node=pose(place)))
    a = stepped.scene.GetScene(GET(names=["a"])).nodes[0]
    assert (a.hidden, a.parent_t_node.position.x, len(a.figures)) == (True, 1.0, 1)
    sphere = nodes_pb2.Figure(sphere=nodes_pb2.Sphere(radius_meters=0.2))
    fields = {"name": "c", "parent_t_node": pose(place), "figures": [sphere], "part": nodes_pb2.Part(mass_kilograms=2)}
    apply(stepped, update("a", *fields, **fields))
    c, b = stepped.scene.GetScene(GET(names=["c", "b"])).nodes
    assert (c.uid, c.hidden, b.parent) == (uid, True, "c")
    assert (c.figures[0].sphere.radius_meters, c.part.mass_kilograms) == (0.2, 2.0)
    assert np.abs(matrix(c.parent_t_node) - place).max() < 1e-12
    assert np.abs(scene(stepped, "b")["b"] - place).max() < 1e-12, "what hangs below goes along"


@pytest.mark.parametrize("mask", [[], ["uid"], ["parent"], ["nonsense"], ["parent_t_node.position"]])
def test_an_update_needs_a_mask_of_fields_that_can_change(stepped: Stubs, mask: list[str]) -> None:
    apply(stepped, create(box("a", x=1.0)))
    with unchanged(stepped):
        refused = refusal(lambda: apply(stepped, update("a", *mask, parent_t_node=pose(np.eye(4)))))
    assert refused.reason in ("INVALID_ARGUMENT", "UNKNOWN_NAME")
    assert "parent_t_node" in refused.message + refused.metadata.get("valid", "")


def test_parts_of_the_scene_by_name_and_mask(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    apply(stepped, create(box("a", x=0.3)))
    mask = FieldMask(paths=["name", "parent"])
    answer = stepped.scene.GetScene(GET(names=["a", "arm.lbr_iiwa_link_1"], read_mask=mask))
    assert [(node.name, node.parent) for node in answer.nodes] == [
        ("a", "world"),
        ("arm.lbr_iiwa_link_1", "arm.lbr_iiwa_link_0"),
    ]
    assert all(node.uid == 0 and not node.figures and node.WhichOneof("kind") is None for node in answer.nodes)
    assert matrices(answer.world_t_node)[0, 0, 3] == 0.3
    refused = refusal(lambda: stepped.scene.GetScene(GET(read_mask=FieldMask(paths=["nmae"]))))
    assert refused.reason == "UNKNOWN_NAME"
    assert "did you mean 'name'" in refused.message
    refused = refusal(lambda: stepped.scene.GetScene(GET(names=["arm.lbr_iiwa_link_77"])))
    assert (refused.code, refused.reason) == (grpc.StatusCode.NOT_FOUND, "UNKNOWN_NAME")
    assert "arm.lbr_iiwa_link_7" in refused.message


def test_parents_come_before_children(stepped: Stubs) -> None:
    apply(stepped, *(create(box(name)) for name in "abcd"))
    apply(stepped, attach("a", "d"), attach("c", "a"), attach("b", "c"))
    told = {"": 0}
    for node in stepped.scene.GetScene(GET()).nodes:
        assert node.parent in told
        told[node.name] = node.uid


@pytest.mark.parametrize("name", ["a", "", " a", "world"])
def test_names_are_unique_and_not_empty(stepped: Stubs, name: str) -> None:
    apply(stepped, create(box("a")), create(box("b")))
    with unchanged(stepped):
        created = refusal(lambda: apply(stepped, create(box(name))))
        renamed = refusal(lambda: apply(stepped, update("b", "name", name=name)))
    assert {created.reason, renamed.reason} == {"NAME_TAKEN" if name in ("a", "world") else "INVALID_ARGUMENT"}


def test_two_clients_see_each_other_s_nodes(stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    other = stepped_kernel.stubs()
    apply(stepped, create(box("mine")))
    apply(other, create(box("yours", parent="mine")))
    assert set(scene(stepped)) == set(scene(other)) == {"world", "mine", "yours"}
    other.channel.close()
    assert scene(stepped, "yours")["yours"].shape == (4, 4), "what a client made stays when it leaves"


def test_models_imported_at_once_get_names_that_differ(stepped: Stubs) -> None:
    requests = [scene_pb2.ImportModelRequest(model=scene_pb2.ModelSource(uri=IIWA)) for _ in range(6)]
    calls = [stepped.scene.ImportModel.future(request) for request in requests]
    names = {call.result(60).created[0].name for call in calls}
    assert len(names) == len(calls)


def test_mesh_files_become_objects_or_parts(stepped: Stubs) -> None:
    mesh = IIWA.replace("model.urdf", "meshes/link_0.stl")
    answer = load(stepped, mesh, "thing", as_part=True, scale=geometry_pb2.Vector3(x=1, y=-1, z=2))
    node = stepped.scene.GetScene(GET(names=["thing"])).nodes[0]
    assert (answer.mesh_count, node.WhichOneof("kind"), node.figures[0].mesh.scale.y) == (1, "part", -1.0)
    assert load(stepped, mesh).created[0].name == "link_0"
