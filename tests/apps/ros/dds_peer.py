"""A program on DDS that is not ours: Cyclone's own types and coder; prints joints that it reads, and sends a twist.

Its types have the names and the fields that ROS 2 gives them in DDS.
"""

import json
import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import float64, int32, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
@final
class Time(IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: int32
    nanosec: uint32


@dataclass
@final
class Header(IdlStruct, typename="std_msgs.msg.dds_.Header_"):
    stamp: Time
    frame_id: str


@dataclass
@final
class JointState(IdlStruct, typename="sensor_msgs.msg.dds_.JointState_"):
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


@dataclass
@final
class String(IdlStruct, typename="std_msgs.msg.dds_.String_"):
    data: str


@dataclass
@final
class Vector3(IdlStruct, typename="geometry_msgs.msg.dds_.Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
@final
class Twist(IdlStruct, typename="geometry_msgs.msg.dds_.Twist_"):
    linear: Vector3
    angular: Vector3


RELIABLE = Policy.Reliability.Reliable(duration(seconds=1))


def main(domain: int, seconds: float) -> None:
    """Print what was read as JSON: all joint states by their times, and the description, latched."""
    participant = DomainParticipant(domain)
    volatile = Qos(RELIABLE, Policy.Durability.Volatile, Policy.History.KeepLast(100))
    latched = Qos(RELIABLE, Policy.Durability.TransientLocal, Policy.History.KeepLast(1))
    joints = DataReader(participant, Topic(participant, "rt/arm/joint_states", JointState), qos=volatile)
    described = DataReader(participant, Topic(participant, "rt/arm/robot_description", String), qos=latched)
    twists = DataWriter(participant, Topic(participant, "rt/ugv/cmd_vel", Twist), qos=volatile)
    print("ready", flush=True)
    states, text = [], ""
    due = time.monotonic() + seconds
    while time.monotonic() < due and not (len(states) > 20 and text):
        twists.write(Twist(Vector3(0.2, 0.0, 0.0), Vector3(0.0, 0.0, 0.0)))
        states += [one for one in joints.take(100) if isinstance(one, JointState)]
        text = next((one.data for one in described.take(1) if isinstance(one, String)), text)
        time.sleep(0.05)
    told = [[one.header.stamp.sec * 10**9 + one.header.stamp.nanosec, one.name, one.position] for one in states]
    print(json.dumps({"states": told, "description": text}), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), float(sys.argv[2]))
