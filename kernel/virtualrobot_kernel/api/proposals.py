"""Proposals that all clients share: motions with the plans that were checked, and what has become of them.

They are not in the world: like the plans that they are started by they say what may be done, not what is. The API's
thread alone reads and changes them.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.shelf import Shelf
from virtualrobot_kernel.api.shown_plans import ShownPlan, ShownPlans
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.world.state import Motion

MOST_REMEMBERED = 50
"""Greatest number of proposals that are remembered; of those that are over the oldest goes first."""

LARGEST_BYTES = 65_536
"""Greatest size of a motion (bytes): all proposals are told in one message, and gRPC clients take 4 MiB by default."""

MOST_UNDONE = 20
"""Greatest number of changes of a proposal that can be taken back."""


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


class Proposals(Shelf[Proposal]):
    """Proposals by name, oldest first."""

    def __init__(self, plans: ShownPlans) -> None:
        """Begin with none; their plans are kept among these."""
        super().__init__("proposal", MOST_REMEMBERED)
        self._plans = plans
        self._starting: set[str] = set()

    def add(self, title: str, checked: Checked, author: str) -> Proposal:
        """Add a proposal; raise KernelError (WRONG_STATE) where all that are remembered are open."""
        over = self.make_room(
            lambda one: one.state not in OPEN,
            "proposals wait to be approved or rejected, and no more are kept; reject some",
        )
        if over is not None:
            self._plans.let_go(over.checked.shown)
        return self._publish(Proposal(self.new_id(), 1, title, checked, author, author))

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
        return self._changed(self.find(id), by, state=ProposalState.APPROVED, motion=motion, reason="")

    def ended(self, proposal: Proposal, motion: Motion | None) -> None:
        """Take note of the end of the motion that a proposal was approved with; None: it is remembered no more."""
        if motion is not None and motion.phase is Phase.SUCCEEDED:
            self._changed(proposal, proposal.changed_by, state=ProposalState.EXECUTED)
            return
        why = None if motion is None else motion.cancellation
        reason = "how its motion ended is not known any more" if why is None else why.reason
        self._changed(proposal, proposal.changed_by, state=ProposalState.STOPPED, reason=reason)

    def _changed(self, proposal: Proposal, by: str, **changes: Any) -> Proposal:  # noqa: ANN401 fields of a proposal
        return self._publish(replace(proposal, revision=proposal.revision + 1, changed_by=by, **changes))

    def _publish(self, proposal: Proposal) -> Proposal:
        self._plans.hold(proposal.checked.shown)
        return self.put(proposal)
