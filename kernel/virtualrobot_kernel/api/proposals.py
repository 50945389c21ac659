"""Proposals that all clients share: motions with the plans that were checked, and what has become of them.

They are not in the world: like the plans that they are started by they say what may be done, not what is. The API's
thread alone reads and changes them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.shown_plans import ShownPlan, ShownPlans
from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.world.listeners import Listeners
from virtualrobot_kernel.world.state import Motion

MOST_REMEMBERED = 50
"""Greatest number of proposals that are remembered; of those that are over the oldest goes first."""

LARGEST_BYTES = 65_536
"""Greatest size of a motion (bytes): all proposals are told in one message, and gRPC clients take 4 MiB by default."""

MOST_UNDONE = 20
"""Greatest number of changes of a proposal that can be taken back."""

LONGEST_TEXT = 200
"""Greatest number of characters of a title, and of a reason."""


class ProposalState(Enum):
    """State of a proposal; the names equal those of `ProposalState` in the contract."""

    PROPOSED = "proposed"
    APPROVED = "approved"
    EXECUTED = "executed"
    STOPPED = "stopped"
    REJECTED = "rejected"


OPEN = (ProposalState.PROPOSED, ProposalState.APPROVED)


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """Motion with what its check has found, and the plan that it is started by; None where it violates something."""

    spec: motion_pb2.MotionSpec
    check: motion_pb2.CheckMotionResponse
    shown: ShownPlan | None


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """Proposal at one revision.

    Attributes:
        id, revision: what it is called, and how often it has changed, from 1.
        title: what it is for, in words for people.
        checked: the motion, and what its check has found.
        author, changed_by: who made it, and who changed it last.
        state: what has become of it.
        motion: the motion that was started when it was approved last; empty before.
        reason: why it was rejected, or why its motion ended early, in words.
        before: the motions that changes can be taken back to, the newest last.
    """

    id: str
    revision: int
    title: str
    checked: Checked
    author: str
    changed_by: str
    state: ProposalState = ProposalState.PROPOSED
    motion: str = ""
    reason: str = ""
    before: tuple[motion_pb2.MotionSpec, ...] = ()


class Proposals:
    """Proposals by name, oldest first."""

    def __init__(self, plans: ShownPlans) -> None:
        """Begin with none; their plans are kept among these."""
        self._plans = plans
        self._by_id: dict[str, Proposal] = {}
        self._count = 0
        self._starting: set[str] = set()
        self._listeners: Listeners[[object]] = Listeners()

    @property
    def all(self) -> list[Proposal]:
        """All of them, oldest first."""
        return [*self._by_id.values()]

    def find(self, id: str, expected_revision: int | None = None) -> Proposal:
        """Return a proposal; raise KernelError for one that there is not, and for another revision than is expected."""
        proposal = self._by_id.get(id)
        if proposal is None:
            raise UnknownNameError("proposal", id, self._by_id)
        if expected_revision is not None and expected_revision != proposal.revision:
            raise KernelError(
                f"{id!r} has the revision {proposal.revision}, not {expected_revision}: {proposal.changed_by} has "
                "changed it meanwhile; look at it again",
                reason=Reason.STALE_REVISION,
                proposal=id,
                expected=expected_revision,
                revision=proposal.revision,
            )
        return proposal

    def add(self, title: str, checked: Checked, author: str) -> Proposal:
        """Add a proposal; raise KernelError (WRONG_STATE) where all that are remembered are open."""
        if len(self._by_id) >= MOST_REMEMBERED:
            over = next((one.id for one in self._by_id.values() if one.state not in OPEN), None)
            if over is None:
                raise KernelError(
                    f"{len(self._by_id)} proposals wait to be approved or rejected, and no more are kept; reject some",
                    reason=Reason.WRONG_STATE,
                )
            self._plans.let_go(self._by_id.pop(over).checked.shown)
        self._count += 1
        return self._publish(Proposal(f"proposal-{self._count}", 1, title, checked, author, author))

    def change(self, seen: Proposal, checked: Checked, by: str, *, title: str, undo: bool = False) -> Proposal:
        """Give a proposal as it was seen another motion, or take its last change back, and return it as it is then.

        Raise KernelError where it is another one by now, or is approved.
        """
        self.find(seen.id, seen.revision)
        self.check_open(seen)
        before = seen.before[:-1] if undo else seen.before
        if not undo and checked.spec != seen.checked.spec:
            before = (*before, seen.checked.spec)[-MOST_UNDONE:]
        self._plans.let_go(seen.checked.shown)
        state = ProposalState.PROPOSED
        return self._changed(seen, by, checked=checked, title=title, before=before, state=state, reason="")

    def reject(self, seen: Proposal, reason: str, by: str) -> Proposal:
        """Turn a proposal down and return it; raise KernelError (WRONG_STATE) unless it is PROPOSED."""
        self.check_proposed(seen)
        return self._changed(seen, by, state=ProposalState.REJECTED, reason=reason)

    def check_open(self, proposal: Proposal) -> None:
        """Raise KernelError (WRONG_STATE) for a proposal whose motion is being started, or runs."""
        if proposal.id in self._starting or proposal.state is ProposalState.APPROVED:
            raise KernelError(
                f"{proposal.id!r} is approved, and what runs is not changed; wait for the end of its motion, or cancel "
                "it",
                reason=Reason.WRONG_STATE,
                proposal=proposal.id,
                state=ProposalState.APPROVED.name,
            )

    def check_proposed(self, proposal: Proposal) -> None:
        """Raise KernelError (WRONG_STATE) for a proposal that nobody can approve or reject any more."""
        self.check_open(proposal)
        if proposal.state is not ProposalState.PROPOSED:
            raise KernelError(
                f"{proposal.id!r} is {proposal.state.value}; propose it again, by a change of it",
                reason=Reason.WRONG_STATE,
                proposal=proposal.id,
                state=proposal.state.name,
            )

    @contextmanager
    def approving(self, id: str, revision: int) -> Iterator[ShownPlan]:
        """Yield the plan of a proposal as it was seen, which nobody changes meanwhile.

        Raise KernelError for another revision, and where it is over or has no plan.
        """
        proposal = self.find(id, revision)
        self.check_proposed(proposal)
        shown = proposal.checked.shown
        if shown is None:
            raise KernelError(
                f"{id!r} can't be approved: {proposal.checked.check.first_violation.message}; change it",
                reason=Reason.WRONG_STATE,
                proposal=id,
                state=proposal.state.name,
            )
        self._starting.add(id)
        try:
            yield shown
        finally:
            self._starting.discard(id)

    def approved(self, id: str, motion: str, by: str) -> Proposal:
        """Take note that the plan of a proposal was started, and return it."""
        return self._changed(self._by_id[id], by, state=ProposalState.APPROVED, motion=motion, reason="")

    def ended(self, proposal: Proposal, motion: Motion | None) -> None:
        """Take note of the end of the motion that a proposal was approved with; None: it is remembered no more."""
        if motion is not None and motion.phase is Phase.SUCCEEDED:
            self._changed(proposal, proposal.changed_by, state=ProposalState.EXECUTED)
            return
        why = None if motion is None else motion.cancellation
        reason = "how its motion ended is not known any more" if why is None else why.reason
        self._changed(proposal, proposal.changed_by, state=ProposalState.STOPPED, reason=reason)

    def subscribe(self, listener: Callable[[object], None]) -> Callable[[], None]:
        """Call `listener` after each change, until the returned function is called."""
        return self._listeners.add(listener)

    def _changed(self, proposal: Proposal, by: str, **changes: Any) -> Proposal:  # noqa: ANN401 fields of a proposal
        return self._publish(replace(proposal, revision=proposal.revision + 1, changed_by=by, **changes))

    def _publish(self, proposal: Proposal) -> Proposal:
        self._plans.hold(proposal.checked.shown)
        self._by_id[proposal.id] = proposal
        self._listeners.tell(proposal)
        return proposal


def changes(told: Iterable[Proposal], now: Iterable[Proposal]) -> tuple[list[Proposal], list[str]]:
    """Return which proposals are new or others than those that were told, and the names of those that are gone."""
    known, kept = {one.id: one for one in told}, [*now]
    gone = known.keys() - {one.id for one in kept}
    return [one for one in kept if known.get(one.id) is not one], [id for id in known if id in gone]
