"""Calls that take long: what is told of them, and that who gives them up ends them in the kernel, too."""

from __future__ import annotations

import io
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import grpc
import pytest
from google.protobuf import descriptor_pool
from virtualrobot._wire.services import Services
from virtualrobot._wire.transport import TOLD_AFTER_SECONDS, WAITED, open_channel
from virtualrobot.progress import Progress, show_progress
from virtualrobot.v1 import motion_pb2, motion_pb2_grpc

WAIT = 60.0


class Slow(motion_pb2_grpc.MotionServiceServicer):
    """A kernel whose plans take until it is let go on."""

    def __init__(self) -> None:
        """Wait."""
        self.goes_on, self.given_up = threading.Event(), threading.Event()

    def PlanMotion(self, request: motion_pb2.PlanMotionRequest, context: Any) -> motion_pb2.PlanMotionResponse:  # noqa: ANN401 grpcio has no type for it
        """Answer when it may, or when nobody waits any more."""
        context.add_callback(lambda: (self.given_up.set(), self.goes_on.set()))
        self.goes_on.wait(WAIT)
        return motion_pb2.PlanMotionResponse(duration_seconds=1.0)


@pytest.fixture
def slow() -> Iterator[tuple[Slow, Services]]:
    """Return such a kernel and its stubs."""
    server, servicer = grpc.server(ThreadPoolExecutor(2)), Slow()
    motion_pb2_grpc.add_MotionServiceServicer_to_server(servicer, server)
    port = server.add_insecure_port("127.0.0.1:0")
    server.start()
    channel = open_channel(f"127.0.0.1:{port}", "127.0.0.1", None, None, WAIT)
    yield servicer, Services(channel, "a slow kernel")
    channel.close()
    servicer.goes_on.set()
    server.stop(None).wait(WAIT)


def test_what_takes_long_are_calls_of_the_contract_with_one_answer() -> None:
    for path in WAITED:
        service, method = path.removeprefix("/").split("/")
        described = descriptor_pool.Default().FindServiceByName(service).methods_by_name[method]
        assert not described.server_streaming


def test_a_call_that_takes_long_is_told_of_until_it_ends(slow: tuple[Slow, Services]) -> None:
    servicer, services = slow
    told: list[Progress] = []

    def on_progress(progress: Progress) -> None:
        told.append(progress)
        if len(told) == 2:
            servicer.goes_on.set()

    services.channel.on_progress = on_progress
    assert services.motion.PlanMotion(motion_pb2.PlanMotionRequest()).duration_seconds == 1.0
    assert {one.what for one in told} == {"planning"}
    assert [one.ended for one in told] == [False] * (len(told) - 1) + [True]
    assert told[0].elapsed >= TOLD_AFTER_SECONDS
    assert [one.elapsed for one in told] == sorted(one.elapsed for one in told)
    # This one has not to wait.
    assert services.motion.PlanMotion(motion_pb2.PlanMotionRequest()) and told[-1].ended


@pytest.mark.parametrize("reason", [KeyboardInterrupt, ValueError])
def test_ctrl_c_and_what_the_listener_raises_end_the_call_in_the_kernel(
    slow: tuple[Slow, Services], reason: type[BaseException]
) -> None:
    servicer, services = slow

    def on_progress(progress: Progress) -> None:
        if not progress.ended:
            raise reason

    services.channel.on_progress = on_progress
    with pytest.raises(reason):
        services.motion.PlanMotion(motion_pb2.PlanMotionRequest())
    assert servicer.given_up.wait(WAIT)


def test_who_wants_to_hear_nothing_hears_nothing(
    slow: tuple[Slow, Services], capsys: pytest.CaptureFixture[str]
) -> None:
    servicer, services = slow
    threading.Timer(2.0 * TOLD_AFTER_SECONDS, servicer.goes_on.set).start()
    services.motion.PlanMotion(motion_pb2.PlanMotionRequest())
    services.channel.on_progress = show_progress  # stderr is no terminal here
    services.motion.PlanMotion(motion_pb2.PlanMotionRequest())
    show_progress(Progress("planning", 1.0))
    assert capsys.readouterr() == ("", "")


def test_a_terminal_shows_a_line_that_goes(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr(sys, "stderr", screen := Terminal())
    show_progress(Progress("looking for a path", 1.26, "30 configurations"))
    show_progress(Progress("looking for a path", 1.5, ended=True))
    assert screen.getvalue() == "\r\x1b[Klooking for a path: 1.3 s 30 configurations\r\x1b[K"
