"""Proposals: motions that several people see, change and approve before anything moves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Unpack

from virtualrobot._wire.arguments import Text, checked
from virtualrobot._wire.messages import Stamp, stamp_of, words_of
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import listed, shown, told
from virtualrobot.motions import plans
from virtualrobot.motions.motion import Motion, StartOptions, check_not_empty, start_request
from virtualrobot.motions.moves import Move, messages_of
from virtualrobot.motions.plans import MotionCheck, MotionPlan, PlanOptions
from virtualrobot.motions.program import Program
from virtualrobot.v1 import motion_pb2, proposal_pb2

STATES = words_of(proposal_pb2.ProposalState, "PROPOSAL_STATE_")


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A proposal as it was at one revision.

    Attributes:
        id: its name, never used again.
        revision: from 1, one more with each change.
        title: its purpose in words.
        state: `proposed`, `approved` while its motion runs, then `executed` or `stopped`; or `rejected`.
        check: what its check has found; only one that is `ok` can be approved.
        robots: the robots that its plan moves; none without a plan.
        author: who made it.
        changed_by: who changed, approved or rejected it last.
        motion_id: the motion that was started when it was approved last; empty before.
        reason: why it was rejected, or why its motion ended before its goal.
        undo_count: how many changes of its motion can be taken back.
    """

    id: str
    revision: int
    title: str
    state: str
    check: MotionCheck
    robots: tuple[str, ...]
    author: str
    changed_by: str
    motion_id: str
    reason: str
    undo_count: int

    @staticmethod
    def of(message: proposal_pb2.Proposal) -> Proposal:
        """Return what a message tells."""
        return Proposal(
            message.id,
            message.revision,
            message.title,
            STATES[message.state],
            MotionCheck.of(message.check),
            tuple(message.robots),
            message.author,
            message.changed_by,
            message.motion_id,
            message.reason,
            message.undo_count,
        )


@shown
@dataclass(frozen=True, slots=True, eq=False)
class ProposalChange:
    """Proposals that are new or have changed, at one instant.

    Attributes:
        stamp: the instant.
        proposals: they, oldest first.
        removed: the names of those that the kernel has forgotten.
    """

    stamp: Stamp
    proposals: tuple[Proposal, ...]
    removed: tuple[str, ...]


class ProposalWatch:
    """Changes of proposals as they come, until it is closed, which any thread may do."""

    def __init__(self, services: Services) -> None:
        """Watch all."""
        self._stream = services.proposal.WatchProposals(proposal_pb2.WatchProposalsRequest())

    def __iter__(self) -> Iterator[ProposalChange]:
        """Yield all proposals, then those that change; of one that changes quickly the newest alone."""
        for response in self._stream:
            proposals = tuple(map(Proposal.of, response.proposals))
            yield ProposalChange(stamp_of(response.stamp), proposals, tuple(response.removed_ids))

    def close(self) -> None:
        """End it; whoever waits for a change comes to the end."""
        self._stream.cancel()

    def __enter__(self) -> ProposalWatch:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()


@checked
class Proposals:
    """The proposals of one kernel, which all of its clients share.

    Whoever changes, approves or rejects one names it as it was seen, a `Proposal`; it is refused by
    StaleRevisionError where somebody has changed it meanwhile. Of an operator it needs no lease, but approving does.

    Example:
        >>> proposal = client.proposals.create([arm.linear(goal)], title="to the press")
        >>> proposal.check.ok, proposal.check.duration
        (True, 2.31)
        >>> client.proposals.approve(proposal)
    """

    def __init__(self, services: Services) -> None:
        """Handle the proposals of one kernel."""
        self._services = services

    def list(self) -> list[Proposal]:
        """Return the proposals that the kernel remembers, oldest first: 50 at most, until it ends."""
        return self._read(())

    def get(self, id: str) -> Proposal:
        """Return a proposal as it is now.

        Raises:
            UnknownNameError: when there is none of this name.
        """
        return self._read((id,))[0]

    def create(self, what: Program | Iterable[Move], title: Text = "") -> Proposal:
        """Plan and check a program, or moves that go together, and propose it. Nothing moves.

        One that violates something is a proposal, too: `check.first_violation` tells what.

        Args:
            what: the motion.
            title: its purpose, one line of up to 200 characters.

        Raises:
            InvalidArgumentError: for a program with steps that are planned when they are reached.
            TooLargeError: for more than 64 KiB.
            RoleTooLowError: for observers.
        """
        request = proposal_pb2.CreateProposalRequest(spec=_spec(what), title=title)
        return Proposal.of(self._services.proposal.CreateProposal(request, timeout=LONG_TIMEOUT_SECONDS).proposal)

    def update(
        self, seen: Proposal | str, what: Program | Iterable[Move] | None = None, *, title: Text | None = None
    ) -> Proposal:
        """Give a proposal another motion or title, plan and check it anew, and return it; it is `proposed` again.

        Args:
            seen: the proposal as it was seen, or its name: then whatever it is by now.
            what: the motion; None: the same, planned on the world as it is.
            title: its purpose; None: the same.

        Raises:
            StaleRevisionError: when it is not the one any more that was seen.
            WrongStateError: while its motion runs.
        """
        id, revision = _named(seen)
        spec = None if what is None else _spec(what)
        request = proposal_pb2.UpdateProposalRequest(id=id, expected_revision=revision, spec=spec, title=title)
        return Proposal.of(self._services.proposal.UpdateProposal(request, timeout=LONG_TIMEOUT_SECONDS).proposal)

    def undo(self, seen: Proposal | str) -> Proposal:
        """Take back the last change of its motion, plan and check that of before, and return it.

        Raises as `update` does, and WrongStateError where there is none.
        """
        id, revision = _named(seen)
        request = proposal_pb2.UndoProposalRequest(id=id, expected_revision=revision)
        return Proposal.of(self._services.proposal.UndoProposal(request, timeout=LONG_TIMEOUT_SECONDS).proposal)

    def reject(self, seen: Proposal | str, reason: Text = "") -> Proposal:
        """Turn a proposal down, for a reason of one line, and return it; errors as of `update`."""
        id, revision = _named(seen)
        request = proposal_pb2.RejectProposalRequest(id=id, expected_revision=revision, reason=reason)
        return Proposal.of(self._services.proposal.RejectProposal(request).proposal)

    def approve(self, seen: Proposal, **options: Unpack[StartOptions]) -> Motion:
        """Start the very plan of a proposal that was seen, and return its motion.

        With `hold` it stands and runs only while it is held: `Motion.held`.

        Raises:
            StaleRevisionError: when somebody has changed it meanwhile.
            PlanOutdatedError: when its path would be another one now, or touch something; `update` plans it anew.
            WrongStateError: when it is rejected, approved or over, or can't be done at all.
            LeasedError, RoleTooLowError: as of any start.
        """
        reference = motion_pb2.ProposalReference(id=seen.id, revision=seen.revision)
        return start_request(self._services, motion_pb2.StartMotionRequest(proposal=reference), **options)

    def plan(self, seen: Proposal, **options: Unpack[PlanOptions]) -> MotionPlan:
        """Return the plan of a proposal in samples, as it would run; see `Client.plan`. Nothing is planned again.

        Raises:
            InvalidArgumentError: for one without a plan.
        """
        return plans.plan_shown(self._services, seen.check, **options)

    def program(self, seen: Proposal | str) -> Program:
        """Return the motion of a proposal as it is now, to be looked at, or changed and given to `update`."""
        id, _ = _named(seen)
        response = self._services.proposal.ListProposals(proposal_pb2.ListProposalsRequest(ids=[id]))
        return Program(self._services, response.proposals[0].spec)

    def watch(self) -> ProposalWatch:
        """Return a watch of all proposals, a context manager.

        Example:
            >>> with client.proposals.watch() as watch:
            ...     for change in watch:
            ...         print([(one.id, one.state) for one in change.proposals])
        """
        return ProposalWatch(self._services)

    def _read(self, ids: Iterable[str]) -> list[Proposal]:
        response = self._services.proposal.ListProposals(proposal_pb2.ListProposalsRequest(ids=ids))
        return [Proposal.of(message) for message in response.proposals]

    def __repr__(self) -> str:
        """Return names and states."""
        return told("Proposals", lambda: listed((f"{one.id} {one.state}" for one in self.list()), "none yet"))


def _spec(what: Program | Iterable[Move]) -> motion_pb2.MotionSpec:
    """Return the motion that is proposed; raise InvalidArgumentError for nothing."""
    spec = what._spec if isinstance(what, Program) else motion_pb2.MotionSpec(moves=messages_of(what))
    check_not_empty(spec)
    return spec


def _named(seen: Proposal | str) -> tuple[str, int | None]:
    """Return the name of a proposal, and the revision that is expected."""
    return (seen, None) if isinstance(seen, str) else (seen.id, seen.revision)
