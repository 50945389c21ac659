"""Tools of the page that are no calls of the contract: connections, films, paths, mappings, curves, processes.

Each is a path of the console's own port, with JSON both ways. Whoever asks needs what the kernel would want, a token
and a role, and what is done is done with that token.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from google.protobuf import json_format
from virtualrobot import Client
from virtualrobot.cli import gamepad_mapping
from virtualrobot.errors import InvalidArgumentError, VirtualRobotError
from virtualrobot.motions.moves import messages_of
from virtualrobot.v1 import token_pb2

from virtualrobot_apps.console import processing
from virtualrobot_apps.console.films import Films, camera_of, size_of
from virtualrobot_apps.console.http_calls import Caller, Receive, Send, begin, refuse
from virtualrobot_apps.console.plots import Plots, curves_of
from virtualrobot_apps.console.refusal import Refusal
from virtualrobot_apps.console.registering import by_pictures, by_touches
from virtualrobot_apps.console.upstream import Upstream
from virtualrobot_apps.console.wires import Limit
from virtualrobot_apps.console.wiring import Wiring


@dataclass(frozen=True, slots=True)
class _Asked:
    """A request: the token that it came with, and the fields of its JSON."""

    token: str
    said: Mapping[str, Any]

    def text(self, field: str) -> str:
        value = self.said.get(field, "")
        if not isinstance(value, str):
            raise InvalidArgumentError(f"{field!r} is a text, not {value!r:.60}")
        return value


Work = Callable[[_Asked], object]

FILMS = "/films/"
"""Path of films, followed by their names."""
STILL = "/cell.usdz"
"""Path of the cell as it stands, for phones and headsets of Apple."""
_CHUNK_BYTES = 1024 * 1024


class PageTools:
    """The tools of one console; all its pages share them."""

    def __init__(self, upstream: Upstream, limit: Limit, connect: Callable[[str], Client]) -> None:
        """Work for pages as `connect` gives a client of the kernel with a token."""
        self._upstream, self._limit, self._connect = upstream, limit, connect
        self._wiring, self._films, self._plots = Wiring(connect), Films(connect), Plots(connect)
        observer, operator = token_pb2.ROLE_OBSERVER, token_pb2.ROLE_OPERATOR
        self._work: dict[tuple[str, str], tuple[int, Work]] = {
            ("GET", "/connections"): (observer, lambda _: self._wiring.state()),
            ("POST", "/connections/open"): (operator, self._open),
            ("POST", "/connections/set"): (operator, self._set),
            ("POST", "/connections/remove"): (operator, lambda one: self._wiring.remove(one.token, one.text("target"))),
            ("POST", "/connections/run"): (operator, lambda one: self._wiring.run(one.token)),
            ("POST", "/connections/pause"): (operator, lambda _: self._wiring.pause()),
            ("POST", "/trajectory"): (observer, self._trajectory),
            ("POST", "/mapping"): (observer, _mapping),
            # Whoever may look may measure; what is kept in the world is the kernel's to refuse.
            ("POST", "/registration/touched"): (observer, lambda one: self._with_client(one, by_touches)),
            ("POST", "/registration/pictures"): (observer, lambda one: self._with_client(one, by_pictures)),
            ("GET", "/streams"): (observer, lambda one: self._plots.streams(one.token)),
            ("POST", "/curves"): (observer, self._curves),
            # Nothing of a process moves here: its program is the page's to start, and the kernel's to refuse.
            ("GET", "/processes"): (observer, lambda _: processing.names()),
            ("POST", "/processes/new"): (observer, lambda one: processing.new(one.said)),
            ("POST", "/processes/read"): (observer, lambda one: processing.read(one.said)),
            ("POST", "/processes/change"): (observer, lambda one: processing.change(one.said)),
            ("POST", "/processes/edge"): (observer, lambda one: self._with_client(one, processing.edge)),
            ("POST", "/processes/look"): (observer, lambda one: self._with_client(one, processing.look)),
            ("POST", "/processes/plan"): (observer, lambda one: self._with_client(one, processing.plan)),
            # Whoever may look may film, as the kernel has it.
            ("GET", "/films"): (observer, lambda _: self._films.state()),
            ("POST", "/films/start"): (observer, self._start_film),
            ("POST", "/films/stop"): (observer, lambda one: self._films.stop(one.text("name"))),
            ("POST", "/films/remove"): (observer, lambda one: self._films.remove(one.text("name"))),
        }

    async def begin(self, token: str, connections: Path) -> None:
        """Run the connections of a file with a token; raises what is wrong with it."""
        await asyncio.to_thread(self._wiring.open_file, token, connections)

    def knows(self, path: str) -> bool:
        """Return whether a path is that of a tool."""
        return path == STILL or path.startswith(FILMS) or any(path == one for _, one in self._work)

    async def serve(self, path: str, verb: str, caller: Caller, receive: Receive, send: Send) -> None:
        """Answer one request with JSON, `{}` where there is nothing to tell."""
        try:
            if verb == "GET" and path.startswith(FILMS):
                await self._admitted(caller, token_pb2.ROLE_OBSERVER, {})
                await _send_file(self._films.path(path.removeprefix(FILMS)), send)
                return
            if verb == "GET" and path == STILL:
                asked = await self._admitted(caller, token_pb2.ROLE_OBSERVER, {})
                await _send_bytes(await asyncio.to_thread(self._still, asked), "model/vnd.usdz+zip", send)
                return
            if (verb, path) not in self._work:
                raise Refusal("unimplemented", f"{path} is asked for otherwise than by {verb}", status=405)
            role, work = self._work[verb, path]
            said = await self._read(receive) if verb == "POST" else {}
            asked = await self._admitted(caller, role, said)
            done = await asyncio.to_thread(work, asked)
        except VirtualRobotError as error:
            await refuse(send, Refusal.of_client(error))
        except Refusal as refusal:
            await refuse(send, refusal)
        else:
            await begin(send, 200, "application/json")
            await send({"type": "http.response.body", "body": json.dumps({} if done is None else done).encode()})

    async def close(self) -> None:
        """End what runs."""
        await asyncio.to_thread(self._wiring.close)
        await asyncio.to_thread(self._films.close)
        await asyncio.to_thread(self._plots.close)

    async def _read(self, receive: Receive) -> dict[str, Any]:
        body, more = bytearray(), True
        while more:
            event = await receive()
            if event["type"] == "http.disconnect":
                raise Refusal("canceled", "the client has gone")
            body += event.get("body", b"")
            self._limit.check(len(body))
            more = event.get("more_body", False)
        try:
            said = json.loads(bytes(body) or b"{}")
        except (ValueError, RecursionError):
            said = None
        if not isinstance(said, dict):
            raise Refusal.of("INVALID_ARGUMENT", "what is asked is one object as JSON")
        return said

    async def _admitted(self, caller: Caller, role: int, said: Mapping[str, Any]) -> _Asked:
        metadata = caller.metadata()
        given = (await self._upstream.info(metadata)).role
        if given < role:
            needed, has = (token_pb2.Role.Name(one).removeprefix("ROLE_").lower() for one in (role, given))
            raise Refusal("permission_denied", f"this needs the role {needed}, and the token is one of the role {has}")
        token = dict(metadata).get("authorization", "").removeprefix("Bearer ")
        return _Asked(token, said)

    def _open(self, asked: _Asked) -> None:
        self._wiring.open(asked.token, asked.text("text"), asked.text("name") or "connections.yaml")

    def _set(self, asked: _Asked) -> None:
        if "source" not in asked.said:
            raise InvalidArgumentError("a connection needs its 'source'")
        self._wiring.set(asked.token, asked.text("target"), asked.said["source"])

    def _start_film(self, asked: _Asked) -> None:
        camera, size = camera_of(asked.said.get("camera")), size_of(asked.said.get("size"))
        self._films.start(asked.token, camera, size)

    def _with_client(self, asked: _Asked, by: Callable[[Client, Mapping[str, Any]], object]) -> object:
        with self._connect(asked.token) as client:
            return by(client, asked.said)

    def _still(self, asked: _Asked) -> bytes:
        with self._connect(asked.token) as client, TemporaryDirectory() as folder:
            client.scene.export("world", file := Path(folder, "cell.usdz"))
            return file.read_bytes()

    def _curves(self, asked: _Asked) -> object:
        return self._plots.read(asked.token, asked.text("page"), curves_of(asked.said.get("curves")))

    def _trajectory(self, asked: _Asked) -> object:
        """Return what a file says for a robot, as the contract's JointTrajectory in JSON."""
        with self._connect(asked.token) as client:
            robot = client.robot(asked.text("robot"))
            move = robot.read_trajectory(asked.text("name") or "trajectory.csv", asked.text("text"))
        (message,) = messages_of([move])
        return json_format.MessageToDict(message.joint_trajectory)


DEVICES = {
    "gamepad": (gamepad_mapping.GAMEPAD, gamepad_mapping.USUAL),
    "space-mouse": (gamepad_mapping.SPACE_MOUSE, gamepad_mapping.USUAL_SPACE_MOUSE),
    "keyboard": (gamepad_mapping.KEYBOARD, gamepad_mapping.USUAL_KEYBOARD),
}
"""Devices of pages, and the files of their usual mappings."""
MOST_LETTERS = 100_000
"""Most letters of a mapping that a page sends."""


def _mapping(asked: _Asked) -> object:
    """Return what a mapping says for a device: that of the text, or the usual one where there is none."""
    if asked.text("device") not in DEVICES:
        raise InvalidArgumentError(f"a device is {' or '.join(DEVICES)}, not {asked.text('device')!r}")
    device, usual = DEVICES[asked.text("device")]
    if "text" not in asked.said:
        return asdict(gamepad_mapping.read_mapping(usual, device))
    name = asked.text("name") or "mapping.yaml"
    if len(asked.text("text")) > MOST_LETTERS:
        raise InvalidArgumentError(f"{name} has {len(asked.text('text'))} letters, at most {MOST_LETTERS} are read")
    return asdict(gamepad_mapping.mapping_of(asked.text("text"), name, device))


async def _send_bytes(data: bytes, kind: str, send: Send) -> None:
    length = (b"content-length", str(len(data)).encode())
    headers = [(b"content-type", kind.encode()), length, (b"cache-control", b"no-store")]
    await send({"type": "http.response.start", "status": 200, "headers": headers})
    await send({"type": "http.response.body", "body": data})


async def _send_file(path: Path, send: Send) -> None:
    """Answer with a film, to be saved under its name."""
    headers = [
        (b"content-type", b"video/mp4"),
        (b"content-length", str(path.stat().st_size).encode()),
        (b"content-disposition", f'attachment; filename="{path.name}"'.encode()),
        (b"cache-control", b"no-store"),
    ]
    with path.open("rb") as file:
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        while chunk := file.read(_CHUNK_BYTES):
            await send({"type": "http.response.body", "body": chunk, "more_body": True})
    await send({"type": "http.response.body", "body": b""})
