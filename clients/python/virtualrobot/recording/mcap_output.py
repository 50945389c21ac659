"""MCAP files of what a kernel tells, in the schemas that Foxglove and PlotJuggler open."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from typing import Any, BinaryIO

from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.message import Message
from google.protobuf.timestamp_pb2 import Timestamp

from virtualrobot._wire.services import Services
from virtualrobot.collisions.watch import event_of
from virtualrobot.motions.state import Phase
from virtualrobot.recording import topics
from virtualrobot.recording.joints import Coordinate, Robots
from virtualrobot.recording.mcap_file import McapFile
from virtualrobot.recording.readings import Readings
from virtualrobot.recording.scenery import Scenery
from virtualrobot.recording.stamps import nanoseconds, time_of
from virtualrobot.recording.transforms import Transforms
from virtualrobot.v1 import (
    collision_pb2,
    geometry_pb2,
    motion_pb2,
    nodes_pb2,
    robot_pb2,
    scene_pb2,
    sensing_pb2,
    sensor_pb2,
    signal_pb2,
)

_WATCHES = {
    "scene": (topics.TRANSFORMS, topics.SCENE, "/sensors/"),
    "signals": ("/signals/",),
    "readings": ("/sensors/",),
    "motions": (topics.MOTIONS, topics.LOG),
    "collisions": (topics.COLLISIONS, topics.LOG),
}
"""The topics that need a watch, by how they begin."""


class McapOutput:
    """A recording in an MCAP file. Each of its methods takes what a watch of that name tells, in its order.

    Attributes:
        watches: the watches that it wants.
        counts: how many messages each topic has.
    """

    def __init__(
        self,
        stream: BinaryIO,
        services: Services,
        selection: topics.Selection,
        about: Mapping[str, str],
        compressed: bool,
    ) -> None:
        """Begin a file in `stream`, which stays the caller's to close; `compressed` colours of cameras are PNG."""
        self._services, self._selection = services, selection
        self._file = McapFile(stream, about)
        self._lock = threading.Lock()
        self._robots = Robots(services)
        self._tool_states: dict[str, dict[str, str]] = {}
        self._motions: dict[str, motion_pb2.Motion] = {}
        self._readings = Readings(selection, compressed)
        self._presets: dict[str, sensing_pb2.RangeSensor] = {}
        self._transforms = Transforms()
        self._scenery = Scenery(services, self._write_scenery) if selection.may_have(topics.SCENE) else None
        self.counts = self._file.counts
        # Robots in any case: from them it is known what has been missed, and which tools look different.
        self.watches = frozenset({"robots"}) | {
            watch for watch, begins in _WATCHES.items() if any(map(selection.may_have, begins))
        }

    def take(self, watch: str, message: Any) -> None:  # noqa: ANN401 what the watch tells
        """Take what one of the watches tells."""
        getattr(self, watch)(message)

    def robots(self, message: robot_pb2.WatchRobotStatesResponse) -> None:
        """Take states of robots."""
        stamp, time = message.stamp, time_of(message.stamp)
        for state in message.robots:
            found = self._robots.coordinates(state, stamp)
            joints = joint_states(found, state.positions, state.velocities, time)
            self._write(topics.joint_states(state.name), joints, stamp)
            if state.commanded_positions:
                commanded = state.commanded_velocities or state.velocities
                joints = joint_states(found, state.commanded_positions, commanded, time)
                self._write(topics.commanded_joint_states(state.name), joints, stamp)
            placed = PoseInFrame(timestamp=time, frame_id="world")
            p, q = state.world_t_tcp.position, state.world_t_tcp.orientation
            placed.pose.position.x, placed.pose.position.y, placed.pose.position.z = p.x, p.y, p.z
            turn = placed.pose.orientation
            turn.x, turn.y, turn.z, turn.w = q.x, q.y, q.z, q.w
            self._write(topics.tool_center_point(state.name), placed, stamp)
            self._see_tools(state, time)

    def _see_tools(self, state: robot_pb2.RobotState, time: Timestamp) -> None:
        now = dict(state.tool_states)
        before = self._tool_states.get(state.name, now)
        self._tool_states[state.name] = now
        if self._scenery is not None and before != now:
            self._scenery.tools_changed([tool for tool in now if before.get(tool) != now[tool]], time)

    def scene(self, message: scene_pb2.WatchSceneResponse) -> None:
        """Take a change of the scene."""
        time = time_of(message.stamp)
        if any(node.HasField("range_sensor") for node in message.nodes):
            self._readings.patterns = {**self._readings.patterns, **self._patterns(message.nodes)}
        if self._scenery is not None:
            self._scenery.update(message, time)
        for topic, transforms in self._transforms.update(message, time):
            self._write(topic, transforms, message.stamp)

    def _patterns(self, nodes: Sequence[nodes_pb2.Node]) -> dict[str, sensing_pb2.ScanPattern]:
        """Return the patterns of the range sensors among some nodes, those of their devices included."""
        if not self._presets:
            presets = self._services.sensor.ListSensorPresets(sensor_pb2.ListSensorPresetsRequest()).presets
            self._presets = {preset.name: preset.sensor for preset in presets}
        found = {}
        for node in nodes:
            if node.HasField("range_sensor"):
                device = self._presets.get(node.range_sensor.preset, sensing_pb2.RangeSensor())
                own = node.range_sensor.HasField("pattern")
                found[node.name] = node.range_sensor.pattern if own else device.pattern
        return found

    def signals(self, message: signal_pb2.WatchSignalsResponse) -> None:
        """Take signals."""
        for one in message.signals:
            self._write(topics.signal(one.name), one, message.stamp)

    def readings(self, reading: sensor_pb2.SensorReading) -> None:
        """Take a reading of a sensor."""
        for topic, message in self._readings.told(reading, time_of(reading.stamp)):
            self._write(topic, message, reading.stamp)

    def motions(self, message: motion_pb2.ListMotionsResponse) -> None:
        """Take the motions that run and those that have ended; those that are as before are left out."""
        for motion in message.motions:
            before = self._motions.get(motion.id)
            if before == motion:
                continue
            self._motions[motion.id] = motion
            self._write(topics.MOTIONS, motion, message.stamp)
            if before is None or (before.phase, before.step_path) != (motion.phase, motion.step_path):
                level = Log.WARNING if motion.end_reason else Log.INFO
                self._log(level, ", ".join(motion.robots), _words(motion), message.stamp)

    def collisions(self, message: collision_pb2.WatchCollisionsResponse) -> None:
        """Take what the collision monitor reports."""
        for event in message.events:
            stamp = geometry_pb2.Stamp(tick=event.tick, tick_nanoseconds=message.stamp.tick_nanoseconds)
            self._write(topics.COLLISIONS, event, stamp)
            self._log(Log.WARNING, "collisions", event_of(event)._words(), stamp)

    def _log(self, level: Log.Level.ValueType, name: str, words: str, stamp: geometry_pb2.Stamp) -> None:
        self._write(topics.LOG, Log(timestamp=time_of(stamp), level=level, name=name, message=words), stamp)

    def _write(self, topic: str, message: Message, stamp: geometry_pb2.Stamp) -> None:
        if topic in self._selection:
            with self._lock:
                self._file.write(topic, message, nanoseconds(stamp))

    def _write_scenery(self, topic: str, update: SceneUpdate, time: Timestamp) -> None:
        if topic in self._selection:
            with self._lock:
                self._file.write(topic, update, time.ToNanoseconds())

    @property
    def notes(self) -> Sequence[str]:
        """Topics that nothing came of, and nodes whose looks are not in the file, and why."""
        return [*self._selection.unmet(), *(() if self._scenery is None else self._scenery.notes)]

    @property
    def idle(self) -> bool:
        """True while nothing is on its way to the file."""
        return self._scenery is None or self._scenery.idle

    def close(self, about: Mapping[str, str]) -> None:
        """Write what is left, what is known of the recording now that it has ended, and the index."""
        if self._scenery is not None:
            self._scenery.close()
        with self._lock:
            self._file.note("recording", about)
            self._file.close()


def joint_states(
    found: Sequence[Coordinate], positions: Sequence[float], velocities: Sequence[float], time: Timestamp
) -> JointStates:
    """Return where coordinates are and how fast; of a part of a quaternion, which has no velocity, only where."""
    joints = JointStates(timestamp=time)
    for one, position in zip(found, positions, strict=False):
        velocity = None if one.velocity is None else velocities[one.velocity]
        joints.joints.add(name=one.name, position=position, velocity=velocity)
    return joints


def _words(motion: motion_pb2.Motion) -> str:
    step = f" at step {motion.step_path}" if motion.step_path else ""
    reason = f": {motion.end_reason}" if motion.end_reason else ""
    return f"{motion.id}: {Phase(motion.phase).name.lower()}{step}{reason}"
