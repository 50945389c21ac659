"""Messages of Externally Guided Motion for Protocol Buffers, by the names and numbers of ABB's `egm.proto`.

They are made when this is imported, in a pool of their own: a program may have loaded ABB's own file beside it.
Enumerations are numbers here, which are the same bytes.
"""

from __future__ import annotations

from typing import Any

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

_TABLE = {
    "EgmHeader": "uint32 seqno 1, uint32 tm 2, int32 mtype 3",
    "EgmCartesian": "double x 1, double y 2, double z 3",
    "EgmQuaternion": "double u0 1, double u1 2, double u2 3, double u3 4",
    "EgmClock": "uint64 sec 1, uint64 usec 2",
    "EgmPose": "EgmCartesian pos 1, EgmQuaternion orient 2",
    "EgmJoints": "double* joints 1",
    "EgmPlanned": "EgmJoints joints 1, EgmPose cartesian 2, EgmJoints externalJoints 3, EgmClock time 4",
    "EgmFeedBack": "EgmJoints joints 1, EgmPose cartesian 2, EgmJoints externalJoints 3, EgmClock time 4",
    "EgmState": "int32 state 1",
    "EgmCollisionInfo": "bool collsionTriggered 1",
    "EgmRAPIDdata": "bool digVal 1, double* dnum 2",
    "EgmRobot": "EgmHeader header 1, EgmFeedBack feedBack 2, EgmPlanned planned 3, EgmState motorState 4, "
    "EgmState mciState 5, bool mciConvergenceMet 6, EgmState rapidExecState 8, double utilizationRate 10, "
    "EgmCollisionInfo CollisionInfo 12, EgmRAPIDdata RAPIDfromRobot 13",
    "EgmSensor": "EgmHeader header 1, EgmPlanned planned 2, EgmRAPIDdata RAPIDtoRobot 4",
}
_PACKAGE = "virtualrobot.egm"


def _file() -> descriptor_pb2.FileDescriptorProto:
    kinds = descriptor_pb2.FieldDescriptorProto
    file = descriptor_pb2.FileDescriptorProto(name="virtualrobot/egm.proto", package=_PACKAGE, syntax="proto2")
    for name, fields in _TABLE.items():
        message = file.message_type.add(name=name)
        for field in fields.split(", "):
            kind, called, number = field.split()
            made = message.field.add(name=called, number=int(number), label=kinds.LABEL_OPTIONAL)
            if kind.endswith("*"):
                kind, made.label = kind[:-1], kinds.LABEL_REPEATED
            if kind in _TABLE:
                made.type, made.type_name = kinds.TYPE_MESSAGE, f".{_PACKAGE}.{kind}"
            else:
                made.type = kinds.Type.Value(f"TYPE_{kind.upper()}")
    return file


_pool = descriptor_pool.DescriptorPool()
_pool.Add(_file())  # pyright: ignore[reportAttributeAccessIssue] the types know only the pool that all share
EgmRobot: Any = message_factory.GetMessageClass(_pool.FindMessageTypeByName(f"{_PACKAGE}.EgmRobot"))
"""Message of the robot."""
EgmSensor: Any = message_factory.GetMessageClass(_pool.FindMessageTypeByName(f"{_PACKAGE}.EgmSensor"))
"""Message of the computer: where to go."""

DATA, CORRECTION = 2, 3
"""Types of messages in their headers: of the robot, of the computer."""
MOTORS_ON, MOTORS_OFF = 1, 2
MCI_ERROR, MCI_STOPPED, MCI_RUNNING = 1, 2, 3
RAPID_STOPPED, RAPID_RUNNING = 1, 2
