"""SignalService: signals."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable, Mapping

from virtualrobot.v1 import signal_pb2, signal_pb2_grpc

from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.errors import UnknownNameError
from virtualrobot_kernel.messages.signals import signal_message
from virtualrobot_kernel.messages.values import stamp
from virtualrobot_kernel.world.state import Signal, Snapshot


class SignalServicer(signal_pb2_grpc.SignalServiceServicer):
    """Servicer of SignalService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel

    async def GetSignals(self, request: signal_pb2.GetSignalsRequest, context: object) -> signal_pb2.GetSignalsResponse:
        """Tell signals as they are."""
        snapshot = self._kernel.world.snapshot
        chosen = _chosen(snapshot.state.signals, request.names)
        return signal_pb2.GetSignalsResponse(stamp=stamp(snapshot), signals=_messages(snapshot, chosen))

    async def WatchSignals(
        self, request: signal_pb2.WatchSignalsRequest, context: object
    ) -> AsyncIterator[signal_pb2.WatchSignalsResponse]:
        """Tell signals, then each change in order."""
        _chosen(self._kernel.world.snapshot.state.signals, request.names)
        told: Mapping[str, Signal] | None = None
        async for snapshot in self._kernel.publications.every_signal_change():
            now = snapshot.state.signals
            if request.names:
                now = {name: now[name] for name in request.names if name in now}
            before: Mapping[str, Signal] = told or {}
            changed = [signal for name, signal in now.items() if before.get(name) != signal]
            removed = [name for name in before if name not in now]
            if changed or removed or told is None:
                yield signal_pb2.WatchSignalsResponse(
                    stamp=stamp(snapshot), signals=_messages(snapshot, changed), removed_names=removed
                )
            told = now


def _messages(snapshot: Snapshot, signals: Iterable[Signal]) -> list[signal_pb2.Signal]:
    return [signal_message(snapshot.structure, signal) for signal in signals]


def _chosen(signals: Mapping[str, Signal], names: Iterable[str]) -> list[Signal]:
    names = list(names)
    for name in names:
        if name not in signals:
            raise UnknownNameError("signal", name, signals)
    return [signals[name] for name in names] if names else list(signals.values())
