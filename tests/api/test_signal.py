"""SignalService: signals by name; a watch tells every change, in order."""

from __future__ import annotations

import threading
from collections import Counter
from itertools import pairwise

import grpc
from virtualrobot.v1 import scene_pb2, signal_pb2

from tests.api.asking import apply, box, create, refusal
from tests.api.reading import unchanged
from tests.kernels import KernelProcess, Stubs

GET, SET, WATCH = signal_pb2.GetSignalsRequest, signal_pb2.SetSignalsRequest, signal_pb2.WatchSignalsRequest
ROUNDS = 500


def signals(stubs: Stubs, *names: str, value: bool = False, description: str = "") -> scene_pb2.ApplyResponse:
    """Create signals."""
    made = [signal_pb2.Signal(name=name, value=value, description=description) for name in names]
    return apply(stubs, *(scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=one)) for one in made))


def removed(name: str) -> scene_pb2.Command:
    return scene_pb2.Command(remove_signal=scene_pb2.RemoveSignal(name=name))


def test_signals_are_created_set_and_removed(stepped: Stubs) -> None:
    signals(stepped, "start", description="green button")
    signals(stepped, "on", "5", value=True)
    stepped.signal.SetSignals(SET(values={"start": True, "5": False}))
    told = stepped.signal.GetSignals(GET()).signals
    assert {signal.name: signal.value for signal in told} == {"start": True, "on": True, "5": False}
    assert stepped.signal.GetSignals(GET(names=["start"])).signals[0].description == "green button"
    apply(stepped, removed("start"), scene_pb2.Command(set_signal=scene_pb2.SetSignal(name="on", value=False)))
    assert [(s.name, s.value) for s in stepped.signal.GetSignals(GET()).signals] == [("on", False), ("5", False)]


def test_all_of_a_call_are_set_between_the_same_ticks(stepped: Stubs) -> None:
    signals(stepped, "a", "b")
    watch = stepped.signal.WatchSignals(WATCH())
    next(watch)
    stepped.signal.SetSignals(SET(values={"a": True, "b": True}))
    assert {signal.name for signal in next(watch).signals} == {"a", "b"}
    watch.cancel()


def test_a_watch_tells_new_changed_and_gone_ones(stepped: Stubs) -> None:
    signals(stepped, "a", "b")
    watch, chosen = stepped.signal.WatchSignals(WATCH()), stepped.signal.WatchSignals(WATCH(names=["b"]))
    assert [signal.name for signal in next(watch).signals] == ["a", "b"]
    assert [signal.name for signal in next(chosen).signals] == ["b"]
    stepped.signal.SetSignals(SET(values={"a": True}))
    assert [(s.name, s.value) for s in next(watch).signals] == [("a", True)]
    stepped.signal.SetSignals(SET(values={"a": True}))  # no change, and nothing is told
    signals(stepped, "c")
    assert [signal.name for signal in next(watch).signals] == ["c"]
    apply(stepped, create(box("nothing to do with signals")), removed("b"))
    assert list(next(watch).removed_names) == ["b"]
    assert list(next(chosen).removed_names) == ["b"]
    watch.cancel()
    chosen.cancel()


def test_no_change_is_lost_or_out_of_order(stubs: Stubs, kernel: KernelProcess) -> None:
    """Two clients switch their own signal as fast as they can, and both one in common."""
    signals(stubs, "a", "b", "common")
    watch = stubs.signal.WatchSignals(WATCH())
    assert len(next(watch).signals) == 3

    def switch(name: str) -> None:
        other = kernel.stubs()
        for place in range(ROUNDS):
            other.signal.SetSignals(SET(values={name: place % 2 == 0, "common": name == "a"}))
        other.channel.close()

    threads = [threading.Thread(target=switch, args=(name,)) for name in "ab"]
    for thread in threads:
        thread.start()
    told: list[tuple[str, bool]] = []
    revisions: list[int] = []
    while Counter(name for name, _ in told)["a"] < ROUNDS or Counter(name for name, _ in told)["b"] < ROUNDS:
        message = next(watch)
        revisions.append(message.stamp.state_revision)
        told += [(signal.name, signal.value) for signal in message.signals]
    for thread in threads:
        thread.join(30)
    for name in "ab":
        assert [value for who, value in told if who == name] == [place % 2 == 0 for place in range(ROUNDS)]
    common = [value for who, value in told if who == "common"]
    assert all(a != b for a, b in pairwise(common)), "each telling is a change"
    assert revisions == sorted(set(revisions))
    watch.cancel()


def test_unknown_names_are_refused(stepped: Stubs) -> None:
    signals(stepped, "start", "stop")
    with unchanged(stepped):
        for call in (
            lambda: stepped.signal.GetSignals(GET(names=["strat"])),
            lambda: stepped.signal.SetSignals(SET(values={"start": True, "strat": True})),
            lambda: next(stepped.signal.WatchSignals(WATCH(names=["strat"]))),
            lambda: apply(stepped, removed("strat")),
        ):
            refused = refusal(call)
            assert (refused.code, refused.reason) == (grpc.StatusCode.NOT_FOUND, "UNKNOWN_NAME")
            assert "did you mean 'start'" in refused.message
            assert refused.metadata["valid"] == "start\nstop"
        assert refusal(lambda: signals(stepped, "start")).reason == "NAME_TAKEN"
        assert refusal(lambda: signals(stepped, "")).reason == "INVALID_ARGUMENT"
