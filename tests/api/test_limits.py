"""Limits of a kernel: what is over one is refused by its name, and changes nothing; clients don't share theirs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import grpc
import pytest
import virtualrobot
from virtualrobot.v1 import kernel_pb2, motion_pb2, nodes_pb2, robot_pb2, scene_pb2

from tests.api.asking import Refusal, apply, box, create, load, refusal
from tests.kernels import EMPTY_SCENE, KernelProcess, StartKernel, Stubs

LIMITS = {
    "nodes": 10,
    "triangles": 5,
    "message_bytes": 65536,
    "asset_bytes": 2000,
    "assets_bytes": 3000,
    "connections": 50,
    "streams": 3,
    "calls_per_second": 10_000,
}


@pytest.fixture(scope="module")
def small(start_kernel: StartKernel) -> KernelProcess:
    return start_kernel(*(word for name, value in LIMITS.items() for word in ("--limit", f"{name}={value}")))


@pytest.fixture
def stubs(small: KernelProcess) -> Stubs:
    stubs = small.stubs()
    stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
    return stubs


def over(call: Callable[[], object], name: str, asked: int, reason: str = "TOO_LARGE") -> Refusal:
    """Check that a call is refused for being over a limit."""
    refused = refusal(call)
    assert (refused.code, refused.reason) == (grpc.StatusCode.RESOURCE_EXHAUSTED, reason)
    said = {key: refused.metadata[key] for key in ("limit_name", "limit", "asked")}
    assert said == {"limit_name": name, "limit": str(LIMITS[name]), "asked": str(asked)}
    assert refused.message.endswith(f"the limit {name!r} of this kernel")
    return refused


def strip(file: Path, triangles: int) -> str:
    """Write a mesh of so many triangles and return its name."""
    corners = "".join(f"v {x} 0 0\nv {x} 1 0\n" for x in range(triangles + 2))
    file.write_text(f"# {file.name}\n" + corners + "".join(f"f {n} {n + 1} {n + 2}\n" for n in range(1, triangles + 1)))
    return str(file)


def test_the_kernel_tells_its_limits(stubs: Stubs) -> None:
    info = stubs.kernel.GetInfo(kernel_pb2.GetInfoRequest())
    assert {limit.name: limit.value for limit in info.limits} == LIMITS
    assert all(limit.description for limit in info.limits)
    assert (info.max_message_bytes, info.max_asset_bytes) == (65536, 2000)


def test_nodes(stubs: Stubs) -> None:
    apply(stubs, *(create(box(f"box {n}")) for n in range(9)))  # and the world itself
    over(lambda: apply(stubs, create(box("one more"))), "nodes", 11)
    nodes = "".join(f"- {{name: n{number}, object: {{}}}}\n" for number in range(10))
    scene = scene_pb2.LoadSceneRequest(text=f"schema_version: 1\nnodes:\n{nodes}")
    over(lambda: stubs.scene.LoadScene(scene), "nodes", 11)
    assert len(stubs.scene.GetScene(scene_pb2.GetSceneRequest()).nodes) == 10
    apply(stubs, scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="box 0")))
    apply(stubs, create(box("one more")))


def test_triangles(stubs: Stubs, tmp_path: Path) -> None:
    three = strip(tmp_path / "three.obj", 3)
    load(stubs, three, "first")
    load(stubs, three, "second")  # is the same mesh
    over(lambda: load(stubs, strip(tmp_path / "more.obj", 4)), "triangles", 7)
    mesh = nodes_pb2.Figure(mesh=nodes_pb2.Mesh(uri=strip(tmp_path / "other.obj", 3), scale=None))
    plate = nodes_pb2.Node(name="plate", object=nodes_pb2.SceneObject(), figures=[mesh])
    over(lambda: apply(stubs, create(plate)), "triangles", 6)
    load(stubs, strip(tmp_path / "two.obj", 2))


def test_bytes_of_a_message(stubs: Stubs) -> None:
    """One that is much larger is not read at all, and refused in the words of gRPC."""
    request = robot_pb2.GetRobotRequest(name="x" * 70_000)
    over(lambda: stubs.robot.GetRobot(request), "message_bytes", len(request.SerializeToString()))
    with pytest.raises(grpc.RpcError) as refused:
        stubs.robot.GetRobot(robot_pb2.GetRobotRequest(name="x" * 140_000))
    assert refused.value.code() is grpc.StatusCode.RESOURCE_EXHAUSTED  # pyright: ignore[reportAttributeAccessIssue]


def test_the_client_names_the_limit_of_messages_that_grpc_does_not_let_through(small: KernelProcess) -> None:
    request = scene_pb2.ApplyRequest(request_id="x" * 3 * LIMITS["message_bytes"])
    with virtualrobot.connect(small.address) as client, pytest.raises(virtualrobot.TooLargeError) as refused:
        client.services.scene.Apply(request)
    asked = len(request.SerializeToString())
    assert refused.value.metadata == {"limit_name": "message_bytes", "asked": str(asked)}
    assert f"a message of {asked} bytes is over the limit 'message_bytes' of this kernel" in str(refused.value)


def test_bytes_of_a_file(stubs: Stubs, tmp_path: Path) -> None:
    file = tmp_path / "large.obj"
    file.write_text("#" * 2001)
    refused = refusal(lambda: load(stubs, str(file)))
    assert refused.reason == "TOO_LARGE" and refused.metadata["limit_bytes"] == "2000"


def test_streams_of_each_client(small: KernelProcess, stubs: Stubs) -> None:
    def watch(who: Stubs) -> grpc.Future:
        stream = who.kernel.WatchClock(kernel_pb2.WatchClockRequest())
        next(stream)
        return stream

    first, *_ = (watch(stubs) for _ in range(3))
    over(lambda: watch(stubs), "streams", 4, "TOO_MANY_CALLS")
    stubs.motion.Stop(motion_pb2.StopRequest())
    with small.channel(options=[("grpc.use_local_subchannel_pool", 1)]) as channel:
        watch(Stubs(channel))
    first.cancel()
    for _ in range(1000):  # until the kernel has heard of it
        try:
            watch(stubs)
            break
        except grpc.RpcError:
            stubs.kernel.GetInfo(kernel_pb2.GetInfoRequest())
    else:
        raise AssertionError("a stream that was cancelled counts for good")
