"""Ticks of robots that are played, with their brakes: one compiled call writes a tick into the rings of all of them.

Where each of them goes if all that moves brakes now is that of `braking_of`, to the last bit. Most ticks move each
robot by one motion of its own, along its plan: of these the table says no more than how far they are. It is made anew
where robots come and go, and where motions begin and end.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.drivers.shared import BRAKE_ROWS

from virtualrobot_kernel.drivers.link import Link
from virtualrobot_kernel.drivers.twin import Columns, Floats
from virtualrobot_kernel.motion.brake import BrakeTable
from virtualrobot_kernel.numeric.memory import address_of
from virtualrobot_kernel.numeric.rings import BY_ROWS, GOES, OUTPUTS, ROBOT, STANDS_STILL, WAY, WAY_ROWS
from virtualrobot_kernel.world.apply_motions import override
from virtualrobot_kernel.world.braking import LONGEST_BRAKE_TICKS, brakes_alone, braking_of, on_plan, way_of
from virtualrobot_kernel.world.change import Forward
from virtualrobot_kernel.world.state import Snapshot


class Ticks:
    """Writer of ticks; for the world thread alone."""

    def __init__(self, forward: Forward) -> None:
        """Know no robot yet."""
        self._forward = forward
        self._known: tuple[object, ...] = ()
        self._moved: list[NDArray[np.int32]] = []
        self._links: Sequence[Link] = ()
        self._columns: list[Columns] = []
        self._slots: list[NDArray[np.int64]] = []
        self._robots = np.empty((0, len(ROBOT)), np.int64)
        self._places = np.empty(0, np.int64)
        self._outputs: list[int] = []
        self._moving: list[tuple[int, int]] = []
        self._goes: list[int] = []
        self._is_apart = True
        self._table = BrakeTable(0)

    def write(self, now: Snapshot, due_ns: int, links: Sequence[Link]) -> bool:
        """Write a tick that was due at a time (ns), in which something moves; return whether all have its brake."""
        state = now.state
        # What a motion moves stays the same array while it does, also where others take the places of those that end.
        known = now.structure, [id(motion.q_index) for motion in state.motions]
        if known != self._known or links != self._links:
            self._learn(now, links)
            self._known, self._links = known, links
        tick, robots = state.tick, self._robots
        for robot, link in enumerate(links):
            link.ring.end_rest(tick)
            if link.outputs != self._outputs[robot]:
                self._outputs[robot] = link.outputs
                robots[robot : robot + 1, OUTPUTS].view(np.uint64)[:] = link.outputs
        ways = self._ways(now) if self._is_apart else self._ways_together(now)
        if ways is None:
            ways = self._ways_together(now)
        for robot, way in ways.items():
            robots[robot, GOES], robots[robot, WAY], robots[robot, WAY_ROWS] = BY_ROWS, address_of(way), len(way)
        braked = self._table.write(
            now.tick_seconds, LONGEST_BRAKE_TICKS, robots, self._places, state.q, state.v, tick, due_ns
        )
        for robot in ways:  # which are there no longer than this
            robots[robot, GOES] = self._goes[robot] = STANDS_STILL
        return braked == len(links)

    def _ways(self, now: Snapshot) -> dict[int, Floats] | None:
        """Tell the table of motions on plans; return the ways of other robots (m, k); None where one needs all."""
        state, table = now.state, self._table
        ways: dict[int, Floats] = {}
        for row, (place, robot) in enumerate(self._moving):
            motion = state.motions[place]
            if (running := on_plan(motion)) is not None:
                table.tell(row, running.plan, running.tau, running.ramp_tau, running.elapsed, running.ramp)
                if self._goes[robot] != row:
                    self._robots[robot, GOES] = self._goes[robot] = row
            elif brakes_alone(motion):
                table.drop(row)
                way = way_of(motion, override(state, motion), now.tick_seconds).positions
                ways[robot] = np.ascontiguousarray(way)
            else:
                return None
        return ways

    def _ways_together(self, now: Snapshot) -> dict[int, Floats]:
        """Return the ways of all robots (m, k) from that of the world; without rows where that takes too long."""
        for row in range(len(self._moving)):
            self._table.drop(row)
        uids = {link.twin.uid for link in self._links}
        way = braking_of(uids, now.structure, now.state, now.tick_seconds, self._forward)
        rows = way.positions if way.ends else way.positions[:0]
        return {robot: np.ascontiguousarray(rows[:, columns]) for robot, columns in enumerate(self._columns)}

    def _learn(self, now: Snapshot, links: Sequence[Link]) -> None:
        """Make the tables of these robots, and of the motions that move them."""
        state = now.state
        self._moved = [motion.q_index for motion in state.motions]  # so that no other gets its id
        self._columns = [link.places(now.structure)[0] for link in links]
        self._slots = [link.ring.slots for link in links]  # so that they stay where they are
        robots: list[tuple[int, ...]] = []
        places: list[int] = []
        for link, slots in zip(links, self._slots, strict=True):
            counts = address_of(slots), slots.shape[1], slots.shape[0], link.ring.joints
            robots.append((*counts, len(places), 0, link.lead_ns, BRAKE_ROWS, STANDS_STILL, 0, 0))
            at_q, at_v = link.places(now.structure)
            places += [*np.arange(len(state.q))[at_q].tolist(), *np.arange(len(state.v))[at_v].tolist()]
        self._robots = np.array(robots, np.int64).reshape(-1, len(ROBOT))
        self._places = np.array(places, np.int64)
        self._outputs, self._goes = [0] * len(links), [STANDS_STILL] * len(links)
        mine = {link.twin.uid: robot for robot, link in enumerate(links)}
        self._moving = [
            (place, mine[uid]) for place, motion in enumerate(state.motions) for uid in motion.robots if uid in mine
        ]
        moved = [robot for _, robot in self._moving]
        # Each robot has at most one motion, which moves just what it plays, in its order, and no other robot.
        self._is_apart = len(set(moved)) == len(moved) and all(
            len(state.motions[place].robots) == 1
            and np.array_equal(state.motions[place].q_index, np.arange(len(state.q))[self._columns[robot]])
            for place, robot in self._moving
        )
        self._table = BrakeTable(len(self._moving))
