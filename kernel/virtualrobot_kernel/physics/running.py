"""Engine at work on a scene: what the world was told last, and what it is told of an answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.physics import Stepped, TouchingBodies

from virtualrobot_kernel.physics.answers import Answers
from virtualrobot_kernel.physics.bodies import Scene
from virtualrobot_kernel.physics.layout import Layout
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.physics_commands import SetContacts, SetDynamics, SetParts
from virtualrobot_kernel.world.state import BodyContacts, PhysicsSettings, Snapshot, State
from virtualrobot_kernel.world.structure import Structure

Floats = NDArray[np.float64]

REST_SPEED = 2e-3
"""Speed of a part that counts as being at rest (m/s); a tenth of a turn of it in a second counts, too (rad/s)."""
REST_TURN = 1e-2
REST_SECONDS = 0.5
"""Time after which a part that was slower all the while rests."""
CREEP = 1e-4
"""Distance (m), and turn (rad), from which on a part that rests is where the engine has it."""


UNTOUCHED = SetContacts(BodyContacts(np.zeros((0, 2), np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3))))
"""Command that tells that nothing touches."""


@dataclass(slots=True)
class Running:
    """Engine with a scene, and what the world was told last."""

    scene: Scene
    layout: Layout
    structure: Structure
    settings: PhysicsSettings
    poses: Floats
    """parent_t_node (n, 4, 4) of all nodes, as it must be where nobody else has changed it."""
    twists: Floats
    """(k, 6) of the free parts, as the world has them."""
    q: Floats
    """(n,) of what forces move of robots, as the world has it."""
    v: Floats
    commanded: tuple[Floats, Floats]
    """Positions (of motors that exert an effort: that) and velocities of joints, as commanded in the last tick."""
    efforts: tuple[Mapping[int, Mapping[str, float]], Floats]
    """Efforts as clients say them, and of the motors that exert one."""
    felt: NDArray[np.bool_] | None
    """Bodies whose contacts sensors feel, in the order of the model; None where there are none."""
    slow_ticks: NDArray[np.int64]
    """(k,) number of ticks that each part was slow."""
    answers: Answers
    """Checks of the engine's answers."""
    still_ticks: int = 0
    """Number of ticks that all robots were slow, and nothing else was commanded of them."""
    stands: bool = False
    """True where everything rests, so that the engine is not asked."""
    is_astray: bool = False
    """True where the engine has made a step that does not count."""

    def command(self, later: State) -> bool:
        """Take what is commanded by the end of a tick; return whether that is the same as in the tick before."""
        place, rate = self.layout.commanded(self.structure, later)
        if len(exerts := self.layout.joints.exerts):
            if self.efforts[0] is not later.efforts:
                self.efforts = later.efforts, self.layout.efforts(later.efforts)
            place[exerts] = self.efforts[1]
        before, self.commanded = self.commanded, (place, rate)
        return equal(place, before[0]) and equal(rate, before[1])

    def told(self, now: Snapshot, answer: Stepped, same: bool) -> Sequence[Command]:
        """Return the commands for what does not rest, and remember what the world is told.

        `same` says that of motors the same is commanded as in the tick before.
        """
        robots, robots_stand = self._robots_told(now, answer, same)
        parts, parts_stand = self._parts_told(now, answer)
        self.stands = robots_stand and parts_stand
        return [*parts, *robots, *self._contacts_told(now.state, answer.contacts)]

    def _contacts_told(self, state: State, found: TouchingBodies) -> Sequence[Command]:
        """Return the command for contacts that sensors feel; none where there are none, as before."""
        felt = None if self.felt is None else self.felt[found.bodies].any(axis=1)
        if felt is None or not felt.any():
            return () if state.contacts is None else (UNTOUCHED,)
        nodes = np.array(self.scene.nodes, np.int64)[found.bodies[felt]]
        return (SetContacts(BodyContacts(nodes, found.positions[felt], found.normals[felt], found.forces[felt])),)

    def _parts_told(self, now: Snapshot, answer: Stepped) -> tuple[Sequence[Command], bool]:
        """Return the command for parts, and whether all rest."""
        layout = self.layout
        if not len(layout.part_rows):
            return (), True
        placed, twists, speeds, off = layout.part_state(now, answer.q, answer.v)
        slow = (speeds < (REST_SPEED, REST_TURN)).all(axis=1)
        self.slow_ticks = np.where(slow, self.slow_ticks + 1, 0)
        resting = self.slow_ticks * now.tick_seconds >= REST_SECONDS
        stays = resting & (off < CREEP)
        if stays.any():
            stays &= ~self.twists.any(axis=1)
        if stays.all():
            return (), True
        twists[resting] = 0.0
        chosen = layout.part_order
        if stays.any():
            chosen = chosen[~stays[chosen]]
        self.twists = self.twists.copy()
        self.twists[chosen] = twists[chosen]
        self.poses = now.state.parent_t_node.copy()
        self.poses[layout.part_rows[chosen]] = placed[chosen]
        return [SetParts(layout.part_uids[chosen], placed[chosen], twists[chosen])], False

    def _robots_told(self, now: Snapshot, answer: Stepped, same: bool) -> tuple[Sequence[Command], bool]:
        """Return the command for robots, and whether all rest."""
        layout, state = self.layout, now.state
        if not len(layout.q):
            return (), True
        entering = tuple(uid for uid in layout.robots if uid not in state.motored)
        q, v, fastest = layout.robot_state(state, answer.q, answer.v)
        still = same and not entering and fastest < REST_SPEED
        self.still_ticks = self.still_ticks + 1 if still else 0
        rests = self.still_ticks * now.tick_seconds >= REST_SECONDS
        if rests and not self.v.any() and np.abs(q - self.q).max() < CREEP:
            return (), True
        self.q, self.v = q, np.zeros(len(v)) if rests else v
        return [SetDynamics(layout.q, q, layout.v, self.v, entering)], False


def equal(one: Floats, other: Floats) -> bool:
    """Return whether two arrays have the same shape and values."""
    return one is other or (one.shape == other.shape and bool((one == other).all()))
