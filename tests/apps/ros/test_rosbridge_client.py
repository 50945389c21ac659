"""The bridge as a client of a rosbridge_server, at which programs of others are: roslibpy, and what the test plays."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from queue import Queue
from typing import Any

import numpy as np
import pytest
import roslibpy
import virtualrobot
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.bridge import RosBridge
from virtualrobot_apps.bridges.ros.hub import Hub
from virtualrobot_apps.bridges.ros.rosbridge.client import RosbridgeClient
from virtualrobot_apps.bridges.ros.rosbridge.server import RosbridgeServer
from virtualrobot_apps.bridges.ros.transport import TransportError
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import ServerConnection, serve

from tests.api.asking import IIWA
from tests.apps.ros.bridges import GUARD, Heard, bridge, roslibpy_client, told
from tests.waiting import until

pytestmark = pytest.mark.long

FOLLOW = "control_msgs/FollowJointTrajectory"


@contextmanager
def server(port: int = 0) -> Iterator[tuple[str, int]]:
    """Give the address and the port of a server with nothing but what its clients bring."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever, daemon=True)
    thread.start()
    served = RosbridgeServer(port=port)
    asyncio.run_coroutine_threadsafe(served.open(Hub()), loop).result(GUARD)
    try:
        yield served.url, int(served.url.rpartition(":")[2])
    finally:
        asyncio.run_coroutine_threadsafe(served.close(), loop).result(GUARD)
        loop.call_soon_threadsafe(loop.stop)
        thread.join(GUARD)
        loop.close()


def test_programs_at_the_server_read_and_move_the_world(client: Client) -> None:
    arm = client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(y=3.0))
    arm.set_positions([0.1, -0.2, 0.3, 0.4, -0.5, 0.6, -0.7])
    client.load_robot("model://ugv", name="ugv", base="planar")
    with (
        server() as (url, _),
        bridge(client, more=[RosbridgeClient(url, say=print)]),
        roslibpy_client(url) as ros,
    ):
        joints = Heard(ros, "/arm/joint_states", "sensor_msgs/JointState").next()
        assert (joints["name"], joints["position"]) == (arm.joint_names, arm.positions.tolist())
        assert "lbr_iiwa_link_7" in Heard(ros, "/arm/robot_description", "std_msgs/String").next()["data"]

        roslibpy.Topic(ros, "/ugv/cmd_vel", "geometry_msgs/Twist").publish({"linear": {"x": 0.2}})
        until(lambda: client.robot("ugv").tcp[0, 3] > 0.02)

        asked = roslibpy.Service(
            ros, "/virtualrobot/get_simulation_state", "simulation_interfaces/GetSimulationState"
        ).call(roslibpy.ServiceRequest({}))
        assert told(asked)["state"]["state"] == 1  # STATE_PLAYING

        _follows(ros, arm)


def _follows(ros: roslibpy.Ros, arm: virtualrobot.Robot) -> None:
    """A goal is reached, with feedback on the way, and one that is cancelled ends as that."""
    action = roslibpy.ActionClient(ros, "/arm/follow_joint_trajectory", FOLLOW)
    results: Queue[dict[str, Any]] = Queue()
    feedback: Queue[dict[str, Any]] = Queue()
    errors: Queue[Any] = Queue()

    def goal(value: float, seconds: int) -> str:
        point = {"positions": [value] * 7, "time_from_start": {"sec": seconds, "nanosec": 0}}
        asked = roslibpy.Goal({"trajectory": {"joint_names": arm.joint_names, "points": [point]}})
        return told(action.send_goal(asked, results.put, feedback.put, errors.put))

    goal(0.5, 2)
    ended = results.get(timeout=GUARD)
    assert (ended["status"].value, ended["values"]["error_code"]) == (4, 0)
    np.testing.assert_allclose(arm.positions, 0.5, atol=1e-9)
    assert feedback.get(timeout=GUARD)["joint_names"] == arm.joint_names
    name = goal(-0.5, 3600)
    until(lambda: bool(arm.state.motion_ids))
    action.cancel_goal(name)
    assert results.get(timeout=GUARD)["status"].value == 5


def test_a_server_that_was_away_is_found_again(client: Client) -> None:
    arm = client.load_robot(IIWA, name="arm")
    said: list[str] = []
    with server() as (url, port):
        link = bridge(client, more=[RosbridgeClient(url, say=said.append)])
        link.__enter__()
    try:
        until(lambda: any(words.startswith(f"{url} has gone") for words in said))
        with server(port), roslibpy_client(url) as ros:
            joints = Heard(ros, "/arm/joint_states", "sensor_msgs/JointState")
            arm.set_positions([0.25] * 7)
            joints.until(lambda one: one["position"] == [0.25] * 7)
            assert f"{url} is back" in said
    finally:
        link.__exit__(None, None, None)


def test_nobody_there_is_one_line(client: Client) -> None:
    with server() as (url, _):
        pass
    with pytest.raises(TransportError, match=f"nobody speaks rosbridge at {url}: "):
        RosBridge(client, [RosbridgeClient(url)], say=print).run()


class Played:
    """A server that a test plays by the protocol's words: it keeps what it is told, and says what the test wants."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.came: list[dict[str, Any]] = []
        self.texts: list[str] = []
        self.headers: list[str | None] = []
        self._open: list[ServerConnection] = []

    def handle(self, connection: ServerConnection) -> None:
        """Keep what comes."""
        assert connection.request is not None
        self.headers.append(connection.request.headers.get("Authorization"))
        self._open.append(connection)
        try:
            for text in connection:
                self.texts.append(str(text))
                self.came.append(json.loads(text))
        except ConnectionClosed:
            pass

    def say(self, **op: object) -> None:
        """Send a message."""
        self._open[-1].send(json.dumps(op))

    def unplug(self) -> None:
        """Close all connections."""
        for one in self._open:
            one.close()

    def has(self, **wanted: object) -> bool:
        """Return whether something with these values has come."""
        return any(all(one.get(key) == value for key, value in wanted.items()) for one in tuple(self.came))


@contextmanager
def played() -> Iterator[tuple[str, Played]]:
    """Give the address of a server that a test plays, and the server."""
    one = Played()
    with serve(one.handle, "127.0.0.1", 0) as listening:
        thread = threading.Thread(target=listening.serve_forever, daemon=True)
        thread.start()
        try:
            yield f"ws://127.0.0.1:{listening.socket.getsockname()[1]}", one
        finally:
            one.unplug()
            listening.shutdown()
            thread.join(GUARD)


def test_what_is_advertised_what_it_complains_of_and_what_goes(client: Client) -> None:
    client.load_robot("model://ugv", name="ugv", base="planar")
    said: list[str] = []
    with played() as (url, peer), bridge(client, more=[RosbridgeClient(url, token="secret", say=said.append)]):
        until(lambda: peer.has(op="advertise", topic="/ugv/odom", type="nav_msgs/msg/Odometry", latch=False))
        assert peer.headers == ["Bearer secret"]
        until(lambda: peer.has(op="advertise", topic="/tf_static", latch=True))
        until(lambda: peer.has(op="subscribe", topic="/ugv/cmd_vel", type="geometry_msgs/msg/Twist"))
        until(lambda: peer.has(op="advertise_action", action="/ugv/follow_joint_trajectory"))
        until(lambda: peer.has(op="advertise_service", service="/virtualrobot/get_entities"))
        assert not any(one.get("service", "").startswith("/rosapi/") for one in peer.came)
        # The lidar sees nothing, which is infinity (REP 117): in JSON of Python's own.
        until(lambda: any('"/ugv/lidar/scan"' in one and "Infinity" in one for one in tuple(peer.texts)))

        peer.say(op="status", level="error", msg="no such type", id="advertise:/x")
        until(lambda: "the server says: no such type" in said)
        peer.say(op="publish", topic="/ugv/cmd_vel", msg={"linear": {"x": "fast"}})
        until(lambda: any(words.startswith("from the server: /ugv/cmd_vel: linear.x") for words in said))
        peer.say(op="call_service", id="service_request:/x:1", service="/virtualrobot/get_simulation_state", args={})
        until(lambda: peer.has(op="service_response", id="service_request:/x:1", result=True))

        client.scene.clear()
        until(lambda: peer.has(op="unadvertise_action", action="/ugv/follow_joint_trajectory"))
        until(lambda: peer.has(op="unsubscribe", topic="/ugv/cmd_vel"))
    assert not peer.has(op="status")
