"""Calls of pages in one WebSocket: answers in order, cancelled with the page, and hold-to-run through it."""

from __future__ import annotations

import signal
from contextlib import ExitStack, suppress

import pytest
from virtualrobot.v1 import kernel_pb2, lease_pb2, motion_pb2
from websockets.exceptions import ConnectionClosed, InvalidStatus

from tests.api.asking import IIWA, joints, load
from tests.api.reading import state, step
from tests.apps.console.consoles import (
    BEGIN,
    CANCEL,
    END,
    HEAD,
    MESSAGE,
    PATIENCE_SECONDS,
    Console,
    PageRefused,
    consoles,
)
from tests.kernels import KernelProcess, StartKernel, Stubs
from tests.waiting import until

PAUSED, RUNNING = motion_pb2.MOTION_PHASE_PAUSED, motion_pb2.MOTION_PHASE_RUNNING


def test_many_calls_go_through_one_connection(console: Console, stepped: Stubs) -> None:
    load(stepped, IIWA, name="arm")
    with console.page() as page:
        # More watches than a browser has connections, and then a call that must not wait.
        watches = [page.open("RobotService/WatchRobotStates", {"max_rate_hertz": rate}) for rate in range(1, 9)]
        assert [next(page.answers(watch))["robots"][0]["name"] for watch in watches] == ["arm"] * 8
        assert page.ask("MotionService/Stop")["stamp"]
        assert page.ask("KernelService/GetClock")["clock"]["mode"] == "CLOCK_MODE_STEPPED"


def test_what_is_refused_ends_its_call_alone(console: Console, stepped: Stubs) -> None:
    with console.page() as page:
        watch = page.open("SceneService/WatchScene", {})
        next(page.answers(watch))
        for method, request, code in (
            ("RobotService/GetRobot", {"name": "nobody"}, "not_found"),
            ("RobotService/GetRobot", {"name": 3}, "invalid_argument"),
            ("RobotService/None", {}, "unimplemented"),
        ):
            with pytest.raises(PageRefused) as refused:
                page.ask(method, request)
            assert refused.value.args[0]["code"] == code
        with pytest.raises(PageRefused) as refused:
            page.ask("SceneService/LoadScene", {"text": " " * (17 << 20)})
        assert refused.value.args[0]["details"][0]["debug"]["metadata"]["limit_name"] == "message_bytes"
        with pytest.raises(PageRefused) as refused:
            list(page.answers(page.open("KernelService/WatchClock", {}, timeout_ms=20)))
        assert refused.value.args[0]["code"] == "deadline_exceeded"
        page.put(watch, CANCEL)
        with pytest.raises(PageRefused) as refused:
            list(page.answers(watch))
        assert refused.value.args[0]["code"] == "canceled"
        for begin in ("{", '{"method": 3}', "[]", '{"method": "a", "timeout_ms": "x"}'):
            page.socket.send(HEAD.pack(77, BEGIN) + begin.encode())
            number, kind, said = page.take()
            assert (number, kind) == (77, END) and said["error"]["code"] in ("invalid_argument", "unimplemented")
        page.put(99, MESSAGE, {})  # of no call
        assert page.ask("KernelService/GetClock")


def test_a_page_of_others_gets_no_connection(console: Console, stepped: Stubs) -> None:
    with (
        pytest.raises(InvalidStatus, match="403"),
        console.page(Origin="https://elsewhere.example"),
    ):
        pass


def test_bytes_go_through_unread(console: Console, stepped: Stubs) -> None:
    with console.page() as page:
        page.put(1, BEGIN, {"method": "/virtualrobot.v1.KernelService/GetClock"})
        page.socket.send(HEAD.pack(1, MESSAGE) + kernel_pb2.GetClockRequest().SerializeToString())
        frame = page.socket.recv()
        assert isinstance(frame, bytes)
        answer = kernel_pb2.GetClockResponse.FromString(frame[HEAD.size :])
        assert answer.clock.mode == kernel_pb2.CLOCK_MODE_STEPPED


def test_pages_that_watch_the_same_all_see_it_though_others_go(console: Console, stepped: Stubs) -> None:
    """Twenty tabs: one that joins late sees everything, and those that stay see what comes after others have gone."""
    load(stepped, IIWA, name="arm")

    def positions(said: dict[str, list[dict[str, list[float]]]]) -> list[float]:
        return said["robots"][0]["positions"]

    with console.page() as stays, console.page() as last:
        watch = stays.open("RobotService/WatchRobotStates", {})
        answers = stays.answers(watch)
        assert positions(next(answers)) == [0.0] * 7
        with ExitStack() as others:  # gone in the middle of their streams
            for _ in range(20):
                page = others.enter_context(console.page())
                seen = next(page.answers(page.open("RobotService/WatchRobotStates", {})))
                assert positions(seen) == [0.0] * 7
        motion = start(stepped, hold=False)
        until(lambda: step(stepped, 20) and stepped.motion.GetMotion(request(motion)).motion.phase != RUNNING)
        end = list(state(stepped, "arm").positions)
        while positions(next(answers)) != end:
            pass
        late = last.answers(last.open("RobotService/WatchRobotStates", {}))
        assert positions(next(late)) == end


def request(motion: str) -> motion_pb2.GetMotionRequest:
    return motion_pb2.GetMotionRequest(id=motion)


def start(stubs: Stubs, hold: bool) -> str:
    """Start a long motion and return its id."""
    move = joints("arm", 0.1, **{f"lbr_iiwa_joint_{number}": 1.0 for number in range(1, 8)})
    spec = motion_pb2.MotionSpec(moves=[move])
    policy = motion_pb2.DISCONNECT_POLICY_CONTINUE
    started = motion_pb2.StartMotionRequest(spec=spec, hold=hold, on_disconnect=policy)
    return stubs.motion.StartMotion(started).motion.id


def test_a_page_that_is_gone_or_silent_lets_the_robot_slow_down(console: Console, stepped: Stubs) -> None:
    """Ticks tell it: however many are made after the last beat has run out, the motion gets no further."""
    load(stepped, IIWA, name="arm")
    motion = start(stepped, hold=True)

    def phase() -> int:
        return stepped.motion.GetMotion(request(motion)).motion.phase

    def runs() -> bool:
        page.put(call, MESSAGE, {})  # the next beat
        step(stepped, 2)
        return any(state(stepped, "arm").velocities)

    def stands() -> bool:
        step(stepped, 2)
        return phase() == PAUSED

    for is_gone in (False, True):
        with console.page() as page:
            call = page.open("MotionService/HoldMotion", {"id": motion})
            until(runs)
            if not is_gone:
                until(stands)  # the page is there and its beats are not
        until(stands)
        here = state(stepped, "arm")
        step(stepped, 200)
        assert state(stepped, "arm").positions == here.positions and not any(here.velocities)
    assert phase() == PAUSED


@pytest.mark.long
@pytest.mark.parametrize("end", [signal.SIGSTOP, signal.SIGKILL])
def test_a_console_that_hangs_or_is_killed_lets_the_robot_slow_down(
    stepped_kernel: KernelProcess, stepped: Stubs, end: signal.Signals
) -> None:
    """The page goes on to send beats, which come to a console that does nothing with them, or to none."""
    load(stepped, IIWA, name="arm")
    motion = start(stepped, hold=True)

    def phase() -> int:
        return stepped.motion.GetMotion(request(motion)).motion.phase

    def beat() -> None:
        with suppress(ConnectionClosed, OSError):
            page.put(call, MESSAGE, {})

    def runs() -> bool:
        beat()
        step(stepped, 2)
        return any(state(stepped, "arm").velocities)

    def stands() -> bool:
        beat()
        step(stepped, 2)
        return phase() == PAUSED

    with consoles(stepped_kernel.address) as console, suppress(ConnectionClosed, OSError), console.page() as page:
        try:
            call = page.open("MotionService/HoldMotion", {"id": motion})
            until(runs)
            console.process.send_signal(end)
            until(stands)
            here = state(stepped, "arm").positions
            step(stepped, 200)
            assert state(stepped, "arm").positions == here
        finally:
            console.process.send_signal(signal.SIGCONT)
    stepped.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=motion))


def test_a_lease_of_a_page_ends_with_the_page(console: Console, stepped: Stubs) -> None:
    load(stepped, IIWA, name="arm")
    with console.page() as page:
        lease = page.ask("LeaseService/AcquireLease", {"robots": ["arm"]})
        next(page.answers(page.open("LeaseService/KeepLeaseAlive", {"token": lease["token"]})))
        turned = {"robot": "arm", "joint_positions": {"lbr_iiwa_joint_1": 0.1}}
        change = {"commands": [{"set_joint_positions": turned}]}
        page.ask("SceneService/Apply", change, headers={"virtualrobot-lease": lease["token"]})
        with pytest.raises(PageRefused) as refused:
            page.ask("SceneService/Apply", change)
        assert refused.value.args[0]["details"][0]["debug"]["reason"] == "LEASED"
    until(lambda: not stepped.lease.ListLeases(lease_pb2.ListLeasesRequest()).leases)


@pytest.mark.long
def test_a_kernel_that_goes_leaves_the_terminal_quiet(start_kernel: StartKernel) -> None:
    """Watches and a stream of requests are open at it: each ends, and Python complains of none that it found later."""
    kernel = start_kernel()
    load(kernel.stubs(), IIWA, name="arm")
    with consoles(kernel.address) as console:
        with console.page() as page:
            watch = page.open("SceneService/WatchScene", {})
            next(page.answers(watch))
            target = {"robot": "arm", "mode": "SETPOINT_MODE_VELOCITY", "timeout_seconds": 60}
            led = page.open("MotionService/StreamSetpoints", {"target": target, "values": [0.0] * 7})
            next(page.answers(led))
            kernel.end()
            for call in (watch, led):
                with pytest.raises(PageRefused) as refused:
                    list(page.answers(call))
                assert refused.value.args[0]["code"] == "unavailable"
        console.process.terminate()
        console.process.wait(PATIENCE_SECONDS)
        assert console.process.stdout
        said = console.process.stdout.read()
        assert not any(word in said for word in ("Task", "aclose", "Traceback")), said
