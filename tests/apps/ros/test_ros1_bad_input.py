"""The bridge's node of ROS 1 and its master under what is no TCPROS and no XML-RPC, with a bystander who reads on."""

from __future__ import annotations

import http.client
import random
import socket
import struct
import xmlrpc.client
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any
from urllib.parse import urlsplit

import pytest
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.messages.ros1 import md5_of
from virtualrobot_apps.bridges.ros.ros1.node import Ros1Node
from virtualrobot_apps.bridges.ros.ros1.tcpros import header

from tests.apps.ros.bridges import GUARD, bridge

pytestmark = pytest.mark.long

CLOCK = {"callerid": "/test", "topic": "/clock", "type": "rosgraph_msgs/Clock", "md5sum": "*"}
SERVICE = {"callerid": "/test", "service": "/virtualrobot/get_entities", "md5sum": "*"}


@pytest.fixture
def node(client: Client) -> Iterator[Ros1Node]:
    """Return a node at a master of its own."""
    one = Ros1Node("http://127.0.0.1:0")
    with bridge(client, more=[one]):
        yield one


def slave(node: Ros1Node) -> str:
    """Return where other nodes ask this one."""
    return asked(node.master, "lookupNode", "/virtualrobot")[2]


def asked(uri: str, method: str, *arguments: Any) -> Any:  # noqa: ANN401 whatever is answered
    """Return what is answered."""
    with xmlrpc.client.ServerProxy(uri, allow_none=True) as other:
        return getattr(other, method)("/test", *arguments)


def connected(node: Ros1Node, data: bytes) -> socket.socket:
    """Return a connection of TCPROS on which these bytes have been sent."""
    _, _, (_, host, port) = asked(slave(node), "requestTopic", "/clock", [["TCPROS"]])
    one = socket.create_connection((host, port), timeout=GUARD)
    one.sendall(data)
    return one


def block(one: socket.socket) -> bytes:
    """Return the bytes behind their length."""
    (size,) = struct.unpack("<I", exactly(one, 4))
    return exactly(one, size)


def exactly(one: socket.socket, size: int) -> bytes:
    """Return so many bytes."""
    found = b""
    while len(found) < size:
        data = one.recv(size - len(found))
        assert data, "it was cut off"
        found += data
    return found


def refused(node: Ros1Node, data: bytes) -> str:
    """Return what the peer of a connection is told before it is cut off."""
    with connected(node, data) as one:
        told = block(one)
        assert one.recv(1) == b""
    assert told[4:10] == b"error=", told
    return told[10:].decode()


def test_connections_that_are_none_are_told_why_and_others_read_on(node: Ros1Node, rng: Any) -> None:  # noqa: ANN401
    draws = random.Random(int(rng.integers(2**32)))
    with connected(node, header(CLOCK)) as stuck, connected(node, header(CLOCK)) as bystander:
        assert f"md5sum={md5_of('rosgraph_msgs/msg/Clock')}".encode() in block(bystander)
        wrong = {**CLOCK, "type": "std_msgs/String", "md5sum": md5_of("std_msgs/msg/String")}
        assert "/clock has the type rosgraph_msgs/Clock with the MD5 sum a9c97c1d" in refused(node, header(wrong))
        assert "has no topic and no service '/other'" in refused(node, header({**CLOCK, "topic": "/other"}))
        assert "1048576" in refused(node, b"POST / HTTP/1.0\r\n\r\n")
        assert "longer than the header" in refused(node, struct.pack("<II", 8, 99) + b"four")
        for _ in range(100):
            with connected(node, draws.randbytes(draws.randrange(60))):
                pass
        with connected(node, header({**SERVICE, "persistent": "1"})) as caller:
            block(caller)
            for body in (b"", b"\xff" * 40, struct.pack("<I", 2**31) + b"x"):
                caller.sendall(struct.pack("<I", len(body)) + body)
                assert exactly(caller, 1) == b"\0" and block(caller)  # in words
            caller.sendall(struct.pack("<I", 2**31))
            assert exactly(caller, 4)  # a header of an error, and the end
        times = [struct.unpack("<II", block(bystander)) for _ in range(50)]
        assert times == sorted(times) and times[0] < times[-1]
        assert stuck.fileno() >= 0  # it has read nothing all the while


@pytest.mark.parametrize("which", [lambda node: node.master, slave], ids=["master", "node"])
def test_calls_that_are_none_are_answered_with_what_is_wrong(
    node: Ros1Node,
    rng: Any,  # noqa: ANN401
    which: Callable[[Ros1Node], str],
) -> None:
    draws = random.Random(int(rng.integers(2**32)))
    uri = which(node)
    place = urlsplit(uri).netloc

    def status(body: bytes, **fields: str) -> tuple[int, bytes]:
        with closing(http.client.HTTPConnection(place, timeout=GUARD)) as one:
            one.request("POST", "/", body, fields)
            answer = one.getresponse()
            return answer.status, answer.read()

    good = xmlrpc.client.dumps(("/test",), "getPid").encode()
    assert status(good)[0] == 200
    assert status(good, Origin="https://example.com")[0] == 403
    bomb = b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "c">]>' + good[good.index(b"<methodCall") :]
    assert b"definitions are not read" in status(bomb)[1]
    deep = b"<methodCall><methodName>setParam</methodName><params><param>" + b"<value><array><data>" * 5000
    for body in (b"", b"<", deep, good[: len(good) // 2], b"\xff\xfe" + good):
        assert b"<fault>" in status(body)[1]
    for _ in range(100):
        broken = bytearray(good)
        for _ in range(draws.randrange(1, 6)):
            broken[draws.randrange(len(broken))] = draws.randrange(256)
        assert status(bytes(broken))[0] == 200
    for name, arguments in (("noSuchMethod", ()), ("getPid", (1, 2, 3))):
        with pytest.raises(xmlrpc.client.Fault):
            asked(uri, name, *arguments)


def test_a_master_refuses_in_words_what_is_no_name_no_address_and_no_value(node: Ros1Node) -> None:
    place = "http://127.0.0.1:9/"
    cases = {
        "begins with /": ("registerPublisher", "no name", "std_msgs/String", place),
        "http://HOST:PORT/": ("registerPublisher", "/x", "std_msgs/String", "file:///etc/passwd"),
        "a word belongs here": ("registerPublisher", 7, "std_msgs/String", place),
        "there is no service": ("lookupService", "/no"),
        "there is no node": ("lookupNode", "/no"),
        "there is no parameter": ("getParam", "/no"),
        "are parameters": ("setParam", "/x", xmlrpc.client.Binary(b"x")),
        "letters at most": ("setParam", "/x", "x" * (1 << 21)),
        "single slashes": ("setParam", "/a//b", 1),
    }
    for words, (method, *arguments) in cases.items():
        code, told, _ = asked(node.master, method, *arguments)
        assert code == -1 and words in told, (method, told)
