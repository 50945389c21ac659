"""Malformed messages to the bridge by rosbridge: each is refused in words, and bystanders are served."""

from __future__ import annotations

import base64
import io
import json
import math
import random
import struct
import time
import zlib
from collections.abc import Iterator
from socket import SHUT_WR, create_connection
from urllib.parse import urlsplit

import pytest
import virtualrobot
from PIL import Image
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.hub import HubError
from virtualrobot_apps.bridges.ros.rosbridge.wire import Fragments, decoded, text_of_png
from websockets.exceptions import ConnectionClosed

from tests.apps.ros.bridges import answer, bridge, say, socket
from tests.tiers import Draws

OPS = (
    *("subscribe", "unsubscribe", "advertise", "unadvertise", "publish", "call_service", "advertise_service"),
    *("service_response", "send_action_goal", "cancel_action_goal", "advertise_action", "action_feedback"),
    *("action_result", "fragment", "png", "set_level", "auth", "status", "", "publish ", None, 5),
)
KEYS = (
    *("op", "id", "topic", "type", "msg", "service", "args", "action", "compression", "throttle_rate", "num", "total"),
    *("queue_length", "fragment_size", "data", "level", "values", "result", "status", "latch", "timeout", "token"),
)
WORDS = (
    *(
        "/clock",
        "/ugv/cmd_vel",
        "/tf",
        "clock",
        "/none",
        "sensor_msgs/JointState",
        "std_msgs/String",
        "cbor",
        "png",
        "",
    ),
    *(
        "rosapi/topics",
        "/rosapi/message_details",
        "std_srvs/SetBool",
        "\ud800",
        "a\0b",
        "//",
        "x" * 300,
        "NaN",
        "error",
    ),
)
NUMBERS = (0, 1, -1, True, None, 1e308, -0.0, 2**63, 10**30, 0.5, float("nan"), float("inf"))


@pytest.fixture
def url(client: Client) -> Iterator[str]:
    """Return the address of a bridge to a world with a UGV."""
    client.load_robot("model://ugv", base="planar", pose=virtualrobot.pose())
    with bridge(client) as (url, _):
        yield url


def drawn(draw: random.Random, depth: int = 0) -> object:
    """Return a value of any kind."""
    kind = draw.randrange(6 if depth < 4 else 3)
    if kind < 2:
        return draw.choice(NUMBERS)
    if kind == 2:
        return draw.choice(WORDS)
    if kind == 3:
        return [drawn(draw, depth + 1) for _ in range(draw.randrange(4))]
    return {draw.choice(KEYS): drawn(draw, depth + 1) for _ in range(draw.randrange(5))}


def malformed(draw: random.Random) -> str | bytes:
    """Return a message that is wrong in one of many ways, or by chance right."""
    kind = draw.randrange(12)
    if kind == 0:
        return bytes(draw.randrange(256) for _ in range(draw.randrange(1, 60)))
    if kind == 1:
        depth = draw.randrange(1, 200_000)
        return draw.choice(("[", '{"a":', '{"op":"publish","msg":')) * depth
    if kind == 2:  # CBOR that says how many things follow, and they don't
        head = draw.choice((0x5B, 0x7B, 0x9B, 0xBB))
        return b"\xa1\x62op" + bytes([head]) + struct.pack(">Q", draw.choice((2**64 - 1, 2**40, 2**31)))
    if kind == 3:
        return b"\xa1\x62op" + bytes([draw.choice((0x81, 0xA1, 0xC2, 0xD8))]) * draw.randrange(1, 5000)
    if kind == 4:  # fragments of messages that never end
        number = draw.choice(("a", str(draw.random())))
        total = draw.choice((2, 9_999, 10**9))
        return json.dumps({"op": "fragment", "id": number, "num": draw.randrange(3), "total": total, "data": "x" * 500})
    if kind == 5:
        return json.dumps(
            {"op": "png", "data": draw.choice((bomb(), "AAAA", "#", base64.b64encode(b"\x89PNG").decode()))}
        )
    if kind == 6:
        whole = json.dumps({"op": draw.choice(OPS), "topic": draw.choice(WORDS), "msg": {}})
        return whole[: draw.randrange(1, len(whole))]
    message = {"op": draw.choice(OPS), **{draw.choice(KEYS[1:]): drawn(draw) for _ in range(draw.randrange(6))}}
    return json.dumps(message)


def bomb(edge: int = 60_000) -> str:
    """Return a picture that is small as it comes and far larger than any message when it is unpacked."""
    out = io.BytesIO()
    header = struct.pack(">IIBBBBB", edge, edge, 8, 2, 0, 0, 0)
    Image.new("RGB", (1, 1)).save(out, "png")
    data = bytearray(out.getvalue())
    data[16:29] = header
    data[29:33] = struct.pack(">I", zlib.crc32(b"IHDR" + header))
    return base64.b64encode(bytes(data)).decode()


def test_malformed_messages_harm_nobody(url: str, seed: int, draws: Draws) -> None:
    draw = random.Random(seed)
    longest = 0.0
    with socket(url) as bystander:
        for round_number in range(draws(50)):
            with socket(url) as bad:
                try:
                    for _ in range(100):
                        bad.send(malformed(draw))
                    say(bad, op="call_service", service="/rosapi/nodes", id="still here")
                    answer(bad, id="still here")
                except ConnectionClosed as error:
                    # Not UTF-8, or so many wrong messages that their answers were not read.
                    assert error.rcvd is not None and error.rcvd.code in (1007, 1008), error
            began = time.monotonic()
            say(
                bystander,
                op="call_service",
                service="/rosapi/topic_type",
                args={"topic": "/clock"},
                id=str(round_number),
            )
            assert answer(bystander, id=str(round_number))["values"] == {"type": "rosgraph_msgs/msg/Clock"}
            longest = max(longest, time.monotonic() - began)
    print(f"longest answer for the bystander: {longest:.3f} s")


def test_what_is_asked_wrongly_is_refused_in_words(url: str) -> None:
    with socket(url) as one:
        for op, words in (
            ({"op": "subscribe"}, "'subscribe' needs the text 'topic'"),
            ({"op": "subscribe", "topic": "/none"}, "there is no topic /none; with a 'type' it is waited for"),
            ({"op": "subscribe", "topic": "/clock", "type": "std_msgs/String"}, "has the type rosgraph_msgs/msg/Clock"),
            ({"op": "subscribe", "topic": "/clock", "throttle_rate": -1}, "'throttle_rate' is a number from 0"),
            (
                {"op": "subscribe", "topic": "/clock", "compression": "zip"},
                "png, cbor, cbor-raw, not 'zip'",
            ),
            ({"op": "subscribe", "topic": "a b", "type": "std_msgs/String"}, "is no name of a topic"),
            ({"op": "advertise", "topic": "/x", "type": "std_msgs/Sting"}, "did you mean 'std_msgs/msg/String'"),
            ({"op": "advertise", "topic": "/clock", "type": "rosgraph_msgs/Clock"}, "/clock is told by the world"),
            ({"op": "publish", "topic": "/clock", "msg": {}}, "/clock is told by the world"),
            ({"op": "publish", "topic": "/x", "msg": {}}, "/x is not advertised"),
            ({"op": "publish", "topic": "/ugv/cmd_vel", "msg": {"linear": {"u": 1}}}, "linear has no field 'u'"),
            ({"op": "publish", "topic": "/ugv/cmd_vel", "msg": {"linear": {"x": None}}}, "finite numbers, not nan"),
            ({"op": "advertise_service", "service": "/rosapi/topics", "type": "std_srvs/Empty"}, "is there already"),
            ({"op": "cancel_action_goal", "id": "x"}, "no goal 'x' is under way"),
            ({"op": "service_response", "id": "x"}, "nothing was asked under the id 'x'"),
            ({"op": "fly"}, "'op' is one of auth, fragment"),
            ({"op": "fragment", "id": "x", "num": 5, "total": 2, "data": ""}, "'num' is from 0 to 'total' - 1"),
        ):
            say(one, **{**op, "id": op.get("id", "asked")})
            told = answer(one, op="status")
            assert words in told["msg"] and told["id"] == op.get("id", "asked"), told
        for service, words in (("/none", "there is no service '/none'"), ("/rosapi/topic_type", "has no field 'x'")):
            say(one, op="call_service", service=service, args={"x": 1}, id="called")
            told = answer(one, op="service_response")
            assert told["result"] is False and words in told["values"] and told["id"] == "called"
        say(one, op="call_service", service=math.nan, id="no name")
        told = answer(one, op="service_response", id="no name")
        assert (told["result"], told["values"]) == (False, "'call_service' needs the text 'service'")
        say(one, op="send_action_goal", action=math.inf, id="no name")
        told = answer(one, op="action_result", id="no name")
        assert (told["result"], told["values"]) == (False, "'send_action_goal' needs the text 'action'")
        say(one, op="send_action_goal", action="/none", id="goal")
        told = answer(one, op="action_result")
        assert (told["result"], told["values"]) == (False, "there is no action '/none'")


def test_a_client_that_reads_nothing_costs_nothing_and_delays_nobody(client: Client, url: str) -> None:
    with socket(url) as deaf, socket(url) as bystander:
        for number in range(20):
            say(deaf, op="subscribe", topic="/clock", id=str(number))
            say(deaf, op="subscribe", topic="/tf", id=str(number))
        for number in range(50):
            say(bystander, op="call_service", service="/rosapi/nodes", id=str(number))
            assert answer(bystander, id=str(number))["result"] is True


def test_who_speaks_no_http_is_not_worth_a_word(url: str, caplog: pytest.LogCaptureFixture) -> None:
    place = urlsplit(url)
    for words in (b"", b"\0\1 nonsense\r\n\r\n", b"GET / HTTP/1.1\r\n"):
        with create_connection((place.hostname, place.port), timeout=60.0) as one:
            one.sendall(words)
            one.shutdown(SHUT_WR)
            while one.recv(4096):
                continue
    assert not caplog.records


def test_pictures_larger_than_a_message_are_not_unpacked() -> None:
    with pytest.raises(HubError, match="a picture of 243000000 bytes is larger than a message may be"):
        text_of_png(bomb(9_000))
    with pytest.raises(HubError, match="no text in a PNG picture in base64: DecompressionBombError"):
        text_of_png(bomb())
    with pytest.raises(HubError, match="no text in a PNG picture"):
        text_of_png("AAAA")


def test_fragments_without_an_end_are_dropped() -> None:
    fragments = Fragments()
    with pytest.raises(HubError, match="too many fragments without an end"):
        for number in range(100):
            fragments.add({"id": str(number), "num": 0, "total": 2, "data": "x"})
    assert fragments.add({"id": "a", "num": 1, "total": 2, "data": "b"}) is None
    assert fragments.add({"id": "a", "num": 0, "total": 2, "data": "a"}) == "ab"


@pytest.mark.parametrize("data", ["[1]", "5", '{"op":' * 100_000, b"\x9b" + b"\xff" * 8, b"\xd8\x55\x43abc", "{", b""])
def test_what_is_no_object_is_refused(data: str | bytes) -> None:
    with pytest.raises(HubError, match="a message is"):
        decoded(data)
