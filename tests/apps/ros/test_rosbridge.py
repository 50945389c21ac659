"""The bridge by rosbridge, with clients of others: roslibpy, and bare WebSockets with cbor2 and Pillow."""

from __future__ import annotations

import base64
import io
import json
import math
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cbor2
import numpy as np
import pytest
import roslibpy
import virtualrobot
from PIL import Image
from rosbags.typesys import Stores, get_typestore
from virtualrobot import Client
from virtualrobot.errors import MalformedFileError
from virtualrobot_apps.bridges.ros.bridge_file import read_choice
from virtualrobot_apps.bridges.ros.rosbridge.server import RosbridgeServer
from websockets.exceptions import InvalidStatus

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import GUARD, Heard, answer, bridge, roslibpy_client, say, socket, stamp_of, told
from tests.kernels import StartKernel
from tests.waiting import repeated

pytestmark = pytest.mark.long

TICK = 0.004
WALL = 2.0
"""Distance (m) of a wall's surface from the scanner."""


@pytest.fixture
def world(client: Client) -> Iterator[Client]:
    """Return a client of a stepped world with an arm, a UGV, a scanner before a wall, and a camera."""
    client.clock.set_stepped()
    client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(y=3.0))
    client.load_robot("model://ugv", base="planar", pose=virtualrobot.pose(y=-3.0))
    flat = virtualrobot.fan(5, -0.4, 0.4)
    client.scene.add_range_sensor("scanner", virtualrobot.range_sensor(pattern=flat, rate=10.0))
    client.scene.add_range_sensor(
        "cloud", virtualrobot.range_sensor(pattern=virtualrobot.raster(4, 3, 0.4, 0.2), rate=10.0)
    )
    client.scene.add_camera("eye", virtualrobot.camera(64, 48, images=["color", "depth"], rate=10.0))
    wall = virtualrobot.box(0.2, 6.0, 4.0)
    client.scene.add_object("wall", wall, pose=virtualrobot.pose(x=WALL + 0.1))
    yield client
    client.clock.set_realtime()


@pytest.fixture
def url(world: Client) -> Iterator[str]:
    """Return the address of a bridge."""
    with bridge(world) as (url, _):
        yield url


@pytest.fixture
def ros(url: str) -> Iterator[roslibpy.Ros]:
    """Return roslibpy, connected."""
    with roslibpy_client(url) as ros:
        yield ros


def test_joints_are_those_of_the_kernels_own_client_bit_by_bit(world: Client, ros: roslibpy.Ros) -> None:
    heard = Heard(ros, "/arm/joint_states", "sensor_msgs/JointState")
    heard.next()
    arm = world.robot("arm")
    arm.move_joints({"lbr_iiwa_joint_2": 0.7, "lbr_iiwa_joint_4": -0.9}, wait=False)
    with world.streams.watch("/robots/arm/joint_states") as watch:
        world.clock.step(60)
        own = {}
        while len(own) < 61:
            sample = watch.next(GUARD)
            assert sample is not None
            own[sample.nanoseconds] = sample.values
    last = max(own)
    came = heard.until(lambda message: stamp_of(message) >= last)
    moved = [one for one in came if stamp_of(one) in own]
    assert len(moved) >= 60, "each tick that moves a joint is told"
    for one in moved:
        values = own[stamp_of(one)]
        assert one["name"] == [f"lbr_iiwa_joint_{number}" for number in range(1, 8)] and one["effort"] == []
        assert one["position"] == [values[f"{name}/position"] for name in one["name"]]
        assert one["velocity"] == [values[f"{name}/velocity"] for name in one["name"]]


def test_frames_lead_to_where_the_kernel_says_and_rest_at_50_hz(world: Client, ros: roslibpy.Ros) -> None:
    moving, fixed = (Heard(ros, name, "tf2_msgs/TFMessage") for name in ("/tf", "/tf_static"))
    still = fixed.next()
    world.robot("arm").set_positions([0.3, -0.5, 0.2, 1.1, -0.4, 0.6, 0.9])
    world.clock.step(100)
    now = round(world.clock.simulation_time * 1e9)
    came = moving.until(lambda message: stamp_of(message["transforms"][0]) >= now - 20_000_000)
    parents = {
        one["child_frame_id"]: (one["header"]["frame_id"], matrix(one["transform"]))
        for one in [*still["transforms"], *came[-1]["transforms"]]
    }
    world_t_link, frame = np.eye(4), "arm/lbr_iiwa_link_7"
    while frame != "world":
        frame, step = parents[frame]
        world_t_link = step @ world_t_link
    own = world.scene["arm.lbr_iiwa_link_7"].pose
    assert np.abs(world_t_link - np.asarray(own)).max() < 1e-9
    times = [stamp_of(one["transforms"][0]) for one in came]
    assert max(np.diff(times)) <= 20_000_000  # 50 Hz of simulation time, though nothing moves


def matrix(transform: dict[str, Any]) -> np.ndarray:
    """Return the matrix of a transform; source: the rotation matrix of a unit quaternion."""
    x, y, z, w = (transform["rotation"][one] for one in "xyzw")
    found = np.eye(4)
    found[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    found[:3, 3] = [transform["translation"][one] for one in "xyz"]
    return found


def test_a_scan_and_a_cloud_of_a_wall_are_where_the_wall_is(world: Client, ros: roslibpy.Ros) -> None:
    scans = Heard(ros, "/scanner/scan", "sensor_msgs/LaserScan")
    clouds = Heard(ros, "/cloud/points", "sensor_msgs/PointCloud2")
    stepped_until(world, lambda: scans.is_there() and clouds.is_there())
    scan = scans.next()
    angles = scan["angle_min"] + scan["angle_increment"] * np.arange(5)
    assert angles == pytest.approx([-0.4, -0.2, 0.0, 0.2, 0.4])
    assert scan["ranges"] == pytest.approx(WALL / np.cos(angles), abs=1e-5)  # a plane at right angles to x
    assert (scan["header"]["frame_id"], scan["range_max"]) == ("scanner", 10.0)
    cloud = clouds.next()
    assert [one["name"] for one in cloud["fields"]] == ["x", "y", "z"] and cloud["width"] == 12
    points = np.frombuffer(base64.b64decode(cloud["data"]), "<f4").reshape(-1, 3)
    assert points[:, 0] == pytest.approx(np.full(12, WALL), abs=1e-5)


def stepped_until(world: Client, wanted: Callable[[], object]) -> None:
    """Let time go on in small steps until something is true."""
    for _ in range(2000):
        if wanted():
            return
        world.clock.step(5)
    raise AssertionError("it has not come in 40 s of simulation time")


def test_pictures_have_the_stamp_and_the_size_of_their_camera_info(world: Client, ros: roslibpy.Ros) -> None:
    names = {"image_raw": "Image", "depth/image_raw": "Image", "camera_info": "CameraInfo"}
    heard = {name: Heard(ros, f"/eye/{name}", f"sensor_msgs/{type}") for name, type in names.items()}
    packed = Heard(ros, "/eye/image_raw/compressed", "sensor_msgs/CompressedImage")
    stepped_until(world, lambda: all(one.is_there() for one in [*heard.values(), packed]))
    infos = {stamp_of(one): one for one in [heard["camera_info"].next()]}
    world.clock.step(100)
    infos |= {stamp_of(one): one for one in heard["camera_info"].until(lambda one: len(one["d"]) == 5)}
    color, depth = heard["image_raw"].next(), heard["depth/image_raw"].next()
    # A pinhole's focal length is half its width over the tangent of half its field, which is 1 rad; its middle is
    # between the middles of the pixels.
    info, focal = next(iter(infos.values())), 32.0 / math.tan(0.5)
    assert info["k"] == pytest.approx([focal, 0.0, 31.5, 0.0, focal, 23.5, 0.0, 0.0, 1.0])
    assert {stamp_of(color), stamp_of(depth)} & set(infos)
    assert (color["encoding"], depth["encoding"]) == ("rgb8", "32FC1")
    pixels = np.frombuffer(base64.b64decode(color["data"]), np.uint8).reshape(48, 64, 3)
    assert color["step"] == 64 * 3 and depth["step"] == 64 * 4
    picture = np.asarray(Image.open(io.BytesIO(base64.b64decode(packed.next()["data"]))))
    assert np.abs(picture.astype(int) - pixels).mean() < 5.0


def test_a_twist_drives_a_craft_and_its_watchdog_stops_it(world: Client, ros: roslibpy.Ros) -> None:
    odometry = Heard(ros, "/ugv/odom", "nav_msgs/Odometry")
    start = odometry.next()
    assert (start["header"]["frame_id"], start["child_frame_id"]) == ("ugv", "ugv/base")
    command = roslibpy.Topic(ros, "/ugv/cmd_vel", "geometry_msgs/Twist")
    command.publish({"linear": {"x": 0.2}, "angular": {"z": 0.0}})
    stepped_until(world, lambda: world.robot("ugv").state.motion_ids)
    world.clock.step(25)
    base = world.streams.sample("/robots/ugv/base").values
    world.clock.step(round(3.0 / TICK))  # the twist holds for 0.5 s, and braking takes less than the rest
    end = odometry.until(lambda one: stamp_of(one) >= round(world.clock.simulation_time * 1e9) - 20_000_000)[-1]
    assert end["twist"]["twist"]["linear"]["x"] == 0.0
    assert not world.robot("ugv").state.motion_ids
    assert 0.02 < end["pose"]["pose"]["position"]["x"] < 0.4 and base["vx"] >= 0.0
    command.publish({"linear": {"x": -0.2}})
    stepped_until(world, lambda: world.robot("ugv").state.motion_ids)  # the next one begins anew


def test_a_description_is_latched_and_names_the_links_of_the_frames(ros: roslibpy.Ros) -> None:
    for _ in range(2):
        text = Heard(ros, "/arm/robot_description", "std_msgs/String").next()["data"]
        assert "<robot name=" in text and '<link name="lbr_iiwa_link_7"' in text


def test_rosapi_tells_what_there_is(ros: roslibpy.Ros) -> None:
    assert {"/clock", "/tf", "/arm/joint_states", "/ugv/cmd_vel", "/ugv/lidar/scan"} <= set(told(ros.get_topics()))
    assert ros.get_topic_type("/ugv/lidar/scan") == "sensor_msgs/msg/LaserScan"
    assert ros.get_topics_for_type("rosgraph_msgs/msg/Clock") == ["/clock"]
    assert ros.get_service_type("/rosapi/topics") == "rosapi_msgs/srv/Topics"
    details = told(ros.get_message_details("sensor_msgs/msg/JointState"))["typedefs"]
    assert details[0]["fieldnames"] == ["header", "name", "position", "velocity", "effort"]
    assert {one["type"] for one in details} == {
        *("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    }


def test_services_and_topics_of_clients_reach_each_other(url: str, ros: roslibpy.Ros) -> None:
    with roslibpy_client(url) as other:
        service = roslibpy.Service(ros, "/lamp", "std_srvs/SetBool")

        def lit(request: dict[str, Any], response: dict[str, Any]) -> bool:
            response |= {"success": request["data"], "message": "lit" if request["data"] else "dark"}
            return True

        service.advertise(lit)
        ros.get_nodes()  # what was asked before is done
        lamp = told(roslibpy.Service(other, "/lamp", "std_srvs/SetBool").call({"data": True}, timeout=GUARD))
        assert (lamp["success"], lamp["message"]) == (True, "lit")
        spoken = Heard(other, "/words", "std_msgs/String")
        other.get_nodes()
        roslibpy.Topic(ros, "/words", "std_msgs/String").publish({"data": "hello"})
        assert spoken.next() == {"data": "hello"}
        service.unadvertise()
        ros.get_nodes()
        assert "/lamp" not in told(other.get_services())


def test_each_packing_holds_the_same_message(world: Client, url: str) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    with socket(url) as one:
        for packing in ("none", "png", "cbor", "cbor-raw"):
            say(one, op="subscribe", topic="/arm/robot_description", id=packing, compression=packing)
            data = one.recv(timeout=GUARD)
            found = cbor2.loads(data) if isinstance(data, bytes) else json.loads(data)
            if packing == "png":
                picture = Image.open(io.BytesIO(base64.b64decode(found["data"])))
                found = json.loads(picture.tobytes())
            assert (found["op"], found["topic"]) == ("publish", "/arm/robot_description")
            if packing == "cbor-raw":
                message: Any = store.deserialize_cdr(found["msg"]["bytes"], "std_msgs/msg/String")
                found["msg"] = {"data": message.data}
            assert found["msg"]["data"].startswith("<?xml")
            say(one, op="unsubscribe", topic="/arm/robot_description", id=packing)


def test_long_messages_come_in_fragments_and_go_in_by_them(url: str) -> None:
    with socket(url) as one:
        say(one, op="subscribe", topic="/arm/robot_description", fragment_size=500)
        first = answer(one, op="fragment")
        parts = [first, *(answer(one, op="fragment", id=first["id"]) for _ in range(first["total"] - 1))]
        assert [part["num"] for part in parts] == list(range(first["total"]))
        assert max(len(part["data"]) for part in parts) == 500
        assert json.loads("".join(part["data"] for part in parts))["msg"]["data"].startswith("<?xml")
        asked = json.dumps({"op": "call_service", "service": "rosapi/topic_type", "args": ["/clock"], "id": "asked"})
        for place in (2, 0, 1):
            say(
                one,
                op="fragment",
                id="in",
                num=place,
                total=3,
                data=asked[place * 40 : (place + 1) * 40 if place < 2 else None],
            )
        assert answer(one, id="asked")["values"] == {"type": "rosgraph_msgs/msg/Clock"}
        one.send(json.dumps({"op": "call_service", "service": "/rosapi/nodes", "id": "bytes"}).encode())  # as ROS# does
        assert answer(one, id="bytes")["values"] == {"nodes": ["/virtualrobot"]}


def test_a_throttle_leaves_the_newest(world: Client, url: str) -> None:
    with socket(url) as one:
        say(one, op="subscribe", topic="/clock", throttle_rate=200)
        first = stamp_of(answer(one, op="publish")["msg"])
        world.clock.step(50)
        last = round(world.clock.simulation_time * 1e9)
        found = [first]
        while found[-1] < last:
            found.append(stamp_of(answer(one, op="publish")["msg"]))
        assert len(found) < 50 and np.all(np.diff(found) > 0)


def test_foreign_pages_and_wrong_tokens_stay_outside(world: Client) -> None:
    server = RosbridgeServer(port=0, token="secret", origins=["https://panel.example"])
    with bridge(world, server=server) as (url, _):
        with pytest.raises(InvalidStatus, match="403"), socket(url, origin="https://evil.example"):
            pass
        with pytest.raises(InvalidStatus, match="401"), socket(f"{url}/?token=wrong"):
            pass
        with socket(url, origin="http://localhost:3000") as one:
            say(one, op="call_service", service="/rosapi/nodes")
            assert "say the token first" in answer(one, op="status")["msg"]
            say(one, op="auth", token="wrong")
            assert answer(one, op="status")["msg"] == "the token is another one"
            say(one, op="auth", token="secret")
            say(one, op="call_service", service="/rosapi/nodes")
            assert answer(one, op="service_response")["result"] is True
        with roslibpy_client(f"{url}/?token=secret") as ros:
            assert ros.get_nodes() == ["/virtualrobot"]
        with socket(url, origin="https://panel.example", additional_headers={"Authorization": "Bearer secret"}) as one:
            say(one, op="call_service", service="/rosapi/nodes")
            assert answer(one, op="service_response")["result"] is True


def test_what_comes_and_goes_in_the_world_comes_and_goes_on_the_bridge(world: Client, url: str) -> None:
    with socket(url) as one:

        def topics() -> set[str]:
            say(one, op="call_service", service="/rosapi/topics", id="topics")
            return set(answer(one, id="topics")["values"]["topics"])

        world.load_robot(IIWA, name="second", pose=virtualrobot.pose(y=6.0))
        while "/second/joint_states" not in topics():
            pass
        world.scene["second"].remove()
        while "/second/joint_states" in topics():
            pass
        assert "/arm/joint_states" in topics()


def test_a_sensor_reads_only_while_somebody_listens(world: Client, url: str) -> None:
    def readings() -> int:
        return world.sensors["scanner"].status.readings

    with socket(url) as one:
        world.clock.step(100)
        assert readings() == 0
        say(one, op="subscribe", topic="/scanner/scan")
        stepped_until(world, lambda: readings() > 0)
    for _ in range(200):
        before = readings()
        world.clock.step(50)
        if readings() == before:
            return
    raise AssertionError("the sensor reads on, though nobody listens")


def test_a_file_gives_other_names_and_its_faults_have_lines(world: Client, tmp_path: Path) -> None:
    file = tmp_path / "bridge.yaml"
    text = """schema_version: 1
auto: false
topics:
  - ros_topic_name: /scan
    ros_type_name: sensor_msgs/LaserScan
    stream: /sensors/scanner/scan
    direction: GZ_TO_ROS
  - ros_topic_name: /cmd_vel
    ros_type_name: geometry_msgs/msg/TwistStamped
    stream: /robots/ugv/command/twist
    direction: IN
  - ros_topic_name: /flange
    stream: /nodes/arm.lbr_iiwa_link_7/pose
"""
    file.write_text(text)
    with bridge(world, read_choice(file, auto=True)) as (url, _), roslibpy_client(url) as ros:
        assert set(told(ros.get_topics())) == {"/scan", "/cmd_vel", "/flange"}
        pose = Heard(ros, "/flange", "geometry_msgs/PoseStamped").next()["pose"]["position"]
        own = np.asarray(world.scene["arm.lbr_iiwa_link_7"].pose)[:3, 3]
        assert [pose["x"], pose["y"], pose["z"]] == own.tolist()
        roslibpy.Topic(ros, "/cmd_vel", "geometry_msgs/TwistStamped").publish({"twist": {"linear": {"x": 0.1}}})
        stepped_until(world, lambda: world.robot("ugv").state.motion_ids)
    for before, after, words in (
        ("ros_type_name", "ros_typename", r"bridge.yaml:5: .*no field 'ros_typename'; did you mean 'ros_type_name'"),
        ("LaserScan", "LaserScann", r"bridge.yaml:5: .*did you mean 'sensor_msgs/msg/LaserScan'"),
        ("GZ_TO_ROS", "BOTH", r"bridge.yaml:7: .*'BOTH' is not known"),
        ("/flange", "/scan", r"bridge.yaml:12: .*/scan stands in line 4 already"),
        ("geometry_msgs/msg/TwistStamped", "std_msgs/msg/String", r"bridge.yaml:9: .*the world hears"),
    ):
        file.write_text(text.replace(before, after))
        with pytest.raises(MalformedFileError, match=words):
            read_choice(file, auto=True)
    for before, after, words in (
        ("msgs/LaserScan", "msgs/Image", r"bridge.yaml:4: .*gives sensor_msgs/msg/LaserScan, not .*Image"),
        ("ugv/command/twist", "ugv/base", r"bridge.yaml:8: .*/robots/NAME/command/twist, not /robots/ugv/base"),
        ("direction: IN", "direction: OUT", r"bridge.yaml:8: .*the world hears /robots/ugv/command/twist: 'direction'"),
    ):
        file.write_text(text.replace(before, after))
        with pytest.raises(AssertionError, match=words), bridge(world, read_choice(file, auto=True)):
            pass


def test_no_number_is_told_where_nothing_is(world: Client, ros: roslibpy.Ros) -> None:
    """REP 117: +inf where there is no echo; JSON has no number for it, and has null."""
    heard = Heard(ros, "/ugv/lidar/scan", "sensor_msgs/LaserScan")
    stepped_until(world, heard.is_there)
    ranges = heard.next()["ranges"]
    assert None in ranges and all(one is None or math.isfinite(one) for one in ranges)


def test_an_action_of_a_client_is_run_by_another_and_cancelled(url: str) -> None:
    with socket(url) as server, socket(url) as asking:
        say(server, op="advertise_action", action="/grip", type="control_msgs/action/GripperCommand")
        say(server, op="call_service", service="/rosapi/action_servers", id="listed")
        assert answer(server, id="listed")["values"]["action_servers"][-1] == "/grip"
        for cancelled in (False, True):
            goal = {"command": {"position": 0.02, "max_effort": 5.0}}
            say(asking, op="send_action_goal", action="/grip", args=goal, feedback=True, id="mine")
            begun = answer(server, op="send_action_goal")
            assert (begun["action"], begun["args"]) == ("/grip", goal)
            told = {"position": 0.01, "effort": 0.0, "stalled": False, "reached_goal": False}
            say(server, op="action_feedback", action="/grip", id=begun["id"], values=told)
            assert answer(asking, op="action_feedback", id="mine")["values"] == told
            if cancelled:
                say(asking, op="cancel_action_goal", action="/grip", id="mine")
                assert answer(server, op="cancel_action_goal")["id"] == begun["id"]
            status = 5 if cancelled else 4  # action_msgs/GoalStatus: CANCELED, SUCCEEDED
            result = {**told, "reached_goal": not cancelled}
            say(server, op="action_result", action="/grip", id=begun["id"], values=result, status=status, result=True)
            over = answer(asking, op="action_result", id="mine")
            assert (over["status"], over["values"], over["result"]) == (status, result, True)
        say(asking, op="send_action_goal", action="/grip", args={"command": {}}, id="left")
        answer(server, op="send_action_goal")
        server.close()
        over = answer(asking, op="action_result", id="left")
        assert (over["result"], over["values"]) == (False, "who served it is gone")


def test_the_program_of_the_tutorial_runs(client: Client, tmp_path: Path) -> None:
    page = (Path(__file__).parents[3] / "docs" / "tutorial-ros.md").read_text("utf-8")
    program = tmp_path / "joints.py"
    program.write_text(page.split("<!-- file: joints.py -->\n```python\n")[1].split("```")[0], "utf-8")
    client.load_robot("model://ugv", base="planar")
    arm = client.load_robot("model://kr6_r700", name="arm", pose=virtualrobot.pose(y=2.0))
    with bridge(client) as (url, _):
        done = subprocess.run([sys.executable, str(program), url], capture_output=True, text=True, timeout=GUARD)
        assert done.returncode == 0, done.stderr
        assert done.stdout.splitlines()[1] == f"{arm.joint_names} {arm.positions.tolist()}"


def test_a_bridge_waits_for_a_kernel_that_has_gone(start_kernel: StartKernel) -> None:
    kernel = start_kernel()
    port = kernel.address.rpartition(":")[2]
    with virtualrobot.connect(kernel.address) as client, bridge(client) as (url, said), roslibpy_client(url) as ros:
        assert "/clock" in told(ros.get_topics())
        kernel.end()
        while "/clock" in told(ros.get_topics()):
            pass
        kernel = start_kernel("--port", port)
        clock = Heard(ros, "/clock", "rosgraph_msgs/Clock")
        clock.next()
        while "the kernel is back" not in said:
            pass
    assert sum("is tried again" in one for one in said) == 1, said


@pytest.mark.skipif(shutil.which("node") is None, reason="roslib runs in Node.js, which is not installed")
def test_roslib_hears_the_same_joints_in_each_packing(world: Client, url: str) -> None:
    positions = [0.1, -0.2, 0.3, 0.4, -0.5, 0.6, -0.7]
    world.robot("arm").set_positions(positions)
    world.clock.step(1)
    program = Path(__file__).parent / "roslib_peer.mjs"
    with repeated(lambda: world.clock.step(1), 0.02):
        # Node.js 20 has WebSocket as an experiment, later ones anyway; roslib is found from the program's folder up.
        command = ["node", "--experimental-websocket", str(program), url]
        done = subprocess.run(command, capture_output=True, text=True, timeout=GUARD)
    assert done.returncode == 0, done.stderr
    told_by = json.loads(done.stdout)
    assert "/arm/joint_states" in told_by["topics"]
    names = [f"lbr_iiwa_joint_{number}" for number in range(1, 8)]
    assert told_by["joints"] == {packing: {"name": names, "position": positions} for packing in ("none", "cbor", "png")}
