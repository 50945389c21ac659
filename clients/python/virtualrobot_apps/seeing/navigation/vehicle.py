"""Vehicles of a kernel as a navigator sees them: by their lidar and encoders, never by where they truly are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from types import MappingProxyType
from typing import Any

import numpy as np
from virtualrobot import Client, Robot
from virtualrobot.errors import InvalidArgumentError, UnknownNameError
from virtualrobot.sensors.motion_sensors import EncoderReading
from virtualrobot.sensors.range_sensors import RangeReading

from virtualrobot_apps.seeing.navigation.footprint import Footprint
from virtualrobot_apps.seeing.navigation.matching import FEWEST
from virtualrobot_apps.seeing.navigation.navigator import Observation
from virtualrobot_apps.seeing.navigation.poses import Floats, between, planar
from virtualrobot_apps.seeing.navigation.scans import OdometryTrack, ScanMaker
from virtualrobot_apps.seeing.navigation.sonars import Sonar

PERIOD = 0.05
"""Time (s) from one command to the next."""
SHARE = 0.95
"""Part of the drives' greatest speeds that is used."""


class Vehicle:
    """A craft with a lidar that looks around in a level plane, and encoders on its drives."""

    def __init__(
        self,
        client: Client,
        name: str,
        lidar: str,
        encoders: str,
        thought: Mapping[str, object] | None = None,
        sonars: Mapping[str, float] = MappingProxyType({}),
    ) -> None:
        """Take a robot that is a craft; `thought` are settings of its component that odometry has wrong.

        `sonars` are ultrasonic sensors that hear what the lidar doesn't see, each with half of its cone's angle (rad).

        Raises:
            UnknownNameError: for a robot or sensor that is not there.
            InvalidArgumentError: for a sensor of another kind.
            WrongStateError: for a robot that is no craft.
            InvalidArgumentError: for one that can't turn on the spot.
        """
        self.name, self.lidar, self.encoders = name, lidar, encoders
        robot = client.robots[name]
        kinds = [(lidar, "range_sensor"), (encoders, "motion_sensor"), *((one, "range_sensor") for one in sonars)]
        for sensor, kind in kinds:
            if client.sensors.status(sensor).kind != kind:
                raise InvalidArgumentError(f"{sensor!r} is a {client.sensors.status(sensor).kind}, not a {kind}")
        first = client.sensors[lidar].read(points=True, frame="sensor")
        rows, rays = first.value.distances.shape if isinstance(first.value, RangeReading) else (0, 0)
        if rows != 1 or rays < FEWEST:
            raise InvalidArgumentError(
                f"{lidar!r} has {rows} x {rays} rays: a lidar that looks around has one row of {FEWEST} rays at least"
            )
        counted = client.sensors[encoders].read().value
        if not isinstance(counted, EncoderReading | None):
            others = [
                one.name
                for one in client.scene.nodes("motion_sensor")
                if isinstance(client.sensors[one.name].read().value, EncoderReading)
            ]
            raise InvalidArgumentError(
                f"{encoders!r} tells no joints, so that there is no odometry by it; encoders are "
                f"{', '.join(map(repr, others)) or 'none here'}"
            )
        self._odometry = robot.odometry(settings=thought, encoders=counted)
        start = self._odometry.reading.pose
        base = np.eye(4)
        base[:2, :2] = [[np.cos(start[2]), -np.sin(start[2])], [np.sin(start[2]), np.cos(start[2])]]
        base[:2, 3] = start[:2]
        world_t_base = planar(client.scene.pose(name) @ base)
        mount = between(world_t_base, planar(first.world_t_sensor))
        self.sonars = {
            one: Sonar(between(world_t_base, planar(client.scene.pose(one))), half, _reach(client, one))
            for one, half in sonars.items()
        }
        self.footprint = _footprint(client, name, world_t_base)
        self._per_twist, self._fastest = _drives(robot)
        self._track = OdometryTrack()
        self.reach = _reach(client, lidar)
        """Distance (m) that its lidar sees."""
        self._maker = ScanMaker(mount, self.reach)
        self._number = -1

    def drivable(self, v: float, w: float) -> tuple[float, float]:
        """Return a twist, v (m/s) and omega (rad/s), on the same arc, slow enough for each drive."""
        speeds = np.abs(np.array([v, w]) @ self._per_twist)
        scale = min(1.0, SHARE / max(1e-9, float((speeds / self._fastest).max(initial=0.0))))
        return v * scale, w * scale

    def observe(self, now: float, readings: Mapping[str, Any]) -> Observation:
        """Return what is seen at a time (s), from readings of the sensors by name."""
        lidar, encoders = readings[self.lidar], readings[self.encoders]
        pose = self._odometry.update(encoders.value).pose
        self._track.add(encoders.stamp.simulation_time, pose)
        scan = None
        if lidar.number != self._number and lidar.value is not None:
            self._number = lidar.number
            scan = self._maker.scan(lidar.stamp.simulation_time, lidar.value, self._track)
        heard = [(sonar, readings[one].value) for one, sonar in self.sonars.items()]
        return Observation(
            now, pose, scan, tuple((sonar, _nearest(value)) for sonar, value in heard if value is not None)
        )


class Drive:
    """Drive of some vehicles in one kernel: each period they are told their twists, and what they see comes back.

    In steps, so that nothing depends on how fast this program is; a context manager. While it is open, simulation time
    goes on by its periods alone.
    """

    def __init__(self, client: Client, vehicles: Sequence[Vehicle]) -> None:
        """Drive vehicles."""
        self.client, self.vehicles = client, list(vehicles)
        self._sensors = [sensor for one in vehicles for sensor in (one.lidar, one.encoders, *one.sonars)]
        self._open = ExitStack()
        self._periods = 0

    def __enter__(self) -> Drive:
        """Begin: sensors run, and the clock is held."""
        self.client.sensors.start(*self._sensors)
        self._open.enter_context(self.client.clock.hold_stepped())
        clock = self.client.clock.read()
        self._tick_seconds, self._tick, self._start = clock.tick_length, clock.stamp.tick, clock.stamp.tick
        return self

    def __exit__(self, *_: object) -> None:
        """Let the vehicles come to rest."""
        try:
            self.client.clock.step(round(1.0 / self._tick_seconds), twists={one.name: None for one in self.vehicles})
        finally:
            self._open.close()

    def step(self, twists: Mapping[str, tuple[float, float]]) -> dict[str, Observation]:
        """Drive vehicles by twists, v (m/s) and omega (rad/s) by name, for a period; return what all of them see."""
        self._periods += 1
        # A period need not be whole ticks: what it leaves over is made up for by the next one.
        due = self._start + round(self._periods * PERIOD / self._tick_seconds)
        slowed = {one.name: one.drivable(*twists[one.name]) for one in self.vehicles if one.name in twists}
        told = {name: (v, 0.0, w) for name, (v, w) in slowed.items()}
        seen = self.client.clock.step(due - self._tick, twists=told, sensors=self._sensors, points=True, frame="sensor")
        self._tick, now = seen.stamp.tick, seen.stamp.simulation_time
        return {one.name: one.observe(now, seen.readings) for one in self.vehicles}


def sensors_of(client: Client, name: str) -> tuple[str, str]:
    """Return the lidar and the encoders that a robot has; raise UnknownNameError where that isn't one of each."""
    name, found = client.robots[name].name, {}
    for kind, word in (("range_sensor", "lidar"), ("motion_sensor", "encoders")):
        own = [one.name for one in client.scene.nodes(kind) if one.name.startswith(f"{name}.") and word in one.name]
        if len(own) != 1:
            raise UnknownNameError(
                f"{name} has {len(own)} sensors named like {word!r}: name one of {own or 'its sensors'}"
            )
        found[word] = own[0]
    return found["lidar"], found["encoders"]


def _drives(robot: Robot) -> tuple[Floats, Floats]:
    """Return how far drives turn for a meter ahead and for a radian on the spot (2, k), and how fast they can (k,)."""
    rows, names = list[Floats](), ()
    for part in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]):
        way = robot.way([part])
        plan, names = way.plan(sample_time=1.0).robots[robot.name], way.joint_names
        columns = [plan.joint_names.index(name) for name in names]
        rows.append(plan.positions[-1, columns] - plan.positions[0, columns])
    return np.array(rows), np.array([robot.limits[name].velocity for name in names])


def _nearest(reading: RangeReading) -> float:
    """Return the least distance of a reading (m); inf: none."""
    return float(reading.distances[reading.valid].min(initial=np.inf))


def _footprint(client: Client, name: str, world_t_base: np.ndarray) -> Footprint:
    """Return the footprint of a robot: the box about all links that move with its base."""
    for link in client.scene.nodes("link"):
        if link.parent == name:
            bounds = client.scene.bounds(link.name)
            if bounds is not None:
                base_t_link = between(world_t_base, planar(client.scene.pose(link.name)))
                (left, low, _), (right, high, _) = bounds + np.array([*base_t_link[:2], 0.0])
                return Footprint(float(left), float(right), float(low), float(high))
    raise InvalidArgumentError(f"{name!r} has no links with a shape, so that its footprint is unknown: give one")


def _reach(client: Client, lidar: str) -> float:
    """Return how far a lidar sees (m)."""
    settings = client.scene.node(lidar)._message.range_sensor
    preset = client.sensors.presets().get(settings.preset)
    for known in (settings, *([] if preset is None else [preset.settings._message])):
        if known.HasField("max_range_meters"):
            return known.max_range_meters
    return 10.0  # as the contract has it
