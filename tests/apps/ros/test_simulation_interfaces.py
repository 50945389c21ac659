"""Services of simulation_interfaces, called by roslibpy: entities, time, worlds, and codes of what is refused."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import roslibpy
import virtualrobot
from virtualrobot import Client

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import GUARD, bridge, roslibpy_client, told
from tests.apps.ros.test_ros_actions import SUCCEEDED, Goal
from tests.kernels import KernelProcess
from tests.waiting import until

pytestmark = pytest.mark.long

OK, NOT_FOUND, FAILED = 1, 2, 4
STOPPED, PLAYING, PAUSED, NO_WORLD = 0, 1, 2, 4
BALL = (
    '<robot name="ball"><link name="body"><visual><geometry><sphere radius="0.1"/></geometry></visual></link></robot>'
)

Call = Callable[..., Any]


@pytest.fixture
def world(client: Client) -> Iterator[Client]:
    """Return a client of a stepped world with an arm, a UGV, a table and a target."""
    client.clock.set_stepped()
    client.load_robot(IIWA, name="arm")
    client.load_robot("model://ugv", base="planar", pose=virtualrobot.pose(y=-3.0))
    client.scene.add_object("table", virtualrobot.box(1.0, 2.0, 0.5), pose=virtualrobot.pose(x=4.0, z=0.25))
    client.scene.add_target("dock", pose=virtualrobot.pose(x=1.0, y=2.0, yaw=0.5))
    yield client
    client.clock.set_realtime()


@pytest.fixture
def ros(world: Client) -> Iterator[roslibpy.Ros]:
    """Return roslibpy, connected to a bridge."""
    with bridge(world) as (url, _), roslibpy_client(url) as ros:
        yield ros


@pytest.fixture
def call(ros: roslibpy.Ros) -> Call:
    """Return what calls a service by its type and gives its response; `code` is what its result shall be."""
    return calls_of(ros)


def calls_of(ros: roslibpy.Ros) -> Call:
    """Return what calls services of a bridge by roslibpy."""

    def called(type: str, code: int = OK, **request: object) -> Any:  # noqa: ANN401
        name = "".join(f"_{one.lower()}" if one.isupper() else one for one in type).removeprefix("_")
        service = roslibpy.Service(ros, f"/virtualrobot/{name}", f"simulation_interfaces/{type}")
        response = dict(told(service.call(roslibpy.ServiceRequest(request), timeout=int(GUARD))))
        if "result" in response:
            assert response["result"]["result"] == code, response
        return response

    return called


def pose(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> dict[str, Any]:
    """Return a pose that turns nothing."""
    return {"position": {"x": x, "y": y, "z": z}, "orientation": {"w": 1.0}}


def place(told: dict[str, Any]) -> list[float]:
    """Return x, y, z of a pose."""
    return [told["position"][one] for one in "xyz"]


def test_entities_are_listed_filtered_and_told(world: Client, call: Call) -> None:
    assert call("GetEntities")["entities"] == ["arm", "ugv", "table"]
    assert call("GetEntities", filters={"filter": "^(arm|table)$"})["entities"] == ["arm", "table"]
    assert call("GetEntities", filters={"categories": [{"category": 2}]})["entities"] == ["arm", "ugv"]
    assert call("GetEntities", filters={"tags": {"tags": ["object", "human"]}})["entities"] == ["table"]
    assert call("GetEntities", filters={"tags": {"tags": ["object", "human"], "filter_mode": 1}})["entities"] == []
    corners = [{"x": 3.0, "y": 1.0, "z": 1.0}, {"x": 5.0, "y": 0.5, "z": -1.0}]
    assert call("GetEntities", filters={"bounds": {"type": 0, "points": corners}})["entities"] == ["table"]
    # The table's nearest edge is at x = 3.5 m.
    for radius, found in ((0.49, []), (0.51, ["table"])):
        sphere = [{"x": 3.0, "y": 0.0, "z": 0.2}, {"x": radius}]
        assert call("GetEntities", filters={"bounds": {"type": 2, "points": sphere}})["entities"] == found
    call("GetEntities", 0, filters={"bounds": {"type": 1, "points": corners}})
    call("GetEntities", NOT_FOUND, filters={"filter": "("})

    info = call("GetEntityInfo", entity="ugv")["info"]
    assert (info["category"], info["tags"]) == ({"category": 2}, ["robot"])
    bounds = call("GetEntityBounds", entity="table")["bounds"]
    assert [place({"position": one}) for one in bounds["points"]] == [[0.5, 1.0, 0.25], [-0.5, -1.0, -0.25]]
    found = call("GetEntitiesStates", filters={"filter": "table|ugv"})
    assert found["entities"] == ["ugv", "table"]
    assert place(found["states"][1]["pose"]) == [4.0, 0.0, 0.25]
    assert "there is no entity 'tabel'" in call("GetEntityInfo", NOT_FOUND, entity="tabel")["result"]["error_message"]


def test_a_state_is_set_and_told_as_it_is(world: Client, call: Call) -> None:
    goal = {"pose": pose(1.0, -2.0, 0.1)}
    call("SetEntityState", entity="ugv", state=goal, set_pose=True)
    state = call("GetEntityState", entity="ugv")["state"]
    assert place(state["pose"]) == pytest.approx([1.0, -2.0, 0.1], abs=1e-12)
    base = world.robots["ugv"].links[0]
    assert world.scene.pose(base)[:3, 3] == pytest.approx([1.0, -2.0, 0.1], abs=1e-12)
    with_frame = {"header": {"frame_id": "arm/lbr_iiwa_link_0"}, "pose": pose(0.0, 5.0)}
    call("SetEntityState", entity="table", state=with_frame, set_pose=True)
    assert world.scene.pose("table")[:3, 3] == pytest.approx([0.0, 5.0, 0.0], abs=1e-12)
    # A craft drives as fast as it is told to.
    world.clock.step(500, twists={"ugv": (0.3, 0.0, 0.2)})
    twist = call("GetEntityState", entity="ugv")["state"]["twist"]
    assert np.linalg.norm([twist["linear"][one] for one in "xyz"]) == pytest.approx(0.3, abs=1e-6)
    assert twist["angular"]["z"] == pytest.approx(0.2, abs=1e-6)
    bad = {"pose": {"position": {"x": 1.0}, "orientation": {"w": 3.0}}}
    call("SetEntityState", 109, entity="table", state=bad, set_pose=True)
    call("SetEntityState", 109, entity="table", state={**goal, "header": {"frame_id": "nowhere"}}, set_pose=True)
    call("SetEntityState", 0, entity="table", state=goal, set_twist=True)


def test_entities_are_spawned_and_deleted(world: Client, call: Call) -> None:
    offered = [one["entity_resource"]["uri"] for one in call("GetSpawnables")["spawnables"]]
    assert "model://ugv" in offered
    ball = {"entity_resource": {"resource_string": BALL}, "initial_pose": {"pose": pose(1.0, 1.0, 1.0)}}
    assert call("SpawnEntity", **ball)["entity_name"] == "ball"
    assert world.scene.pose("ball")[:3, 3] == pytest.approx([1.0, 1.0, 1.0])
    call("SpawnEntity", 101, name="arm", **ball)
    assert call("SpawnEntity", name="arm", allow_renaming=True, **ball)["entity_name"] == "arm_2"
    assert call("SpawnEntity", name="one", entity_namespace="/team", **ball)["entity_name"] == "team.one"
    call("SpawnEntity", 105, name="one", entity_namespace="a b", **ball)
    call("SpawnEntity", 104)
    call("SpawnEntity", 103, entity_resource={"resource_string": "no model"})
    call("SpawnEntity", 106, entity_resource={"resource_string": '<robot name="x"><link/></robot>'})
    call("SpawnEntity", 107, entity_resource={"uri": "/nowhere/robot.urdf"})
    call("SpawnEntity", 109, entity_resource={"resource_string": BALL}, initial_pose={"header": {"frame_id": "x"}})
    driving = {"name": "second", "entity_resource": {"uri": "model://ugv?base=planar"}}
    spawned = call("SpawnEntities", 150, spawn_requests=[driving, {"name": "third"}])["results"]
    assert [one["entity_name"] for one in spawned] == ["second", ""]
    assert [one["result"]["result"] for one in spawned] == [OK, 104]
    assert "/robots/second/command/twist" in [one.name for one in world.streams.table()]
    call("DeleteEntity", entity="ball")
    assert "ball" not in world.scene
    call("DeleteEntity", NOT_FOUND, entity="ball")
    call("ResetSimulation", scope=4)
    assert call("GetEntities")["entities"] == ["arm", "ugv", "table"]


def test_time_is_paused_stepped_and_reset(world: Client, ros: roslibpy.Ros, call: Call) -> None:
    assert call("GetSimulationState")["state"]["state"] == PAUSED
    call("SetSimulationState", 101, state={"state": PAUSED})
    began = world.clock.read().stamp.tick
    call("StepSimulation", steps=25)
    assert world.clock.read().stamp.tick == began + 25
    assert "simulate_steps takes more" in call("StepSimulation", FAILED, steps=2**40)["result"]["error_message"]
    goal = Goal(ros, "/virtualrobot/simulate_steps", "simulation_interfaces/action/SimulateSteps", {"steps": 40})
    ended = goal.result()
    assert (ended["status"], ended["values"]["result"]["result"]) == (SUCCEEDED, OK)
    assert [one["completed_steps"] for one in goal.feedback] == list(range(1, 41))
    assert world.clock.read().stamp.tick == began + 65
    world.robot("arm").set_positions([0.5] * 7)
    call("SpawnEntity", name="ball", entity_resource={"resource_string": BALL})
    call("ResetSimulation", 0, scope=1)
    call("ResetSimulation", 0, scope=2)
    with bridge(world, name="another bridge"):  # which keeps the world as it is now, and ends
        pass
    call("ResetSimulation")
    assert call("GetEntities")["entities"] == ["arm", "ugv", "table"]
    assert world.robot("arm").positions.tolist() == [0.0] * 7
    call("SetSimulationState", state={"state": PLAYING})
    assert world.clock.mode == "realtime"
    assert "pause the simulation" in call("StepSimulation", FAILED, steps=1)["result"]["error_message"]
    world.robot("arm").stop()
    call("SetSimulationState", state={"state": STOPPED})
    assert call("GetSimulationState")["state"]["state"] == STOPPED
    call("SetSimulationState", 0, state={"state": 3})


def test_worlds_are_loaded_and_unloaded(world: Client, call: Call, tmp_path: Path) -> None:
    world.scene.save(tmp_path / "cell.yaml")
    (tmp_path / "notes.txt").write_text("no world")
    found = call("GetAvailableWorlds", additional_sources=[str(tmp_path)])["worlds"]
    assert [one["name"] for one in found] == ["cell"]
    call("GetAvailableWorlds", FAILED, additional_sources=["/nowhere"])
    call("UnloadWorld")
    assert call("GetEntities")["entities"] == []
    assert call("GetSimulationState")["state"]["state"] == NO_WORLD
    call("GetCurrentWorld", 101)
    call("UnloadWorld", 101)
    assert call("LoadWorld", world_resource=found[0]["world_resource"])["world"]["name"] == "cell"
    assert call("GetEntities")["entities"] == ["arm", "ugv", "table"]
    assert call("GetSimulationState")["state"]["state"] == STOPPED
    call("DeleteEntity", entity="table")
    call("ResetSimulation")
    assert "table" in world.scene
    assert call("GetCurrentWorld")["world"]["name"] == "cell"
    call("LoadWorld", world_resource={"resource_string": "schema_version: 1\n"})
    call("LoadWorld", 102)
    call("LoadWorld", 103, world_resource={"resource_string": "nodes: [}"})
    call("LoadWorld", 104, world_resource={"uri": str(tmp_path / "other.yaml")})


def test_features_and_named_poses_are_told(world: Client, call: Call) -> None:
    features = call("GetSimulatorFeatures")["features"]
    assert {0, 31, 50} <= set(features["features"]) and "urdf" in features["spawn_formats"]
    found = call("GetNamedPoses")["poses"]
    assert [one["name"] for one in found] == ["dock"] and place(found[0]["pose"]) == [1.0, 2.0, 0.0]
    assert found[0]["pose"]["orientation"]["z"] == pytest.approx(np.sin(0.25), abs=1e-12)
    assert call("GetNamedPoses", tags={"tags": ["parking"]})["poses"] == []


def test_collision_objects_stand_in_the_scene(world: Client, ros: roslibpy.Ros) -> None:
    topic = roslibpy.Topic(ros, "/collision_object", "moveit_msgs/CollisionObject")
    topic.advertise()

    def tell(operation: int, **fields: object) -> None:
        topic.publish({"header": {"frame_id": "world"}, "id": "bin", "operation": operation, **fields})

    box = {"primitives": [{"type": 1, "dimensions": [0.2, 0.4, 0.6]}], "primitive_poses": [pose(z=0.3)]}
    tell(0, pose=pose(2.0, 1.0), **box)
    until(lambda: "bin" in world.scene)
    assert world.scene.pose("bin")[:3, 3].tolist() == [2.0, 1.0, 0.0]
    box_of_it = np.array([[-0.1, -0.2, 0.0], [0.1, 0.2, 0.6]])
    assert world.scene.bounds("bin") == pytest.approx(box_of_it, abs=1e-6)
    corners = [{"x": x, "y": y, "z": 1.0} for x, y in ((0, 0), (1, 0), (0, 1))]
    mesh = {"triangles": [{"vertex_indices": [0, 1, 2]}], "vertices": corners}
    rod = {"primitives": [{"type": 3, "dimensions": [2.0, 0.05]}], "primitive_poses": [pose()]}
    tell(2, **rod, meshes=[mesh], mesh_poses=[pose()])
    wide = np.array([[-0.1, -0.2, -1.0], [1.0, 1.0, 1.0]])
    until(lambda: np.allclose(np.asarray(world.scene.bounds("bin")), wide, atol=1e-6))
    tell(3, pose=pose(-2.0))
    until(lambda: world.scene.pose("bin")[0, 3] == -2.0)
    tell(0, primitives=[{"type": 2, "dimensions": [0.1, 0.1]}], primitive_poses=[pose()])
    tell(1)
    until(lambda: "bin" not in world.scene)


def test_version_1_has_its_own_fields(client: Client, kernel: KernelProcess) -> None:
    environment = {**os.environ, "VIRTUALROBOT_ADDRESS": kernel.address}
    command = [sys.executable, "-m", "virtualrobot", "ros", "--port", "0", "--simulation-interfaces", "1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        try:
            url = process.stdout.readline().removeprefix("rosbridge at ").strip()
            with roslibpy_client(url) as ros:
                called = calls_of(ros)
                offered = [one["uri"] for one in called("GetSpawnables")["spawnables"]]
                assert "model://ugv" in offered
                spawned = called("SpawnEntity", name="one", uri="model://ugv?base=planar")
                assert spawned["entity_name"] == "one"
                again = called("SpawnEntity", name="two", resource_string=BALL)
                assert again["entity_name"] == "two" and {"one", "two"} <= set(called("GetEntities")["entities"])
                features = called("GetSimulatorFeatures")["features"]["features"]
                assert max(features) == 33 and 0 in features
                assert not [one for one in told(ros.get_services()) if "world" in one or "spawn_entities" in one]
        finally:
            process.terminate()
