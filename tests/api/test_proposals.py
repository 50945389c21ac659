"""Proposals over TCP: seen by all, changed, taken back, rejected, and started as they were seen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import grpc
import numpy as np
import pytest
from virtualrobot.v1 import (
    geometry_pb2,
    lease_pb2,
    motion_pb2,
    nodes_pb2,
    proposal_pb2,
    scene_pb2,
    signal_pb2,
    token_pb2,
)

from tests.api.asking import IIWA, Refusal, apply, box, create, joints, load, refusal
from tests.api.moving import RUNNING, finished, motion
from tests.api.reading import state, step, values
from tests.kernels import EMPTY_SCENE, StartKernel, Stubs
from tests.waiting import until

CONTINUE = motion_pb2.DISCONNECT_POLICY_CONTINUE
PROPOSED, APPROVED = proposal_pb2.PROPOSAL_STATE_PROPOSED, proposal_pb2.PROPOSAL_STATE_APPROVED
EXECUTED, STOPPED = proposal_pb2.PROPOSAL_STATE_EXECUTED, proposal_pb2.PROPOSAL_STATE_STOPPED
REJECTED = proposal_pb2.PROPOSAL_STATE_REJECTED


@pytest.fixture
def cell(stepped: Stubs) -> Stubs:
    """Return a kernel with an arm, and one that can be reached by a second client."""
    load(stepped, IIWA, "arm")
    return stepped


def turn(angle: float, robot: str = "arm") -> motion_pb2.MotionSpec:
    return motion_pb2.MotionSpec(moves=[joints(robot, lbr_iiwa_joint_1=angle)])


def propose(stubs: Stubs, spec: motion_pb2.MotionSpec, title: str = "") -> proposal_pb2.Proposal:
    request = proposal_pb2.CreateProposalRequest(spec=spec, title=title)
    return stubs.proposal.CreateProposal(request).proposal


def update(stubs: Stubs, id: str, revision: int | None = None, **fields: object) -> proposal_pb2.Proposal:
    request = proposal_pb2.UpdateProposalRequest(id=id, expected_revision=revision, **fields)  # pyright: ignore[reportArgumentType]
    return stubs.proposal.UpdateProposal(request).proposal


def undo(stubs: Stubs, id: str) -> proposal_pb2.Proposal:
    return stubs.proposal.UndoProposal(proposal_pb2.UndoProposalRequest(id=id)).proposal


def reject(stubs: Stubs, id: str, reason: str = "") -> proposal_pb2.Proposal:
    return stubs.proposal.RejectProposal(proposal_pb2.RejectProposalRequest(id=id, reason=reason)).proposal


def approve(stubs: Stubs, seen: proposal_pb2.Proposal, **fields: object) -> motion_pb2.Motion:
    reference = motion_pb2.ProposalReference(id=seen.id, revision=seen.revision)
    request = motion_pb2.StartMotionRequest(proposal=reference, on_disconnect=CONTINUE, **fields)  # pyright: ignore[reportArgumentType]
    return stubs.motion.StartMotion(request).motion


def now(stubs: Stubs, id: str) -> proposal_pb2.Proposal:
    (found,) = stubs.proposal.ListProposals(proposal_pb2.ListProposalsRequest(ids=[id])).proposals
    return found


def test_what_was_seen_is_what_runs(cell: Stubs) -> None:
    """Whoever looks at it, by a client of its own, sees the very samples that the arm goes through, bit for bit."""
    spec = motion_pb2.MotionSpec(moves=[joints("arm", **{f"lbr_iiwa_joint_{one}": 0.1 * one for one in range(1, 8)})])
    made = propose(cell, spec, "to the press")
    assert (made.revision, made.title, made.state, list(made.robots)) == (1, "to the press", PROPOSED, ["arm"])
    assert made.spec == spec and made.author == made.changed_by != ""
    assert made.check.duration_seconds > 0.0 and not made.check.HasField("first_violation")
    assert now(cell, made.id) == made
    shown = cell.motion.PlanMotion(motion_pb2.PlanMotionRequest(plan=made.check.plan))
    assert shown.plan == made.check.plan and shown.duration_seconds == made.check.duration_seconds
    started = approve(cell, made)
    approved = now(cell, made.id)
    assert (approved.state, approved.revision, approved.motion_id) == (APPROVED, 2, started.id)
    (told,) = shown.robots
    for positions, velocities in zip(values(told.positions), values(told.velocities), strict=True):
        here = state(cell, "arm")
        np.testing.assert_array_equal(here.positions, positions)
        np.testing.assert_array_equal(here.velocities, velocities)
        step(cell)
    until(lambda: now(cell, made.id).state == EXECUTED)
    assert now(cell, made.id).reason == ""


def test_all_who_watch_are_told(cell: Stubs) -> None:
    made = propose(cell, turn(0.5))
    watches = [cell.proposal.WatchProposals(proposal_pb2.WatchProposalsRequest()) for _ in range(2)]
    for watch in watches:
        assert made in next(watch).proposals
    changed = update(cell, made.id, 1, spec=turn(0.6))
    rejected = reject(cell, made.id, "too near to the door")
    for watch in watches:
        told = [made]
        while told[-1] != rejected:  # the newest counts
            told += [one for one in next(watch).proposals if one.id == made.id]
        assert [one.revision for one in told] in ([1, 2, 3], [1, 3])
        watch.cancel()
    assert (changed.revision, changed.spec, changed.undo_count) == (2, turn(0.6), 1)
    assert (rejected.state, rejected.reason) == (REJECTED, "too near to the door")


def test_changes_are_taken_back(cell: Stubs) -> None:
    made = propose(cell, turn(0.5))
    update(cell, made.id, spec=turn(0.6), title="other words")
    anew = update(cell, made.id)
    assert (anew.spec, anew.title, anew.undo_count) == (turn(0.6), "other words", 1)
    assert anew.check.plan.id != made.check.plan.id
    back = undo(cell, made.id)
    assert (back.spec, back.undo_count, back.revision) == (turn(0.5), 0, 4)
    assert back.check.plan.digest == made.check.plan.digest, "the same motion on the same world"
    told = refusal(lambda: undo(cell, made.id))
    assert told.reason == "WRONG_STATE" and "no change of its motion" in told.message


def test_what_violates_something_is_proposed_and_not_approved(cell: Stubs) -> None:
    apply(cell, create(box("in the way", x=0.35, y=0.25, z=0.6)))
    apply(
        cell,
        scene_pb2.Command(
            set_joint_positions=scene_pb2.SetJointPositions(
                robot="arm", joint_positions={"lbr_iiwa_joint_2": 0.6, "lbr_iiwa_joint_4": -1.4}
            )
        ),
    )
    made = propose(cell, turn(1.2))
    assert made.check.first_violation.second == "in the way", made.check
    assert not made.check.HasField("plan") and not made.robots
    told = refusal(lambda: approve(cell, made))
    assert told.reason == "WRONG_STATE" and made.check.first_violation.message in told.message
    far = propose(cell, turn(-9.0))
    assert far.check.first_violation.joint == "lbr_iiwa_joint_1"


def test_the_end_of_its_motion_is_told(cell: Stubs) -> None:
    made = propose(cell, turn(0.5))
    started = approve(cell, made)
    step(cell, 5)
    assert motion(cell, started.id).phase == RUNNING
    for attempt in (lambda: update(cell, made.id), lambda: undo(cell, made.id), lambda: reject(cell, made.id)):
        told = refusal(attempt)
        assert told.reason == "WRONG_STATE" and "what runs is not changed" in told.message
    cell.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=started.id, reason="a hand in the cell"))
    finished(cell, started.id)
    until(lambda: now(cell, made.id).state == STOPPED)
    assert now(cell, made.id).reason == "a hand in the cell"
    again = update(cell, made.id)
    assert (again.state, again.motion_id) == (PROPOSED, started.id)
    finished(cell, approve(cell, again).id)
    until(lambda: now(cell, made.id).state == EXECUTED)
    assert state(cell, "arm").positions[0] == 0.5


def test_a_stale_proposal_is_refused(cell: Stubs) -> None:
    made = propose(cell, turn(0.5))
    update(cell, made.id, title="another one")
    for attempt in (lambda: approve(cell, made), lambda: update(cell, made.id, 1)):
        told = refusal(attempt)
        assert (told.reason, told.metadata["revision"]) == ("STALE_REVISION", "2"), told
    apply(
        cell,
        scene_pb2.Command(
            set_joint_positions=scene_pb2.SetJointPositions(robot="arm", joint_positions={"lbr_iiwa_joint_1": 0.1})
        ),
    )
    told = refusal(lambda: approve(cell, now(cell, made.id)))
    assert told.reason == "PLAN_OUTDATED" and "stands at 0.1, not at 0" in told.message
    assert now(cell, made.id).state == PROPOSED
    finished(cell, approve(cell, update(cell, made.id)).id)


def test_it_is_held_as_any_motion(cell: Stubs) -> None:
    started = approve(cell, propose(cell, turn(0.5)), hold=True)
    step(cell, 20)
    assert motion(cell, started.id).phase == motion_pb2.MOTION_PHASE_PAUSED and not state(cell, "arm").positions[0]


def test_what_makes_no_proposal_is_refused(cell: Stubs) -> None:
    def field(call: Callable[[], object]) -> str:
        told = refusal(call)
        assert told.reason == "INVALID_ARGUMENT", told
        return told.metadata["field"]

    made = propose(cell, turn(0.5))
    assert field(lambda: propose(cell, motion_pb2.MotionSpec())) == "spec"
    assert field(lambda: propose(cell, turn(0.5), "x" * 201)) == "title"
    assert field(lambda: propose(cell, turn(0.5), "two\nlines")) == "title"
    assert field(lambda: reject(cell, made.id, "x" * 201)) == "reason"
    assert field(lambda: approve(cell, made, spec=turn(0.5))) == "spec"
    assert field(lambda: approve(cell, made, plan=made.check.plan)) == "plan"
    assert field(lambda: approve(cell, made, open=True)) == "open"
    ready = signal_pb2.Signal(name="ready")
    ready.value.boolean = True
    apply(cell, scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=ready)))
    condition = motion_pb2.SignalCondition(signal="ready")
    condition.value.boolean = True
    then = [motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=turn(0.1).moves))]
    decision = motion_pb2.ProgramStep(if_signal=motion_pb2.IfStep(condition=condition, then=then))
    assert field(lambda: propose(cell, motion_pb2.MotionSpec(steps=[decision]))) == "spec"
    large = motion_pb2.MotionSpec(steps=[motion_pb2.ProgramStep(dwell=motion_pb2.DwellStep(seconds=0.1))] * 6000)
    told = refusal(lambda: propose(cell, large))
    assert (told.reason, told.metadata["most"]) == ("TOO_LARGE", "65536")
    assert refusal(lambda: propose(cell, turn(0.5, "arn"))).reason == "UNKNOWN_NAME"
    assert refusal(lambda: now(cell, "proposal-999")).reason == "UNKNOWN_NAME"
    missing = motion_pb2.StartMotionRequest(proposal=motion_pb2.ProposalReference(id="proposal-999", revision=1))
    assert refusal(lambda: cell.motion.StartMotion(missing)).metadata["kind"] == "proposal"


def test_a_leased_robot_is_proposed_by_anyone_and_approved_by_its_lease(cell: Stubs) -> None:
    lease = cell.lease.AcquireLease(lease_pb2.AcquireLeaseRequest(robots=["arm"], owner="ann"))
    keeping = cell.lease.KeepLeaseAlive(lease_pb2.KeepLeaseAliveRequest(token=lease.token))
    next(keeping)
    made = propose(cell, turn(0.5))
    assert refusal(lambda: approve(cell, made)).reason == "LEASED"
    assert now(cell, made.id).state == PROPOSED
    reference = motion_pb2.ProposalReference(id=made.id, revision=made.revision)
    request = motion_pb2.StartMotionRequest(proposal=reference, on_disconnect=CONTINUE)
    started = cell.motion.StartMotion(request, metadata=[("virtualrobot-lease", lease.token)]).motion
    assert now(cell, made.id).motion_id == started.id
    cell.lease.ReleaseLease(lease_pb2.ReleaseLeaseRequest(token=lease.token))
    keeping.cancel()


@pytest.mark.long
def test_an_observer_looks_an_operator_approves_with_a_lease_and_an_engineer_changes_the_cell(
    start_kernel: StartKernel,
) -> None:
    kernel = start_kernel(token=True)
    admin = kernel.stubs()
    admin.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
    load(admin, IIWA, "arm")

    def given(role: str) -> Stubs:
        request = token_pb2.CreateTokenRequest(name=role, role=f"ROLE_{role.upper()}")
        return replace(kernel, token=admin.token.CreateToken(request).secret).stubs()

    observer, operator, engineer = given("observer"), given("operator"), given("engineer")
    made = propose(operator, turn(0.5))
    assert made.author.startswith("operator with ")

    def too_low(call: Callable[[], object]) -> Refusal:
        told = refusal(call)
        assert (told.code, told.reason) == (grpc.StatusCode.PERMISSION_DENIED, "ROLE_TOO_LOW"), told
        return told

    assert now(observer, made.id) == made
    assert observer.motion.PlanMotion(motion_pb2.PlanMotionRequest(plan=made.check.plan)).plan == made.check.plan
    assert next(observer.proposal.WatchProposals(proposal_pb2.WatchProposalsRequest())).proposals == [made]
    for call in (
        lambda: propose(observer, turn(0.5)),
        lambda: update(observer, made.id),
        lambda: undo(observer, made.id),
        lambda: reject(observer, made.id),
        lambda: approve(observer, made),
    ):
        too_low(call)
    too_low(lambda: apply(operator, create(box("box", x=3.0))))
    apply(
        engineer,
        create(nodes_pb2.Node(name="table", object=nodes_pb2.SceneObject(), parent_t_node=geometry_pb2.Pose())),
    )
    # Steps are those of who starts them, whoever has asked for the plan.
    attach = motion_pb2.ProgramStep(attach=scene_pb2.AttachNode(name="table", parent="arm"))
    changing = propose(operator, motion_pb2.MotionSpec(steps=[attach]))
    for call in (
        lambda: approve(operator, changing),
        lambda: operator.motion.StartMotion(motion_pb2.StartMotionRequest(plan=changing.check.plan)),
    ):
        assert "the command 'attach' needs the role 'engineer'" in too_low(call).message
    assert now(operator, changing.id).state == PROPOSED
    approve(engineer, changing)
    assert "is free: lease it" in too_low(lambda: approve(operator, made)).message
    lease = operator.lease.AcquireLease(lease_pb2.AcquireLeaseRequest(robots=["arm"]))
    keeping = operator.lease.KeepLeaseAlive(lease_pb2.KeepLeaseAliveRequest(token=lease.token))
    next(keeping)
    reference = motion_pb2.ProposalReference(id=made.id, revision=made.revision)
    request = motion_pb2.StartMotionRequest(proposal=reference, on_disconnect=CONTINUE)
    started = operator.motion.StartMotion(request, metadata=[("virtualrobot-lease", lease.token)]).motion
    assert now(engineer, made.id).motion_id == started.id
    keeping.cancel()
