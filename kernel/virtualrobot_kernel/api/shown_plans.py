"""Plans that clients have been shown: kept by name, started as they were, or refused with what has changed."""

from __future__ import annotations

import secrets
import threading
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import sha256

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.collision.surroundings import Difference, Surroundings, surroundings_of
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.planning.plan_motion import PlannedMotion
from virtualrobot_kernel.planning.program import MotionSpec
from virtualrobot_kernel.planning.violations import Violation
from virtualrobot_kernel.world.apply_motions import START_TOLERANCE
from virtualrobot_kernel.world.change import joint_places
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.measured import commanded
from virtualrobot_kernel.world.preconditions import broken
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

MOST_REMEMBERED = 100
"""Greatest number of plans that are remembered; the oldest goes first."""

TOLD = 3
"""Greatest number of changes that the message of a refusal names; its metadata have all."""


@dataclass(frozen=True, slots=True, eq=False)
class ShownPlan:
    """Plan as a client was shown it.

    Attributes:
        id, digest: what it is called, and the SHA-256 of all that is below.
        said: what was asked for, as it was said: by its steps it is known who may start it.
        spec: the same as values.
        planned: the command that starts it.
        joints: what it moves, as (robot uid, joint name).
        robots: the robots (uids) whose components it needed.
        seen: the world that it was planned on.
        surroundings: what stood around it when it was checked for collisions; None: it was not.
        resolution: how exact that check was (m).
    """

    id: str
    digest: str
    said: motion_pb2.MotionSpec
    spec: MotionSpec
    planned: PlannedMotion
    joints: tuple[tuple[int, str], ...]
    robots: frozenset[int]
    seen: Snapshot
    surroundings: Surroundings | None
    resolution: float

    @property
    def message(self) -> motion_pb2.PlanReference:
        """Return what clients call it by."""
        return motion_pb2.PlanReference(id=self.id, digest=self.digest)

    def checked_in(self, snapshot: Snapshot, resolution: float) -> ShownPlan:
        """Return the plan as one that was checked for collisions in a world: it depends on what stands there."""
        return replace(self, surroundings=surroundings_of(snapshot, self.joints), resolution=resolution)

    def is_surrounded_in(self, now: Snapshot) -> bool:
        """Return whether all that its check for collisions used is as it was."""
        return self.surroundings is None or not self.surroundings.differences(now)

    def check(self, now: Snapshot, commands: Sequence[Command] = ()) -> None:
        """Raise KernelError (PLAN_OUTDATED) with all that it, or its check, has used and that is another one now."""
        self.check_path(now)
        if self.surroundings is not None and (differences := self.surroundings.differences(now)):
            raise self.outdated(differences)

    def check_path(self, now: Snapshot) -> None:
        """Raise KernelError (PLAN_OUTDATED) with all by which its path would be another one now."""
        structure, command = now.structure, self.planned.command
        differences = [
            Difference(robot, "NAME", f"another robot is called {robot!r}")
            for (robot, _), (uid, _) in zip(command.joints, self.joints, strict=True)
            if structure.uid_by_name.get(robot) != uid
        ]
        differences += [
            Difference(name, fact.aspect.name, f"of {name!r} {what}")
            for fact, name, what in broken(command.preconditions, structure, now.state)
        ]
        differences += self._strays(now)
        if differences:
            raise self.outdated(differences)

    def outdated(self, differences: Sequence[Difference], violation: Violation | None = None) -> KernelError:
        """Return the error of a plan whose world is another one, and of what it violates there, if that is known."""
        words = list(dict.fromkeys(one.words for one in differences))
        more = f", and {len(words) - TOLD} more" if len(words) > TOLD else ""
        found = f", and {violation.message}" if violation else ""
        touching = violation.contact if violation else None
        return KernelError(
            f"the world is not the one that {self.id!r} was made for: {'; '.join(words[:TOLD])}{more}{found}; plan "
            "again",
            reason=Reason.PLAN_OUTDATED,
            plan=self.id,
            node=differences[0].node,
            aspect=differences[0].aspect,
            changes="\n".join(words),
            **({} if touching is None else {"first": touching[0][0], "second": touching[1][0]}),
        )

    def _strays(self, now: Snapshot) -> list[Difference]:
        """Return the joints that don't stand where the plan starts."""
        command, robots = self.planned.command, now.structure.robots
        if not all(uid in robots and joint in robots[uid].coordinates for uid, joint in self.joints):
            return []  # that is told already
        here = commanded(now.structure, now.state)[0][joint_places(now.structure, self.joints)[0]]
        places = zip(command.joints, here.tolist(), command.program.start.tolist(), strict=True)
        return [
            Difference(robot, "START", f"{joint!r} of {robot!r} stands at {now_at:g}, not at {start:g}")
            for (robot, joint), now_at, start in places
            if abs(now_at - start) > START_TOLERANCE
        ]


class ShownPlans:
    """Plans that were shown, the newest of them and those that are held; for any thread."""

    def __init__(self) -> None:
        """Begin with none."""
        self._plans: OrderedDict[str, ShownPlan] = OrderedDict()
        self._held: dict[str, ShownPlan] = {}
        self._lock = threading.Lock()

    def keep(
        self,
        snapshot: Snapshot,
        said: motion_pb2.MotionSpec,
        spec: MotionSpec,
        planned: PlannedMotion,
        robots: frozenset[int],
        resolution: float | None,
    ) -> ShownPlan | None:
        """Keep a plan that was made in a world, and return it; None for one that belongs to the moment.

        resolution: how exact it was checked for collisions (m), by which it depends on all that can collide; None: it
        was not.
        """
        if spec.tracking is not None or spec.deferred:
            return None
        command = planned.command
        joints = tuple((snapshot.structure.node(robot, Kind.ROBOT).uid, joint) for robot, joint in command.joints)
        around = None if resolution is None else surroundings_of(snapshot, joints)
        facts = () if around is None else [(uid, aspect.name, value) for (uid, aspect), value in around.facts.items()]
        digest = sha256(world_codec().encode((command, tuple(facts), resolution))).hexdigest()
        id = f"plan-{secrets.token_hex(6)}"
        shown = ShownPlan(id, digest, said, spec, planned, joints, robots, snapshot, around, resolution or 0.0)
        with self._lock:
            self._plans[shown.id] = shown
            if len(self._plans) > MOST_REMEMBERED:
                self._plans.popitem(last=False)
        return shown

    def hold(self, shown: ShownPlan | None) -> None:
        """Remember a plan until it is let go, however many come after it."""
        if shown is not None:
            self._held[shown.id] = shown

    def let_go(self, shown: ShownPlan | None) -> None:
        """Remember a plan no longer than others."""
        if shown is not None:
            self._held.pop(shown.id, None)

    def find(self, reference: motion_pb2.PlanReference) -> ShownPlan:
        """Return a plan; raise KernelError for one that is not remembered, and for another digest than its own."""
        shown = self._plans.get(reference.id) or self._held.get(reference.id)
        if shown is None:
            raise KernelError(
                f"no plan {reference.id!r} is remembered: the kernel keeps the last {MOST_REMEMBERED}, until it ends; "
                "plan again",
                reason=Reason.UNKNOWN_NAME,
                kind="plan",
                name=reference.id,
            )
        if reference.digest not in ("", shown.digest):
            raise KernelError(
                f"{shown.id!r} has the digest {shown.digest}, not {reference.digest!r}: another plan is meant",
                field="plan.digest",
                plan=shown.id,
            )
        return shown
