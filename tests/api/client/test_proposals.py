"""Proposals from the client library, from tasks of asyncio, and from the command line."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
import virtualrobot.aio
from virtualrobot import Client, Phase, Robot

from tests.api.client.conftest import Run
from tests.kernels import KernelProcess
from tests.waiting import until

TURN = {"lbr_iiwa_joint_1": 0.3}
BACK = {"lbr_iiwa_joint_1": 0.0}


def test_a_motion_is_proposed_changed_looked_at_and_approved(client: Client, iiwa: Robot) -> None:
    proposals = client.proposals
    made = proposals.create([iiwa.ptp(TURN)], title="to the press")
    assert (made.revision, made.title, made.state, made.robots) == (1, "to the press", "proposed", ("iiwa",))
    assert made.check.ok and made.id in [one.id for one in proposals.list()] and made.id in repr(proposals)
    with proposals.watch() as watch:
        changes = iter(watch)
        assert made.id in [one.id for one in next(changes).proposals]
        changed = proposals.update(made, client.program().move(iiwa.ptp({"lbr_iiwa_joint_1": 0.2})).dwell(0.1))
        (told,) = next(found for change in changes if (found := [p for p in change.proposals if p.id == made.id]))
        assert (told.revision, told.undo_count) == (2, 1)
    assert len(proposals.program(changed)) == 2
    with pytest.raises(virtualrobot.StaleRevisionError, match=f"'{made.id}' has the revision 2, not 1"):
        proposals.approve(made)
    back = proposals.undo(changed)
    plan = proposals.plan(back)
    assert plan.duration == back.check.duration and plan.reference == back.check.reference
    motion = proposals.approve(back)
    assert motion.phase is Phase.SUCCEEDED
    assert iiwa.positions[0] == plan.robots["iiwa"].positions[-1, 0] == 0.3
    until(lambda: proposals.get(made.id).state == "executed")
    assert proposals.get(made.id).motion_id == motion.id
    rejected = proposals.reject(proposals.update(made.id, [iiwa.ptp(BACK)]), "not now")
    assert (rejected.state, rejected.reason) == ("rejected", "not now")
    with pytest.raises(virtualrobot.WrongStateError, match="is rejected; propose it again"):
        proposals.approve(rejected)
    far = proposals.create([iiwa.ptp({"lbr_iiwa_joint_1": 9.0})])
    assert not far.check.ok and far.robots == ()
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"is not to be started: .*leaves its range"):
        proposals.plan(far)
    with pytest.raises(virtualrobot.UnknownNameError, match="no proposal named 'proposal-0'"):
        proposals.get("proposal-0")
    with pytest.raises(virtualrobot.InvalidArgumentError, match="there is nothing to do"):
        proposals.create([])


def test_tasks_propose_and_approve(kernel: KernelProcess, client: Client, iiwa: Robot) -> None:
    async def day() -> str:
        async with virtualrobot.aio.connect(kernel.address) as other:
            arm = await other.robot("iiwa")
            made = await other.proposals.create([await arm.ptp(TURN)])
            async with other.proposals.watch() as watch:
                motion = await other.proposals.approve(made, wait=False)
                async for change in watch:
                    if any(one.id == made.id and one.state == "executed" for one in change.proposals):
                        break
            assert (await motion.phase) is Phase.SUCCEEDED
            return made.id

    made = asyncio.run(day())
    assert client.proposals.get(made).state == "executed"
    np.testing.assert_allclose(iiwa.positions[0], 0.3, atol=1e-12)


def test_proposals_on_the_command_line(run: Run, client: Client, iiwa: Robot, tmp_path: Path) -> None:
    line = run("proposal", "create", "iiwa", "lbr_iiwa_joint_1=0.3", "--title", "to the press")
    id = line.partition(",")[0]
    assert f"{id}, revision 1 (to the press), is proposed: takes " in line and "touches nothing" in line
    assert "revision 2" in run("proposal", "change", id, "iiwa", "lbr_iiwa_joint_1=9")
    told = run("proposal", "show", id)
    assert "leaves its range" in told and '"lbr_iiwa_joint_1": 9' in told and "made by " in told
    assert "can't be approved: the joint 'lbr_iiwa_joint_1'" in run("proposal", "approve", id, "2", code=1)
    assert "revision 3" in run("proposal", "undo", id)
    assert "revision 4" in run("proposal", "renew", id)
    assert "has the revision 4, not 3" in run("proposal", "approve", id, "3", code=1)
    assert run("proposal", "approve", id, "4").endswith("reached its goal\n")
    np.testing.assert_allclose(iiwa.positions[0], 0.3, atol=1e-12)
    until(lambda: f"{id}" in run("proposal", "list") and "executed" in run("proposal", "list"))
    file = tmp_path / "program.yaml"
    file.write_text("schema_version: 1\nsteps:\n  - dwell: {seconds: 0.1}\n")
    second = run("proposal", "program", str(file)).partition(",")[0]
    assert "is rejected" in run("proposal", "reject", second, "--reason", "not now")
    assert "because: not now" in run("proposal", "show", second)
    assert "no proposal named 'proposal-0'" in run("proposal", "show", "proposal-0", code=1)
    assert "--hold needs a terminal" in run("proposal", "approve", id, "5", "--hold", code=2)
