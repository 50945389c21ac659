"""Who gets in, and how a kernel ends: token, TLS, ports, signals of the system."""

from __future__ import annotations

import contextlib
import signal
import socket
import stat
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import grpc
import pytest
import trustme
from google.protobuf.internal.encoder import _VarintBytes  # pyright: ignore[reportAttributeAccessIssue]
from grpc_health.v1 import health_pb2, health_pb2_grpc
from grpc_reflection.v1alpha import reflection_pb2, reflection_pb2_grpc
from virtualrobot.v1 import collision_pb2, geometry_pb2, kernel_pb2, kernel_pb2_grpc, robot_pb2, view_pb2

from tests.api.asking import IIWA, load, refusal
from tests.kernels import KernelProcess, StartKernel
from tests.tiers import every_fifth

SERVE = [sys.executable, "-m", "virtualrobot_kernel.serve"]
INFO = kernel_pb2.GetInfoRequest()
HANDSHAKE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes([0, 0, 0, 4, 0, 0, 0, 0, 0])
"""First words of HTTP/2: its preface and empty settings."""


def deep_settings(depth: int) -> bytes:
    """Return a message whose field 3 is a Struct nested so deep: each level is two messages and an entry of a map."""
    inner = b""
    for tag in (b"\x2a", b"\x12", b"\x0a") * depth:
        inner = tag + _VarintBytes(len(inner)) + inner
    return b"\x1a" + _VarintBytes(len(inner)) + inner


@pytest.fixture(scope="module")
def guarded(start_kernel: StartKernel) -> KernelProcess:
    return start_kernel(token=True)


def test_the_token_lets_in(guarded: KernelProcess) -> None:
    assert guarded.stubs().kernel.GetInfo(INFO).api_version == "virtualrobot.v1"


@pytest.mark.parametrize("token", [None, "Bearer wrong", "wrong", ""])
def test_no_token_or_a_wrong_one_is_refused(guarded: KernelProcess, token: str | None) -> None:
    stub = kernel_pb2_grpc.KernelServiceStub(grpc.insecure_channel(guarded.address))
    metadata = () if token is None else (("authorization", token),)
    refused = refusal(lambda: stub.GetInfo(INFO, metadata=metadata))
    assert refused.code is grpc.StatusCode.UNAUTHENTICATED
    assert refused.reason == "UNAUTHENTICATED"
    assert "authorization: Bearer" in refused.message


def test_streams_want_the_token_too(guarded: KernelProcess) -> None:
    stub = kernel_pb2_grpc.KernelServiceStub(grpc.insecure_channel(guarded.address))
    assert refusal(lambda: next(stub.WatchClock(kernel_pb2.WatchClockRequest()))).reason == "UNAUTHENTICATED"


@pytest.mark.parametrize(
    ("method", "data"),
    [
        ("robot.SolveInverse", b"\xff" * 40),
        ("sensor.SetRangeComponents", deep_settings(60)),
        ("scene.WatchScene", b"\xff" * 40),
        ("motion.StreamSetpoints", b"\xff" * 40),
    ],
    ids=["unary", "deep", "stream", "both streams"],
)
def test_what_cannot_be_decoded_is_refused_and_never_before_the_token(
    guarded: KernelProcess, method: str, data: bytes
) -> None:
    noun, name = method.split(".")
    path = f"/virtualrobot.v1.{noun.capitalize()}Service/{name}"
    stranger = grpc.insecure_channel(guarded.address)
    for channel, reason in ((stranger, "UNAUTHENTICATED"), (guarded.channel(), "INVALID_ARGUMENT")):
        call = channel.stream_stream(path)  # whatever the method: what is sent and answered is a stream on the wire
        refused = refusal(lambda call=call: list(call(iter([data]))))
        assert (refused.reason, refused.code) == (reason, grpc.StatusCode[reason])
        assert channel is stranger or f"the {len(data)} bytes of the request are not decodable" in refused.message
        channel.close()
    assert not [line for line in guarded.lines if "Traceback" in line]


def test_health_is_open_and_says_serving(guarded: KernelProcess) -> None:
    stub = health_pb2_grpc.HealthStub(grpc.insecure_channel(guarded.address))
    for service in ("", "virtualrobot.v1.MotionService"):
        answer = stub.Check(health_pb2.HealthCheckRequest(service=service))  # pyright: ignore  its stubs have no types
        assert answer.status == health_pb2.HealthCheckResponse.SERVING


def test_a_watch_of_health_wants_the_token(guarded: KernelProcess) -> None:
    """Strangers hold no stream open."""
    ask = health_pb2.HealthCheckRequest()  # pyright: ignore  its stubs have no types
    stranger, friend = (
        health_pb2_grpc.HealthStub(channel) for channel in (grpc.insecure_channel(guarded.address), guarded.channel())
    )
    assert refusal(lambda: next(stranger.Watch(ask))).reason == "UNAUTHENTICATED"  # pyright: ignore
    watch = friend.Watch(ask)  # pyright: ignore
    assert next(watch).status == health_pb2.HealthCheckResponse.SERVING
    watch.cancel()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no descriptors")
@pytest.mark.long
@pytest.mark.parametrize("said", [b"", HANDSHAKE], ids=["nothing", "handshake"])
def test_who_connects_and_says_no_more_locks_nobody_out(start_kernel: StartKernel, said: bytes) -> None:
    """More than there are descriptors; each is closed, at once or when it has said nothing for some seconds.

    Neither before HTTP/2 nor after its first words.
    """
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (256, hard))
    try:
        kernel = start_kernel()
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    host, port = kernel.address.split(":")
    with contextlib.ExitStack() as stack:
        silent = [stack.enter_context(socket.create_connection((host, int(port)))) for _ in range(300)]
        for connection in silent:
            with contextlib.suppress(OSError):
                connection.send(said)
        stub = kernel.stubs().kernel
        assert stub.GetInfo(INFO, wait_for_ready=True, timeout=40).process_id == kernel.process.pid
        for connection in silent:
            with contextlib.suppress(ConnectionResetError):
                while connection.recv(1000):
                    pass
    assert kernel.end() == 0
    assert not [line for line in kernel.lines if "Traceback" in line or "ERROR" in line], kernel.lines


def test_reflection_lists_the_services_but_wants_the_token(guarded: KernelProcess) -> None:
    def ask(channel: grpc.Channel) -> Iterator[Any]:
        request = reflection_pb2.ServerReflectionRequest(list_services="")
        stub = reflection_pb2_grpc.ServerReflectionStub(channel)
        return stub.ServerReflectionInfo(iter([request]))  # pyright: ignore  its stubs have no types

    with guarded.channel() as channel:
        answers = ask(channel)
        names = {service.name for service in next(answers).list_services_response.service}
    nouns = ("Kernel", "Asset", "Scene", "Robot", "Motion", "Signal", "View")
    assert {f"virtualrobot.v1.{noun}Service" for noun in nouns} <= names
    assert refusal(lambda: next(ask(grpc.insecure_channel(guarded.address)))).reason == "UNAUTHENTICATED"


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no file modes; the file lies in the user's profile")
def test_only_the_user_reads_the_token_and_it_goes_with_the_kernel(start_kernel: StartKernel, tmp_path: Path) -> None:
    path = tmp_path / "token"
    kernel = start_kernel("--token-file", str(path), token=False, no_token=False)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert kernel.end() == 0
    assert not path.exists()


def test_beyond_this_machine_needs_tls() -> None:
    refused = subprocess.run([*SERVE, "--host", "0.0.0.0", "--port", "0"], capture_output=True, text=True, timeout=100)
    assert refused.returncode == 1
    assert refused.stderr.strip().splitlines()[-1].startswith("virtualrobot serve: 0.0.0.0 is reachable from other")
    assert "Traceback" not in refused.stderr


@pytest.mark.long
def test_tls_serves_with_a_certificate(start_kernel: StartKernel, tmp_path: Path) -> None:
    authority = trustme.CA()
    issued = authority.issue_cert("localhost")
    certificate, key = tmp_path / "certificate.pem", tmp_path / "key.pem"
    certificate.write_bytes(b"".join(blob.bytes() for blob in issued.cert_chain_pems))
    key.write_bytes(issued.private_key_pem.bytes())
    kernel = start_kernel("--tls-certificate", str(certificate), "--tls-key", str(key))
    port = kernel.address.rpartition(":")[2]
    credentials = grpc.ssl_channel_credentials(authority.cert_pem.bytes())
    with grpc.secure_channel(f"localhost:{port}", credentials) as channel:
        assert kernel_pb2_grpc.KernelServiceStub(channel).GetInfo(INFO, timeout=30).process_id
    with grpc.insecure_channel(f"localhost:{port}") as channel, pytest.raises(grpc.RpcError) as refused:
        kernel_pb2_grpc.KernelServiceStub(channel).GetInfo(INFO, timeout=30)
    assert refused.value.code() is grpc.StatusCode.UNAVAILABLE  # pyright: ignore[reportAttributeAccessIssue]


def test_a_port_in_use_is_one_readable_line(kernel: KernelProcess) -> None:
    port = kernel.address.rpartition(":")[2]
    command = [*SERVE, "--headless", "--no-token", "--port", port]
    refused = subprocess.run(command, capture_output=True, text=True, timeout=100)
    assert refused.returncode == 1
    lines = [line for line in refused.stderr.splitlines() if not line.startswith("compiling")]
    assert len(lines) == 1, refused.stderr
    assert f"cannot listen on 127.0.0.1:{port}: the port is in use" in lines[0]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows knows neither signal")
@pytest.mark.parametrize("number", every_fifth([signal.SIGTERM, signal.SIGINT]))
def test_a_signal_ends_the_kernel_cleanly(start_kernel: StartKernel, number: signal.Signals) -> None:
    kernel = start_kernel()
    stubs = kernel.stubs()
    watch = stubs.robot.WatchRobotStates(robot_pb2.WatchRobotStatesRequest(max_rate_hertz=1))
    next(watch)
    kernel.process.send_signal(number)
    refused = refusal(lambda: next(watch))
    assert (refused.code, refused.reason) == (grpc.StatusCode.UNAVAILABLE, "SHUTTING_DOWN")
    assert kernel.process.wait(30) == 0
    assert not [line for line in kernel.lines if "Traceback" in line or "ERROR" in line], kernel.lines


@pytest.mark.long
def test_an_ending_kernel_says_so_to_who_waits_for_long_work(start_kernel: StartKernel) -> None:
    """Some check configurations, one tries some, two take pictures: each for much longer than a kernel takes to end."""
    kernel = start_kernel()
    stubs = kernel.stubs()
    load(stubs, IIWA, "arm")
    zeros = geometry_pb2.NumericArray(
        shape=[200_000, 7], type=geometry_pb2.NUMERIC_TYPE_FLOAT64, data=bytes(8 * 7 * 200_000)
    )
    request = collision_pb2.CheckConfigurationsRequest(
        configurations=[collision_pb2.RobotConfigurations(robot="arm", positions=zeros)]
    )
    tried = collision_pb2.FindAllowedPairsRequest(robot="arm", samples=100_000)
    checks = [stubs.collision.FindAllowedPairs(tried, timeout=100)]
    checks += [stubs.collision.CheckConfigurations(request, timeout=100) for _ in range(3)]
    for check in checks:
        assert next(part.progress for part in check if part.progress) < 0.5
    shot = view_pb2.Shot(width=4000, height=3000)
    picture = stubs.view.CaptureImage.future(view_pb2.CaptureImageRequest(shot=shot), timeout=100)
    film = stubs.view.RecordFilm(view_pb2.RecordFilmRequest(shot=shot, frames_per_second=10), timeout=100)
    stubs.kernel.Shutdown(kernel_pb2.ShutdownRequest())
    waiting = [lambda check=check: [None for _ in check] for check in (*checks, film)]
    for wait in (picture.result, *waiting):
        refused = refusal(wait)
        assert (refused.code, refused.reason) == (grpc.StatusCode.UNAVAILABLE, "SHUTTING_DOWN")
    assert kernel.process.wait(30) == 0
    assert not [line for line in kernel.lines if "Traceback" in line or "ERROR" in line], kernel.lines


@pytest.mark.long
def test_a_client_can_end_the_kernel(start_kernel: StartKernel) -> None:
    kernel = start_kernel()
    stubs = kernel.stubs()
    watch = stubs.kernel.WatchClock(kernel_pb2.WatchClockRequest())
    next(watch)
    stubs.kernel.Shutdown(kernel_pb2.ShutdownRequest())
    assert refusal(lambda: [None for _ in watch]).code is grpc.StatusCode.UNAVAILABLE
    assert kernel.process.wait(30) == 0


def test_a_message_over_the_limit_is_refused_and_hurts_nobody(kernel: KernelProcess) -> None:
    stubs = kernel.stubs()
    limit = stubs.kernel.GetInfo(INFO).max_message_bytes
    large = robot_pb2.GetRobotRequest(name="x" * (limit + 1))
    with pytest.raises(grpc.RpcError) as refused:
        stubs.robot.GetRobot(large)
    assert refused.value.code() is grpc.StatusCode.RESOURCE_EXHAUSTED  # pyright: ignore[reportAttributeAccessIssue]
    assert str(limit) in str(refused.value.details())  # pyright: ignore[reportAttributeAccessIssue]
    assert stubs.kernel.GetInfo(INFO).process_id == kernel.process.pid


@pytest.mark.long
def test_a_child_kernel_ends_when_its_parent_is_killed() -> None:
    """The parent here is a Python process that starts a kernel as `virtualrobot demo` does, and is killed."""
    program = (
        "import sys, time\n"
        "from virtualrobot.kernel_process import KernelProcess\n"
        "kernel = KernelProcess('--no-token', headless=True)\n"
        "print(kernel.address, flush=True)\n"
        "time.sleep(600)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert parent.stdout
    address = parent.stdout.readline().strip()
    with grpc.insecure_channel(address) as channel:
        watch = kernel_pb2_grpc.KernelServiceStub(channel).WatchClock(kernel_pb2.WatchClockRequest())
        next(watch)
        parent.kill()
        parent.wait(30)
        parent.stdout.close()
        refused = refusal(lambda: [None for _ in watch])
    assert (refused.code, refused.reason) == (grpc.StatusCode.UNAVAILABLE, "SHUTTING_DOWN")
