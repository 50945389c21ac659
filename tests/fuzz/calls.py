"""Calls of the contract as bytes: a kernel in this process answers up to four of them, one after the other."""

from __future__ import annotations

import logging
import random
import struct
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import grpc
from google.protobuf.message import Message
from google.protobuf.message_factory import GetMessageClass
from virtualrobot.v1 import kernel_pb2, lease_pb2, motion_pb2, scene_pb2
from virtualrobot_kernel.api.server import SERVICES
from virtualrobot_kernel.formats import program_file, scene_file

from tests.fuzz.messages import Maker, words_of
from tests.fuzz.readers import READERS, start_scene
from tests.inside import kernel_inside
from tests.kernels import Stubs

LEFT_OUT = ("Shutdown", "ReloadPlugins")
"""Methods that end the kernel, or start processes of all plugins."""

METHODS = [
    method
    for module, _, _ in SERVICES
    for service in module.DESCRIPTOR.services_by_name.values()
    for method in service.methods
    if method.name not in LEFT_OUT
]
MOST_CALLS = 4
SECONDS = 60.0
"""Longest time of a call; a guard against what has no end."""

STREAM_SECONDS = 0.2
"""Longest time for the first answer of a stream: where time stands, many never come."""

BROKEN = (grpc.StatusCode.INTERNAL, grpc.StatusCode.UNKNOWN, grpc.StatusCode.DEADLINE_EXCEEDED)


@dataclass(frozen=True, slots=True)
class Call:
    """Call of a method, by its place among METHODS, with a request as bytes."""

    method: int
    request: bytes


def packed(calls: list[Call]) -> bytes:
    """Return calls as bytes."""
    return b"".join(struct.pack("<BI", one.method, len(one.request)) + one.request for one in calls)


def unpacked(data: bytes) -> list[Call]:
    """Return the calls that bytes stand for, whatever bytes they are."""
    calls: list[Call] = []
    while len(data) >= 5 and len(calls) < MOST_CALLS:
        method, size = struct.unpack_from("<BI", data)
        calls.append(Call(method % len(METHODS), data[5 : 5 + size]))
        data = data[5 + size :]
    return calls


class Log(logging.Handler):
    """What a kernel in this process logs as errors: faults of threads that no call tells."""

    def __init__(self) -> None:
        """Begin empty."""
        super().__init__(logging.ERROR)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a line."""
        self.lines.append(self.format(record))


class BrokenCallError(AssertionError):
    """Call that has met a fault of the kernel."""


@contextmanager
def caller_inside() -> Iterator[Caller]:
    """Give a caller of a kernel in this process, whose code can be watched."""
    log = Log()
    logging.getLogger("virtualrobot_kernel").addHandler(log)
    with kernel_inside() as (_, address), tempfile.TemporaryDirectory() as folder:
        with grpc.insecure_channel(address) as channel:
            yield Caller(Stubs(channel), start_scene(Path(folder)), log.lines)


@dataclass
class Caller:
    """Caller of a kernel. Each input meets the world of the scene `start`; `lines` are those that the kernel logs."""

    stubs: Any
    start: str
    lines: list[str]

    def __post_init__(self) -> None:
        """Make the world."""
        self.reset()

    def reset(self) -> None:
        """Take back what calls have done: clock, leases, nodes, signals, motions, settings."""
        for lease in self.stubs.lease.ListLeases(lease_pb2.ListLeasesRequest()).leases:
            taken = self.stubs.lease.TakeLease(lease_pb2.TakeLeaseRequest(robots=lease.robots))
            self.stubs.lease.ReleaseLease(lease_pb2.ReleaseLeaseRequest(token=taken.token))
        self.stubs.kernel.SetClock(kernel_pb2.SetClockRequest(mode=kernel_pb2.CLOCK_MODE_STEPPED, speed_factor=1.0))
        self.stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text=self.start))

    def answer(self, data: bytes) -> list[grpc.StatusCode]:
        """Make the calls, in a world as at the start, and return how each ended; raise for a fault of the kernel."""
        codes: list[grpc.StatusCode] = []
        for call in unpacked(data):
            codes.append(self._made(call))
            if faults := [line for line in self.lines if "inside the kernel" in line]:
                self.lines.clear()
                raise BrokenCallError(f"{METHODS[call.method].full_name} made the kernel log:\n" + "\n".join(faults))
        self.reset()
        return codes

    def _made(self, call: Call) -> grpc.StatusCode:
        method = METHODS[call.method]
        path = f"/{method.containing_service.full_name}/{method.name}"
        try:
            if method.client_streaming and method.server_streaming:
                self._some(self.stubs.channel.stream_stream(path)(iter([call.request]), timeout=SECONDS))
            elif method.client_streaming:
                self.stubs.channel.stream_unary(path)(iter([call.request]), timeout=SECONDS)
            elif method.server_streaming:
                self._some(self.stubs.channel.unary_stream(path)(call.request, timeout=SECONDS))
            else:
                self.stubs.channel.unary_unary(path)(call.request, timeout=SECONDS)
        except grpc.RpcError as error:
            refused: Any = error
            code = refused.code()
            if code in BROKEN:
                raise BrokenCallError(f"{path}: {code.name}: {refused.details()}") from None
            return code
        return grpc.StatusCode.OK

    def _some(self, answers: Any) -> None:  # noqa: ANN401 a call of grpcio
        """Wait a while for the first answer of a stream, and go away."""
        timer = threading.Timer(STREAM_SECONDS, answers.cancel)
        timer.start()
        try:
            next(answers, None)
        finally:
            timer.cancel()
            answers.cancel()


def shown(data: bytes) -> str:
    """Return the calls that an input stands for in words."""
    return "\n".join(f"{METHODS[one.method].full_name} {_message(one)}" for one in unpacked(data))


def _message(call: Call) -> Message | bytes:
    try:
        return GetMessageClass(METHODS[call.method].input_type).FromString(call.request)
    except Exception:
        return call.request


class Changer:
    """Makes inputs anew and changes those that there are, by words that make sense in the world of the start."""

    def __init__(self, start: str) -> None:
        """Take words from a scene and from all programs of the repository."""
        self.scene = scene_file.parse(start)
        self.specs = [program_file.parse(one.decode()) for one in READERS["program"].seeds()]
        self.words = words_of([self.scene, *self.specs])
        nodes = self.words["name"]
        for key in ("robot", "robots", "names", "tool", "parent", "part", "node", "first", "second", "owner", "base"):
            self.words[key] = [*self.words.get(key, ()), *nodes]
        self.words["paths"] = ["name", "parent_t_node", "figures", "hidden", "object", "part", "robot", "*", "tool"]
        self.words["id"] = ["motion-1", "motion-2", "1"]

    def seeds(self) -> Iterator[bytes]:
        """Yield inputs: an empty request of each method, programs, and each node made, removed and attached."""
        for place, _ in enumerate(METHODS):
            yield packed([Call(place, b"")])
        step = kernel_pb2.StepClockRequest(ticks=100).SerializeToString()
        for spec in self.specs:
            request = motion_pb2.StartMotionRequest(spec=spec, on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE)
            calls = [self._call("StartMotion", request.SerializeToString()), self._call("StepClock", step)]
            yield packed(calls)
            plan = motion_pb2.CheckMotionRequest(spec=spec).SerializeToString()
            yield packed([self._call("CheckMotion", plan)])
        for node in self.scene.nodes:
            made = scene_pb2.Command(create_node=scene_pb2.CreateNode(node=node))
            made.create_node.node.name = f"{node.name}2"
            gone = scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name=node.name))
            request = scene_pb2.ApplyRequest(commands=[made, gone])
            yield packed([self._call("Apply", request.SerializeToString()), self._call("StepClock", step)])

    def _call(self, name: str, request: bytes) -> Call:
        return Call(next(i for i, one in enumerate(METHODS) if one.name == name), request)

    def made(self, rng: random.Random) -> bytes:
        """Return calls with random requests."""
        maker = Maker(rng, self.words)
        return packed([self._new(rng, maker) for _ in range(rng.choice((1, 2, MOST_CALLS)))])

    def _new(self, rng: random.Random, maker: Maker) -> Call:
        place = rng.randrange(len(METHODS))
        message = GetMessageClass(METHODS[place].input_type)()
        maker.fill(message)
        return Call(place, message.SerializeToString())

    def changed(self, data: bytes, rng: random.Random) -> bytes:
        """Return an input with damage in one to three of its messages, calls added, gone, or in another order."""
        maker, calls = Maker(rng, self.words), unpacked(data)
        kind = rng.random()
        if not calls or kind < 0.1:
            calls.insert(rng.randint(0, len(calls)), self._new(rng, maker))
        elif kind < 0.2:
            calls.insert(rng.randint(0, len(calls)), rng.choice(calls))
        elif kind < 0.25:
            del calls[rng.randrange(len(calls))]
        else:
            place = rng.randrange(len(calls))
            message = _message(calls[place])
            if isinstance(message, Message):
                for _ in range(rng.choice((1, 1, 2, 3))):
                    maker.damage(message)
                calls[place] = Call(calls[place].method, message.SerializeToString())
        return packed(calls[:MOST_CALLS])
