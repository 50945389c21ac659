"""The contract over HTTP: Connect, gRPC-Web and lines of JSON, and what is refused before the kernel hears of it."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import struct
from contextlib import closing
from http.client import HTTPConnection
from pathlib import Path

import pytest
from google.rpc import error_details_pb2, status_pb2
from virtualrobot.v1 import kernel_pb2, lease_pb2, motion_pb2, scene_pb2
from virtualrobot_apps.console.contract import methods

from tests.api.asking import IIWA, load
from tests.api.reading import step
from tests.apps.console.consoles import PATIENCE_SECONDS, Console
from tests.kernels import Stubs
from tests.waiting import until

PROTO = Path(__file__).parents[3] / "proto" / "virtualrobot" / "v1"
CLOCK = "KernelService/GetClock"
ENVELOPE = struct.Struct(">BI")


def enveloped(*messages: bytes) -> bytes:
    return b"".join(ENVELOPE.pack(0, len(message)) + message for message in messages)


def opened(body: bytes) -> list[tuple[int, bytes]]:
    """Return flags and data of each envelope."""
    found = []
    while body:
        flags, size = ENVELOPE.unpack_from(body)
        found.append((flags, body[ENVELOPE.size : ENVELOPE.size + size]))
        body = body[ENVELOPE.size + size :]
    return found


def test_every_method_of_the_contract_is_there() -> None:
    said = {
        f"/virtualrobot.v1.{service}/{rpc}"
        for file in PROTO.glob("*.proto")
        for service, body in re.findall(r"^service (\w+) \{(.*?)^\}", file.read_text("utf-8"), re.M | re.S)
        for rpc in re.findall(r"^  rpc (\w+)\(", body, re.M)
    }
    assert set(methods()) == said and len(said) > 80


def test_a_call_is_a_post_of_json(console: Console, stepped: Stubs) -> None:
    step(stepped, 3)
    reply = console.ask(CLOCK)
    here = stepped.kernel.GetClock(kernel_pb2.GetClockRequest())
    assert reply.status == 200 and reply.headers["content-type"] == "application/json"
    assert reply.json["stamp"]["tick"] == str(here.stamp.tick)  # 64 bits are text in protobuf's JSON
    assert reply.json["clock"]["mode"] == "CLOCK_MODE_STEPPED"
    assert console.ask(CLOCK, b"").json["clock"] == reply.json["clock"]


def test_a_call_is_a_post_of_bytes(console: Console, stepped: Stubs) -> None:
    reply = console.ask(CLOCK, b"", content_type="application/proto")
    assert kernel_pb2.GetClockResponse.FromString(reply.body).clock.mode == kernel_pb2.CLOCK_MODE_STEPPED


@pytest.mark.parametrize("kind", ["grpc-web", "grpc-web+proto", "grpc-web+json", "grpc-web-text"])
def test_grpc_web_answers_and_refuses_in_trailers(console: Console, stepped: Stubs, kind: str) -> None:
    def ask(method: str, message: bytes) -> list[tuple[int, bytes]]:
        body = enveloped(message)
        body = base64.b64encode(body) if "text" in kind else body
        reply = console.ask(method, body, content_type=f"application/{kind}")
        assert reply.status == 200
        return opened(_plain(kind, reply.body))

    (_, answer), (flags, trailers) = ask(CLOCK, b"{}" if "json" in kind else b"")
    if "json" in kind:
        assert json.loads(answer)["clock"]["mode"] == "CLOCK_MODE_STEPPED"
    else:
        assert kernel_pb2.GetClockResponse.FromString(answer).clock.mode == kernel_pb2.CLOCK_MODE_STEPPED
    assert flags == 0x80 and trailers == b"grpc-status: 0\r\n"

    request = b'{"id": "none"}' if "json" in kind else motion_pb2.GetMotionRequest(id="none").SerializeToString()
    ((flags, trailers),) = ask("MotionService/GetMotion", request)
    said = dict(line.split(": ", 1) for line in trailers.decode().splitlines())
    assert flags == 0x80 and said["grpc-status"] == "5"
    details = said["grpc-status-details-bin"]
    status = status_pb2.Status.FromString(base64.b64decode(details + "=" * (-len(details) % 4)))
    info = error_details_pb2.ErrorInfo()
    assert status.details[0].Unpack(info) and info.reason == "UNKNOWN_NAME"


def _plain(kind: str, body: bytes) -> bytes:
    """Return the envelopes of an answer; in base64 each is a text of its own, with its own padding."""
    if "text" not in kind:
        return body
    return b"".join(base64.b64decode(part) for part in re.findall(rb"[^=]+=*", body))


@pytest.mark.parametrize("kind", ["json", "proto"])
def test_connect_streams_answers_and_refuses_in_the_last_envelope(console: Console, stepped: Stubs, kind: str) -> None:
    content_type = f"application/connect+{kind}"
    empty = b"{}" if kind == "json" else b""
    with console.begun("RobotService/WatchRobotStates", enveloped(empty), content_type=content_type) as response:
        assert response.getheader("content-type") == content_type
        flags, size = ENVELOPE.unpack(response.read(ENVELOPE.size))
        assert flags == 0 and (kind == "proto" or json.loads(response.read(size))["robots"] == [])
    name = "x" * 300
    request = json.dumps({"id": name}).encode() if kind == "json" else motion_pb2.WatchMotionRequest(id=name)
    body = request if isinstance(request, bytes) else request.SerializeToString()
    reply = console.ask("MotionService/WatchMotion", enveloped(body), content_type=content_type)
    ((flags, end),) = opened(reply.body)
    error = json.loads(end)["error"]
    assert flags == 2 and error["code"] == "not_found"
    assert error["details"][0]["debug"]["reason"] == "UNKNOWN_NAME"
    detail = base64.b64decode(error["details"][0]["value"] + "==")
    assert error_details_pb2.ErrorInfo.FromString(detail).reason == "UNKNOWN_NAME"


def test_requests_are_streamed_too(console: Console, stepped: Stubs, seed: int) -> None:
    """UploadAsset takes a file in pieces and answers once."""
    file = seed.to_bytes(8, "big") * 1000
    pieces = [{"sha256": hashlib.sha256(file).hexdigest(), "chunk": base64.b64encode(file[:5000]).decode()}]
    pieces.append({"chunk": base64.b64encode(file[5000:]).decode()})
    body = enveloped(*(json.dumps(piece).encode() for piece in pieces))
    reply = console.ask("AssetService/UploadAsset", body, content_type="application/connect+json")
    (_, answer), (_, end) = opened(reply.body)
    assert json.loads(answer) == {"sha256": pieces[0]["sha256"], "size_bytes": "8000"} and json.loads(end) == {}
    # What is no JSON in the middle ends the call with its own words.
    reply = console.ask("AssetService/UploadAsset", enveloped(b"{}", b"{"), content_type="application/connect+json")
    assert "this is no JSON" in json.loads(opened(reply.body)[-1][1])["error"]["message"]


def test_answers_come_as_lines_of_json_and_a_client_that_goes_ends_the_call(console: Console, stepped: Stubs) -> None:
    load(stepped, IIWA, name="arm")
    lease = console.ask("LeaseService/AcquireLease", {"robots": ["arm"], "owner": "a page"}).json
    with console.begun("LeaseService/KeepLeaseAlive", json.dumps({"token": lease["token"]}).encode()) as response:
        assert response.getheader("content-type") == "application/x-ndjson"
        assert json.loads(response.readline())["lease"]["robots"] == ["arm"]
        held = stepped.lease.ListLeases(lease_pb2.ListLeasesRequest())
        assert [one.owner for one in held.leases] == ["a page"]
        turned = {"robot": "arm", "joint_positions": {"lbr_iiwa_joint_1": 0.1}}
        change = {"commands": [{"set_joint_positions": turned}]}
        assert console.ask("SceneService/Apply", change).reason == "LEASED"
        assert console.ask("SceneService/Apply", change, virtualrobot_lease=lease["token"]).status == 200
    until(lambda: not stepped.lease.ListLeases(lease_pb2.ListLeasesRequest()).leases)


def test_a_refusal_of_the_kernel_keeps_its_reason_and_values(console: Console, stepped: Stubs) -> None:
    reply = console.ask("RobotService/GetRobot", {"name": "arn"})
    assert reply.status == 404 and reply.json["code"] == "not_found" and reply.reason == "UNKNOWN_NAME"
    watch = console.ask("MotionService/WatchMotion", {"id": "none"})
    assert watch.status == 404 and watch.reason == "UNKNOWN_NAME"


def test_a_deadline_is_kept(console: Console, stepped: Stubs) -> None:
    reply = console.ask("KernelService/WatchClock", connect_timeout_ms="50")
    last = json.loads(reply.body.splitlines()[-1])
    assert last["error"]["code"] == "deadline_exceeded"
    assert console.ask(CLOCK, connect_timeout_ms="soon").reason == "INVALID_ARGUMENT"


@pytest.mark.parametrize(
    ("body", "field"),
    [
        (b'{"commands": [{"set_speed_factor": {"factor": 0,5}}]}', "factor"),
        (b'{"commands": [{"set_speed_factor": {"factor": "0,5"}}]}', "commands[0].set_speed_factor.factor"),
        (b'{"commands": [{"set_speed_factor": {"factor": [1]}}]}', "commands.factor"),
        (b'{"commands": [{"set_sped_factor": {}}]}', "commands[0].set_sped_factor"),
        (b'{"comands": []}', "comands"),
        (b'{"commands": [', "commands"),
    ],
)
def test_a_wrong_value_is_told_by_its_field(console: Console, stepped: Stubs, body: bytes, field: str) -> None:
    reply = console.ask("SceneService/Apply", body)
    assert reply.status == 400 and reply.reason == "INVALID_ARGUMENT" and reply.metadata["field"] == field
    assert field.rpartition(".")[2] in reply.json["message"]
    assert ("1.5 and not 1,5" in reply.json["message"]) == (b"0,5" in body)


@pytest.mark.parametrize("body", [b"[]", b"7", b"null", b"\xff", b"[" * 100_000])
def test_what_is_no_message_is_refused(console: Console, stepped: Stubs, body: bytes) -> None:
    reply = console.ask("SceneService/Apply", body)
    assert reply.status == 400 and reply.reason == "INVALID_ARGUMENT"


def test_a_body_that_is_too_large_is_refused_before_it_is_sent(console: Console, stepped: Stubs) -> None:
    with closing(HTTPConnection("127.0.0.1", console.port, timeout=PATIENCE_SECONDS)) as connection:
        connection.putrequest("POST", "/virtualrobot.v1.SceneService/LoadScene")
        connection.putheader("content-type", "application/json")
        connection.putheader("content-length", "20000000")
        connection.endheaders()  # and no byte of the body
        with connection.getresponse() as response:
            told = json.loads(response.read())["details"][0]["debug"]
    assert response.status == 429 and told["reason"] == "TOO_LARGE"
    assert told["metadata"] == {"limit_name": "message_bytes", "limit": str(16 << 20), "asked": "20000000"}
    # An envelope says its size, too.
    reply = console.ask("AssetService/UploadAsset", ENVELOPE.pack(0, 1 << 30), content_type="application/connect+proto")
    assert json.loads(opened(reply.body)[0][1])["error"]["details"][0]["debug"]["reason"] == "TOO_LARGE"


def test_what_is_no_call_is_told_in_words(console: Console, stepped: Stubs) -> None:
    assert console.ask("SceneService/Nope").status == 404
    assert console.ask(CLOCK, verb="GET").status == 405
    reply = console.ask(CLOCK, content_type="text/plain")
    assert reply.status == 415 and "application/json" in reply.json["message"]
    assert console.ask(CLOCK, content_encoding="gzip").status == 415
    assert console.ask("/none").status == 404


def test_pages_of_others_are_kept_out(console: Console, stepped: Stubs) -> None:
    refused = console.ask(CLOCK, origin="https://elsewhere.example")
    assert refused.status == 403 and "--origin" in refused.json["message"]
    assert console.ask(CLOCK, origin="null").status == 403
    preflight = console.ask(CLOCK, verb="OPTIONS", origin="https://elsewhere.example")
    assert preflight.status == 403 and "access-control-allow-origin" not in preflight.headers
    assert console.ask(CLOCK, origin=console.url).status == 200
    assert console.ask(CLOCK, host="elsewhere.example").status == 403  # a name that leads here
    assert console.ask(CLOCK, host=f"localhost:{console.port}").status == 200


def test_an_empty_scene_goes_through_as_bytes_and_as_json(console: Console, stepped: Stubs) -> None:
    request = scene_pb2.GetSceneRequest()
    there = stepped.scene.GetScene(request)
    reply = console.ask("SceneService/GetScene", request.SerializeToString(), content_type="application/proto")
    assert scene_pb2.GetSceneResponse.FromString(reply.body).nodes == there.nodes
