"""Services and actions of a client, both ways: it calls those of others, and serves its own."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from virtualrobot_apps.bridges.ros.hub import ABORTED, Action, Feedback, GoalRefusedError, HubError, Service
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue
from virtualrobot_apps.bridges.ros.messages.types import NO_FIELD, fields, of_kind
from virtualrobot_apps.bridges.ros.messages.values import FieldError, default, from_plain, to_plain
from virtualrobot_apps.bridges.ros.rosbridge.subscription import number
from virtualrobot_apps.bridges.ros.rosbridge.wire import MOST_BYTES

if TYPE_CHECKING:
    from virtualrobot_apps.bridges.ros.rosbridge.session import Session

ANSWER_SECONDS = 60.0
"""Time (s) after which a service of a client that doesn't answer has failed."""

MOST_TIMEOUT_SECONDS = 86_400.0


class Calls:
    """Calls and goals of one client, and those that it serves."""

    def __init__(self, session: Session) -> None:
        """Begin with none."""
        self._session, self._hub = session, session.hub
        self._served: list[Service | Action] = []
        self._asked: dict[str, asyncio.Future[Any]] = {}
        self._feedback: dict[str, Callable[[Any], None]] = {}
        self._goals: dict[str, asyncio.Event] = {}
        self._numbers = itertools.count(1)
        self.operations: dict[str, Callable[[dict[str, Any]], None]] = {
            "call_service": self._call_service,
            "advertise_service": self._advertise_service,
            "unadvertise_service": lambda op: self._unadvertise(Service, text(op, "service")),
            "service_response": self._service_response,
            "send_action_goal": self._send_goal,
            "cancel_action_goal": self._cancel_goal,
            "advertise_action": self._advertise_action,
            "unadvertise_action": lambda op: self._unadvertise(Action, text(op, "action")),
            "action_feedback": self._action_feedback,
            "action_result": self._action_result,
        }

    def close(self) -> None:
        """End all: what it serves is gone, and goals end with who has sent them."""
        for one in self._served:
            self._hub.end(one)
        for future in self._asked.values():
            if not future.done():
                future.set_exception(HubError("who served it is gone"))
        for cancel in self._goals.values():
            cancel.set()

    # Calls of this client.

    def _call_service(self, op: dict[str, Any]) -> None:
        fragment = int(number(op, "fragment_size", 0, MOST_BYTES))
        timeout = number(op, "timeout", 0.0, MOST_TIMEOUT_SECONDS) or None
        self._session.start(self._call(op, fragment, timeout))

    async def _call(self, op: dict[str, Any], fragment: int, timeout: float | None) -> None:
        head = {"op": "service_response", "service": _named(op, "service"), **_number_of(op)}
        try:
            service = self._hub.services.get(slashed(text(op, "service")))
            if service is None:
                raise HubError(f"there is no service {op['service'][:80]!r}")
            request = from_plain(f"{service.type}_Request", _arguments(f"{service.type}_Request", op.get("args")))
            async with asyncio.timeout(timeout):
                answer = await service.answer(request)
            reply = {**head, "values": to_plain(answer), "result": True}
        except TimeoutError:
            reply = {**head, "values": f"no answer after {timeout} s", "result": False}
        except Exception as error:  # whatever a service raises is for who has called it
            reply = {**head, "values": str(error) or type(error).__name__, "result": False}
        self._session.reply(reply, fragment)

    def _send_goal(self, op: dict[str, Any]) -> None:
        name = str(op.get("id") or f"goal {next(self._numbers)}")[:200]
        if name in self._goals:
            raise HubError(f"the goal {name!r} is under way already")
        self._session.start(self._goal(op, name))

    async def _goal(self, op: dict[str, Any], name: str) -> None:
        head = {"op": "action_result", "action": _named(op, "action"), "id": name}
        cancel = self._goals[name] = asyncio.Event()
        try:
            action = self._hub.actions.get(slashed(text(op, "action")))
            if action is None:
                raise HubError(f"there is no action {op['action'][:80]!r}")
            goal = from_plain(f"{action.type}_Goal", _arguments(f"{action.type}_Goal", op.get("args")))

            def feedback(value: RosValue) -> None:
                if op.get("feedback"):
                    told = {"op": "action_feedback", "action": op["action"], "id": name, "values": to_plain(value)}
                    self._session.reply(told)

            status, result = await action.run(goal, feedback, cancel)
            reply = {**head, "values": to_plain(result), "status": status, "result": True}
        except Exception as error:  # whatever an action raises is for who has sent the goal
            reply = {**head, "values": str(error) or type(error).__name__, "status": ABORTED, "result": False}
        finally:
            self._goals.pop(name, None)
        self._session.reply(reply)

    def _cancel_goal(self, op: dict[str, Any]) -> None:
        if (cancel := self._goals.get(str(op.get("id"))[:200])) is None:
            raise HubError(f"no goal {str(op.get('id'))[:80]!r} is under way")
        cancel.set()

    # What this client serves.

    def _advertise_service(self, op: dict[str, Any]) -> None:
        name, type = slashed(text(op, "service")), of_kind(op.get("type"), "srv")

        async def answer(request: RosValue) -> RosValue:
            asked = {"op": "call_service", "service": name, "args": to_plain(request)}
            async with asyncio.timeout(ANSWER_SECONDS):
                values = await self._ask(asked)
            return from_plain(f"{type}_Response", values)

        one = Service(name, type, answer, self._session)
        self._hub.serve(one)
        self._served.append(one)

    def _advertise_action(self, op: dict[str, Any]) -> None:
        name, type = slashed(text(op, "action")), of_kind(op.get("type"), "action")

        async def run(goal: RosValue, feedback: Feedback, cancel: asyncio.Event) -> tuple[int, RosValue]:
            key = f"{name} {next(self._numbers)}"
            self._feedback[key] = lambda values: feedback(from_plain(f"{type}_Feedback", values))
            asked = {"op": "send_action_goal", "action": name, "action_type": type, "feedback": True}
            work = asyncio.create_task(self._ask({**asked, "args": to_plain(goal), "id": key}))
            cancelled = asyncio.create_task(cancel.wait())
            try:
                await asyncio.wait({work, cancelled}, return_when=asyncio.FIRST_COMPLETED)
                if not work.done():
                    self._session.reply({"op": "cancel_action_goal", "action": name, "id": key})
                status, values = await work
            finally:
                cancelled.cancel()
                self._feedback.pop(key, None)
            return status, from_plain(f"{type}_Result", values) if values else default(f"{type}_Result")

        one = Action(name, type, run, self._session)
        self._hub.act(one)
        self._served.append(one)

    def _unadvertise(self, kind: type[Service] | type[Action], name: str) -> None:
        found = [one for one in self._served if isinstance(one, kind) and one.name == slashed(name)]
        if not found:
            raise HubError(f"{name[:80]!r} is not advertised by this client")
        self._served.remove(found[0])
        self._hub.end(found[0])

    async def _ask(self, op: dict[str, Any]) -> Any:  # noqa: ANN401 values of any message
        key = op.setdefault("id", f"call {next(self._numbers)}")
        future = self._asked[key] = asyncio.get_running_loop().create_future()
        try:
            self._session.reply(op)
            return await future
        finally:
            del self._asked[key]

    def _answered(self, op: dict[str, Any]) -> asyncio.Future[Any]:
        future = self._asked.get(str(op.get("id")))
        if future is None or future.done():
            raise HubError(f"nothing was asked under the id {str(op.get('id'))[:80]!r}")
        return future

    def _service_response(self, op: dict[str, Any]) -> None:
        future = self._answered(op)
        if op.get("result") is False:
            future.set_exception(HubError(str(op.get("values") or "the service has failed")[:1000]))
        else:
            future.set_result(op.get("values") or {})

    def _action_result(self, op: dict[str, Any]) -> None:
        future = self._answered(op)
        if op.get("result") is False:
            future.set_exception(GoalRefusedError(str(op.get("values") or "the goal was refused")[:1000]))
            return
        status = op.get("status", 0)
        if not isinstance(status, int) or isinstance(status, bool) or not 0 <= status <= ABORTED:
            raise HubError(f"'status' is that of action_msgs/GoalStatus, 0 to {ABORTED}, not {str(status)[:40]!r}")
        future.set_result((status, op.get("values")))

    def _action_feedback(self, op: dict[str, Any]) -> None:
        if (feedback := self._feedback.get(str(op.get("id")))) is None:
            raise HubError(f"no goal {str(op.get('id'))[:80]!r} is under way here")
        feedback(op.get("values") or {})


def text(op: dict[str, Any], key: str) -> str:
    """Return a text of a message; raises HubError where it is absent, empty or none."""
    value = op.get(key)
    if not isinstance(value, str) or not value:
        raise HubError(f"{str(op.get('op'))[:40]!r} needs the text {key!r}")
    return value


def slashed(name: str) -> str:
    """Return a name with the slash in front that some clients leave out."""
    return "/" + name.removeprefix("/")


def _named(op: dict[str, Any], key: str) -> str | None:
    """Return a text of a message as it goes back in an answer; None where it is none, such as a NaN."""
    return value if isinstance(value := op.get(key), str) else None


def _number_of(op: dict[str, Any]) -> dict[str, Any]:
    return {"id": op["id"]} if isinstance(op.get("id"), str | int) else {}


def _arguments(type: str, given: object) -> object:
    """Return arguments by name; a list has them in their order."""
    if not isinstance(given, list):
        return given or {}
    names = [one for one in fields(type) if one != NO_FIELD]
    if len(given) > len(names):
        raise FieldError(f"{type} has {len(names)} fields, not {len(given)}")
    return dict(zip(names, given, strict=False))
