"""WatchScene: all first, then differences; slow readers, many readers, readers that die."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterable

import numpy as np
import pytest
from google.protobuf.field_mask_pb2 import FieldMask
from virtualrobot.v1 import kernel_pb2, nodes_pb2, scene_pb2

from tests.api.asking import IIWA, apply, box, create, joints, load, refusal, start
from tests.api.reading import matrices, pose, random_matrix, scene, step
from tests.api.test_scene import attach, remove, update
from tests.kernels import KernelProcess, Stubs

WATCH = scene_pb2.WatchSceneRequest

SMALL_WINDOW = [("grpc.http2.bdp_probe", 0), ("grpc.http2.lookahead_bytes", 4096)]
"""How the client library opens its channels: what a reader leaves unread fills no more than this window (HTTP/2)."""


class Mirror:
    """What a client knows of the scene that only listens."""

    def __init__(self) -> None:
        """Know nothing."""
        self.nodes: dict[int, nodes_pb2.Node] = {}
        self.world_t_node: dict[int, np.ndarray] = {}
        self.revision = 0

    def hear(self, message: scene_pb2.WatchSceneResponse) -> None:
        for uid in message.removed_uids:
            del self.nodes[uid], self.world_t_node[uid]
        for node in message.nodes:
            self.nodes[node.uid] = node
        self.world_t_node |= dict(zip(message.moved_uids, matrices(message.world_t_node), strict=True))
        self.revision = message.stamp.state_revision

    def hear_until(self, messages: Iterable[scene_pb2.WatchSceneResponse], revision: int) -> None:
        for message in messages:
            self.hear(message)
            if message.stamp.state_revision >= revision:
                return


def assert_equal_to_the_scene(mirror: Mirror, stubs: Stubs) -> None:
    """Compare with GetScene; where nodes are, a listener learns in the world's frame only."""
    answer = stubs.scene.GetScene(scene_pb2.GetSceneRequest())
    assert set(mirror.nodes) == set(mirror.world_t_node) == {node.uid for node in answer.nodes}
    for node, frame in zip(answer.nodes, matrices(answer.world_t_node), strict=True):
        heard = nodes_pb2.Node()
        heard.CopyFrom(mirror.nodes[node.uid])
        for message in (heard, node):
            message.ClearField("parent_t_node")
        assert heard == node
        assert np.array_equal(mirror.world_t_node[node.uid], frame)


def test_the_scene_first_then_only_what_changes(stepped: Stubs) -> None:
    created = apply(stepped, create(box("a")), create(box("b", parent="a")), create(box("c"))).created
    a, b, c = (node.uid for node in created)
    watch = stepped.scene.WatchScene(WATCH(max_rate_hertz=250))
    first = next(watch)
    assert [node.name for node in first.nodes] == ["world", "a", "b", "c"]
    assert list(first.moved_uids) == [node.uid for node in first.nodes]
    apply(stepped, update("a", "parent_t_node", parent_t_node=pose(np.diag([1.0, -1.0, -1.0, 1.0]))))
    moved = next(watch)
    assert (list(moved.nodes), set(moved.moved_uids), list(moved.removed_uids)) == ([], {a, b}, [])
    apply(stepped, update("c", "hidden", hidden=True))
    changed = next(watch)
    assert ([node.uid for node in changed.nodes], list(changed.moved_uids)) == ([c], [])
    apply(stepped, remove("a"), create(box("d")))
    last = next(watch)
    assert (set(last.removed_uids), [node.name for node in last.nodes]) == ({a, b}, ["d"])
    assert set(last.moved_uids) == {last.nodes[0].uid}
    watch.cancel()


def test_a_listener_knows_what_a_reader_reads(stepped: Stubs, rng: np.random.Generator) -> None:
    """Random changes, heard or skipped: what adds up from differences is what GetScene tells."""
    load(stepped, IIWA, "arm")
    apply(stepped, create(box("beacon")))
    watch = stepped.scene.WatchScene(WATCH(max_rate_hertz=250))
    mirror = Mirror()
    names: list[str] = []

    def listen() -> None:
        # What was created and removed unheard is no difference, and tells nothing: the beacon's move always does.
        moved = apply(stepped, update("beacon", "parent_t_node", parent_t_node=pose(random_matrix(rng))))
        mirror.hear_until(watch, moved.stamp.state_revision)

    for place in range(60):
        kind = rng.integers(6) if names else 0
        name = str(rng.choice(names)) if names else ""
        others = [other for other in names if other != name] + ["world", "arm.lbr_iiwa_link_7", "arm"]
        if kind <= 1:
            command = create(box(f"n{place}", x=rng.uniform(), parent=str(rng.choice(others))))
            names.append(f"n{place}")
        elif kind == 2:
            command = update(name, "parent_t_node", parent_t_node=pose(random_matrix(rng)))
        elif kind == 3:
            command = update(name, "name", name=f"m{place}")
            names[names.index(name)] = f"m{place}"
        elif kind == 4:
            below = "" if rng.random() < 0.5 else "arm.lbr_iiwa_link_5"
            command = attach(name, below)
        else:
            command = remove(name)
        apply(stepped, command)
        left = scene(stepped)
        names = [name for name in names if name in left]
        if rng.random() < 0.5:
            listen()
    apply(stepped, update("arm", "name", name="kuka"))
    rotation = nodes_pb2.Joint(name="extra", type=nodes_pb2.JOINT_TYPE_REVOLUTE)
    extra = nodes_pb2.Node(name="kuka.extra", parent="kuka.lbr_iiwa_link_7", link=nodes_pb2.Link(joint=rotation))
    apply(stepped, create(extra))
    listen()
    assert_equal_to_the_scene(mirror, stepped)
    watch.cancel()


def test_names_and_mask_choose_what_is_told(stepped: Stubs) -> None:
    created = apply(stepped, create(box("a")), create(box("b"))).created
    request = WATCH(names=["b"], read_mask=FieldMask(paths=["name"]), max_rate_hertz=250)
    watch = stepped.scene.WatchScene(request)
    first = next(watch)
    assert [(node.name, node.uid) for node in first.nodes] == [("b", 0)]
    apply(stepped, create(box("c")), remove("a"))
    apply(stepped, update("b", "name", name="d"))
    second = next(watch)
    assert ([node.name for node in second.nodes], list(second.moved_uids)) == (["d"], [])
    apply(stepped, remove("d"))
    assert list(next(watch).removed_uids) == [created[1].uid]
    watch.cancel()
    for bad in (WATCH(names=["nobody"]), WATCH(read_mask=FieldMask(paths=["nothing"]))):
        assert refusal(lambda bad=bad: next(stepped.scene.WatchScene(bad))).reason == "UNKNOWN_NAME"


def carried(stubs: Stubs, count: int) -> None:
    """Load an arm that carries many boxes, and let it move for more than a minute."""
    load(stubs, IIWA, "arm")
    apply(stubs, *(create(box(f"b{i}", parent="arm.lbr_iiwa_link_7")) for i in range(count)))
    start(stubs, joints("arm", lbr_iiwa_joint_1=2.0, lbr_iiwa_joint_2=1.0, speed_factor=0.003))


@pytest.mark.long
def test_a_slow_reader_skips_states_and_ends_with_the_last_one(stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    carried(stepped, 300)
    slow = Stubs(stepped_kernel.channel(SMALL_WINDOW))
    watch = slow.scene.WatchScene(WATCH(max_rate_hertz=250))
    mirror = Mirror()
    mirror.hear(next(watch))
    for _ in range(500):
        last = step(stepped)
        time.sleep(0.005)  # lets 250 messages a second happen; nothing is measured
    messages = 0
    while mirror.revision < last.stamp.state_revision:
        mirror.hear(next(watch))
        messages += 1
    assert messages < 20, "what was not read has not piled up"
    assert_equal_to_the_scene(mirror, stepped)
    slow.channel.close()


def test_no_more_messages_than_asked_for(stubs: Stubs) -> None:
    carried(stubs, 1)
    watch = stubs.scene.WatchScene(WATCH(max_rate_hertz=20))
    times = [next(watch).stamp.wall_time.ToNanoseconds() for _ in range(21)]
    # Told times are those of states, and the last one may be old already; a rate is an upper bound on average.
    assert (times[-1] - times[0]) / 1e9 > 0.75 * (len(times) - 1) / 20.0
    watch.cancel()


def test_twenty_watchers_leave_the_kernel_free_to_answer(stubs: Stubs, kernel: KernelProcess) -> None:
    carried(stubs, 20)
    channels = [kernel.stubs() for _ in range(5)]
    watches = [channels[i % 5].scene.WatchScene(WATCH(max_rate_hertz=60)) for i in range(20)]
    for watch in watches:
        next(watch)
    for _ in range(20):
        assert stubs.kernel.GetInfo(kernel_pb2.GetInfoRequest(), timeout=10).process_id
    for watch in watches:
        assert next(watch).moved_uids
        watch.cancel()
    for channel in channels:
        channel.channel.close()


WATCHER = """
import grpc
import sys
from virtualrobot.v1 import scene_pb2, scene_pb2_grpc
stub = scene_pb2_grpc.SceneServiceStub(grpc.insecure_channel(sys.argv[1]))
for message in stub.WatchScene(scene_pb2.WatchSceneRequest(max_rate_hertz=100)):
    print(len(message.moved_uids), flush=True)
"""


def test_a_client_that_dies_while_watching_hurts_nobody(stubs: Stubs, kernel: KernelProcess) -> None:
    carried(stubs, 50)
    before = len(kernel.lines)
    for _ in range(3):
        with subprocess.Popen([sys.executable, "-c", WATCHER, kernel.address], stdout=subprocess.PIPE) as client:
            assert client.stdout
            assert client.stdout.readline().strip() == b"60", "world, arm, 8 links and 50 boxes"
            client.stdout.readline()
            client.kill()
    watch = stubs.scene.WatchScene(WATCH(max_rate_hertz=100))
    assert [len(next(watch).moved_uids) > 50 for _ in range(3)] == [True] * 3
    watch.cancel()
    assert not [line for line in kernel.lines[before:] if "Traceback" in line]
