"""ProposalService: motions that several clients see, change, and approve or reject."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import aclosing

from virtualrobot.v1 import motion_pb2, proposal_pb2, proposal_pb2_grpc

from virtualrobot_kernel.api.author import person
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.motion_plans import checked_motion
from virtualrobot_kernel.api.proposals import LARGEST_BYTES, Checked, Proposal, ProposalState
from virtualrobot_kernel.api.shelf import line_of, seen_revision
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.messages.values import stamp

STATES = EnumTable(ProposalState, proposal_pb2.ProposalState)


class ProposalServicer(proposal_pb2_grpc.ProposalServiceServicer):
    """Servicer of ProposalService; what is approved MotionService starts."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel, self._proposals = kernel, kernel.proposals

    async def ListProposals(
        self, request: proposal_pb2.ListProposalsRequest, context: object
    ) -> proposal_pb2.ListProposalsResponse:
        """Tell proposals as they are."""
        chosen = [self._proposals.find(id) for id in request.ids] if request.ids else self._proposals.all
        now = stamp(self._kernel.world.snapshot)
        return proposal_pb2.ListProposalsResponse(stamp=now, proposals=map(_message, chosen))

    async def WatchProposals(
        self, request: proposal_pb2.WatchProposalsRequest, context: object
    ) -> AsyncIterator[proposal_pb2.WatchProposalsResponse]:
        """Tell all proposals, then what changes."""
        async with aclosing(self._proposals.changes(self._kernel.publications)) as told:
            async for changed, gone in told:
                yield proposal_pb2.WatchProposalsResponse(
                    stamp=stamp(self._kernel.world.snapshot), proposals=map(_message, changed), removed_ids=gone
                )

    async def CreateProposal(
        self, request: proposal_pb2.CreateProposalRequest, context: object
    ) -> proposal_pb2.CreateProposalResponse:
        """Plan and check a motion, and make it a proposal."""
        title = line_of(request.title, "title")
        made = self._proposals.add(title, await self._checked(request.spec), person(context))
        return proposal_pb2.CreateProposalResponse(stamp=stamp(self._kernel.world.snapshot), proposal=_message(made))

    async def UpdateProposal(
        self, request: proposal_pb2.UpdateProposalRequest, context: object
    ) -> proposal_pb2.UpdateProposalResponse:
        """Give a proposal another motion or other words."""
        seen = self._proposals.find(request.id, seen_revision(request))
        self._proposals.check_open(seen)
        title = line_of(request.title, "title") if request.HasField("title") else seen.title
        checked = await self._checked(request.spec if request.HasField("spec") else seen.checked.spec)
        now = self._proposals.change(seen, checked, person(context), title=title)
        return proposal_pb2.UpdateProposalResponse(stamp=stamp(self._kernel.world.snapshot), proposal=_message(now))

    async def UndoProposal(
        self, request: proposal_pb2.UndoProposalRequest, context: object
    ) -> proposal_pb2.UndoProposalResponse:
        """Take back the last change of a proposal's motion."""
        seen = self._proposals.find(request.id, seen_revision(request))
        self._proposals.check_open(seen)
        if not seen.before:
            raise KernelError(
                f"{seen.id!r} has no change of its motion that could be taken back",
                reason=Reason.WRONG_STATE,
                proposal=seen.id,
                state=seen.state.name,
            )
        checked = await self._checked(seen.before[-1])
        now = self._proposals.change(seen, checked, person(context), title=seen.title, undo=True)
        return proposal_pb2.UndoProposalResponse(stamp=stamp(self._kernel.world.snapshot), proposal=_message(now))

    async def RejectProposal(
        self, request: proposal_pb2.RejectProposalRequest, context: object
    ) -> proposal_pb2.RejectProposalResponse:
        """Turn a proposal down."""
        seen = self._proposals.find(request.id, seen_revision(request))
        now = self._proposals.reject(seen, line_of(request.reason, "reason"), person(context))
        return proposal_pb2.RejectProposalResponse(stamp=stamp(self._kernel.world.snapshot), proposal=_message(now))

    async def _checked(self, spec: motion_pb2.MotionSpec) -> Checked:
        """Return a motion with what its check finds on the world as it is; raise KernelError for one without a plan."""
        if not spec.moves and not spec.steps:
            raise KernelError("a proposal needs a motion: give its moves, or its steps", field="spec")
        if (size := spec.ByteSize()) > LARGEST_BYTES:
            raise KernelError(
                f"a motion that is proposed has at most {LARGEST_BYTES} bytes, not {size}; propose parts of it",
                reason=Reason.TOO_LARGE,
                field="spec",
                bytes=size,
                most=LARGEST_BYTES,
            )
        check = await checked_motion(self._kernel, self._kernel.plans, motion_pb2.CheckMotionRequest(spec=spec))
        shown = self._kernel.plans.find(check.plan) if check.HasField("plan") else None
        if shown is None and not check.HasField("first_violation"):
            raise KernelError(
                "a motion along a moving frame, or with steps that are planned when they are reached, belongs to the "
                "moment, so nobody can look at its plan before; start it, or propose one without them",
                field="spec",
            )
        return Checked(spec, check, shown)


def _message(proposal: Proposal) -> proposal_pb2.Proposal:
    checked = proposal.checked
    moved = () if checked.shown is None else (robot for robot, _ in checked.shown.planned.command.joints)
    return proposal_pb2.Proposal(
        id=proposal.id,
        revision=proposal.revision,
        title=proposal.title,
        spec=checked.spec,
        check=checked.check,
        robots=dict.fromkeys(moved),
        state=STATES.write(proposal.state),
        author=proposal.author,
        changed_by=proposal.changed_by,
        motion_id=proposal.motion,
        reason=proposal.reason,
        undo_count=len(proposal.before),
    )
