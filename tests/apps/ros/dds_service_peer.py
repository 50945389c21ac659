"""A client of services and of an action by DDS that is not ours: Cyclone's own types and coder.

It does what rmw_cyclonedds does: an id of the client in the user data of its writer and its reader, and before each
request and reply a header of the client's number and a sequence number (`cdds_request_header_t`).
"""

import json
import sys
import time
from dataclasses import dataclass
from typing import Any

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, int8, int32, int64, sequence, uint8, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

SIMULATION, ACTION = "simulation_interfaces.srv.dds_.", "simulation_interfaces.action.dds_.SimulateSteps_"


@dataclass
@final
class Result(IdlStruct, typename="simulation_interfaces.msg.dds_.Result_"):
    result: uint8
    error_message: str


@dataclass
@final
class State(IdlStruct, typename="simulation_interfaces.msg.dds_.SimulationState_"):
    state: uint8


@dataclass
@final
class StateRequest(IdlStruct, typename=f"{SIMULATION}GetSimulationState_Request_"):
    guid: uint64
    seq: int64
    structure_needs_at_least_one_member: uint8


@dataclass
@final
class StateResponse(IdlStruct, typename=f"{SIMULATION}GetSimulationState_Response_"):
    guid: uint64
    seq: int64
    state: State
    result: Result


@dataclass
@final
class Time(IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: int32
    nanosec: uint32


@dataclass
@final
class Uuid(IdlStruct, typename="unique_identifier_msgs.msg.dds_.UUID_"):
    uuid: array[uint8, 16]


@dataclass
@final
class StepsGoal(IdlStruct, typename=f"{ACTION}Goal_"):
    steps: uint64


@dataclass
@final
class StepsResult(IdlStruct, typename=f"{ACTION}Result_"):
    result: Result


@dataclass
@final
class StepsFeedback(IdlStruct, typename=f"{ACTION}Feedback_"):
    completed_steps: uint64
    remaining_steps: uint64


@dataclass
@final
class SendRequest(IdlStruct, typename=f"{ACTION}SendGoal_Request_"):
    guid: uint64
    seq: int64
    goal_id: Uuid
    goal: StepsGoal


@dataclass
@final
class SendResponse(IdlStruct, typename=f"{ACTION}SendGoal_Response_"):
    guid: uint64
    seq: int64
    accepted: bool
    stamp: Time


@dataclass
@final
class ResultRequest(IdlStruct, typename=f"{ACTION}GetResult_Request_"):
    guid: uint64
    seq: int64
    goal_id: Uuid


@dataclass
@final
class ResultResponse(IdlStruct, typename=f"{ACTION}GetResult_Response_"):
    guid: uint64
    seq: int64
    status: int8
    result: StepsResult


@dataclass
@final
class Feedback(IdlStruct, typename=f"{ACTION}FeedbackMessage_"):
    goal_id: Uuid
    feedback: StepsFeedback


@dataclass
@final
class GoalInfo(IdlStruct, typename="action_msgs.msg.dds_.GoalInfo_"):
    goal_id: Uuid
    stamp: Time


@dataclass
@final
class CancelRequest(IdlStruct, typename="action_msgs.srv.dds_.CancelGoal_Request_"):
    guid: uint64
    seq: int64
    goal_info: GoalInfo


@dataclass
@final
class CancelResponse(IdlStruct, typename="action_msgs.srv.dds_.CancelGoal_Response_"):
    guid: uint64
    seq: int64
    return_code: int8
    goals_canceling: sequence[GoalInfo]


RELIABLE = Policy.Reliability.Reliable(duration(seconds=10))
SERVICE = Qos(RELIABLE, Policy.Durability.Volatile, Policy.History.KeepLast(10))


class Caller:
    """A client of a service."""

    def __init__(self, participant: DomainParticipant, name: str, request: Any, response: Any) -> None:  # noqa: ANN401
        """Wait until the service is there."""
        qos = SERVICE + Qos(Policy.Userdata(f"clientid={name};".encode()))
        self._guid, self._last, self._request = hash(name) & 0x7FFFFFFFFFFFFFFF, 0, request
        self._writer = DataWriter(participant, Topic(participant, f"rq{name}Request", request), qos=qos)
        self._reader = DataReader(participant, Topic(participant, f"rr{name}Reply", response), qos=qos)
        while not (self._writer.get_matched_subscriptions() and self._reader.get_matched_publications()):
            time.sleep(0.01)

    def send(self, *fields: object) -> None:
        """Send a request."""
        self._last += 1
        self._writer.write(self._request(self._guid, self._last, *fields))

    def receive(self) -> Any:  # noqa: ANN401
        """Return the reply to the request that was sent last."""
        while True:
            for one in self._reader.take(10):
                if getattr(one, "guid", None) == self._guid and one.seq == self._last:
                    return one
            time.sleep(0.01)


def _identity(number: int) -> Any:  # noqa: ANN401 Cyclone's arrays have no type that is known before they are made
    return [number] * 16


def main(domain: int) -> None:
    """Print the state of the simulation, and how two goals have ended: one ran, one was cancelled."""
    participant = DomainParticipant(domain)
    place = "/virtualrobot/simulate_steps/_action"
    heard: Any = DataReader(participant, Topic(participant, f"rt{place}/feedback", Feedback), qos=SERVICE)
    while not heard.get_matched_publications():
        time.sleep(0.01)
    state = Caller(participant, "/virtualrobot/get_simulation_state", StateRequest, StateResponse)
    state.send(0)
    told = {"state": state.receive().state.state}
    send = Caller(participant, f"{place}/send_goal", SendRequest, SendResponse)
    result = Caller(participant, f"{place}/get_result", ResultRequest, ResultResponse)
    cancel = Caller(participant, f"{place}/cancel_goal", CancelRequest, CancelResponse)

    first, second, none = (Uuid(_identity(number)) for number in (1, 2, 3))
    send.send(first, StepsGoal(3))
    told["accepted"] = send.receive().accepted
    result.send(first)
    ended = result.receive()
    told["first"] = ended.status, ended.result.result.result, ended.result.result.error_message
    steps: list[int] = []
    while not steps or steps[-1] < 3:
        steps += [one.feedback.completed_steps for one in heard.take(10) if one.goal_id.uuid[0] == 1]
        time.sleep(0.01)
    told["steps"] = steps

    send.send(second, StepsGoal(10**12))
    send.receive()
    result.send(second)
    cancel.send(GoalInfo(second, Time(0, 0)))
    told["canceling"] = [list(one.goal_id.uuid) for one in cancel.receive().goals_canceling]
    told["second"] = result.receive().status
    cancel.send(GoalInfo(none, Time(0, 0)))
    told["unknown"] = cancel.receive().return_code
    print(json.dumps(told), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]))
