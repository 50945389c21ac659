"""Watch of streams: each watch of the contract that is needed is read by a thread, and tells samples in order."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from virtualrobot._wire import interruptions
from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import array_of
from virtualrobot._wire.services import Services
from virtualrobot._wire.transport import Stream as Call
from virtualrobot.errors import CallTimeoutError, UnknownNameError
from virtualrobot.recording import topics
from virtualrobot.recording.frames import Frames
from virtualrobot.recording.joints import Robots
from virtualrobot.streams import sample as samples
from virtualrobot.streams.sample import Sample, sampled
from virtualrobot.streams.table import MOTIONS_HERTZ, Stream, base_joint
from virtualrobot.v1 import (
    collision_pb2,
    motion_pb2,
    robot_pb2,
    scene_pb2,
    sensor_pb2,
    signal_pb2,
)

AT_ONCE_HERTZ = 1e6
"""Rate of messages at which a watch tells ticks at once; those that come meanwhile come together."""

MOST_WAITING = 10_000
"""So many samples wait in this program; while they do, what comes waits at the kernel."""

_WAIT_SECONDS = 0.2
"""Waited for in small steps: Ctrl-C would not get through on Windows."""

_BEGIN_SECONDS = 30.0
"""Longest time (s) until all watches have begun."""


@checked
class StreamWatch:
    """Samples of streams as they come, every tick and every reading, until it is closed. `Streams.watch` makes it.

    What is lost, since this program was too slow, each sample counts. Sensors read while they are watched.
    """

    def __init__(
        self,
        services: Services,
        streams: Sequence[Stream],
        *,
        take: Callable[[Sample], None] | None = None,
        wanted: Callable[[str], bool] = lambda name: True,
    ) -> None:
        """Begin to watch; when this returns, nothing that happens later is left out.

        Args:
            services: of the kernel.
            streams: what is watched.
            take: gets each sample in the thread that reads it, in place of those who ask for the next one. So a
                sample is not handed from thread to thread; what ends a watch is raised by `next` all the same.
            wanted: tells of a stream whether samples of it are made now.
        """
        self.streams = tuple(streams)
        self._take, self._wanted = take, wanted
        self._services = services
        self._robots = Robots(services)
        self._waiting: queue.Queue[Sample | BaseException] = queue.Queue(MOST_WAITING)
        self._closed = threading.Event()
        by_watch: dict[str, list[Stream]] = {}
        for one in streams:
            if one.watch:
                by_watch.setdefault(one.watch, []).append(one)
        begins: dict[str, Callable[[list[Stream]], Callable[[threading.Event], None]]] = {
            "robots": self._of_robots,
            "scene": self._of_nodes,
            "signals": self._of_signals,
            "readings": self._of_readings,
            "motions": self._of_motions,
            "collisions": self._of_collisions,
        }
        self._calls: list[Call[Any]] = []
        self._begun = {name: threading.Event() for name in by_watch}
        try:
            readers = {name: begins[name](list(of)) for name, of in by_watch.items()}
            for name, read in readers.items():
                threading.Thread(
                    target=self._run, args=(read, self._begun[name]), name=f"streams {name}", daemon=True
                ).start()
            self._await()
        except BaseException:
            self.close()  # sensors would go on reading for a watch that nobody has
            raise

    def _await(self) -> None:
        """Wait until all watches have begun."""
        due = time.monotonic() + _BEGIN_SECONDS
        for begun in self._begun.values():
            while not begun.wait(_WAIT_SECONDS):
                interruptions.check()
                if time.monotonic() > due:
                    raise CallTimeoutError(f"the kernel has not begun to tell after {_BEGIN_SECONDS:g} s")

    def __iter__(self) -> Iterator[Sample]:
        """Yield samples as they come; raises what ends a watch, such as a kernel that has gone."""
        while not self._closed.is_set():
            if (one := self.next(_WAIT_SECONDS)) is not None:
                yield one
            interruptions.check()

    def next(self, timeout: float) -> Sample | None:
        """Return the next sample; None where none has come after `timeout` seconds of the wall clock."""
        try:
            one = self._waiting.get(timeout=timeout)
        except queue.Empty:
            return None
        if isinstance(one, BaseException):
            raise one
        return one

    def close(self) -> None:
        """End it; any thread may."""
        self._closed.set()
        for call in self._calls:
            call.cancel()

    def __enter__(self) -> StreamWatch:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()

    def _run(self, read: Callable[[threading.Event], None], begun: threading.Event) -> None:
        try:
            read(begun)
        except Exception as error:
            if not self._closed.is_set():
                self._put(error)
        begun.set()

    def _put(self, one: Sample | BaseException) -> None:
        if self._take is not None and isinstance(one, Sample):
            return self._take(one)
        while not self._closed.is_set():
            try:
                return self._waiting.put(one, timeout=_WAIT_SECONDS)
            except queue.Full:
                continue

    def _opened(self, call: Call[Any]) -> Call[Any]:
        self._calls.append(call)
        return call

    def _of_robots(self, streams: list[Stream]) -> Callable[[threading.Event], None]:
        names = list(dict.fromkeys(one.about for one in streams if one.about))
        mask = None if names else {"paths": ["name"]}
        call = self._opened(
            self._services.robot.WatchRobotStates(
                robot_pb2.WatchRobotStatesRequest(
                    names=names, every_tick=True, max_rate_hertz=AT_ONCE_HERTZ, read_mask=mask
                )
            )
        )
        states: dict[str, robot_pb2.RobotState] = {}
        bases = {one.about: self._base(one.about) for one in streams if one.content == "base"}

        def told(one: Stream, tick: robot_pb2.WatchRobotStatesResponse) -> dict[str, Any] | None:
            if one.content == "clock":
                return samples.of_stamp(tick.stamp)
            if (state := states.get(one.about)) is None:
                return None
            if one.content == "tcp":
                return samples.of_pose(state.world_t_tcp)
            if one.content == "base":
                return samples.of_base(state, *bases[one.about])
            known = self._robots.coordinates(state, tick.stamp)
            return samples.of_joints(state, known, one.content == "commanded") if known else None

        def read(begun: threading.Event) -> None:
            before = -1
            for message in call:
                for tick in message.ticks:
                    for name in tick.removed_names:
                        states.pop(name, None)
                    states.update(changed := {state.name: state for state in tick.robots})
                    # Of a change between two ticks only what has changed is told again.
                    again, before = tick.stamp.tick == before, tick.stamp.tick
                    for one in streams:
                        is_due = (one.about in changed or not again) and self._wanted(one.name)
                        if is_due and (values := told(one, tick)) is not None:
                            state = states.get(one.about)
                            told_by = tick.stamp if state is None else state
                            self._put(sampled(one.name, tick.stamp, values, told_by, tick.lost_ticks, state))
                begun.set()

        return read

    def _base(self, name: str) -> tuple[list[robot_pb2.JointDescription], str]:
        joints = list(self._services.robot.GetRobot(robot_pb2.GetRobotRequest(name=name)).joints)
        node = self._services.scene.GetScene(scene_pb2.GetSceneRequest(names=[name])).nodes[0]
        joint = base_joint(node, joints)
        if joint is None:
            raise UnknownNameError(f"the robot {name!r} has no base that moves")
        return joints, joint.name

    def _of_nodes(self, streams: list[Stream]) -> Callable[[threading.Event], None]:
        names = [one.about for one in streams if one.about]
        told = {one.name for one in streams if not one.about}
        call = self._opened(
            self._services.scene.WatchScene(
                scene_pb2.WatchSceneRequest(
                    names=[] if told else names,
                    every_tick=True,
                    max_rate_hertz=AT_ONCE_HERTZ,
                    read_mask={"paths": ["uid", "name", *(("parent", "link") if told else ())]},
                )
            )
        )
        stream_of = {one.about: one.name for one in streams if one.about}
        frames = Frames(joints=True)
        places: dict[int, np.ndarray] = {}
        name_of: dict[int, str] = {}

        def put(stream: str, tick: scene_pb2.WatchSceneResponse, values: dict[str, Any], size: int) -> None:
            self._put(sampled(stream, tick.stamp, values, size, tick.lost_ticks))

        def poses(tick: scene_pb2.WatchSceneResponse, again: bool) -> None:
            name_of.update({node.uid: node.name for node in tick.nodes})
            for uid in tick.removed_uids:
                places.pop(uid, None)
            moved = set(tick.moved_uids)
            if moved:
                places.update(zip(tick.moved_uids, array_of(tick.world_t_node), strict=True))
            for uid, row in places.items():
                stream = stream_of.get(name_of[uid]) if uid in moved or not again else None
                if stream is not None and self._wanted(stream):
                    put(stream, tick, samples.of_row(row), row.nbytes)

        def transforms(tick: scene_pb2.WatchSceneResponse, again: bool) -> None:
            changed = frames.update(tick)
            for group in frames.groups.values():
                each_tick = group.topic == topics.TRANSFORMS and not again and group.rows
                if group.topic in told and (group in changed or each_tick) and self._wanted(group.topic):
                    rows = frames.poses(group)
                    put(group.topic, tick, samples.of_frames(group, rows), rows.nbytes)

        def read(begun: threading.Event) -> None:
            before = -1
            for message in call:
                for tick in message.ticks:
                    again, before = tick.stamp.tick == before, tick.stamp.tick
                    if stream_of:
                        poses(tick, again)
                    if told:
                        transforms(tick, again)
                begun.set()

        return read

    def _of_signals(self, streams: list[Stream]) -> Callable[[threading.Event], None]:
        stream_of = {one.about: one.name for one in streams}
        call = self._opened(self._services.signal.WatchSignals(signal_pb2.WatchSignalsRequest(names=list(stream_of))))

        def read(begun: threading.Event) -> None:
            for message in call:
                for signal in message.signals:
                    values = samples.of_signal(signal)
                    self._put(sampled(stream_of[signal.name], message.stamp, values, signal))
                begun.set()

        return read

    def _of_readings(self, streams: list[Stream]) -> Callable[[threading.Event], None]:
        of_sensor: dict[str, list[Stream]] = {}
        for one in streams:
            of_sensor.setdefault(one.about, []).append(one)
        call = self._opened(
            self._services.sensor.WatchReadings(
                sensor_pb2.WatchReadingsRequest(
                    sensors=list(of_sensor),
                    every_reading=True,
                    run=True,
                    options=sensor_pb2.ReadingOptions(points=any(one.content == "points" for one in streams)),
                )
            )
        )

        def read(begun: threading.Event) -> None:
            for message in call:
                for reading in message.readings if begun.is_set() else ():
                    for one in of_sensor[reading.sensor]:
                        values = samples.of_reading(reading, one.content) if self._wanted(one.name) else None
                        if values is not None:
                            self._put(sampled(one.name, reading.stamp, values, reading, reading.lost, reading))
                begun.set()

        return read

    def _of_motions(self, streams: list[Stream]) -> Callable[[threading.Event], None]:
        request = motion_pb2.WatchMotionsRequest(max_rate_hertz=MOTIONS_HERTZ)
        call = self._opened(self._services.motion.WatchMotions(request))

        def read(begun: threading.Event) -> None:
            told: dict[str, motion_pb2.Motion] = {}
            for answer in call:
                for motion in answer.motions:
                    if told.get(motion.id) != motion:
                        values = {
                            "id": motion.id,
                            "phase": motion_pb2.MotionPhase.Name(motion.phase).removeprefix("MOTION_PHASE_"),
                            "progress": motion.progress,
                        }
                        for one in streams:
                            self._put(sampled(one.name, answer.stamp, values, motion))
                told = {motion.id: motion for motion in answer.motions}
                begun.set()

        return read

    def _of_collisions(self, streams: list[Stream]) -> Callable[[threading.Event], None]:
        call = self._opened(self._services.collision.WatchCollisions(collision_pb2.WatchCollisionsRequest()))

        def read(begun: threading.Event) -> None:
            for message in call:
                for event in message.events:
                    for one in streams:
                        self._put(
                            sampled(one.name, message.stamp, samples.of_event(event), event, message.missed_events)
                        )
                begun.set()

        return read
