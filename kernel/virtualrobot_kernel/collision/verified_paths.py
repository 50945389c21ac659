"""Paths of planned motions that are known to be free, so that the guard need not look at them in every tick again.

A planned motion stays on its path, whether it runs, slows down, pauses or brakes. So when all that is left of the path
is free, all ways on it are, to the next tick and of any brake. Paths are swept a part at a time, ahead of the motion,
each against what stands and what the same group of joints carries (`kinematic_groups.py`); that two groups keep apart
is told by boxes around what they sweep (`group_boxes.py`). All of it proves freedom only: what is not proven is told as
unverified.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.group_boxes import GroupBoxes
from virtualrobot_kernel.collision.joint_path import JointPath, of_path
from virtualrobot_kernel.collision.kinematic_groups import KinematicGroups, kinematic_groups_of
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.swept import free_until
from virtualrobot_kernel.motion.brake import nominal_time
from virtualrobot_kernel.motion.planned import Track
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.running_motion import RunningMotion
from virtualrobot_kernel.world.crafts import moves_craft
from virtualrobot_kernel.world.state import Motion, Snapshot, State, unchanged

Booleans = NDArray[np.bool_]
Integers = NDArray[np.int64]

PART_SECONDS = 0.1
"""Largest part of a path, by its nominal time (s), that is swept in a tick."""

AGAIN_TICKS = 25
"""After how many ticks a path is looked at again, when what was near is behind."""

SAME = 1e-9
"""Largest offset (rad, m) of joints from the path that they are said to be on."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Part of a track of a motion's plan that is known to be free of what stands and of what its own group carries.

    Attributes:
        place: which track of the plan it is.
        group: the only one that it moves.
        track: the track.
        path: the way by its path parameter, up to its end.
        until: up to there it is free.
        left_out: the pairs (uids) that were not asked.
        tick: when it was begun to look at.
        blocked: whether something may touch right after `until`.
    """

    place: int
    group: int
    track: Track
    path: JointPath
    until: float
    left_out: frozenset[Pair]
    tick: int
    blocked: bool = False

    @property
    def whole(self) -> bool:
        """True when all of it is free."""
        return self.until >= self.path.end


@dataclass(frozen=True, slots=True, eq=False)
class _Stage:
    """The stage of a program that runs, and what is known of the tracks that move in it."""

    program: Program
    at: int
    parts: tuple[Part, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Unverified:
    """Pairs and joints that are not known to be free.

    Attributes:
        of: the groups.
        groups: (u, u) of which groups pairs may touch.
        moving: (u,) which groups move, or may by any brake.
        followed: (u,) which groups need a brake that is known, for whatever reason.
        partly: of motions (ids), what is known of their tracks where that is not all.
    """

    of: KinematicGroups
    groups: Booleans
    moving: Booleans
    followed: Booleans
    partly: Mapping[str, tuple[Part, ...]]

    def follow(self, row: int, other: int) -> bool:
        """Return whether two nodes, given by their rows, may be elsewhere soon; if so, their groups are followed."""
        groups = self.of.rows[[row, other]]
        if not np.any(self.moving[groups]):
            return False
        self.followed[groups] = True
        return True

    def add_pair(self, row: int, other: int) -> None:
        """Unverified of a pair of nodes, given by their rows."""
        one, to = self.of.rows[[row, other]].tolist()
        self.groups[one, to] = self.groups[to, one] = True

    def add_reached(self, reached: Mapping[str, tuple[float, ...]]) -> None:
        """Unverified what brakes reach, given the places of the tracks of motions (ids), beyond what is known of it."""
        for id, parts in self.partly.items():
            places = reached.get(id)
            for part in parts:
                if places is None or places[part.place] > part.until:
                    group = part.group
                    self.groups[group, group] = self.groups[group, 0] = self.groups[0, group] = True

    def of_motions(self, motions: Sequence[Motion]) -> tuple[Motion, ...]:
        """Return the motions of which has to be known how they brake."""
        unsure = self.coordinates()
        asked = [motion.id in self.partly or bool(unsure[motion.q_index].any()) for motion in motions]
        if any(motion.tracked_joint is not None for motion, one in zip(motions, asked, strict=True) if one):
            return tuple(motions)
        return tuple(motion for motion, one in zip(motions, asked, strict=True) if one)

    def asked(self, rows: Integers) -> Booleans:
        """Return of which pairs of nodes (k, 2), given by their rows, it is not known that they do not touch."""
        return self.groups[self.of.rows[rows[:, 0]], self.of.rows[rows[:, 1]]]

    def coordinates(self) -> Booleans:
        """Return which coordinates (nq,) move something that is in doubt or followed."""
        return (np.asarray(np.any(self.groups, axis=0)) | self.followed)[self.of.coordinates]


class VerifiedPaths:
    """Paths of the planned motions that run, as far as they are known to be free. Used by one thread."""

    def __init__(self, scene: CollisionScene) -> None:
        """Know nothing yet; others may use the scene, too."""
        self._scene = scene
        self._stages: dict[str, _Stage] = {}
        self._world: tuple[object, ...] = ()
        self._q: tuple[object, ...] = ()
        self._boxes = GroupBoxes(scene)

    def unverified(
        self, now: Snapshot, later: State | None, robots: Collection[int], tolerated: frozenset[Pair]
    ) -> Unverified:
        """Return what may touch on the way to `later`, if it is not None, and on any brake from there.

        Args:
            now: the world.
            later: it one tick later, with nothing done to it.
            robots: pairs with one of these (uids) are asked.
            tolerated: pairs of nodes (uids) that are not asked.
        """
        state, groups = now.state, kinematic_groups_of(now.structure)
        unsure = np.zeros((groups.count, groups.count), np.bool_)
        self._begin(now, state if later is None else later)
        if later is not None and later.tool_states is not state.tool_states:
            unsure[:] = True
            return Unverified(groups, unsure, np.ones(groups.count, np.bool_), np.zeros(groups.count, np.bool_), {})
        coming = state.motions if later is None else (*later.ended[-len(state.motions) :], *later.motions)
        after = {motion.id: motion.running for motion in coming}
        found: dict[str, tuple[Motion, _Stage]] = {}
        loose = set[int]()
        for motion in state.motions:
            stage = self._stage(now, motion, after.get(motion.id), groups)
            if stage is None:
                loose.update(groups.coordinates[motion.q_index].tolist())
            else:
                found[motion.id] = motion, stage
        _leave_to_one(found, loose)
        partly: dict[str, tuple[Part, ...]] = {}
        self._stages = {}
        for id, (motion, stage) in found.items():
            if not all(part.whole and part.left_out <= tolerated for part in stage.parts):
                parts = tuple(self._gone_on(now, part, motion.running, robots, tolerated) for part in stage.parts)
                stage = replace(stage, parts=parts)
                if not all(part.whole for part in parts):
                    partly[id] = parts
            self._stages[id] = stage
        for group in loose:
            unsure[group] = unsure[:, group] = True
            self._boxes.forget(group)
        moving = {part.group: (motion.running, part) for motion, stage in found.values() for part in stage.parts}

        def reached(group: int) -> float:
            run, part = moving[group]
            return _reached(run, part.place, part.track)

        paths = {group: part.path for group, (_, part) in moving.items()}
        for one, other in self._boxes.meeting(now, groups, robots, paths, reached, loose):
            unsure[one, other] = unsure[other, one] = True
        moves = np.zeros(groups.count, np.bool_)
        moves[[*moving, *loose]] = True
        return Unverified(groups, unsure, moves, np.zeros(groups.count, np.bool_), partly)

    def _begin(self, now: Snapshot, later: State) -> None:
        """Forget what was known of another world, or of one whose joints have been put elsewhere since."""
        state = now.state
        world = (now.structure, state.collisions, state.parent_t_node, state.allowed_pairs, state.tool_states)
        if not unchanged(self._world, world) or not any(state.q is one for one in self._q):
            self._stages, self._boxes = {}, GroupBoxes(self._scene)
        self._world, self._q = world, (state.q, later.q)

    def _stage(
        self, now: Snapshot, motion: Motion, after: RunningMotion | None, groups: KinematicGroups
    ) -> _Stage | None:
        """Return what a motion moves until the next tick and on any brake from there; None where it isn't on a path."""
        run = motion.running
        if not isinstance(run, ProgramRun) or not isinstance(after, ProgramRun) or motion.tracked_joint is not None:
            return None
        if moves_craft(now.structure, motion):
            return None
        program, at = run.program, run.at
        if after.at != at and not (after.ended and after.at == at + 1 == len(program.stages)):
            return None
        known = self._stages.get(motion.id)
        if known is not None and known.program is program and known.at == at:
            return known
        done = program.stages[at + 1].steps[0][1] if at + 1 < len(program.stages) else max(1, program.step_count)
        if any(run.steps_done <= step < done for step, _, _ in motion.tool_states):
            return None
        plan = program.stages[at].plan if at < len(program.stages) else None
        if plan is None:
            return _Stage(program, at, ())
        columns, first, parts = motion.q_index[list(program.stages[at].columns)], 0, []
        for place, track in enumerate(plan.tracks):
            own = columns[first : first + track.path.dimension]
            first += len(own)
            moved, u = set(groups.coordinates[own].tolist()), _reached(run, place, track)
            if len(moved) != 1 or np.abs(track.path.state(u, 0)[0] - now.state.q[own]).max() > SAME:
                return None
            if track.path.start < track.path.end:
                path = of_path(now.state.q, own, track.path)
                parts.append(Part(place, moved.pop(), track, path, u, frozenset(), now.state.tick))
        for part in parts:
            self._boxes.forget(part.group)
        return _Stage(program, at, tuple(parts))

    def _gone_on(
        self, now: Snapshot, part: Part, run: RunningMotion, robots: Collection[int], tolerated: frozenset[Pair]
    ) -> Part:
        """Return what is known of a track after one more part of it was swept."""
        u = _reached(run, part.place, part.track)
        passed = part.blocked and part.until <= u and now.state.tick >= part.tick + AGAIN_TICKS
        if passed or not part.left_out <= tolerated:
            part = replace(part, until=u, left_out=frozenset(), tick=now.state.tick, blocked=False)
        if part.whole or part.blocked:
            return part
        begin, law = max(part.until, u), part.track.time_law
        end = min(law.scalar_state(nominal_time(law, begin, law.start) + PART_SECONDS)[0], part.path.end)
        if not begin < end:
            end = part.path.end
        groups, group = kinematic_groups_of(now.structure), part.group

        def alone(rows: Integers) -> Booleans:
            of = groups.rows[rows]
            return (of == group).any(axis=1) & ((of == group) | (of == 0)).all(axis=1)

        ours = frozenset(
            pair for pair in tolerated if any(groups.rows[now.structure.rows[uid]] == group for uid in pair)
        )
        path = replace(part.path, begin=begin, end=end)
        until = free_until(self._scene, now, path, robots, ours, alone)
        return replace(part, until=until, left_out=part.left_out | ours, blocked=until < end)


def _reached(run: RunningMotion, place: int, track: Track) -> float:
    """Return where on its path a track of a program's stage is."""
    assert isinstance(run, ProgramRun)
    return run.running.path_states[place][0] if run.running is not None else track.path.start


def _leave_to_one(found: dict[str, tuple[Motion, _Stage]], loose: set[int]) -> None:
    """Take for loose what several tracks move at once, or one of them and something loose, with all that move with it.

    They are taken out of `found`, and their groups put into `loose`.
    """
    owners: dict[int, list[str]] = {}
    for id, (_, stage) in found.items():
        for part in stage.parts:
            owners.setdefault(part.group, []).append(id)
    loose.update(group for group, ids in owners.items() if len(ids) > 1)
    waiting = list(loose)
    while waiting:
        for id in owners.pop(waiting.pop(), ()):
            if id in found:
                groups = {part.group for part in found.pop(id)[1].parts} - loose
                loose |= groups
                waiting += groups
