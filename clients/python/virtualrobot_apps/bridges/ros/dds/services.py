"""Services by DDS as rmw_cyclonedds carries them: topics of requests and of replies, with who has asked as a header.

Source: rmw_cyclonedds_cpp, rmw_node.cpp: `cdds_request_header_t`, `rmw_init_cs`, `rmw_send_response`.
"""

from __future__ import annotations

import asyncio
import struct
import time
from typing import Any

from cyclonedds.core import DDSException, Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic

from virtualrobot_apps.bridges.ros.dds.types import Heard, idl_type, quality
from virtualrobot_apps.bridges.ros.hub import HubError, Service
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.values import refusal

QUEUE, MOST_CALLS = 100, 64
"""Requests that wait to be taken, and calls of a service that go on at once."""

_MATCH_SECONDS, _LOOK_SECONDS = 1.0, 0.01
_ENCAPSULATION, _LITTLE_ENDIAN = 4, b"\x00\x01\x00\x00"


def header_of(cdr: bytes) -> tuple[bytes, bytes]:
    """Return the header of a request, as replies repeat it (16 bytes, little-endian), and its message in CDR.

    Raises:
        ValueError: when there are fewer bytes than a header has.
    """
    order = "<" if cdr[1:2] == b"\x01" else ">"
    try:
        numbers = struct.unpack_from(f"{order}Qq", cdr, _ENCAPSULATION)
    except struct.error as error:
        raise ValueError("a request begins with a header of 16 bytes") from error
    header = struct.pack("<Qq", *numbers)
    # 16 bytes keep the alignment to 8 that CDR has behind its first 4 bytes.
    return header, cdr[:_ENCAPSULATION] + cdr[_ENCAPSULATION + len(header) :]


class DdsService:
    """A service in a domain; `reader` and `writer` are told of in the graph of ROS 2."""

    def __init__(self, participant: DomainParticipant, service: Service, identity: str) -> None:
        """Serve in the domain; `identity` tells which reader and writer belong together."""
        self._service = service
        self._loop = asyncio.get_running_loop()
        self._tasks: set[asyncio.Task[None]] = set()
        qos = quality(latched=False, depth=QUEUE) + Qos(Policy.Userdata(f"serviceid={identity};".encode()))
        self._listener = Heard(lambda cdr, writer: self._loop.call_soon_threadsafe(self._begin, cdr, writer))
        request, response = (
            idl_type(f"{service.type}_{part}", raw=True, called=True) for part in ("Request", "Response")
        )
        reply = DdsTopic(participant, f"rr{service.name}Reply", response)
        self.writer = DataWriter(participant, reply, qos=qos)
        asked = DdsTopic(participant, f"rq{service.name}Request", request)
        self.reader = DataReader(participant, asked, qos=qos, listener=self._listener)
        self._make_reply = response

    def close(self) -> None:
        """Answer no more."""
        for task in self._tasks:
            task.cancel()

    def _begin(self, cdr: bytes, writer: int) -> None:
        task = self._loop.create_task(self._call(cdr, writer))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _call(self, cdr: bytes, writer: int) -> None:
        """Answer a request: always, as its caller waits for ever; ROS 2 has no other way to tell a refusal."""
        try:
            header, body = header_of(cdr)
        except ValueError:
            return
        type = self._service.type
        try:
            if len(self._tasks) > MOST_CALLS:
                raise HubError(f"{MOST_CALLS} calls go on at once; ask again later")
            request = Message.from_cdr(f"{type}_Request", body).value
            answer = Message(f"{type}_Response", await self._service.answer(request)).cdr
        except Exception as error:  # whatever a service raises, and rosbags for bytes of another type
            answer = Message(f"{type}_Response", refusal(type, str(error) or repr(error))).cdr
        await asyncio.to_thread(self._reply, header, answer, writer)

    def _reply(self, header: bytes, answer: bytes, writer: int) -> None:
        try:
            self._await_reader(writer)
            self.writer.write(self._make_reply(_LITTLE_ENDIAN + header + answer[_ENCAPSULATION:]))
        except DDSException:
            pass  # who has asked is gone, or does not read

    def _await_reader(self, writer: int) -> None:
        """Wait until the reader of who has asked is known: what is written before, it would not get."""
        due = time.monotonic() + _MATCH_SECONDS
        client = _identity(self.reader.get_matched_publication_data(writer))
        while client and time.monotonic() < due:
            readers = (
                self.writer.get_matched_subscription_data(one) for one in self.writer.get_matched_subscriptions()
            )
            if any(_identity(one) == client for one in readers):
                return
            time.sleep(_LOOK_SECONDS)


def _identity(endpoint: Any) -> bytes:  # noqa: ANN401 an endpoint, or None
    """Return by what a client's reader and writer tell that they belong together; empty where they don't."""
    told = next((one for one in endpoint.qos if isinstance(one, Policy.Userdata)), None) if endpoint else None
    pairs = (one.partition(b"=") for one in (told.data if told else b"").split(b";"))
    return next((value for key, _, value in pairs if key == b"clientid"), b"")
