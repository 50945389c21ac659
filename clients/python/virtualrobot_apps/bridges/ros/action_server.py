"""An action of the hub as ROS 2 carries one: three services and two topics, for transports that have no actions.

Source: "Actions", design.ros2.org, and rcl_action: a goal is accepted, runs, and tells its result to whoever asks.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field

from virtualrobot_apps.bridges.ros.hub import ABORTED, Action, Hub, Service, Topic
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue, nanoseconds_of, time_of
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import make
from virtualrobot_apps.bridges.ros.messages.values import default

ACCEPTED, EXECUTING, CANCELING = 1, 2, 3
"""States of a goal that is not over; source: action_msgs/GoalStatus."""

NO_ERROR, REJECTED, UNKNOWN_GOAL, TERMINATED = 0, 1, 2, 3
"""Answers to a wish to cancel; source: action_msgs/CancelGoal."""

MOST_GOALS, MOST_ENDED = 64, 100
"""Goals of an action that run at once, and those that are over whose results are kept."""


@dataclass
class _Goal:
    id: RosValue
    time: int
    cancel: asyncio.Event = field(default_factory=asyncio.Event)
    over: asyncio.Event = field(default_factory=asyncio.Event)
    status: int = EXECUTING
    result: RosValue = None
    task: asyncio.Task[None] | None = None


class ActionServer:
    """An action as services and topics.

    Attributes:
        services: send_goal, cancel_goal and get_result.
        topics: feedback, and the latched status of all goals.
    """

    def __init__(self, action: Action, now: Callable[[], int]) -> None:
        """Serve no goal yet; `now` gives simulation time (ns)."""
        self._action, self._now = action, now
        self._goals: dict[bytes, _Goal] = {}
        place = f"{action.name}/_action"
        self.services = (
            Service(f"{place}/send_goal", f"{action.type}_SendGoal", self._send),
            Service(f"{place}/cancel_goal", "action_msgs/srv/CancelGoal", self._cancel),
            Service(f"{place}/get_result", f"{action.type}_GetResult", self._result),
        )
        self._feedback = Topic(f"{place}/feedback", f"{action.type}_FeedbackMessage", is_told=True)
        self._status = Topic(f"{place}/status", "action_msgs/msg/GoalStatusArray", latched=True, is_told=True)
        self.topics = self._feedback, self._status
        self._tell_status()

    def close(self) -> None:
        """Cancel all goals."""
        for goal in self._goals.values():
            goal.cancel.set()

    async def _send(self, request: RosValue) -> RosValue:
        key, time = bytes(request.goal_id.uuid), self._now()
        running = sum(not one.over.is_set() for one in self._goals.values())
        accepted = key not in self._goals and running < MOST_GOALS
        if accepted:
            goal = self._goals[key] = _Goal(request.goal_id, time)
            goal.task = asyncio.create_task(self._run(goal, request.goal))
        return make(f"{self._action.type}_SendGoal_Response", accepted=accepted, stamp=time_of(time))

    async def _run(self, goal: _Goal, value: RosValue) -> None:
        self._tell_status()

        def feedback(told: RosValue) -> None:
            message = make(self._feedback.type, goal_id=goal.id, feedback=told)
            _publish(self._feedback, Message(self._feedback.type, message, self._now()))

        try:
            goal.status, goal.result = await self._action.run(value, feedback, goal.cancel)
        except Exception:  # whatever an action raises; ROS 2 has no words for it
            goal.status, goal.result = ABORTED, default(f"{self._action.type}_Result")
        goal.over.set()
        for key in [key for key, one in self._goals.items() if one.over.is_set()][:-MOST_ENDED]:
            del self._goals[key]
        self._tell_status()

    async def _cancel(self, request: RosValue) -> RosValue:
        """Cancel the goal that is named, and all up to a time; all, where neither is said."""
        info = request.goal_info
        key, time = bytes(info.goal_id.uuid), nanoseconds_of(info.stamp)
        named, everything = any(key), not any(key) and not time
        found = [
            one
            for name, one in self._goals.items()
            if everything or (named and name == key) or (time and one.time <= time)
        ]
        live = [one for one in found if not one.over.is_set()]
        for goal in live:
            goal.status = CANCELING
            goal.cancel.set()
        if live:
            self._tell_status()
        code = NO_ERROR if live or not named else TERMINATED if found else UNKNOWN_GOAL
        return make(
            "action_msgs/srv/CancelGoal_Response", return_code=code, goals_canceling=[_info(one) for one in live]
        )

    async def _result(self, request: RosValue) -> RosValue:
        type = f"{self._action.type}_GetResult_Response"
        if (goal := self._goals.get(bytes(request.goal_id.uuid))) is None:
            return default(type)  # status 0 is unknown
        await goal.over.wait()
        return make(type, status=goal.status, result=goal.result)

    def _tell_status(self) -> None:
        told = [
            make("action_msgs/msg/GoalStatus", goal_info=_info(one), status=one.status) for one in self._goals.values()
        ]
        message = make(self._status.type, status_list=told)
        _publish(self._status, Message(self._status.type, message, self._now()))


def _info(goal: _Goal) -> RosValue:
    return make("action_msgs/msg/GoalInfo", goal_id=goal.id, stamp=time_of(goal.time))


def _publish(topic: Topic, message: Message) -> None:
    topic.last = message if topic.latched else None
    for reader in tuple(topic.readers):
        reader(message)


def change_action(
    servers: dict[str, ActionServer],
    action: Action,
    is_there: bool,
    hub: Hub,
    change: Callable[[Service | Topic, bool], object],
) -> None:
    """Carry an action that is there, and no more one that has gone, by `change`, which does so for services and topics.

    `servers` has those that are carried, by name.
    """
    if is_there:
        server = servers[action.name] = ActionServer(action, lambda: hub.now)
    elif (server := servers.pop(action.name, None)) is None:
        return
    for one in (*server.services, *server.topics):
        change(one, is_there)
    if not is_there:
        server.close()
