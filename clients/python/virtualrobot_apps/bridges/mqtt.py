"""MQTT: client of a broker, by paho. Values are JSON (true, 1.5), texts are themselves."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import Mapping, Sequence
from urllib.parse import unquote, urlsplit

from paho.mqtt.client import Client, MQTTMessage
from paho.mqtt.enums import CallbackAPIVersion
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.bridges.mapping import BridgeMapping, Entry
from virtualrobot_apps.bridges.peer import Peer, PeerError
from virtualrobot_apps.bridges.words import Raw

QUALITY = 1
"""Quality of service: each message comes at least once."""

LOGIN = ("Bad user name or password", "Not authorized")
"""Reasons of a refusal that another user or password may mend."""


Event = dict[Entry, object] | PeerError | None
"""Event of a broker: values of topics, that it refuses or is gone, or (None) that it has done as it was asked."""


def payload_of(entry: Entry, raw: Raw) -> bytes:
    """Return the bytes of a message for a value."""
    return (str(raw) if entry.type == "text" else json.dumps(raw)).encode()


def value_of(entry: Entry, payload: bytes) -> object:
    """Return the value of a message; what is none is returned as text, which only a text takes."""
    text = payload.decode("utf-8", "replace")
    if entry.type == "text":
        return text
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


class MqttClient(Peer):
    """Client of a broker: what goes out is retained, so that who comes later hears it, too."""

    def __init__(self, mapping: BridgeMapping, url: str) -> None:
        """Talk to the broker `mqtt://[USER:PASSWORD@]HOST[:PORT]`; what an URL reserves is written as in %40 for @."""
        parts = urlsplit(url)
        try:
            port = parts.port or 1883
        except ValueError as error:
            raise InvalidArgumentError(f"{url!r}: {error}") from error
        if parts.scheme != "mqtt" or not parts.hostname:
            raise InvalidArgumentError(f"{url!r} is not mqtt://HOST:PORT")
        self.name = f"mqtt://{parts.hostname}:{port}"
        self._host, self._port = parts.hostname, port
        self._user = None if parts.username is None else unquote(parts.username)
        self._password = None if parts.password is None else unquote(parts.password)
        self._mapping = mapping
        self._entries = {entry.place: entry for entry in mapping.entries if entry.incoming}
        self._client: Client | None = None
        self._events: asyncio.Queue[Event] = asyncio.Queue()

    async def open(self) -> None:
        """Connect and subscribe."""
        loop = asyncio.get_running_loop()
        events: asyncio.Queue[Event] = asyncio.Queue()
        self._events = events

        def tell(event: Event) -> None:
            with contextlib.suppress(RuntimeError):  # the loop has ended meanwhile
                loop.call_soon_threadsafe(events.put_nowait, event)

        def connected(client: Client, data: object, flags: object, reason: object, properties: object) -> None:
            tell(PeerError(self._refusal(str(reason))) if getattr(reason, "is_failure", False) else None)

        def disconnected(client: Client, data: object, flags: object, reason: object, properties: object) -> None:
            tell(PeerError(f"the broker is gone: {reason}"))

        def subscribed(
            client: Client, data: object, number: int, reasons: Sequence[object], properties: object
        ) -> None:
            # The answer has a reason for each topic, in the order of the question (MQTT 3.1.1, 3.9.3).
            answers = zip(self._entries, reasons, strict=True)
            refused = [topic for topic, reason in answers if getattr(reason, "is_failure", False)]
            tell(PeerError(self._unheard(refused)) if refused else None)

        def message(client: Client, data: object, message: MQTTMessage) -> None:
            if (entry := self._entries.get(message.topic)) is not None:
                tell({entry: value_of(entry, bytes(message.payload))})

        client = self._client = Client(CallbackAPIVersion.VERSION2, reconnect_on_failure=False)
        client.on_connect, client.on_disconnect = connected, disconnected
        client.on_subscribe, client.on_message = subscribed, message
        if self._user is not None:
            client.username_pw_set(self._user, self._password)
        client.connect_timeout = self._mapping.timeout
        # A broker that is silent for that long is gone.
        alive = max(1, round(self._mapping.timeout))
        try:
            await asyncio.to_thread(client.connect, self._host, self._port, alive)
        except (OSError, ValueError) as error:
            raise PeerError(f"nobody answers: {error}") from error
        client.loop_start()
        await self._answer(events)
        if self._entries:
            client.subscribe([(topic, QUALITY) for topic in self._entries])
            told: list[Event] = []
            while (event := await self._answer(events)) is not None:
                told.append(event)  # a broker may send what it retains before it answers
            while not events.empty():
                told.append(events.get_nowait())
            for event in told:
                events.put_nowait(event)

    async def _answer(self, events: asyncio.Queue[Event]) -> dict[Entry, object] | None:
        """Return the next event, None for an answer; raise PeerError for a refusal, and where there is none."""
        try:
            event = await asyncio.wait_for(events.get(), 2 * self._mapping.timeout)
        except TimeoutError as error:
            raise PeerError("the broker says nothing") from error
        if isinstance(event, PeerError):
            raise event
        return event

    def _refusal(self, reason: str) -> str:
        if reason not in LOGIN:
            return f"the broker refuses: {reason}"
        who = "a login without a user" if self._user is None else f"the login of {self._user!r}"
        return f"the broker refuses {who}: {reason}; user and password stand in mqtt://USER:PASSWORD@HOST:PORT"

    def _unheard(self, topics: Sequence[str]) -> str:
        who = "whoever logs in without a user" if self._user is None else repr(self._user)
        which = f"topic{'s' if len(topics) > 1 else ''} {', '.join(map(repr, topics))}"
        return f"the broker does not let {who} hear the {which}; its access list says who may"

    async def read(self) -> dict[Entry, object]:
        """Wait for the next message."""
        event = await self._events.get()
        if isinstance(event, PeerError):
            raise event
        return event or {}

    async def write(self, values: Mapping[Entry, Raw]) -> None:
        """Publish."""
        assert self._client is not None
        for entry, raw in values.items():
            sent = self._client.publish(entry.place, payload_of(entry, raw), QUALITY, retain=True)
            if sent.rc != 0:
                raise PeerError(f"{entry.place} is not published: code {sent.rc}")

    async def close(self) -> None:
        """Disconnect."""
        if self._client is not None:
            client, self._client = self._client, None
            client.disconnect()
            await asyncio.to_thread(client.loop_stop)
