"""Looking ahead: whether what runs will touch something within the next seconds, and who must stop so that it won't.

All running motions are taken together, each by its own law from now on (`motion/prediction.py`), in the world as it is.
What was found free stays so until something else changes than the time: then only the seconds that came in view are
looked at. So a look costs as much as it finds new.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.bodies import made_of
from virtualrobot_kernel.collision.joint_path import JointPath, of_laws, of_program, together
from virtualrobot_kernel.collision.node_pairs import coordinates_between, names_of
from virtualrobot_kernel.collision.program_sweep import Switch, first_along, program_switches
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.swept import SweptContact
from virtualrobot_kernel.collision.transitions import RobotStop, watched
from virtualrobot_kernel.motion.prediction import Prediction, predict
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.world.apply_motions import override
from virtualrobot_kernel.world.collisions import STOPPING
from virtualrobot_kernel.world.state import Motion, Snapshot, unchanged

IN_ADVANCE = 0.25
"""By which part of the time that is looked ahead more is looked at each time, so that it need not be in every tick."""

CHUNK_SECONDS = 0.25
"""Part of a motion (s) that is looked at before it is asked whether there is time for more."""

NEAR_SECONDS = 0.2
"""Pairs that are nearer than the swept check can tell are left out for so long (s), then it is asked again."""

SECONDS = 30.0
"""Time (s), beyond what is looked ahead, for which the ways of motions are told at once."""

SAME = 1e-9
"""By how much joints (rad, m) may be elsewhere than was foreseen."""

GOES_ON = (Phase.RUNNING, Phase.WAITING)


@dataclass(frozen=True, slots=True, eq=False)
class Foreseen:
    """Prediction by simulation time (s): the way of all joints, and when tools get other states.

    moving: the motions (ids) that move joints, or will. until: as long as it is enough to look ahead by; inf where it
    tells all that is known.
    """

    path: JointPath
    switches: list[Switch]
    moving: frozenset[str]
    until: float


class _Proof:
    """Knowledge of the time to come, of a world in which certain motions go on as they did.

    `left_out` are the pairs that are not asked. Up to `until` (s of simulation time) all is free but for these; a
    `contact` there is the first one.
    """

    def __init__(
        self,
        snapshot: Snapshot,
        motions: tuple[object, ...],
        coming: Foreseen,
        touching: frozenset[Pair],
        left_out: set[Pair],
    ) -> None:
        """Begin with nothing known."""
        self._snapshot, self._motions, self._touching = snapshot, motions, touching
        self.coming, self.left_out = coming, left_out
        self.until, self.contact = coming.path.begin, None
        self._expires = coming.until

    def holds(self, snapshot: Snapshot, touching: Collection[Pair]) -> bool:
        """Return whether all is as it was foreseen."""
        then, now, time = self._snapshot.state, snapshot.state, snapshot.simulation_time
        return (
            time < self._expires
            and unchanged(made_of(self._snapshot), made_of(snapshot))
            and then.parent_t_node is now.parent_t_node
            and then.collisions is now.collisions
            and self._touching == frozenset(touching)
            and self._motions == _motions(snapshot)
            and bool((np.abs(self.coming.path.at(time) - now.q) <= SAME).all())
        )

    def extend(
        self,
        scene: CollisionScene,
        snapshot: Snapshot,
        robots: Collection[int],
        until: float,
        enough: Callable[[], bool],
    ) -> None:
        """Look at what is not known yet, up to a time; what is as near as can be already is left out."""
        path, now = self.coming.path, snapshot.simulation_time
        self.until = max(self.until, now)  # it may have been late
        end = min(until, path.end)
        while self.contact is None and self.until < end:
            chunk = replace(path, begin=self.until, end=min(self.until + CHUNK_SECONDS, end))
            contact = first_along(scene, snapshot, chunk, self.coming.switches, robots=robots, tolerated=self.left_out)
            if contact is not None and contact.time <= now:
                self.left_out.add((contact.first, contact.second))
                self._expires = min(self._expires, now + NEAR_SECONDS)
                continue
            self.contact, self.until = contact, chunk.end if contact is None else contact.time
            if enough():
                break


class LookAhead:
    """Remembers what was found free; used by one thread at a time."""

    def __init__(self) -> None:
        """Begin with nothing known."""
        self._proof: _Proof | None = None

    def look(
        self,
        scene: CollisionScene,
        snapshot: Snapshot,
        touching: Collection[Pair] = (),
        enough: Callable[[], bool] = lambda: False,
    ) -> RobotStop | None:
        """Return who is to stop for the first contact within the seconds that are looked ahead; None for nobody.

        Asked are pairs with a robot whose mode is STOP or GUARD; all motions count that are planned, those of other
        robots too. Motions by setpoints have no time to come, and those that go along with a frame depend on its: both
        are taken to stand.

        Args:
            scene: is used for it.
            snapshot: the world as it is.
            touching: pairs of nodes (uids, the smaller first) that touch already: they are not asked.
            enough: whether there is no time for more now; what is left is for the next look.
        """
        settings = snapshot.state.collisions
        ahead = settings.look_ahead_seconds
        proof, self._proof = self._proof, None
        if not ahead or not snapshot.state.motions:
            return None
        by = {uid for uid, mode in watched(snapshot).items() if mode in STOPPING}
        if not by:
            return None
        if proof is None or not proof.holds(snapshot, touching):
            coming = foreseen(snapshot, ahead)
            if coming is None:
                return None
            proof = _Proof(snapshot, _motions(snapshot), coming, frozenset(touching), set(touching))
        now, stop = snapshot.simulation_time, None
        while stop is None:
            if proof.contact is None and proof.until < min(now + ahead, proof.coming.path.end):
                proof.extend(scene, snapshot, by, now + (1.0 + IN_ADVANCE) * ahead, enough)
            contact = proof.contact
            if contact is None or contact.time > now + ahead:
                break
            stop = _stop_for(scene, snapshot, contact, proof.coming.moving, by)
            if stop is None:
                # All that leads to it stops already, or is no planned motion: nothing is left to be done about it.
                proof.left_out.add((contact.first, contact.second))
                proof.contact = None
        self._proof = proof
        return stop


def foreseen(snapshot: Snapshot, ahead: float) -> Foreseen | None:
    """Return what the planned motions of a world will do in the next `ahead` seconds at the least; None for nothing."""
    now = snapshot.simulation_time
    paths: list[JointPath] = []
    switches: list[Switch] = []
    moving: list[str] = []
    until = np.inf
    signals = {name: signal.value for name, signal in snapshot.state.signals.items()}
    for motion in snapshot.state.motions:
        if not isinstance(motion.running, ProgramRun):
            continue
        coming = predict(motion.running, override(snapshot.state, motion), signals, ahead + SECONDS)
        if coming is None:
            continue
        moving.append(motion.id)
        if coming.goes_on:
            until = now + SECONDS
        paths.append(_path(snapshot.state.q, motion, motion.running, coming, now))
        if not coming.brakes:
            made = [one for one in motion.tool_states if one[0] >= motion.running.steps_done]
            switches += [
                (now + coming.when(time), tool, state) for time, tool, state in program_switches(coming.program, made)
            ]
    if not paths:
        return None
    return Foreseen(paths[0] if len(paths) == 1 else together(paths), switches, frozenset(moving), until)


def _path(q: NDArray[np.float64], motion: Motion, run: ProgramRun, coming: Prediction, now: float) -> JointPath:
    """Return the way of a motion from now on, by simulation time."""
    if coming.running is not None and coming.brakes:
        stage, elapsed = run.program.stages[run.at], coming.running.elapsed
        assert stage.plan is not None, "what brakes has a plan"
        columns = motion.q_index[list(stage.columns)]
        own = of_laws(q, columns, stage.plan, coming.running.brakes, 0.0, elapsed + coming.end)
        by = partial(_since, now, elapsed)
    else:
        own, by = of_program(q, motion.q_index, coming.program), partial(_nominal, coming, now)
    return JointPath(
        now,
        now + coming.end,
        lambda time: own.at(by(time)),
        lambda first, last: own.travel(by(first), by(last)),
    )


def _since(now: float, elapsed: float, time: float) -> float:
    return elapsed + time - now


def _nominal(coming: Prediction, now: float, time: float) -> float:
    return coming.nominal(time - now)


def _motions(snapshot: Snapshot) -> tuple[object, ...]:
    """Return what tells that motions go on as before."""
    state = snapshot.state
    return tuple(
        (motion.id, motion.step_count, motion.running.phase in GOES_ON, override(state, motion))
        for motion in state.motions
    )


def _stop_for(
    scene: CollisionScene, snapshot: Snapshot, contact: SweptContact, moving: Collection[str], by: Collection[int]
) -> RobotStop | None:
    """Return whom a contact to come stops: who moves one of its nodes by plan and does not stop yet, if anybody.

    Those that slow down to a pause are stopped when nobody else can be.
    """
    structure, state = snapshot.structure, snapshot.state
    places = coordinates_between((contact.first, contact.second), structure)
    found: dict[bool, dict[int, None]] = {False: {}, True: {}}
    for motion in state.motions:
        if motion.id in moving and motion.cancellation is None:
            pauses = motion.running.phase is Phase.PAUSING
            leads = zip(motion.joints, motion.q_index.tolist(), strict=True)
            found[pauses].update({robot: None for (robot, _), place in leads if place in places})
    robots = tuple(found[False] or found[True])
    if not robots:
        return None
    first, second = names_of((contact.first, contact.second), structure)
    seconds = contact.time - snapshot.simulation_time
    groups = scene.bodies.allowed.groups
    own = frozenset(groups[uid] for uid in (contact.first, contact.second)) & frozenset(by)
    return RobotStop(robots, f"{first!r} would touch {second!r} in {seconds:.3g} s", own)
