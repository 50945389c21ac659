"""Settings of collision handling: none, reports, stops, or a guard that keeps collisions from happening."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

from virtualrobot_kernel.world.structure import Structure

LONGEST_LOOK_AHEAD_SECONDS = 60.0

STOP_AHEAD_SECONDS = 1.0
"""Look-ahead from when the first robot is to be stopped, where nothing is said: more than robots take to stop whose
files tell no accelerations (0.35 s, `formats/limits.py`)."""
MOST_PADDING_METERS = 1.0


class CollisionMode(Enum):
    """Collision handling of a robot; the names equal those of `CollisionMode` in the contract."""

    OFF = "off"
    MONITOR = "monitor"
    STOP = "stop"
    GUARD = "guard"


STOPPING = frozenset({CollisionMode.STOP, CollisionMode.GUARD})
"""Modes of robots that a collision stops; a guarded one should not come into any."""


@dataclass(frozen=True, slots=True)
class Allowance:
    """Reason for which two nodes may touch; `built`: an import has found it, else a client has set it."""

    reason: str = ""
    built: bool = False


@dataclass(frozen=True, slots=True)
class CollisionSettings:
    """Settings of collision handling.

    Attributes:
        mode: for robots without a mode of their own.
        modes: for robots (uids) that have one.
        look_ahead_seconds: how far ahead running motions are checked, in simulation time; 0: not at all.
        paddings: by how much the figures of nodes (uids) count as thicker, in meters, above 0.
    """

    mode: CollisionMode = CollisionMode.OFF
    modes: Mapping[int, CollisionMode] = field(default_factory=dict)
    look_ahead_seconds: float = 0.0
    paddings: Mapping[int, float] = field(default_factory=dict)

    def modes_of(self, structure: Structure) -> dict[int, CollisionMode]:
        """Return the mode of each robot (uid): its own, else that of a robot whose gripper it is, else that of all."""
        modes = dict(self.modes)
        for robot, mode in self.modes.items():
            modes = {**dict.fromkeys(structure.grippers_of(robot), mode), **modes}
        return {uid: modes.get(uid, self.mode) for uid in structure.robots}

    def among(self, alive: Container[int]) -> CollisionSettings:
        """Return the settings without nodes that are gone; the same object when none is."""
        if all(uid in alive for uid in self.modes) and all(uid in alive for uid in self.paddings):
            return self
        modes = {uid: mode for uid, mode in self.modes.items() if uid in alive}
        return replace(self, modes=modes, paddings={uid: one for uid, one in self.paddings.items() if uid in alive})


NOTHING_SET = CollisionSettings()
"""Settings of a new world: collisions are ignored."""
