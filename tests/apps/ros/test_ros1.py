"""The bridge as a node of ROS 1, with Debian's rospy, actionlib, tf2 and roscore, and roscpp's rosbag record."""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import xmlrpc.client
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import roslibpy
import virtualrobot
from rosbags.rosbag1 import Reader, Writer
from rosbags.typesys import Stores, get_typestore
from virtualrobot import Client
from virtualrobot.geometry import pose_from_quaternion
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.ros1 import ROS1, definition_of, from_ros1_bytes, md5_of
from virtualrobot_apps.bridges.ros.messages.types import STORE
from virtualrobot_apps.bridges.ros.messages.values import default
from virtualrobot_apps.bridges.ros.ros1.node import Ros1Node

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import GUARD, bridge, roslibpy_client
from tests.waiting import until

pytestmark = pytest.mark.long

PYTHON, MASTER = "/usr/bin/python3", shutil.which("rosmaster")
"""Debian's own Python, for which its packages are, and its master."""
RECORD, PLAY = "/usr/lib/rosbag/record", "/usr/lib/rosbag/play"
PEER = Path(__file__).parent / "ros1_peer.py"
needs_ros1 = pytest.mark.skipif(
    MASTER is None or not Path(RECORD).exists(),
    reason="no ROS 1: Debian's packages of it are installed by tools/install_toolchains.sh",
)
STD_SRVS = ("Empty", "SetBool", "Trigger")
WALL = 2.0
"""Distance (m) of a wall's surface from the scanner."""

SUMS = {
    "Goal": "69636787b6ecbde4d61d711979bc7ecb",
    "ActionGoal": "cff5c1d533bf2f82dd0138d57f4304bb",
    "Result": "493383b18409bfb604b4e26c676401d2",
    "ActionResult": "c4fb3b000dc9da4fd99699380efcc5d9",
    "Feedback": "10817c60c2486ef6b33e97dcd87f4474",
    "ActionFeedback": "d8920dc4eae9fc107e00999cce4be641",
}
"""MD5 sums of control_msgs/FollowJointTrajectory as ROS 1's generators have written them (rosserial, ROS.NET)."""


@pytest.fixture
def world(client: Client) -> Iterator[Client]:
    """Return a client of a world with an arm, a UGV, a scanner before a wall, and a camera."""
    client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(y=3.0))
    client.robot("arm").set_positions([0.1, -0.2, 0.3, 0.4, -0.5, 0.6, -0.7])
    client.load_robot("model://ugv", base="planar", pose=virtualrobot.pose(y=-3.0))
    flat = virtualrobot.fan(5, -0.4, 0.4)
    client.scene.add_range_sensor("scanner", virtualrobot.range_sensor(pattern=flat, rate=10.0))
    client.scene.add_camera("eye", virtualrobot.camera(64, 48, rate=10.0))
    client.scene.add_object("wall", virtualrobot.box(0.2, 2.0, 4.0), pose=virtualrobot.pose(x=WALL + 0.1))
    yield client


def environment(master: str, folder: Path) -> dict[str, str]:
    """Return the environment of programs on ROS 1 that don't leave this machine, and write to a folder."""
    return {**os.environ, "ROS_MASTER_URI": master, "ROS_IP": "127.0.0.1", "ROS_HOME": str(folder), "PYTHONPATH": ""}


@contextmanager
def roscore(folder: Path, port: int = 0) -> Iterator[str]:
    """Give the address of Debian's master."""
    if not port:
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
    uri = f"http://127.0.0.1:{port}"
    with subprocess.Popen(
        [str(MASTER), "--core", "-p", str(port)], env=environment(uri, folder), stdout=subprocess.DEVNULL
    ) as master:
        try:
            until(lambda: answers(uri))
            yield uri
        finally:
            master.kill()


def answers(uri: str) -> bool:
    """Return whether a master answers."""
    try:
        return ask(uri, "getPid")[0] == 1
    except OSError:
        return False


def ask(uri: str, method: str, *arguments: Any, caller: str = "/test") -> Any:  # noqa: ANN401 whatever is answered
    """Return what a master or a node answers to this test."""
    with xmlrpc.client.ServerProxy(uri, allow_none=True) as other:
        return getattr(other, method)(caller, *arguments)


@contextmanager
def node(client: Client, master: str = "http://127.0.0.1:0") -> Iterator[tuple[Ros1Node, list[str], str]]:
    """Give a bridge's node of ROS 1 that has joined a master, what it says, and the address of its rosbridge."""
    said: list[str] = []
    one = Ros1Node(master, say=said.append)
    with bridge(client, more=[one]) as (url, others):
        yield one, said, url
    said.extend(others)


@contextmanager
def joined(client: Client, folder: Path, own: bool) -> Iterator[tuple[Ros1Node, list[str], str]]:
    """Give a bridge's node at a master of its own, or at Debian's."""
    if own:
        with node(client) as found:
            yield found
        return
    with roscore(folder) as master, node(client, master) as found:
        yield found


def ended(command: list[str], master: str, folder: Path) -> str:
    """Return what a program on ROS 1 prints; one that fails fails the test with its words."""
    done = subprocess.run(
        command, env=environment(master, folder), cwd=folder, capture_output=True, text=True, timeout=GUARD
    )
    assert done.returncode == 0, f"{done.stdout}{done.stderr}"
    return done.stdout


@needs_ros1
@pytest.mark.parametrize("own", [True, False], ids=["own master", "roscore"])
def test_a_program_on_rospy_hears_drives_calls_and_acts(world: Client, tmp_path: Path, own: bool) -> None:
    arm = world.robot("arm")
    positions = arm.positions
    names = [f"control_msgs/FollowJointTrajectory{part}" for part in SUMS]
    asked = {
        "definitions": {one: definition_of(one.replace("/", "/msg/")) for one in names if own},
        "joints": arm.joint_names,
        "positions": [0.3, -0.2, 0.1, 0.2, -0.3, 0.4, -0.5],
        "frame": "arm/lbr_iiwa_link_7",
    }
    place = np.asarray(world.scene["arm.lbr_iiwa_link_7"].pose)

    def switch(request: Any, response: Any) -> bool:  # noqa: ANN401
        response["success"], response["message"] = True, f"on: {request['data']}"
        return bool(request["data"])

    with joined(world, tmp_path, own) as (one, _, url), roslibpy_client(url) as ros:
        roslibpy.Service(ros, "/switch", "std_srvs/SetBool").advertise(switch)
        until(lambda: ask(one.master, "lookupService", "/switch")[0] == 1)
        told = json.loads(ended([PYTHON, str(PEER), json.dumps(asked)], one.master, tmp_path).splitlines()[-1])
    times = [time for time, *_ in told["states"]]
    assert times == sorted(times) and len(times) == 20
    assert all(one[1:] == [arm.joint_names, positions.tolist()] for one in told["states"])
    first, step, ranges = told["scan"]
    assert ranges == pytest.approx(WALL / np.cos(first + step * np.arange(5)), abs=1e-5)  # a plane at right angles to x
    intrinsic, width, *image = told["camera"]
    assert (width, image) == (64, [64, "rgb8", 64 * 48 * 3]) and intrinsic[8] == 1.0
    assert '<link name="lbr_iiwa_link_7"' in told["description"] and told["parameter"] == told["description"]
    assert told["simulated"] is True and told["clock"] > 0
    assert np.abs(pose_from_quaternion(told["frame"][:3], told["frame"][3:]) - place).max() < 1e-9
    assert told["switched"] == "on: True" and "refused" in told
    assert told["private"] == [1.5, True]
    if own:
        assert told["action"]["first"] == [3, 0, True] and told["action"]["second"] == 2  # SUCCEEDED, PREEMPTED
        sums = {f"control_msgs/FollowJointTrajectory{part}": sum for part, sum in SUMS.items()}
        assert told["action"]["sums"] == sums
    assert ["/arm/joint_states", "sensor_msgs/JointState"] in told["topics"]


@needs_ros1
def test_types_have_the_sums_of_debians() -> None:
    code = (
        "import importlib, json, sys\n"
        "def sum(name):\n"
        "    package, kind, base = name.split('/')\n"
        "    try: return getattr(importlib.import_module(f'{package}.{kind}'), base)._md5sum\n"
        "    except (ImportError, AttributeError): return None\n"
        "print(json.dumps({name: sum(name) for name in json.load(sys.stdin)}))"
    )
    names = [name for name in ROS1.types if "/msg/" in name] + [f"std_srvs/srv/{one}" for one in STD_SRVS]
    done = subprocess.run([PYTHON, "-c", code], input=json.dumps(names), capture_output=True, text=True, check=True)
    known = {name: sum for name, sum in json.loads(done.stdout).items() if sum}
    assert len(known) > 100 and known == {name: md5_of(name) for name in known}
    # As published with MoveIt's package, which Debian lacks.
    assert md5_of("moveit_msgs/msg/CollisionObject") == "dbba710596087da521c07564160dfccb"


def test_messages_of_all_types_go_to_ros_1_and_back() -> None:
    for name in (name for name in STORE.types if "/action/" not in name):
        there = Message(name, default(name)).ros1
        assert Message(name, from_ros1_bytes(name, there)).cdr == Message(name, default(name)).cdr, name


@needs_ros1
def test_tools_list_call_drive_and_record(world: Client, tmp_path: Path) -> None:
    positions, store = world.robot("arm").positions, get_typestore(Stores.ROS1_NOETIC)
    with node(world) as (one, _, url), roslibpy_client(url) as ros:
        roslibpy.Service(ros, "/switch", "std_srvs/SetBool").advertise(lambda asked, answer: asked["data"])
        until(lambda: ask(one.master, "lookupService", "/switch")[0] == 1)

        def run(*words: str) -> list[str]:
            return ended([*words], one.master, tmp_path).splitlines()

        assert {"/clock", "/tf", "/arm/joint_states", "/ugv/cmd_vel"} <= set(run("rostopic", "list"))
        assert "Publishers: None" in run("rostopic", "info", "/ugv/cmd_vel")
        assert run("rosservice", "call", "/switch", "true")[0] == "success: False"
        run("rosparam", "set", "/speeds", "{slow: 1, fast: [2.5, 3]}")
        assert run("rosparam", "get", "/speeds/fast")[:2] == ["- 2.5", "- 3"]
        assert ros.get_param("/speeds") == {"slow": 1, "fast": [2.5, 3]}
        # roscpp drives, which begins to publish after the bridge has subscribed.
        with Writer(tmp_path / "drive.bag") as drive:
            link = drive.add_connection("/ugv/cmd_vel", "geometry_msgs/msg/Twist", typestore=store)
            told = default("geometry_msgs/msg/Twist", store)
            told.linear.x = 0.5
            for tenth in range(20):
                drive.write(link, tenth * 100_000_000, store.serialize_ros1(told, link.msgtype))
        run(PLAY, "-q", "drive.bag")
        assert world.streams.sample("/robots/ugv/base").values["x"] > 0.05
        own = ask(one.master, "lookupNode", "/virtualrobot")[2]
        # roscpp: each topic ends after ten messages.
        run(RECORD, "-q", "-l", "10", "-O", "run.bag", "/arm/joint_states", "/clock")
        until(lambda: not any(link[4] == "/clock" for link in ask(own, "getBusInfo")[2]))
    with Reader(tmp_path / "run.bag") as bag:
        found: list[Any] = [
            store.deserialize_ros1(data, link.msgtype) for link, _, data in bag.messages() if "joint" in link.topic
        ]
    assert len(found) == 10 and all(value.position.tolist() == positions.tolist() for value in found)


@needs_ros1
def test_a_master_that_comes_back_is_told_all_again_and_a_name_is_had_once(client: Client, tmp_path: Path) -> None:
    client.load_robot(IIWA, name="arm")
    with ExitStack() as stack:
        with roscore(tmp_path) as master:
            _, said, _ = stack.enter_context(node(client, master))
        until(lambda: any("tried again" in words for words in said))
        with roscore(tmp_path, int(master.rpartition(":")[2])):
            until(lambda: any("is back" in words for words in said))
            known = [topic for topic, _ in ask(master, "getPublishedTopics", "")[2]]
            assert {"/clock", "/arm/joint_states", "/tf"} <= set(known)
            until(lambda: ask(master, "hasParam", "/arm/robot_description")[2])
            with pytest.raises(AssertionError, match="has a node /virtualrobot already"), node(client, master):
                pass
            # Somebody else takes the name: the master tells this one to end.
            place = "http://127.0.0.1:9/"
            ask(master, "registerPublisher", "/x", "std_msgs/String", place, caller="/virtualrobot")
            until(lambda: any("has ended /virtualrobot" in words for words in said))
