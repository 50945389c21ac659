"""Publishing to a world: signals, and what robots and crafts shall do, published under the names of streams."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.services import Services
from virtualrobot._wire.signal_values import GivenValue, set_command
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.motions.setpoints import SetpointStream
from virtualrobot.robots.robots import Robots
from virtualrobot.streams.table import OUT, TOOL_STREAMS, Stream


@checked
class Publisher:
    """Publisher to one stream; a context manager. `Streams.publisher` makes it.

    A robot follows what is published until the end of the block, or until nothing has come for the timeout. Then it
    comes to rest.
    """

    def __init__(self, services: Services, stream: Stream, timeout: float) -> None:
        """Publish to a stream that the world hears; after `timeout` (s of simulation time) without, robots stop."""
        if stream.direction == OUT:
            raise InvalidArgumentError(f"{stream.name} is told by the world; nobody else publishes it")
        self.stream = stream
        self._setpoints: SetpointStream | None = None
        self._send: Callable[[GivenValue | Mapping[str, float] | ArrayLike], None]
        if stream.watch == "signals":
            self._send = lambda value: _set(services, stream.about, value)  # pyright: ignore[reportArgumentType] it says what is wrong
            return
        robot = Robots(services)[stream.about]
        if stream.content == "twist":
            self._setpoints = robot.stream_twist(timeout=timeout)
        elif stream.content in TOOL_STREAMS:
            self._setpoints = robot.stream_tool(TOOL_STREAMS[stream.content], timeout=timeout)
        else:
            self._setpoints = robot.stream(stream.content, timeout=timeout)
        self._send = self._setpoints.send

    def send(self, value: GivenValue | Mapping[str, float] | ArrayLike) -> None:
        """Publish a value: of a signal its value, else numbers in the order of the joints, or by name.

        A craft's twist is (vx, vy, omega) in m/s and rad/s; a tool's has six values, its pose seven. Raises as
        `SetpointStream.send` and as setting a signal do.
        """
        self._send(value)

    def check(self) -> None:
        """Raise why a robot follows no more, such as a value that was refused; nothing while all is well."""
        if self._setpoints is not None:
            self._setpoints.check()

    def close(self) -> None:
        """Let a robot come to rest."""
        if self._setpoints is not None:
            self._setpoints.close()

    def __enter__(self) -> Publisher:
        """Return itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Let a robot come to rest; stop it at once where the block has failed."""
        if self._setpoints is not None and kind is not None:
            self._setpoints.cancel("the program that published failed")
        else:
            self.close()

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Publisher of {self.stream.name}>"


def _set(services: Services, name: str, value: GivenValue) -> None:
    services.apply([set_command(name, value)])
