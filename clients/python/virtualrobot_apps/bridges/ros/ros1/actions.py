"""An action of the hub as actionlib carries one in ROS 1: topics for goals, cancelling, status, feedback, results.

Source: wiki.ros.org, "actionlib/DetailedDescription".
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field

from virtualrobot_apps.bridges.ros.hub import ABORTED, CANCELED, SUCCEEDED, Action, GoalRefusedError, Refused, Topic
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue, header, nanoseconds_of, time_of
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.ros1 import ROS1, converted, part_of
from virtualrobot_apps.bridges.ros.messages.types import STORE
from virtualrobot_apps.bridges.ros.messages.values import default

ACTIVE, PREEMPTED, DONE, FAILED, REJECTED, PREEMPTING, RECALLED = 1, 2, 3, 4, 5, 6, 8
"""States of a goal; source: actionlib_msgs/GoalStatus."""

STATUS_SECONDS = 0.2
"""Time (s) after which the states of all goals are told again: a client takes a server for gone without them."""

MOST_GOALS, MOST_ENDED = 64, 100
"""Goals of an action that run at once, and those that are over whose states are told."""

_ENDED = {SUCCEEDED: DONE, CANCELED: PREEMPTED, ABORTED: FAILED}


@dataclass
class _Goal:
    id: RosValue
    status: int = ACTIVE
    words: str = ""
    cancel: asyncio.Event = field(default_factory=asyncio.Event)
    task: asyncio.Task[None] | None = None


class ActionlibServer:
    """An action as topics: `topics` are goal and cancel, which are heard, and status, feedback and result."""

    def __init__(self, action: Action, now: Callable[[], int]) -> None:
        """Serve no goal yet; `now` gives simulation time (ns)."""
        self._action, self._now = action, now
        self._goals: dict[str, _Goal] = {}
        self._number = 0

        def told(name: str, type: str) -> Topic:
            return Topic(f"{action.name}/{name}", type, is_told=True)

        self._status = told("status", "actionlib_msgs/msg/GoalStatusArray")
        self._feedback = told("feedback", part_of(action.type, "ActionFeedback"))
        self._result = told("result", part_of(action.type, "ActionResult"))
        self.topics = (
            Topic(f"{action.name}/goal", part_of(action.type, "ActionGoal"), take=self._take),
            Topic(f"{action.name}/cancel", "actionlib_msgs/msg/GoalID", take=self._cancel),
            self._status,
            self._feedback,
            self._result,
        )
        self._telling = asyncio.create_task(self._repeat())

    def close(self) -> None:
        """Cancel all goals."""
        self._telling.cancel()
        for goal in self._goals.values():
            goal.cancel.set()

    def _take(self, value: RosValue, _: Refused) -> None:
        id = value.goal_id
        if not id.id:
            self._number += 1
            id.id = f"{self._action.name}-{self._number}"
        if id.id in self._goals:
            raise ValueError(f"the goal {id.id[:80]!r} is there already")
        if not nanoseconds_of(id.stamp):
            id.stamp = time_of(self._now())
        goal = _Goal(id)
        if sum(not one.task.done() for one in self._goals.values() if one.task) >= MOST_GOALS:
            return self._end(goal, REJECTED, f"{MOST_GOALS} goals run at once", default(f"{self._action.type}_Result"))
        self._goals[id.id] = goal
        goal.task = asyncio.create_task(self._run(goal, converted(value.goal, f"{self._action.type}_Goal", STORE)))

    async def _run(self, goal: _Goal, value: RosValue) -> None:
        self._tell_status()

        def feedback(told: RosValue) -> None:
            part = converted(told, part_of(self._action.type, "Feedback"), ROS1)
            self._tell(self._feedback, status=_status(goal), feedback=part)

        result, words = default(f"{self._action.type}_Result"), ""
        try:
            state, result = await self._action.run(value, feedback, goal.cancel)
            status = _ENDED[state]
            words = str(getattr(result, "error_string", ""))
        except GoalRefusedError as error:
            status, words = REJECTED, str(error)
        except Exception as error:  # whatever an action raises
            status, words = FAILED, str(error) or repr(error)
        self._end(goal, status, words, result)

    def _end(self, goal: _Goal, status: int, words: str, result: RosValue) -> None:
        goal.status, goal.words = status, words
        part = converted(result, part_of(self._action.type, "Result"), ROS1)
        self._tell(self._result, status=_status(goal), result=part)
        ended = [key for key, one in self._goals.items() if one.status not in (ACTIVE, PREEMPTING)]
        for key in ended[:-MOST_ENDED]:
            del self._goals[key]
        self._tell_status()

    def _cancel(self, id: RosValue, _: Refused) -> None:
        """Cancel the goal that is named, and all up to a time; all, where neither is said."""
        time, everything = nanoseconds_of(id.stamp), not id.id and not nanoseconds_of(id.stamp)
        for key, goal in self._goals.items():
            meant = everything or key == id.id or (time and nanoseconds_of(goal.id.stamp) <= time)
            if meant and goal.status == ACTIVE:
                goal.status = PREEMPTING
                goal.cancel.set()
        self._tell_status()

    async def _repeat(self) -> None:
        while True:
            self._tell_status()
            await asyncio.sleep(STATUS_SECONDS)

    def _tell_status(self) -> None:
        self._tell(self._status, status_list=[_status(one) for one in self._goals.values()])

    def _tell(self, topic: Topic, **values: object) -> None:
        now = self._now()
        if not topic.readers:
            return
        value = converted(header(now, ""), "std_msgs/msg/Header", ROS1)
        message = Message(topic.type, ROS1.types[topic.type](header=value, **values), now)
        for reader in tuple(topic.readers):
            reader(message)


def _status(goal: _Goal) -> RosValue:
    return ROS1.types["actionlib_msgs/msg/GoalStatus"](goal_id=goal.id, status=goal.status, text=goal.words)
