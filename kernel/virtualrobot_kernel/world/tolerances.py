"""Tolerances of motions: how far joints may be from where they are commanded to be, and from their goal. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.world.apply_motions import replaced
from virtualrobot_kernel.world.change import Change, joint_places
from virtualrobot_kernel.world.measured import commanded
from virtualrobot_kernel.world.state import Cancellation, Deviation, DeviationKind, EndCause, Motion, Snapshot, State
from virtualrobot_kernel.world.structure import Structure

Floats = NDArray[np.float64]

_UNITS = {DeviationKind.POSITION: "", DeviationKind.VELOCITY: " per second"}


@dataclass(frozen=True, slots=True, eq=False)
class AwaitedJoints:
    """Joints (robot uid, name) that a motion waits for, to be at rest at their goal.

    goal (k,): rad or m. tolerances (k, 2): of positions, and of velocities; 0 means any.
    """

    joints: tuple[tuple[int, str], ...]
    goal: Floats
    tolerances: Floats

    def __str__(self) -> str:
        """Return what is amiss while they are not there, for people."""
        return "the joints have not come to their goal"

    def deviations(self, structure: Structure, state: State) -> tuple[Deviation, ...]:
        """Return the joints that are not there, none where their robot is gone."""
        if not all(uid in structure.robots and name in structure.robots[uid].coordinates for uid, name in self.joints):
            return ()
        q_index, v_index, _ = joint_places(structure, self.joints)
        off = np.stack([state.q[q_index] - self.goal, state.v[v_index]], axis=1)
        return _beyond(self.joints, off, self.tolerances)

    def is_there(self, snapshot: Snapshot) -> bool:
        """Return whether they are there now."""
        return not self.deviations(snapshot.structure, snapshot.state)


def kept(structure: Structure, state: State) -> State:
    """Return the state a tick after which motions brake whose joints are beyond their tolerance on the way.

    What has ended in this tick since its joints did not come to their goal has them told.
    """
    there = None
    for motion in state.motions:
        if motion.path_tolerances is None or motion.cancellation is not None or not _goes(motion):
            continue
        there = there or commanded(structure, state)
        q, v = state.q - there[0], state.v - there[1]
        off = np.stack([q[motion.q_index], v[motion.v_index]], axis=1)
        if found := _beyond(motion.joints, off, motion.path_tolerances):
            why = Cancellation(EndCause.PATH_TOLERANCE, _words(structure, found, "from where it is commanded to be"))
            braking = replace(motion, running=motion.running.cancel(), cancellation=why, deviations=found)
            state = replaced(Change(structure, state), braking).state
    late = [motion for motion in state.ended if motion.end_tick == state.tick and _missed(motion)]
    if late:
        told = {motion.id: _with_deviations(structure, state, motion) for motion in late}
        state = replace(state, ended=tuple(told.get(motion.id, motion) for motion in state.ended))
    return state


def concerned(motions: Sequence[Motion]) -> bool:
    """Return whether joints of one of some motions may be beyond a tolerance, or have not come to its goal in time."""
    return any(
        motion.path_tolerances is not None
        or (motion.cancellation is not None and motion.cancellation.cause is EndCause.GOAL_TOLERANCE)
        for motion in motions
    )


def _goes(motion: Motion) -> bool:
    """Return whether a motion is on its way, and not at its goal already."""
    run = motion.running
    return isinstance(run, ProgramRun) and run.running is not None


def _awaited(motion: Motion) -> AwaitedJoints | None:
    run = motion.running
    if not isinstance(run, ProgramRun):
        return None
    orders = (order for stage in run.program.stages[-1:] for order in stage.orders)
    return next((order for order in orders if isinstance(order, AwaitedJoints)), None)


def _missed(motion: Motion) -> bool:
    why = motion.cancellation
    return why is not None and why.cause is EndCause.GOAL_TOLERANCE and not motion.deviations


def _with_deviations(structure: Structure, state: State, motion: Motion) -> Motion:
    awaited, run = _awaited(motion), motion.running
    found = () if awaited is None else awaited.deviations(structure, state)
    if not found or motion.cancellation is None or not isinstance(run, ProgramRun):
        return motion
    words = f"{run.waited:g} s after its end {_words(structure, found, 'from its goal')}"
    return replace(motion, cancellation=replace(motion.cancellation, reason=words), deviations=found)


def _beyond(joints: Sequence[tuple[int, str]], off: Floats, tolerances: Floats) -> tuple[Deviation, ...]:
    """Return the joints whose values are off (k, 2) by more than their tolerances (k, 2)."""
    found = np.argwhere((np.abs(off) > tolerances) & (tolerances > 0.0))
    kinds = (DeviationKind.POSITION, DeviationKind.VELOCITY)
    return tuple(
        Deviation(joints[row], kinds[column], float(off[row, column]), float(tolerances[row, column]))
        for row, column in found.tolist()
    )


def _words(structure: Structure, found: Sequence[Deviation], whence: str) -> str:
    def one(deviation: Deviation) -> str:
        uid, joint = deviation.joint
        unit = _UNITS[deviation.kind]
        return (
            f"{joint!r} of {structure.nodes[uid].name!r} is off by {deviation.value:.3g}{unit} {whence}, its tolerance "
            f"is {deviation.tolerance:.3g}{unit}"
        )

    return "; ".join(map(one, found))


def tolerance_rows(names: Sequence[str], given: Sequence[tuple[str, float, float]], what: str) -> Floats | None:
    """Return the tolerances (k, 2) of joints by name, position and velocity; None where none are given.

    Raises KernelError for a joint that is not among them or is named twice, and for negative tolerances.
    """
    if not given:
        return None
    rows = np.zeros((len(names), 2))
    for place, (joint, *tolerances) in enumerate(given):
        if joint not in names:
            raise KernelError(
                f"{what}[{place}].joint must be one of the trajectory's, {', '.join(names)}, not {joint!r}",
                field=f"{what}[{place}].joint",
            )
        if rows[names.index(joint)].any():
            raise KernelError(f"{what} names {joint!r} twice", field=f"{what}[{place}].joint")
        rows[names.index(joint)] = tolerances
    return rows if rows.any() else None
