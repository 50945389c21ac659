"""Steps of the clock: what is set before one, what ends it, and what is read after it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from virtualrobot._wire.arguments import ArrayLike
from virtualrobot._wire.signal_values import GivenValue, condition
from virtualrobot.motions.motion import Motion
from virtualrobot.v1 import kernel_pb2, motion_pb2

Values: TypeAlias = Mapping[str, float] | ArrayLike | None
"""Setpoint of a robot: values by name or in order; None lets it come to rest."""

_MODES = {
    "twists": motion_pb2.SETPOINT_MODE_TWIST,
    "positions": motion_pb2.SETPOINT_MODE_POSITION,
    "velocities": motion_pb2.SETPOINT_MODE_VELOCITY,
}


@dataclass(frozen=True, slots=True)
class Event:
    """Event that ends a step: `motion_ends`, `signal_is`, `collides` and `reads` of this module make them."""

    _message: kernel_pb2.StepEvent


def motion_ends(motion: Motion) -> Event:
    """Return the event that a motion has ended."""
    return Event(kernel_pb2.StepEvent(motion_ended=motion.id))


def signal_is(name: str, value: GivenValue = True, comparison: str = "==") -> Event:
    """Return the event that a signal has a value; `comparison` is ==, !=, <, <=, > or >=."""
    return Event(kernel_pb2.StepEvent(signal=condition(name, value, comparison)))


def collides(robot: str) -> Event:
    """Return the event that a robot touches what it may not; its collisions must be monitored."""
    return Event(kernel_pb2.StepEvent(collision_of=robot))


def reads(sensor: str) -> Event:
    """Return the event that a sensor, which reads at its rate, has a new reading."""
    return Event(kernel_pb2.StepEvent(reading_of=sensor))


def setpoints(
    kind: str, robots: Mapping[str, Values] | None, timeout: float, preempt: bool
) -> Iterator[kernel_pb2.StepSetpoint]:
    """Yield the setpoints of robots by name; `kind` is twists, positions or velocities."""
    for robot, values in (robots or {}).items():
        named = values if isinstance(values, Mapping) else {}
        target = motion_pb2.SetpointTarget(
            robot=robot,
            joint_names=list(named),
            mode=_MODES[kind],
            timeout_seconds=timeout,
            busy_policy=motion_pb2.BUSY_POLICY_PREEMPT if preempt else motion_pb2.BUSY_POLICY_REJECT,
        )
        numbers: Iterable[float] = named.values()
        if values is not None and not isinstance(values, Mapping):
            numbers = np.asarray(values, dtype=float).ravel().tolist()
        yield kernel_pb2.StepSetpoint(target=target, values=numbers)
