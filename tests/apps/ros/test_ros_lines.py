"""Operations of rosbridge as lines of JSON by plain TCP, by a socket of Python's own."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from urllib.parse import urlsplit

import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.rosbridge.lines import LineServer

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import GUARD, bridge
from tests.kernels import KernelProcess
from tests.waiting import until


class Lines:
    """A client: one line out, one line in."""

    def __init__(self, url: str, open: ExitStack) -> None:
        """Connect until `open` is closed."""
        place = urlsplit(url)
        assert place.hostname and place.port
        self.socket = open.enter_context(socket.create_connection((place.hostname, place.port), GUARD))
        self._file = open.enter_context(self.socket.makefile("rb"))

    def say(self, **op: object) -> None:
        """Send an operation."""
        self.socket.sendall(json.dumps(op).encode() + b"\n")

    def next(self, op: str) -> dict[str, Any]:
        """Return the next message with this operation."""
        while True:
            line = self._file.readline()
            assert line, "the bridge has hung up"
            if (message := json.loads(line))["op"] == op:
                return message

    def rest(self) -> list[dict[str, Any]]:
        """Return all that still comes, until the bridge hangs up."""
        return [json.loads(line) for line in self._file]


@contextmanager
def lines(client: Client, token: str = "") -> Iterator[str]:
    server = LineServer("127.0.0.1", 0, token=token)
    with bridge(client, more=[server]):
        yield server.url


def test_a_craft_is_driven_and_an_arm_is_read(client: Client) -> None:
    arm = client.load_robot(IIWA, name="arm")
    client.load_robot("model://ugv", name="ugv", base="planar", pose=virtualrobot.pose(y=3.0))
    with lines(client) as url, ExitStack() as open:
        one = Lines(url, open)
        one.say(op="subscribe", topic="/arm/joint_states", type="sensor_msgs/JointState")
        until(lambda: one.next("publish")["msg"]["position"] == [0.0] * 7)
        arm.set_positions([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7])
        until(lambda: one.next("publish")["msg"]["position"] == [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7])
        one.say(op="unsubscribe", topic="/arm/joint_states")

        def drives() -> bool:
            one.say(op="publish", topic="/ugv/cmd_vel", msg={"linear": {"x": 0.2}})
            return client.streams.sample("/robots/ugv/base").values["x"] > 0.02

        until(drives)
        one.say(op="call_service", service="/rosapi/topics", id="7")
        told = one.next("service_response")
        assert told["id"] == "7" and "/arm/joint_states" in told["values"]["topics"]


def test_bad_lines_are_told_and_take_nobody_down(client: Client) -> None:
    with lines(client, token="word") as url, ExitStack() as open:
        bystander, one, page, endless = (Lines(url, open) for _ in range(4))
        bystander.say(op="auth", token="word")
        one.say(op="subscribe", topic="/clock")
        assert "say the token first" in one.next("status")["msg"]
        one.say(op="auth", token="word")
        one.socket.sendall(b"\n  \n{never\n")
        assert "a message is no JSON" in one.next("status")["msg"]
        one.say(op="subscribe", topic="/clock", compression="cbor")
        assert one.next("status")["msg"] == "'compression' of lines is one of none, png"
        one.say(op="subscribe", topic="/clock")
        assert "clock" in one.next("publish")["msg"]

        # What a page of a browser would send is not read on.
        page.socket.sendall(b'POST / HTTP/1.1\r\n\r\n{"op": "auth", "token": "word"}\n{"op": "subscribe"}\n')
        assert [said["msg"] for said in page.rest()] == ["a line is an object of JSON with an 'op'"]

        with pytest.raises(OSError):
            for _ in range(200):
                endless.socket.sendall(b" " * (1 << 20))
        bystander.say(op="subscribe", topic="/clock")
        assert "clock" in bystander.next("publish")["msg"]


def test_a_port_that_is_taken_is_named(kernel: KernelProcess) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        command = [
            sys.executable,
            "-m",
            "virtualrobot",
            "--address",
            kernel.address,
            "ros",
            "--port",
            "0",
            "--lines",
            port,
        ]
        done = subprocess.run(command, capture_output=True, text=True, timeout=GUARD)
    assert (done.returncode, done.stderr.count("\n")) == (1, 1), done.stderr
    assert f"lines can't be served at 127.0.0.1:{port}: Address already in use" in done.stderr
