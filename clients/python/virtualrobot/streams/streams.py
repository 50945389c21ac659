"""The streams of one kernel by name: which there are, what they tell, and what may be told to the world."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import listed, table_html, told
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.streams.publishing import Publisher
from virtualrobot.streams.sample import Sample
from virtualrobot.streams.scans import ScanGeometry, scan_geometry
from virtualrobot.streams.table import IN, Stream, chosen
from virtualrobot.streams.table import table as table_of
from virtualrobot.streams.watch import StreamWatch


@checked
class Streams(Mapping[str, Stream]):
    """The streams of one kernel, like a dictionary of names to rows of the table.

    Example:
        >>> with client.streams.watch("/robots/arm/tcp") as watch:
        ...     for sample in watch:
        ...         print(sample.time, sample.values["z"])
        >>> client.streams.sample("/sensors/lidar/scan").values["nearest"]
        >>> with client.streams.publisher("/robots/ugv/command/twist") as twist:
        ...     twist.send([0.3, 0.0, 0.1])
    """

    def __init__(self, services: Services) -> None:
        """Handle the streams of one kernel."""
        self._services = services

    def table(self) -> list[Stream]:
        """Return the streams that there are now, in the table's order."""
        return table_of(self._services)

    def watch(self, *names: str) -> StreamWatch:
        """Watch streams by their names, or by patterns such as `/robots/*`; every tick and reading comes.

        Sensors read while they are watched, whether they were started or not. What happens after this has returned is
        not left out; what this program is too slow for is counted (`Sample.lost`).

        Raises:
            UnknownNameError: for a name or pattern that fits no stream.
            InvalidArgumentError: for a name or pattern of what the world only hears, and tells nobody.
        """
        if not names:
            raise InvalidArgumentError("say which streams, by names or patterns; '*' is all")
        return StreamWatch(self._services, told_streams(self._services, names))

    def sample(self, name: str, timeout: float = 10.0) -> Sample:
        """Return the next sample of a stream; raises CallTimeoutError after `timeout` (s of the wall clock) without."""
        from virtualrobot.errors import CallTimeoutError

        with self.watch(name) as watch:
            if (sample := watch.next(timeout)) is None:
                raise CallTimeoutError(f"{name} has told nothing for {timeout:g} s")
            return sample

    def scan_geometry(self, sensor: str) -> ScanGeometry:
        """Return what the distances of a range sensor are measured along, and how far; for those who draw them."""
        return scan_geometry(self._services, sensor)

    def publisher(self, name: str, *, timeout: float = 0.5) -> Publisher:
        """Publish to a stream that the world hears: a signal, or commands of a robot.

        Args:
            name: such as `/signals/gripper`, `/robots/ugv/command/twist`, `/robots/arm/command/position`.
            timeout: after how many seconds of simulation time without a value a robot stops.

        Raises:
            UnknownNameError: when there is no such stream.
            InvalidArgumentError: when the world alone tells it.
            RobotBusyError: when the robot moves already.
        """
        return Publisher(self._services, self[name], timeout)

    def __getitem__(self, name: str) -> Stream:
        """Return a stream; raises UnknownNameError, a KeyError, when there is none of this name."""
        from virtualrobot._wire.names import unknown_name

        known = {one.name: one for one in self.table()}
        if name not in known:
            raise unknown_name("no stream", name, list(known))
        return known[name]

    def __iter__(self) -> Iterator[str]:
        """Return the names."""
        return iter([one.name for one in self.table()])

    def __len__(self) -> int:
        """Return the count of streams."""
        return len(self.table())

    def _ipython_key_completions_(self) -> list[str]:
        """Return the names that IPython completes."""
        return [*self]

    def _repr_html_(self) -> str:
        """Return a table for notebooks."""
        rows = [[one.name, one.type, rate_words(one), one.unit, one.frame] for one in self.table()]
        return table_html("Streams", [["stream", "type", "rate", "unit", "frame"], *rows])

    def __repr__(self) -> str:
        """Return a line for people."""
        return told("Streams", lambda: listed(list(self), "none"))


def told_streams(services: Services, names: Sequence[str]) -> list[Stream]:
    """Return the streams of some names or patterns that the world tells; raises as `Streams.watch` does."""
    table = table_of(services)
    for name in names:
        if all(one.direction == IN for one in chosen(table, [name])):
            raise InvalidArgumentError(f"{name} is only heard by the world; publish to it")
    return [one for one in chosen(table, names) if one.direction != IN]


def rate_words(stream: Stream) -> str:
    """Return the rate of a stream in words."""
    return "at changes" if stream.rate is None else f"{stream.rate:g} Hz"
