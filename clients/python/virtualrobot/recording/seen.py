"""States as the watches of a recording have told them: whether that is all there is, and what is left out."""

from __future__ import annotations

from typing import Any

from virtualrobot._wire.messages import array_of
from virtualrobot._wire.services import Services
from virtualrobot.v1 import robot_pb2, scene_pb2, sensor_pb2, signal_pb2

_ROW_BYTES = 7 * 8


class Seen:
    """States as the watches of a recording have told them.

    A watch is silent while nothing changes, so that it has told all there is when it is as new as a question's answer,
    or says the same.

    Attributes:
        begun: the watches that have told anything.
        missed_ticks: number of ticks that were left out while a robot moved.
        missed_readings: number of readings of sensors that were left out.
    """

    def __init__(self, services: Services, counts_gaps: bool, wants_readings: bool) -> None:
        """Begin with nothing."""
        self._wants_readings = wants_readings
        self._services, self._counts_gaps = services, counts_gaps
        self.begun: set[str] = set()
        self.missed_ticks = self.missed_readings = 0
        self._ticks: dict[str, int] = {}
        self._robots: dict[str, robot_pb2.RobotState] = {}
        self._poses: dict[int, bytes] = {}
        self._signals: dict[str, Any] = {}
        self._numbers: dict[str, int] = {}

    def take(self, watch: str, message: Any) -> None:  # noqa: ANN401 a message of the contract
        """Take what a watch has told."""
        if watch == "readings":
            self._take_readings(message)
        elif watch == "robots":
            self._take_robots(message)
        elif watch == "scene":
            rows = array_of(message.world_t_node).tobytes()
            for place, uid in enumerate(message.moved_uids):
                self._poses[uid] = rows[_ROW_BYTES * place : _ROW_BYTES * (place + 1)]
        elif watch == "signals":
            self._signals.update({one.name: one for one in message.signals})
        if watch != "readings":
            self._ticks[watch] = message.stamp.tick
        self.begun.add(watch)

    def _take_robots(self, message: robot_pb2.WatchRobotStatesResponse) -> None:
        before = self._ticks.get("robots", message.stamp.tick)
        if self._counts_gaps and any(any(state.velocities) for state in self._robots.values()):
            # What moves is elsewhere in the next tick.
            self.missed_ticks += max(message.stamp.tick - before - 1, 0)
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

    def is_up_to_date(self) -> bool:
        """Return whether the watches have told all that is true now."""
        looks = {"robots": self._has_robots, "scene": self._has_poses, "signals": self._has_signals}
        return all(look() for watch, look in looks.items() if watch in self.begun) and self._has_readings()

    def _has_robots(self) -> bool:
        now = self._services.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest())
        return self._ticks["robots"] >= now.stamp.tick or all(
            self._robots.get(state.name) == state for state in now.robots
        )

    def _has_poses(self) -> bool:
        request = scene_pb2.GetSceneRequest(read_mask={"paths": ["uid"]})
        now = self._services.scene.GetScene(request)
        rows = array_of(now.world_t_node)
        return self._ticks["scene"] >= now.stamp.tick or all(
            self._poses.get(node.uid) == row.tobytes() for node, row in zip(now.nodes, rows, strict=True)
        )

    def _has_signals(self) -> bool:
        now = self._services.signal.GetSignals(signal_pb2.GetSignalsRequest())
        return all(self._signals.get(signal.name) == signal for signal in now.signals)

    def _has_readings(self) -> bool:
        if not self._wants_readings:
            return True
        now = self._services.sensor.ListSensors(sensor_pb2.ListSensorsRequest())
        return all(
            self._numbers.get(one.name, 0) >= one.readings
            for one in now.sensors
            if one.state == sensor_pb2.SENSOR_STATE_RUNNING
        )
