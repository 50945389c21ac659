"""Digital signals by name: set, get, watch, wait for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping, Sequence

from virtualrobot.editor import Direct
from virtualrobot.errors import CallTimeoutError
from virtualrobot.services import Services
from virtualrobot.v1 import signal_pb2


class Signals(MutableMapping[str, bool]):
    """The digital signals of one kernel, like a dictionary of names to values.

    Example:
        >>> client.signals.create("gripper closed")
        >>> client.signals["gripper closed"] = True
        >>> client.signals.wait_for("box arrived", timeout=10.0)
    """

    def __init__(self, services: Services) -> None:
        """Handle the signals of one kernel."""
        self._services = services

    def create(self, name: str, value: bool = False, description: str = "") -> None:
        """Add a signal; raises NameTakenError when there is one of this name."""
        Direct(self._services).create_signal(name, value, description)

    def read(self, names: Sequence[str] = ()) -> list[signal_pb2.Signal]:
        """Return all signals, or these, with their descriptions."""
        return list(self._services.signal.GetSignals(signal_pb2.GetSignalsRequest(names=names)).signals)

    def set(self, values: Mapping[str, bool]) -> None:
        """Set several signals at the same instant."""
        self._services.signal.SetSignals(signal_pb2.SetSignalsRequest(values=values))

    def watch(self, names: Sequence[str] = ()) -> Iterator[dict[str, bool]]:
        """Yield the values of all signals, or of these, and then those that are new or changed; no change is lost."""
        with self._services.signal.WatchSignals(signal_pb2.WatchSignalsRequest(names=names)) as stream:
            for response in stream:
                yield {signal.name: signal.value for signal in response.signals}

    def wait_for(self, name: str, value: bool = True, timeout: float | None = None) -> None:
        """Wait until a signal has this value; return at once when it has it already.

        Raises:
            CallTimeoutError: when it does not have it within `timeout` seconds of the wall clock.
            UnknownNameError: when there is no such signal.
        """
        request = signal_pb2.WatchSignalsRequest(names=[name])
        try:
            with self._services.signal.WatchSignals(request, timeout=timeout) as stream:
                for response in stream:
                    if any(signal.name == name and signal.value == value for signal in response.signals):
                        return
        except CallTimeoutError as error:
            wanted = "on" if value else "off"
            raise CallTimeoutError(f"the signal {name!r} was not {wanted} within {timeout} s") from error

    def __getitem__(self, name: str) -> bool:
        """Return the value of a signal."""
        return self.read([name])[0].value

    def __setitem__(self, name: str, value: bool) -> None:
        """Set a signal that exists; see `create`."""
        self.set({name: bool(value)})

    def __delitem__(self, name: str) -> None:
        """Take a signal out of the world."""
        Direct(self._services).remove_signal(name)

    def __iter__(self) -> Iterator[str]:
        """Return the names."""
        return iter([signal.name for signal in self.read()])

    def __len__(self) -> int:
        """Return the count of signals."""
        return len(self.read())

    def __repr__(self) -> str:
        """Return names and values."""
        return f"<Signals { ({signal.name: signal.value for signal in self.read()}) }>"
