"""Twin of a real robot: which joints of the world are its controller's, and what a driver must know of them. Pure."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import urlsplit

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.drivers.shared import Values

from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.world.structure import Joint, Structure

Floats = NDArray[np.float64]
Columns = slice | NDArray[np.intp]
"""Index of some columns of an array."""

AT_REST = 1e-3
"""Distance (rad, m) of each joint within which robot and twin stand at the same place."""

LEADS = (0.02, 0.4)
"""Least and greatest lead (s)."""


@dataclass(frozen=True, slots=True)
class ControllerJoint:
    """Joint of a controller: the robot's coordinate that it is, whether it counts the other way, and where its 0 is."""

    joint: str
    reversed: bool = False
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Asked:
    """Connection that a client asks for: who is to be connected how.

    Attributes:
        component: the driver's name.
        settings: its settings as plain values.
        joints: the controller's joints in its order; empty: the robot's own.
        lead: how much later than its twin the robot does things, s.
        following_warning, following_limit: following error (rad, m) that is warned of, and that stops the robot.
        without_watchdog: whether a controller will do that doesn't stop by itself when it hears nothing more.
    """

    component: str
    settings: dict[str, object]
    joints: tuple[ControllerJoint, ...] = ()
    lead: float = 0.1
    following_warning: float = 0.02
    following_limit: float = 0.1
    without_watchdog: bool = False

    def __post_init__(self) -> None:
        """Refuse numbers that make no sense, by the names of their fields."""
        if not LEADS[0] <= self.lead <= LEADS[1]:
            raise KernelError(
                f"lead_seconds must be {LEADS[0]:g} to {LEADS[1]:g}, not {self.lead:g}", field="lead_seconds"
            )
        if not 0.0 < self.following_limit < math.inf:
            raise KernelError(
                f"following_limit must be finite and above 0, not {self.following_limit:g}", field="following_limit"
            )
        if not 0.0 < self.following_warning <= self.following_limit:
            raise KernelError(
                f"following_warning must be above 0 and at most following_limit ({self.following_limit:g}), not "
                f"{self.following_warning:g}",
                field="following_warning",
            )
        for place, one in enumerate(self.joints):
            if not math.isfinite(one.offset):
                raise KernelError(f"joints[{place}].offset must be finite, not {one.offset}", field="joints")

    @property
    def lines(self) -> frozenset[str]:
        """Lines that its settings name: `socket://host:port` of serial device servers, and serial ports."""
        return frozenset(line for line in map(_line_of, self.settings.values()) if line)


_LOCAL = {"localhost": "127.0.0.1", "::1": "127.0.0.1"}
"""Names of this machine, by which one line may be named twice."""

_DEVICES = ("/dev/tty", "/dev/pts/", "/dev/cu.")
_PORT = re.compile(r"COM[0-9]+", re.IGNORECASE)
"""Names of serial ports: how devices begin on Linux and macOS, and whole ones on Windows."""


def _line_of(value: object) -> str:
    """Return `socket://host:port`, or the device that a serial port is, by whatever link; empty of anything else."""
    if not isinstance(value, str):
        return ""
    if _PORT.fullmatch(value):
        return value.upper()
    if value.startswith("/"):
        device = os.path.realpath(value)
        return device if device.startswith(_DEVICES) else ""
    try:
        url = urlsplit(value)
        host, port = url.hostname, url.port
    except ValueError:
        return ""
    return f"socket://{_LOCAL.get(host, host)}:{port}" if url.scheme == "socket" and host and port else ""


@dataclass(frozen=True, slots=True, eq=False)
class Twin:
    """Joints of a robot (uid) that a controller has, k in its order, with their limits (rad or m, per s)."""

    uid: int
    joints: tuple[ControllerJoint, ...]
    lower: Floats
    upper: Floats
    velocity: Floats

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the robot's coordinates."""
        return tuple(one.joint for one in self.joints)

    def outside(self, positions: Values) -> tuple[str, ...]:
        """Return the names of joints that positions (k,) have outside their limits."""
        q = np.asarray(positions)
        beyond = (q < self.lower - AT_REST) | (q > self.upper + AT_REST)
        return tuple(np.array(self.names)[beyond].tolist())

    def outside_told(self, positions: Values) -> str:
        """Return where joints stand that are outside their limits, and these; empty when none is."""
        q, out = np.asarray(positions), self.outside(positions)
        return ", ".join(
            f"{name} at {value:.6g} ({lower:.6g} to {upper:.6g})"
            for name, value, lower, upper in zip(self.names, q, self.lower, self.upper, strict=True)
            if name in out
        )


def twin_of(structure: Structure, robot: str, joints: Sequence[ControllerJoint]) -> Twin:
    """Return the twin of a controller with these joints; without any, those of the robot that can be moved by itself.

    Raises UnknownNameError for a joint that the robot has not, KernelError for one that is named twice, and for a robot
    without joints.
    """
    node, index = structure.robot(robot)
    chosen = tuple(joints) or tuple(map(ControllerJoint, index.coordinates_of(index.joint_names)))
    if not chosen:
        raise KernelError(f"the robot {robot!r} has no joints that a controller could move", robot=robot)
    seen: set[str] = set()
    found: list[Joint] = []
    for one in chosen:
        if one.joint not in index.coordinates:
            raise UnknownNameError(f"joint of {node.name!r} that can be moved", one.joint, index.coordinates)
        if one.joint in seen:
            raise KernelError(f"the joint {one.joint!r} of {robot!r} is named twice", robot=robot, joint=one.joint)
        seen.add(one.joint)
        coordinate = index.coordinates[one.joint]
        if coordinate.v < 0 or len(index.joints[coordinate.place].coordinate_names) > 6:
            raise KernelError(
                f"{one.joint!r} of {robot!r} is a coordinate of a floating joint, which no controller has",
                robot=robot,
                joint=one.joint,
            )
        found.append(coordinate.joint)
    limits = [joint.limits for joint in found]
    return Twin(
        node.uid,
        chosen,
        np.array([one.lower for one in limits]),
        np.array([one.upper for one in limits]),
        np.array([one.velocity for one in limits]),
    )


def columns(structure: Structure, twin: Twin) -> tuple[Columns, Columns]:
    """Return where the twin's k joints are in the world's q and in its v."""
    found = [structure.robots[twin.uid].coordinates[name] for name in twin.names]
    return _columns([one.q for one in found]), _columns([one.v for one in found])


def _columns(places: list[int]) -> Columns:
    """Return places as an index, a slice where they follow each other: that copies nothing."""
    first, count = places[0], len(places)
    return slice(first, first + count) if places == list(range(first, first + count)) else np.array(places, np.intp)
