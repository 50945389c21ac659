"""Proposals by themselves: their revisions, states, ends and limits; of plans only the name counts here."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from virtualrobot.v1 import motion_pb2
from virtualrobot_kernel.api.proposals import (
    MOST_REMEMBERED,
    MOST_UNDONE,
    Checked,
    Proposal,
    Proposals,
    ProposalState,
)
from virtualrobot_kernel.api.shelf import changes
from virtualrobot_kernel.api.shown_plans import ShownPlans
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.running_motion import Phase

AGREED = "it touches the box"


def checked(robot: str, plan: str = "") -> Checked:
    """Return a motion of a robot with a plan of that name, or with a violation."""
    spec = motion_pb2.MotionSpec(moves=[motion_pb2.Move(robot=robot)])
    check = motion_pb2.CheckMotionResponse()
    if not plan:
        check.first_violation.message = AGREED
    shown: Any = SimpleNamespace(id=plan, digest="") if plan else None
    return Checked(spec, check, shown)


def motion(phase: Phase, reason: str = "") -> Any:  # noqa: ANN401 as much of a motion as is asked
    return SimpleNamespace(phase=phase, cancellation=SimpleNamespace(reason=reason) if reason else None)


@pytest.fixture
def plans() -> ShownPlans:
    return ShownPlans()


@pytest.fixture
def proposals(plans: ShownPlans) -> Proposals:
    return Proposals(plans)


def approve(proposals: Proposals, proposal: Proposal) -> Proposal:
    with proposals.approving(proposal.id, proposal.revision) as shown:
        assert shown is proposal.checked.shown
        return proposals.approved(proposal.id, "motion-1", "op")


def refused(error: pytest.ExceptionInfo[KernelError]) -> Reason:
    return error.value.reason


def test_what_becomes_of_a_proposal(proposals: Proposals) -> None:
    told: list[object] = []
    end = proposals.subscribe(told.append)
    one = proposals.add("to the press", checked("arm", "plan-1"), "ann")
    assert (one.id, one.revision, one.state, one.author) == ("proposal-1", 1, ProposalState.PROPOSED, "ann")
    two = proposals.change(one, checked("arm", "plan-2"), "bob", title="to the press")
    assert (two.revision, two.author, two.changed_by) == (2, "ann", "bob")
    three = approve(proposals, two)
    assert (three.state, three.motion, three.changed_by) == (ProposalState.APPROVED, "motion-1", "op")
    proposals.ended(three, motion(Phase.SUCCEEDED))
    assert proposals.find(one.id).state is ProposalState.EXECUTED
    assert len(told) == 4 and told[-1] is proposals.find(one.id)
    end()
    again = proposals.change(proposals.find(one.id), checked("arm", "plan-3"), "ann", title="")
    assert again.state is ProposalState.PROPOSED and len(told) == 4
    proposals.ended(approve(proposals, again), motion(Phase.CANCELLED, "let go"))
    stopped = proposals.find(one.id)
    assert (stopped.state, stopped.reason) == (ProposalState.STOPPED, "let go")
    gone = approve(proposals, proposals.change(stopped, checked("arm", "plan-4"), "ann", title=""))
    assert gone.reason == ""
    proposals.ended(gone, None)
    assert "not known any more" in proposals.find(one.id).reason


def test_another_revision_than_was_seen_is_refused(proposals: Proposals) -> None:
    seen = proposals.add("", checked("arm", "plan-1"), "ann")
    now = proposals.change(seen, checked("arm", "plan-2"), "bob", title="")
    with pytest.raises(KernelError, match=r"has the revision 2, not 1: bob has changed it meanwhile") as stale:
        proposals.change(seen, checked("arm", "plan-3"), "ann", title="")
    assert refused(stale) is Reason.STALE_REVISION and stale.value.metadata["revision"] == "2"
    with pytest.raises(KernelError) as stale, proposals.approving(seen.id, 1):
        pass
    assert refused(stale) is Reason.STALE_REVISION
    with pytest.raises(KernelError, match="there is no proposal named 'proposal-9'; did you mean 'proposal-1'"):
        proposals.find("proposal-9")
    assert proposals.find(seen.id) is now


def test_what_is_approved_nobody_changes(proposals: Proposals) -> None:
    one = proposals.add("", checked("arm", "plan-1"), "ann")
    with proposals.approving(one.id, 1):  # while it is being started
        for attempt in (
            lambda: proposals.change(one, checked("arm", "plan-2"), "bob", title=""),
            lambda: proposals.reject(one, "", "bob"),
            lambda: proposals.approving(one.id, 1).__enter__(),
        ):
            with pytest.raises(KernelError, match="is approved, and what runs is not changed") as wrong:
                attempt()
            assert refused(wrong) is Reason.WRONG_STATE
    now = approve(proposals, one)
    with pytest.raises(KernelError, match="is approved"):
        proposals.change(now, checked("arm", "plan-2"), "bob", title="")


def test_a_start_that_is_refused_leaves_it_as_it_was(proposals: Proposals) -> None:
    one = proposals.add("", checked("arm", "plan-1"), "ann")
    with pytest.raises(ZeroDivisionError), proposals.approving(one.id, 1):
        raise ZeroDivisionError
    assert proposals.find(one.id) is one
    rejected = proposals.reject(one, "too near to the door", "bob")
    assert (rejected.state, rejected.reason) == (ProposalState.REJECTED, "too near to the door")
    with pytest.raises(KernelError, match="is rejected; propose it again"), proposals.approving(one.id, 2):
        pass
    with pytest.raises(KernelError, match="is rejected"):
        proposals.reject(rejected, "", "bob")


def test_one_without_a_plan_is_not_approved(proposals: Proposals) -> None:
    one = proposals.add("", checked("arm"), "ann")
    with pytest.raises(KernelError, match=f"can't be approved: {AGREED}; change it"), proposals.approving(one.id, 1):
        pass


def test_changes_of_the_motion_are_taken_back_one_after_the_other(proposals: Proposals) -> None:
    now = proposals.add("", checked("0", "plan-0"), "ann")
    for number in range(1, MOST_UNDONE + 3):
        now = proposals.change(now, checked(f"{number}", f"plan-{number}"), "ann", title="")
    assert len(now.before) == MOST_UNDONE
    anew = proposals.change(now, checked(now.checked.spec.moves[0].robot, "plan-x"), "ann", title="other words")
    assert anew.before == now.before, "the same motion planned anew is no change of it"
    back = proposals.change(
        anew, Checked(anew.before[-1], motion_pb2.CheckMotionResponse(), None), "ann", title="", undo=True
    )
    assert back.checked.spec.moves[0].robot == f"{MOST_UNDONE + 1}" and len(back.before) == MOST_UNDONE - 1


def test_plans_of_proposals_are_held(proposals: Proposals, plans: ShownPlans) -> None:
    def is_known(plan: str) -> bool:
        try:
            plans.find(motion_pb2.PlanReference(id=plan))
        except KernelError:
            return False
        return True

    one = proposals.add("", checked("arm", "plan-1"), "ann")
    assert is_known("plan-1")
    proposals.change(one, checked("arm", "plan-2"), "ann", title="")
    assert is_known("plan-2") and not is_known("plan-1")


def test_those_that_are_over_are_forgotten_first(proposals: Proposals) -> None:
    made = [proposals.add("", checked("arm", f"plan-{number}"), "ann") for number in range(MOST_REMEMBERED)]
    with pytest.raises(KernelError, match="wait to be approved or rejected, and no more are kept") as full:
        proposals.add("", checked("arm"), "ann")
    assert refused(full) is Reason.WRONG_STATE
    told = proposals.all
    proposals.reject(made[3], "", "bob")
    new = proposals.add("", checked("arm"), "ann")
    assert new.id == f"proposal-{MOST_REMEMBERED + 1}" and len(proposals.all) == MOST_REMEMBERED
    assert changes(told, proposals.all) == ([new], [made[3].id])
    assert changes((), told) == (told, [])
