"""WatchCollisions and what the monitor stops, over TCP: tick by tick, in real time, with leases, by slow readers."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import pytest
from google.protobuf.field_mask_pb2 import FieldMask
from virtualrobot.v1 import collision_pb2, geometry_pb2, motion_pb2, nodes_pb2, scene_pb2

from tests.api.asking import IIWA, apply, box, create, ended, joints, load, start
from tests.api.leasing import Holder, free
from tests.api.moving import ABORTED, SUCCEEDED, motion
from tests.api.reading import step
from tests.kernels import EMPTY_SCENE, KernelProcess, Stubs

MODES = {name: getattr(collision_pb2, f"COLLISION_MODE_{name.upper()}") for name in ("off", "monitor", "stop", "guard")}
COLLISION = motion_pb2.END_CAUSE_COLLISION
LEANING = {"lbr_iiwa_joint_2": 0.75}
"""Here link 6 is in the box; on the way to FAR the arm does not brake yet."""
FAR = {"lbr_iiwa_joint_2": 1.9}
UPRIGHT = {"lbr_iiwa_joint_2": 0.0}
SECONDS = 60.0


class Watch:
    """What the monitor tells, message by message; `messages` are those so far."""

    def __init__(self, stubs: Stubs) -> None:
        """Begin, and read the first message."""
        self.call: Any = stubs.collision.WatchCollisions(collision_pb2.WatchCollisionsRequest(), timeout=SECONDS)
        self.messages: list[collision_pb2.WatchCollisionsResponse] = [next(self.call)]

    @property
    def first(self) -> collision_pb2.WatchCollisionsResponse:
        """The first message."""
        return self.messages[0]

    def until(self, count: int) -> list[tuple[int, str]]:
        """Read until there were so many events, and return them as (tick, words)."""
        while len(self.told) < count:
            self.messages.append(next(self.call))
        return self.told

    @property
    def told(self) -> list[tuple[int, str]]:
        """All events so far as (tick, words)."""
        return [(event.tick, words(event)) for message in self.messages for event in message.events]

    def close(self) -> None:
        """End."""
        self.call.cancel()


def words(event: collision_pb2.CollisionEvent) -> str:
    """Return an event in words."""
    kind = event.WhichOneof("what")
    if kind == "begun":
        pair = event.begun.pair
        return f"{pair.first}/{pair.second} {'tolerated' if event.begun.tolerated else 'begun'}"
    if kind == "ended":
        return f"{event.ended.first}/{event.ended.second} {'apart' if event.ended.apart else 'unwatched'}"
    if kind == "stopped":
        return f"stopped {' '.join(event.stopped.robots)}"
    return event.fault


def mode(stubs: Stubs, name: str = "", **robots: str) -> None:
    """Set modes, without looking ahead."""
    own = [collision_pb2.RobotCollisionMode(robot=robot, mode=MODES[one]) for robot, one in robots.items()]
    settings = collision_pb2.SetCollisionSettings(mode=MODES.get(name), robots=own, look_ahead_seconds=0.0)
    apply(stubs, scene_pb2.Command(set_collision_settings=settings))


def update(name: str, field: str, node: nodes_pb2.Node) -> scene_pb2.Command:
    """Return the command that changes a field of a node."""
    return scene_pb2.Command(
        update_node=scene_pb2.UpdateNode(name=name, node=node, update_mask=FieldMask(paths=[field]))
    )


def put(stubs: Stubs, **joint_positions: float) -> None:
    jump = scene_pb2.SetJointPositions(robot="arm", joint_positions=joint_positions)
    apply(stubs, scene_pb2.Command(set_joint_positions=jump))


def place(x: float = 0.0, y: float = 0.0) -> geometry_pb2.Pose:
    return geometry_pb2.Pose(position=geometry_pb2.Vector3(x=x, y=y))


def names(pairs: Sequence[collision_pb2.ReportedCollision]) -> set[tuple[str, str]]:
    return {(one.pair.first, one.pair.second) for one in pairs}


def arm_and_box(stubs: Stubs) -> None:
    """An arm, and a box where its sixth link gets when it leans forward."""
    load(stubs, IIWA, "arm")
    apply(stubs, create(box("box", x=0.5, z=0.9)))


@pytest.fixture
def watching() -> Iterator[Callable[[Stubs], Watch]]:
    """Return what begins a watch that ends with the test."""
    begun: list[Watch] = []

    def begin(stubs: Stubs) -> Watch:
        begun.append(Watch(stubs))
        return begun[-1]

    yield begin
    for watch in begun:
        watch.close()


Watching = Callable[[Stubs], Watch]


def test_a_touch_is_told_in_its_tick_and_stops_the_arm(stepped: Stubs, watching: Watching) -> None:
    """The tick is the first in which CheckCollision, asked of each, finds the same pair."""
    arm_and_box(stepped)
    mode(stepped, "stop")
    watch = watching(stepped)
    assert not watch.first.touching and not watch.first.events and watch.first.fault == ""
    id = start(stepped, joints("arm", 0.2, **FAR)).id
    check = collision_pb2.CheckCollisionRequest()
    began = stepped.collision.CheckCollision(check).stamp.tick
    while not (found := stepped.collision.CheckCollision(check)).pairs:
        assert step(stepped).stamp.tick < began + 2000
    tick, pair = found.stamp.tick, found.pairs[0]
    told = watch.until(2)
    assert told == [(tick, f"{pair.first}/{pair.second} begun"), (tick, "stopped arm")]
    step(stepped, 500)
    stopped = motion(stepped, id)
    assert stopped.phase == ABORTED
    assert stopped.end_cause == COLLISION
    assert stopped.end_reason == f"{pair.first!r} touches {pair.second!r}"
    begun = watch.messages[1].events[0].begun
    assert begun.pair.contacts
    assert begun.simulation_time_seconds == pytest.approx(tick * 0.004)
    last = watch.messages[-1]
    assert names(last.touching) == {(pair.first, pair.second)}
    assert not last.touching[0].pair.contacts
    assert last.checks > 1 and last.check_seconds > 0.0
    again = watching(stepped)
    assert again.first.touching[0].pair.contacts and not again.first.events


def test_scenes_come_and_go_under_a_watch(stepped: Stubs, watching: Watching) -> None:
    arm_and_box(stepped)
    put(stepped, **LEANING)
    mode(stepped, "monitor")
    text = stepped.scene.SaveScene(scene_pb2.SaveSceneRequest()).text
    watch = watching(stepped)
    there = names(watch.first.touching)
    assert there
    apply(stepped, scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="box")))
    stepped.scene.LoadScene(scene_pb2.LoadSceneRequest(text=text))
    stepped.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
    count = len(there)
    told = [what.split()[1] for _, what in watch.until(3 * count)]
    assert told == ["unwatched"] * count + ["tolerated"] * count + ["unwatched"] * count
    assert not watch.messages[-1].touching
    stepped.scene.LoadScene(scene_pb2.LoadSceneRequest(text=text))
    watch.until(4 * count)
    assert names(watch.messages[-1].touching) == there


def test_the_monitor_stops_leased_robots(stepped: Stubs, stepped_kernel: KernelProcess, watching: Watching) -> None:
    arm_and_box(stepped)
    mode(stepped, "stop")
    holder = Holder(stepped_kernel, "arm")
    try:
        watch = watching(stepped)
        id = holder.start(joints("arm", 0.2, **FAR))
        step(stepped, 1000)
        assert watch.until(2)[1][1] == "stopped arm"
        assert motion(stepped, id).end_cause == COLLISION
    finally:
        holder.vanish()
        free(stepped)


def at_rest(stubs: Stubs, watching: Watching) -> None:
    """Return once nothing is checked any more for a while, as it is at rest, however long."""
    waiting, checks = threading.Event(), [-1, 0]
    for _ in range(300):
        if checks[-1] == checks[-2]:
            return
        waiting.wait(0.2)
        checks.append(watching(stubs).first.checks)
    raise AssertionError(f"it goes on checking: {checks}")


def test_in_real_time_an_arm_stops_too(stubs: Stubs, watching: Watching) -> None:
    arm_and_box(stubs)
    mode(stubs, "stop")
    watch = watching(stubs)
    stopped = ended(stubs, start(stubs, joints("arm", 0.2, **FAR)).id)
    assert (stopped.phase, stopped.end_cause) == (ABORTED, COLLISION)
    while "stopped arm" not in [what for _, what in watch.told]:
        watch.until(len(watch.told) + 1)
    assert watch.told[0][1].endswith("begun")
    assert [tick for tick, _ in watch.told] == sorted(tick for tick, _ in watch.told)
    at_rest(stubs, watching)  # else what it begins to touch while it brakes might stop the next motion
    assert ended(stubs, start(stubs, joints("arm", **UPRIGHT)).id).phase == SUCCEEDED
    while watch.messages[-1].touching:
        watch.until(len(watch.told) + 1)
    at_rest(stubs, watching)


@pytest.mark.long
def test_who_never_reads_gets_the_latest_and_what_was_missed(
    stepped: Stubs, stepped_kernel: KernelProcess, watching: Watching
) -> None:
    """20 boxes jump in and out of a ball, 2,400 events: others are told all, who slept the last and how many not."""
    ball = nodes_pb2.Node(
        name="ball", robot=nodes_pb2.Robot(), figures=[nodes_pb2.Figure(sphere=nodes_pb2.Sphere(radius_meters=0.1))]
    )
    boxes = [f"box-{i}" for i in range(20)]
    apply(stepped, create(ball), *(create(box(name, x=3.0)) for name in boxes))
    mode(stepped, "monitor")
    # Without probing a stream holds 64 KiB for one who does not read.
    sleeper = watching(Stubs(stepped_kernel.channel([("grpc.http2.bdp_probe", 0)])))
    reader = watching(stepped)
    count = 0
    for i in range(120):
        moved = nodes_pb2.Node(parent_t_node=place(x=3.0 * (i % 2)))
        apply(stepped, *(update(name, "parent_t_node", moved) for name in boxes))
        count += len(boxes)
        reader.until(count)
    last = reader.messages[-1].events[-1].number
    while sleeper.messages[-1].events[-1:] == [] or sleeper.messages[-1].events[-1].number < last:
        sleeper.messages.append(next(sleeper.call))
    missed = sum(message.missed_events for message in sleeper.messages)
    assert len(reader.told) == count
    assert missed > 0
    assert len(sleeper.told) + missed == count
    numbers = [event.number for message in sleeper.messages for event in message.events]
    assert numbers == sorted(set(numbers))
    assert not sleeper.messages[-1].touching
