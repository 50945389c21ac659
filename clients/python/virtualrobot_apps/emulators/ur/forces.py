"""Forces on the tool of an emulated arm: as a sensor of the kernel measures them, or as a client of RTDE tells them."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from virtualrobot import Client, VirtualRobotError
from virtualrobot.robots.robot import Robot
from virtualrobot.sensors.readings import Reading

from virtualrobot_apps.emulators.body import Twin
from virtualrobot_apps.emulators.ur.kinematics import Floats, Model
from virtualrobot_apps.emulators.ur.lengths import turn_of_flange
from virtualrobot_apps.wrist import wrist_of

_SILENT_SECONDS = 0.5
"""Simulation time (s) without a reading after which a sensor is silent."""
_ASKED_SECONDS = 0.2
"""Time (s) for which physics are taken to be as they were."""
_OFF = "no forces are known where physics are off; client.physics.set('mujoco') switches them on"
_GRAVITY = np.array([0.0, 0.0, -9.81])
"""Gravity (m/s^2) in the base's frame of an arm that knows of no other."""


class Unmeasured(RuntimeError):
    """Nothing measures forces; the words say why, and what would."""


class Meter(Protocol):
    """Something that measures what pushes on the flange."""

    def find(self) -> None:
        """Look for what measures, unless it is known. Raises Unmeasured."""
        ...

    def read(self) -> tuple[Floats, Floats]:
        """Return force and torque (6,) about the flange's origin (N, Nm), and gravity (3,) in m/s^2.

        Both are in the flange's frame. Raises Unmeasured, where nothing was found, too.
        """
        ...


def moved(wrench: Floats, a_t_b: Floats) -> Floats:
    """Return force and torque (6,) about the origin of b, in its frame, as those about the origin of a, in a's."""
    force, torque = a_t_b[:3, :3] @ wrench[:3], a_t_b[:3, :3] @ wrench[3:]
    return np.concatenate([force, torque + np.cross(a_t_b[:3, 3], force)])


@dataclass(frozen=True, slots=True)
class Payload:
    """Mass (kg) on the flange, and its centre (3,) in the flange's frame (m)."""

    mass: float
    center: Floats

    def weight(self, gravity: Floats) -> Floats:
        """Return its weight (6,) about the flange's origin, by gravity (3,) in the flange's frame."""
        force = self.mass * gravity
        return np.concatenate([force, np.cross(self.center, force)])


class Forces:
    """Forces on the flange without the payload's weight."""

    def __init__(self, meter: Meter | None = None) -> None:
        """Take what measures, if anything does."""
        self._meter = meter
        self._zero = np.zeros(6)
        self._outside: tuple[Payload, Floats] | None = None
        self.told = np.zeros(6)
        """Force and torque (6,) that a client of RTDE tells."""

    def find(self) -> None:
        """Look for what measures. Raises Unmeasured."""
        if self._outside is not None:
            return
        if self._meter is None:
            raise Unmeasured("an arm without a kernel feels nothing until ft_rtde_input_enable has it told of forces")
        self._meter.find()

    def hear(self, sensor: Payload | None, place: Floats) -> None:
        """Take what a client of RTDE tells from now on, of a sensor; with None the arm's own sensor measures.

        It measures at `place` (3,), along the axes of the flange's frame.
        """
        self._outside = None if sensor is None else (sensor, place)
        self._zero = np.zeros(6)

    def on_tool(self, base_t_flange: Floats, tcp: Floats, payload: Payload) -> Floats:
        """Return force and torque (6,) on the tool about the TCP, (4, 4) in the flange's frame, along the base's axes.

        Raises Unmeasured where nothing measures.
        """
        around = np.eye(4)
        around[:3, :3] = base_t_flange[:3, :3]
        around[:3, 3] = -base_t_flange[:3, :3] @ tcp[:3, 3]
        return moved(self._loaded(base_t_flange, payload) - self._zero, around)

    def set_zero(self, base_t_flange: Floats, payload: Payload) -> None:
        """Measure from what there is now. Raises Unmeasured."""
        self._zero = self._loaded(base_t_flange, payload)

    def _loaded(self, base_t_flange: Floats, payload: Payload) -> Floats:
        wrench, gravity = self.measured(base_t_flange)
        return wrench - payload.weight(gravity)

    def measured(self, base_t_flange: Floats) -> tuple[Floats, Floats]:
        """Return all force and torque (6,) about the flange's origin, and gravity (3,), in the flange's frame.

        Raises Unmeasured.
        """
        if self._outside is not None:
            sensor, place = self._outside
            gravity = base_t_flange[:3, :3].T @ _GRAVITY
            flange_t_sensor = np.eye(4)
            flange_t_sensor[:3, 3] = place
            return moved(self.told, flange_t_sensor) - sensor.weight(gravity), gravity
        if self._meter is None:
            raise Unmeasured("nothing measures")
        return self._meter.read()


class Wrist:
    """Force and torque sensor on the flange of a robot in a kernel, where physics move what it touches.

    It is looked for when it is told to, and anew where it was not there or has gone.
    """

    def __init__(self, client: Client, robot: Robot, body: Twin, model: Model) -> None:
        """Know the robot."""
        self._client, self._robot, self._body, self._model = client, robot, body, model
        self._news: Reading | None = None
        self._flange_t_sensor = np.eye(4)
        self._gravity = _GRAVITY
        self._fault = "nobody has looked for it"

    def read(self) -> tuple[Floats, Floats]:
        """Return force and torque (6,) about the flange's origin, and gravity (3,), in the flange's frame."""
        news = self._news
        if news is None or self._fault:
            self._news = None
            raise Unmeasured(self._fault)
        if self._body.time - news.stamp.simulation_time > _SILENT_SECONDS:
            raise Unmeasured(f"the sensor {news.sensor!r} is silent")
        wrench = np.concatenate([news.value.force, news.value.torque])
        gravity = self._flange_t_sensor[:3, :3] @ news.world_t_sensor[:3, :3].T @ self._gravity
        return moved(wrench, self._flange_t_sensor), gravity

    def find(self) -> None:
        """Look for the sensor and start it. Raises Unmeasured."""
        if self._news is not None and not self._fault:
            return
        try:
            status = self._client.physics.status
            if status.engine in ("", "none"):
                raise Unmeasured(_OFF)
            first, flange_t_sensor = wrist_of(self._client, self._robot)
            sensor = self._client.sensors[first.sensor]
            if sensor.status.state != "running":
                sensor.start()
            turn = np.eye(4)
            turn[:3, :3] = turn_of_flange(self._robot, self._model)
        except VirtualRobotError as error:
            raise Unmeasured(str(error)) from error
        self._gravity, self._flange_t_sensor, self._news = status.gravity, turn @ flange_t_sensor, first
        self._fault = ""
        threading.Thread(
            target=self._watch, args=(first.sensor,), name=f"forces on {self._robot.name}", daemon=True
        ).start()

    def _watch(self, name: str) -> None:
        asked = time.monotonic()
        try:
            for reading in self._client.sensors[name].watch(max_rate=500.0):
                if reading.value is None:
                    self._fault = f"the sensor {name!r} tells nothing: {reading.fault or reading.state}"
                    return
                if time.monotonic() - asked > _ASKED_SECONDS:
                    # Without physics a sensor goes on, and feels no contact.
                    asked, status = time.monotonic(), self._client.physics.status
                    if status.engine in ("", "none"):
                        self._fault = _OFF
                        return
                    self._gravity = status.gravity
                self._news = reading
            self._fault = f"the sensor {name!r} is there no more"
        except VirtualRobotError as error:
            self._fault = str(error)
