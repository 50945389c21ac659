"""Proposals over rosbridge, with roslibpy: proposed, changed, looked at, approved and stopped by a program of ROS."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import roslibpy
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.proposals import TOLD, TYPE

from tests.api.client.conftest import IIWA
from tests.apps.ros.bridges import Heard, bridge, roslibpy_client
from tests.waiting import until

pytestmark = pytest.mark.long


def asked(ros: roslibpy.Ros, name: str, base: str, **values: object) -> dict[str, Any]:
    """Return the answer of a service of proposals."""
    called = roslibpy.Service(ros, f"/virtualrobot/{name}", f"virtualrobot_msgs/{base}")
    answer: Any = called.call(roslibpy.ServiceRequest(values), timeout=120)
    return dict(answer)


def goal(angle: float) -> dict[str, object]:
    return {"robot": "arm", "joints": {"name": ["lbr_iiwa_joint_1"], "position": [angle]}}


def test_a_program_proposes_changes_and_approves_and_others_see_it(client: Client) -> None:
    arm = client.load_robot(IIWA, name="arm")
    with bridge(client) as (url, _), roslibpy_client(url) as ros:
        heard = Heard(ros, TOLD, TYPE)
        made = asked(ros, "create_proposal", "CreateProposal", goals=[goal(0.3)], title="to the press")
        assert made["success"], made
        id = made["proposal"]["id"]
        assert (made["proposal"]["ok"], made["proposal"]["robots"]) == (True, ["arm"])
        seen = client.proposals.get(id)
        assert (seen.title, seen.revision, seen.state) == ("to the press", 1, "proposed")

        client.proposals.update(seen, [arm.ptp({"lbr_iiwa_joint_1": 0.2})])  # somebody at another client
        told = heard.until(lambda one: any(p["id"] == id and p["revision"] == 2 for p in one["proposals"]))
        (last,) = (one for one in told[-1]["proposals"] if one["id"] == id)
        assert (last["undo_count"], last["state"]) == (1, "proposed")
        stale = asked(ros, "approve_proposal", "ApproveProposal", id=id, revision=1)
        assert not stale["success"] and "has the revision 2, not 1" in stale["message"]
        unseen = asked(ros, "approve_proposal", "ApproveProposal", id=id)
        assert not unseen["success"] and "'revision'" in unseen["message"]
        changed = asked(ros, "update_proposal", "UpdateProposal", id=id, revision=2, goals=[goal(0.2), goal(0.5)])
        assert changed["proposal"]["undo_count"] == 2 and len(client.proposals.program(id)) == 2
        back = asked(ros, "undo_proposal", "UndoProposal", id=id, revision=3)
        assert back["proposal"]["revision"] == 4

        plan = asked(ros, "get_proposal_plan", "GetProposalPlan", id=id, sample_seconds=0.1)
        own = client.proposals.plan(client.proposals.get(id), sample_time=0.1)
        (trajectory,) = plan["trajectories"]
        points = np.array([one["positions"] for one in trajectory["points"]])
        np.testing.assert_array_equal(points, own.robots["arm"].positions)
        assert (plan["revision"], trajectory["joint_names"]) == (4, list(own.robots["arm"].joint_names))

        approved = asked(ros, "approve_proposal", "ApproveProposal", id=id, revision=4)
        assert approved["success"] and approved["motion"] == client.proposals.get(id).motion_id
        until(lambda: client.proposals.get(id).state == "executed")
        assert arm.positions[0] == own.robots["arm"].positions[-1, 0] == 0.2
        over = asked(ros, "stop_proposal", "StopProposal", id=id)
        assert not over["success"] and "no motion of" in over["message"]

        again = asked(ros, "update_proposal", "UpdateProposal", id=id, goals=[{**goal(2.0), "speed_factor": 0.01}])
        asked(ros, "approve_proposal", "ApproveProposal", id=id, revision=again["proposal"]["revision"])
        assert asked(ros, "stop_proposal", "StopProposal", id=id, reason="a hand in the cell")["success"]
        until(lambda: client.proposals.get(id).state == "stopped")
        assert client.proposals.get(id).reason == "a hand in the cell"
        rejected = asked(ros, "reject_proposal", "RejectProposal", id=id, reason="not now")
        assert not rejected["success"] and "is stopped; propose it again" in rejected["message"]


def test_goals_that_are_none_are_refused(client: Client) -> None:
    client.load_robot(IIWA, name="arm")
    with bridge(client) as (url, _), roslibpy_client(url) as ros:

        def refused(**given: object) -> str:
            told = asked(ros, "create_proposal", "CreateProposal", goals=[{"robot": "arm", **given}])
            assert not told["success"], told
            return told["message"]

        assert "'joints' have a position for each name" in refused(joints={"name": ["a", "b"], "position": [0.1]})
        assert "point to point" in refused(joints={"name": ["lbr_iiwa_joint_1"], "position": [0.1]}, linear=True)
        assert "there is no frame 'nowhere'" in refused(pose={"header": {"frame_id": "nowhere"}})
        turned = {"orientation": {"w": 2.0}}
        assert "a quaternion of the length 1" in refused(pose={"header": {"frame_id": "world"}, "pose": turned})
        assert "'arn'" in refused(robot="arn")
        far = {"header": {"frame_id": "arm/lbr_iiwa_link_0"}, "pose": {"position": {"x": 9.0}}}
        found = asked(ros, "create_proposal", "CreateProposal", goals=[{"robot": "arm", "pose": far}])
        assert found["success"] and not found["proposal"]["ok"] and "cannot reach" in found["proposal"]["violation"]
        empty = asked(ros, "create_proposal", "CreateProposal")
        assert not empty["success"] and "there is nothing to do" in empty["message"]
