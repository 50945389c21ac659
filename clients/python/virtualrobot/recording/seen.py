"""States as the watches of a recording have told them: whether that is all there is, and what is left out."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from typing import Any

from virtualrobot._wire import interruptions
from virtualrobot._wire.messages import array_of
from virtualrobot._wire.services import Services
from virtualrobot.v1 import kernel_pb2, robot_pb2, scene_pb2, sensor_pb2, signal_pb2

_ROW_BYTES = 7 * 8
_LONGEST_SECONDS = 10.0
"""Longest time (s) that is waited for what is on its way; it comes within milliseconds."""
_SOON_SECONDS = 0.005
"""Time (s) in which a watch tells that something moves, as a rule; after it the kernel is asked whether it does."""


class Seen:
    """States as the watches of a recording have told them.

    A watch is silent while nothing changes, so that it has told all there is when it is as new as a question's answer,
    or says the same.

    Attributes:
        begun: the watches that have told anything.
        counts_gaps: whether each tick is wanted.
        missed_ticks: number of ticks that were left out while a robot moved.
        missed_readings: number of readings of sensors that were left out.
    """

    def __init__(self, services: Services, counts_gaps: bool, wants_readings: bool) -> None:
        """Begin with nothing."""
        self._services, self.counts_gaps, self._wants_readings = services, counts_gaps, wants_readings
        self.begun: set[str] = set()
        self.missed_ticks = self.missed_readings = 0
        self._changed = threading.Condition()
        self._ended = False
        self._revisions: dict[str, int] = {}
        self._robots_tick = 0
        self._robots: dict[str, robot_pb2.RobotState] = {}
        self._poses: dict[int, bytes] = {}
        self._signals: dict[str, Any] = {}
        self._numbers: dict[str, int] = {}
        self._without_sensors = -1

    def take(self, watch: str, message: Any) -> None:  # noqa: ANN401 a message of the contract
        """Take what a watch has told."""
        with self._changed:
            if watch == "readings":
                self._take_readings(message)
            else:
                self._revisions[watch] = message.stamp.state_revision
            if watch == "robots":
                self._take_robots(message)
            elif watch == "scene":
                rows = array_of(message.world_t_node).tobytes()
                for place, uid in enumerate(message.moved_uids):
                    self._poses[uid] = rows[_ROW_BYTES * place : _ROW_BYTES * (place + 1)]
            elif watch == "signals":
                self._signals.update({one.name: one for one in message.signals})
            self.begun.add(watch)
            self._changed.notify_all()

    def _take_robots(self, message: robot_pb2.WatchRobotStatesResponse) -> None:
        if self.counts_gaps and any(any(state.velocities) for state in self._robots.values()):
            # What moves is elsewhere in the next tick.
            self.missed_ticks += max(message.stamp.tick - self._robots_tick - 1, 0)
        self._robots_tick = message.stamp.tick
        for name in message.removed_names:
            self._robots.pop(name, None)
        self._robots.update({state.name: state for state in message.robots})

    def _take_readings(self, message: sensor_pb2.WatchReadingsResponse) -> None:
        for reading in message.readings:
            if reading.WhichOneof("reading") is None:
                self._numbers.pop(reading.sensor, None)
                continue
            before = self._numbers.get(reading.sensor)
            if before is not None and reading.number > before:
                self.missed_readings += reading.number - before - 1
            self._numbers[reading.sensor] = reading.number

    def end(self) -> None:
        """Let nobody wait any longer."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def wait_for_begin(self, watches: Iterable[str]) -> None:
        """Wait until these watches have told anything."""
        wanted = set(watches)
        self._wait(lambda: self.begun >= wanted)

    def catch_up(self, step: kernel_pb2.StepClockResponse | None = None) -> None:
        """Wait until the watches have told all that is true now; of the end of a step its answer says what that is."""
        robots = step or self._services.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest())
        self._wait(lambda: self._has("robots", robots, [self._robots.get(one.name) == one for one in robots.robots]))
        if "signals" in self.begun:
            signals = step or self._services.signal.GetSignals(signal_pb2.GetSignalsRequest())
            self._wait(
                lambda: self._has("signals", signals, [self._signals.get(one.name) == one for one in signals.signals])
            )
        if "scene" in self.begun:
            moves = step is not None and any(any(state.velocities) for state in step.robots)
            if not (moves and self._wait(lambda: self._has("scene", step, [False]), _SOON_SECONDS)):
                self._catch_up_poses()
        if self._wants_readings and self._without_sensors != robots.stamp.structure_revision:
            self._catch_up_readings()

    def _catch_up_poses(self) -> None:
        scene = self._services.scene.GetScene(scene_pb2.GetSceneRequest(read_mask={"paths": ["uid"]}))
        rows = array_of(scene.world_t_node)
        told = {node.uid: row.tobytes() for node, row in zip(scene.nodes, rows, strict=True)}
        self._wait(lambda: self._has("scene", scene, [self._poses.get(uid) == row for uid, row in told.items()]))

    def _catch_up_readings(self) -> None:
        now = self._services.sensor.ListSensors(sensor_pb2.ListSensorsRequest())
        self._without_sensors = -1 if now.sensors else now.stamp.structure_revision
        running = {one.name: one.readings for one in now.sensors if one.state == sensor_pb2.SENSOR_STATE_RUNNING}
        self._wait(lambda: all(self._numbers.get(name, 0) >= count for name, count in running.items()))

    def _has(self, watch: str, answer: Any, alike: Iterable[bool]) -> bool:  # noqa: ANN401 an answer with a stamp
        return self._revisions.get(watch, -1) >= answer.stamp.state_revision or all(alike)

    def _wait(self, done: Callable[[], bool], seconds: float = _LONGEST_SECONDS) -> bool:
        """Wait until something is done or the recording has ended, so long at most; return whether it is done."""
        end = time.monotonic() + seconds
        with self._changed:
            while not (found := done()) and not self._ended and (left := end - time.monotonic()) > 0.0:
                interruptions.wait(
                    self._changed, min(left, 0.1)
                )  # in small steps: Ctrl-C would not get through on Windows
            return found
