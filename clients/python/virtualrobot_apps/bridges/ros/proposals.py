"""Proposals of a world: a latched topic that tells them, and services by which programs propose, change and approve."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable, Iterable
from dataclasses import replace
from functools import partial

import numpy as np
from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError
from virtualrobot.motions.motion import Motion
from virtualrobot.motions.moves import Move
from virtualrobot.motions.plans import RobotTrajectory
from virtualrobot.motions.program import Program
from virtualrobot.motions.proposals import Proposal, ProposalChange

from virtualrobot_apps.bridges.ros.following import Following
from virtualrobot_apps.bridges.ros.frames import world_t_frame
from virtualrobot_apps.bridges.ros.hub import Hub, Service, Topic
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue, header, matrix_of, time_of
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import make
from virtualrobot_apps.bridges.ros.messages.values import default

NAMESPACE = "/virtualrobot"
TOLD, TYPE = f"{NAMESPACE}/proposals", "virtualrobot_msgs/msg/Proposals"

_OPERATOR = "operator"


class ProposalServices:
    """Proposals on a hub, whose loop calls all of this; `soon` lets that loop call something from any thread."""

    def __init__(self, client: Client, hub: Hub, soon: Callable[..., None], *, bare: bool = False) -> None:
        """Serve, and tell nothing yet; `bare` as in FrameNames."""
        self._client, self._hub, self._bare = client, hub, bare
        self._known: dict[str, Proposal] = {}
        self._following = Following("proposals", client.proposals.watch, self._take, soon)
        hub.declare(Topic(TOLD, TYPE, latched=True, is_told=True))
        for name, base, answer in (
            ("create_proposal", "CreateProposal", self._create),
            ("update_proposal", "UpdateProposal", self._update),
            ("undo_proposal", "UndoProposal", self._undo),
            ("reject_proposal", "RejectProposal", self._reject),
            ("approve_proposal", "ApproveProposal", self._approve),
            ("stop_proposal", "StopProposal", self._end),
            ("get_proposal_plan", "GetProposalPlan", self._plan),
        ):
            type = f"virtualrobot_msgs/srv/{base}"
            hub.serve(Service(f"{NAMESPACE}/{name}", type, partial(self._answered, f"{type}_Response", answer)))

    def open(self) -> None:
        """Tell all proposals, and those that come later."""
        self._following.open()

    def close(self) -> None:
        """Tell no more."""
        self._following.close()
        self._known = {}

    def _take(self, change: ProposalChange, is_first: bool) -> None:
        known = {} if is_first else self._known
        known |= {one.id: one for one in change.proposals}
        self._known = {id: one for id, one in known.items() if id not in change.removed}
        time = round(change.stamp.simulation_time * 1e9)
        told = [message_of(one) for one in self._known.values()]
        self._hub.publish(TOLD, Message(TYPE, make(TYPE, header=header(time, ""), proposals=told), time))

    def _answered(
        self, type: str, answer: Callable[[RosValue], dict[str, object]], request: RosValue
    ) -> Awaitable[RosValue]:
        """Return the response: what `answer` gives, or the words of what it has raised."""

        async def made() -> RosValue:
            response = default(type)
            try:
                told = {"success": True, **await asyncio.to_thread(answer, request)}
            except (VirtualRobotError, ValueError) as error:
                told = {"success": False, "message": str(error)}
            for key, value in told.items():
                setattr(response, key, value)
            return response

        return made()

    def _create(self, asked: RosValue) -> dict[str, object]:
        return _told(self._client.proposals.create(self._motion(asked.goals), asked.title))

    def _update(self, asked: RosValue) -> dict[str, object]:
        motion = self._motion(asked.goals) if asked.goals else None
        return _told(self._client.proposals.update(self._seen(asked), motion, title=asked.title or None))

    def _undo(self, asked: RosValue) -> dict[str, object]:
        return _told(self._client.proposals.undo(self._seen(asked)))

    def _reject(self, asked: RosValue) -> dict[str, object]:
        return _told(self._client.proposals.reject(self._seen(asked), asked.reason))

    def _approve(self, asked: RosValue) -> dict[str, object]:
        """Start the plan of a proposal; the bridge watches its motion, and so it goes on as long as the bridge does."""
        client = self._client
        if not asked.revision:
            raise ValueError("'revision' is missing; give that of the proposal which was seen")
        seen = self._seen(asked)
        if client.info.role != _OPERATOR:
            motion = client.proposals.approve(seen, wait=False)
        else:
            lease = client.lease(*seen.robots, owner="a program of ROS")
            try:
                motion = client.proposals.approve(seen, wait=False)
            except BaseException:
                lease.release()
                raise
            threading.Thread(target=_released, args=(motion, lease.release), name=motion.id, daemon=True).start()
        return {**_told(client.proposals.get(asked.id)), "motion": motion.id}

    def _end(self, asked: RosValue) -> dict[str, object]:
        found = self._client.proposals.get(asked.id)
        running = [one for one in self._client.motions() if one.id == found.motion_id]
        if not running:
            raise ValueError(f"no motion of {asked.id!r} runs")
        running[0].cancel(asked.reason or "stopped by a program of ROS")
        return _told(self._client.proposals.get(asked.id))

    def _plan(self, asked: RosValue) -> dict[str, object]:
        seen = self._client.proposals.get(asked.id)
        plan = self._client.proposals.plan(seen, sample_time=asked.sample_seconds or None)
        told = [trajectory_of(one, plan.times) for one in plan.robots.values()]
        return {"trajectories": told, "revision": seen.revision}

    def _seen(self, asked: RosValue) -> Proposal:
        """Return the proposal that a request means, at the revision that was seen; without one as it is now."""
        found = self._client.proposals.get(asked.id)
        return replace(found, revision=asked.revision) if asked.revision else found

    def _motion(self, goals: Iterable[RosValue]) -> Program | list[Move]:
        """Return a move to one goal, or a program through several.

        Raises:
            ValueError: for a goal that is none.
        """
        moves = [self._move(goal) for goal in goals]
        if len(moves) == 1:
            return moves
        program = self._client.program()
        for move in moves:
            program.move(move)
        return program

    def _move(self, goal: RosValue) -> Move:
        robot, speed = self._client.robot(goal.robot), goal.speed_factor or 1.0
        if goal.joints.name:
            if goal.linear:
                raise ValueError("a goal of 'joints' is reached point to point; leave out 'linear', or give a pose")
            names, count = len(goal.joints.name), len(goal.joints.position)
            if names != count:
                raise ValueError(f"'joints' have a position for each name, and not {count} for {names}")
            places = dict(zip(goal.joints.name, map(float, goal.joints.position), strict=True))
            return robot.ptp(places, speed_factor=speed)
        wanted = world_t_frame(self._client, goal.pose.header.frame_id, bare=self._bare) @ matrix_of(goal.pose.pose)
        return (robot.linear if goal.linear else robot.ptp)(wanted, speed_factor=speed)


def message_of(one: Proposal) -> RosValue:
    """Return a proposal as `virtualrobot_msgs/Proposal`."""
    return make(
        "virtualrobot_msgs/msg/Proposal",
        id=one.id,
        revision=one.revision,
        title=one.title,
        state=one.state,
        robots=list(one.robots),
        ok=one.check.ok,
        violation="" if one.check.first_violation is None else one.check.first_violation.message,
        duration=one.check.duration,
        author=one.author,
        changed_by=one.changed_by,
        motion=one.motion_id,
        reason=one.reason,
        undo_count=one.undo_count,
    )


def trajectory_of(robot: RobotTrajectory, times: np.ndarray) -> RosValue:
    """Return the motion of a robot as `trajectory_msgs/JointTrajectory`, a point for each of the times (n,) in s."""
    points = [
        make(
            "trajectory_msgs/msg/JointTrajectoryPoint",
            positions=robot.positions[row],
            velocities=robot.velocities[row],
            accelerations=robot.accelerations[row],
            effort=np.empty(0),
            time_from_start=_duration(round(time * 1e9)),
        )
        for row, time in enumerate(times.tolist())
    ]
    type = "trajectory_msgs/msg/JointTrajectory"
    return make(type, header=header(0, ""), joint_names=list(robot.joint_names), points=points)


def _duration(nanoseconds: int) -> RosValue:
    time = time_of(nanoseconds)
    return make("builtin_interfaces/msg/Duration", sec=time.sec, nanosec=time.nanosec)


def _told(one: Proposal) -> dict[str, object]:
    return {"proposal": message_of(one)}


def _released(motion: Motion, release: Callable[[], None]) -> None:
    """Give robots back when a motion has ended, however it ends."""
    try:
        for _ in motion.watch(max_rate=1.0):
            pass
        release()
    except VirtualRobotError:
        pass  # the kernel has gone, and the lease with it
