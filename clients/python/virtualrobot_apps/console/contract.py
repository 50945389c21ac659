"""The methods of the contract as its descriptors tell them, and their messages as JSON and back."""

from __future__ import annotations

import asyncio
import importlib
import json
import pkgutil
import re
from dataclasses import dataclass
from functools import cache, cached_property

import virtualrobot.v1
from google.protobuf import json_format, message_factory
from google.protobuf.descriptor import FileDescriptor, MethodDescriptor
from google.protobuf.message import DecodeError, Message

from virtualrobot_apps.console.refusal import Refusal

SHARED = {
    "/virtualrobot.v1.DriverService/WatchDrivers",
    "/virtualrobot.v1.KernelService/WatchClock",
    "/virtualrobot.v1.RobotService/WatchRobotStates",
    "/virtualrobot.v1.SceneService/WatchScene",
    "/virtualrobot.v1.ViewService/WatchView",
}
"""Watches whose first answer is everything and whose every answer has a stamp, so that one serves many readers."""

QUICK_BYTES = 16 * 1024
"""Messages that are larger become JSON, or are read from it, in a thread: a scene of thousands of nodes takes a second,
and a stop must not wait for it."""

_MOST_WORDS = 300


@dataclass(frozen=True, slots=True)
class Method:
    """A method of the contract.

    path: as in a URL and in gRPC, `/virtualrobot.v1.MotionService/Stop`.
    """

    path: str
    request: type[Message]
    response: type[Message]
    streams_requests: bool
    streams_answers: bool

    def is_shared(self, request: bytes) -> bool:
        """Return whether one watch serves all who ask for this: not where each wants every tick, none left out."""
        if self.path not in SHARED:
            return False
        try:
            return not getattr(self.request.FromString(request), "every_tick", False)
        except DecodeError:  # the kernel refuses it
            return False

    async def read_json(self, text: bytes) -> bytes:
        """Return what `request_of_json` does; other calls go on meanwhile."""
        if len(text) < QUICK_BYTES:
            return self.request_of_json(text)
        return await asyncio.to_thread(self.request_of_json, text)

    def request_of_json(self, text: bytes) -> bytes:
        """Return the encoded request that JSON says; empty text is an empty request.

        Raises:
            Refusal: INVALID_ARGUMENT with the field in the metadata, where it is known.
        """
        text = text or b"{}"
        try:
            read = json_format.Parse(text, self.request())
            if not text.lstrip().startswith(b"{"):
                raise json_format.ParseError("a message is an object in braces")
        except (json_format.ParseError, UnicodeDecodeError, RecursionError) as error:
            said, field = _explained(text, str(error))
            metadata = {"field": field} if field else {}
            raise Refusal.of("INVALID_ARGUMENT", f"{self.request.DESCRIPTOR.name}: {said}", metadata) from None
        return read.SerializeToString()

    def json_of_answer(self, data: bytes) -> bytes:
        """Return an encoded answer as a line of JSON with the contract's names and all fields that are always there."""
        try:
            message = self.response.FromString(data)
        except DecodeError as error:
            raise Refusal("internal", f"the kernel's answer is no {self.response.DESCRIPTOR.name}: {error}") from None
        said = json_format.MessageToDict(
            message, preserving_proto_field_name=True, always_print_fields_with_no_presence=True
        )
        return json.dumps(said, separators=(",", ":")).encode()


class Answer:
    """An encoded answer, made JSON at most once however many pages read it."""

    def __init__(self, method: Method, data: bytes) -> None:
        """Keep the bytes as they came."""
        self._method = method
        self.data = data

    async def make_json(self) -> None:
        """Have `json` ready; other calls go on meanwhile."""
        if len(self.data) >= QUICK_BYTES:
            await asyncio.to_thread(getattr, self, "json")

    @cached_property
    def json(self) -> bytes:
        """The answer as a line of JSON."""
        return self._method.json_of_answer(self.data)

    @cached_property
    def moment(self) -> tuple[int, int]:
        """Epoch and state revision of its stamp, by which answers of a watch that is shared have an order."""
        stamp = getattr(self._method.response.FromString(self.data), "stamp")  # noqa: B009 each response has its own type
        return stamp.epoch, stamp.state_revision


@cache
def methods() -> dict[str, Method]:
    """Return all methods of the contract by path."""
    found = {}
    for module in pkgutil.iter_modules(virtualrobot.v1.__path__):
        if module.name.endswith("_pb2"):
            file: FileDescriptor = importlib.import_module(f"virtualrobot.v1.{module.name}").DESCRIPTOR
            for service in file.services_by_name.values():
                for method in service.methods:
                    one = _method(method)
                    found[one.path] = one
    return found


def _method(method: MethodDescriptor) -> Method:
    return Method(
        f"/{method.containing_service.full_name}/{method.name}",
        message_factory.GetMessageClass(method.input_type),
        message_factory.GetMessageClass(method.output_type),
        method.client_streaming,
        method.server_streaming,
    )


def _explained(text: bytes, said: str) -> tuple[str, str]:
    """Return in words what is wrong with JSON, and the field that it is about, "" where that isn't known."""
    try:
        json.loads(text)
    except json.JSONDecodeError as error:
        before = text.decode("utf-8", "replace")[: error.pos]
        names = re.findall(r'"([^"\\]+)"\s*:', before)
        field = names[-1] if names else ""
        place = f"after the field {field!r}, near {before[-20:]!r}" if field else "at its beginning"
        hint = "; decimals have a point, 1.5 and not 1,5" if re.search(r"\d\s*,\s*\d*\s*$", before) else ""
        return f"this is no JSON {place}: {error.msg} in line {error.lineno}, column {error.colno}{hint}", field
    except (UnicodeDecodeError, RecursionError):
        return "this is no JSON: it is no UTF-8, or nested too deeply", ""
    # "Failed to parse commands field: Failed to parse factor field: Couldn't parse float: 1,5 at Request.a.b.."
    names = re.findall(r"Failed to parse (\w+) field: ", said)
    last = re.sub(r"Failed to parse \w+ field: ", "", said).split("\n")[0].rstrip(".")
    place = re.search(r' at "?\w+\.([\w.\[\]]+)"?$', last)
    unknown = re.search(r'has no field named "([^"]+)"', last)
    field = place[1] if place else ".".join(names)
    if unknown:
        field = ".".join([field, unknown[1]] if field else [unknown[1]])
    hint = "; decimals have a point, 1.5 and not 1,5" if re.search(r"\d,\d", last) else ""
    return f"{f'field {field}: ' if field else ''}{last[:_MOST_WORDS]}{hint}", field
