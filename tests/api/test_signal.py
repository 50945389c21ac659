"""SignalService: signals by name; a watch tells every change, in order."""

from __future__ import annotations

import threading
from collections import Counter
from itertools import pairwise

import grpc
import pytest
from virtualrobot._wire.signal_values import SignalValue, condition, set_command, value_message, value_of
from virtualrobot.v1 import motion_pb2, nodes_pb2, scene_pb2, signal_pb2

from tests.api.asking import IIWA, apply, box, create, load, refusal, set_signals
from tests.api.leasing import Holder
from tests.api.moving import SUCCEEDED, motion
from tests.api.reading import step, unchanged
from tests.kernels import KernelProcess, Stubs

GET, WATCH = signal_pb2.GetSignalsRequest, signal_pb2.WatchSignalsRequest
ROUNDS = 500


def signals(stubs: Stubs, *names: str, value: SignalValue = False, description: str = "") -> scene_pb2.ApplyResponse:
    """Create signals."""
    made = [signal_pb2.Signal(name=name, value=value_message(value), description=description) for name in names]
    return apply(stubs, *(scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=one)) for one in made))


def removed(name: str) -> scene_pb2.Command:
    return scene_pb2.Command(remove_signal=scene_pb2.RemoveSignal(name=name))


def test_signals_are_created_set_and_removed(stepped: Stubs) -> None:
    signals(stepped, "start", description="green button")
    signals(stepped, "on", "5", value=True)
    set_signals(stepped, {"start": True, "5": False})
    told = stepped.signal.GetSignals(GET()).signals
    assert {signal.name: value_of(signal.value) for signal in told} == {"start": True, "on": True, "5": False}
    assert stepped.signal.GetSignals(GET(names=["start"])).signals[0].description == "green button"
    apply(stepped, removed("start"), set_command("on", False))
    left = stepped.signal.GetSignals(GET()).signals
    assert [(signal.name, value_of(signal.value)) for signal in left] == [("on", False), ("5", False)]


def test_all_of_a_call_are_set_between_the_same_ticks(stepped: Stubs) -> None:
    signals(stepped, "a", "b")
    watch = stepped.signal.WatchSignals(WATCH())
    next(watch)
    set_signals(stepped, {"a": True, "b": True})
    assert {signal.name for signal in next(watch).signals} == {"a", "b"}
    watch.cancel()


def test_a_watch_tells_new_changed_and_gone_ones(stepped: Stubs) -> None:
    signals(stepped, "a", "b")
    watch, chosen = stepped.signal.WatchSignals(WATCH()), stepped.signal.WatchSignals(WATCH(names=["b"]))
    assert [signal.name for signal in next(watch).signals] == ["a", "b"]
    assert [signal.name for signal in next(chosen).signals] == ["b"]
    set_signals(stepped, {"a": True})
    assert [(s.name, value_of(s.value)) for s in next(watch).signals] == [("a", True)]
    set_signals(stepped, {"a": True})  # no change, and nothing is told
    signals(stepped, "c")
    assert [signal.name for signal in next(watch).signals] == ["c"]
    apply(stepped, create(box("nothing to do with signals")), removed("b"))
    assert list(next(watch).removed_names) == ["b"]
    assert list(next(chosen).removed_names) == ["b"]
    watch.cancel()
    chosen.cancel()


@pytest.mark.long
def test_no_change_is_lost_or_out_of_order(stubs: Stubs, kernel: KernelProcess) -> None:
    """Two clients switch their own signal as fast as they can, and both one in common."""
    signals(stubs, "a", "b", "common")
    watch = stubs.signal.WatchSignals(WATCH())
    assert len(next(watch).signals) == 3

    def switch(name: str) -> None:
        other = kernel.stubs()
        for place in range(ROUNDS):
            set_signals(other, {name: place % 2 == 0, "common": name == "a"})
        other.channel.close()

    threads = [threading.Thread(target=switch, args=(name,)) for name in "ab"]
    for thread in threads:
        thread.start()
    told: list[tuple[str, SignalValue]] = []
    revisions: list[int] = []
    while Counter(name for name, _ in told)["a"] < ROUNDS or Counter(name for name, _ in told)["b"] < ROUNDS:
        message = next(watch)
        revisions.append(message.stamp.state_revision)
        told += [(signal.name, value_of(signal.value)) for signal in message.signals]
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
            lambda: set_signals(stepped, {"start": True, "strat": True}),
            lambda: next(stepped.signal.WatchSignals(WATCH(names=["strat"]))),
            lambda: apply(stepped, removed("strat")),
        ):
            refused = refusal(call)
            assert (refused.code, refused.reason) == (grpc.StatusCode.NOT_FOUND, "UNKNOWN_NAME")
            assert "did you mean 'start'" in refused.message
            assert refused.metadata["valid"] == "start\nstop"
        assert refusal(lambda: signals(stepped, "start")).reason == "NAME_TAKEN"
        assert refusal(lambda: signals(stepped, "")).reason == "INVALID_ARGUMENT"


VALUES: list[SignalValue] = [True, 7, -(2**63), 5.25, "MONDAY 5", (True, False, True)]


@pytest.mark.parametrize("value", VALUES, ids=lambda value: type(value).__name__)
def test_a_signal_keeps_the_type_of_its_first_value(stepped: Stubs, value: SignalValue) -> None:
    signals(stepped, "s", value=value)
    assert value_of(stepped.signal.GetSignals(GET()).signals[0].value) == value
    for other in (*VALUES, (True, False)):
        widened = type(value) is float and type(other) is int
        if (type(other) is type(value) and (not isinstance(other, tuple) or len(other) == 3)) or widened:
            set_signals(stepped, {"s": other})
            continue
        refused = refusal(lambda other=other: set_signals(stepped, {"s": other}))
        assert refused.reason == "INVALID_ARGUMENT"
        assert refused.message.startswith("the signal 's' is an " if type(value) is int else "the signal 's' is a ")
        assert refused.metadata["signal"] == "s"
    told = value_of(stepped.signal.GetSignals(GET()).signals[0].value)
    assert type(told) is type(value)


@pytest.mark.parametrize(
    ("first", "value", "said"),
    [
        (0.0, float("nan"), "finite numbers only, not nan"),
        (0.0, float("inf"), "finite numbers only, not inf"),
        ("", "x" * 4097, "at most 4096 characters, not 4097"),
        (0.0, "fast", "is a number and takes no text ('fast')"),
        ((True,), (True, False), "is a group of 1 booleans and takes no group of 2 booleans"),
    ],
)
def test_values_that_a_signal_cannot_have_are_refused_with_the_whole_batch(
    stepped: Stubs, first: SignalValue, value: SignalValue, said: str
) -> None:
    signals(stepped, "other")
    signals(stepped, "s", value=first)
    with unchanged(stepped):
        refused = refusal(lambda: set_signals(stepped, {"other": True, "s": value}))
        assert said in refused.message
        assert refused.metadata["command_index"] == "1"
        absent = scene_pb2.Command(set_signal=scene_pb2.SetSignal(name="s"))
        assert "set_signal.value is absent" in refusal(lambda: apply(stepped, absent)).message


def test_signals_are_part_of_an_atomic_batch(stepped: Stubs) -> None:
    signals(stepped, "s")
    with unchanged(stepped):
        assert refusal(lambda: apply(stepped, set_command("s", True), create(box("a", parent="nowhere"))))
    apply(stepped, set_command("s", True), create(box("a")))
    assert value_of(stepped.signal.GetSignals(GET()).signals[0].value) is True


def owned(name: str, owner: str, direction: signal_pb2.SignalDirection) -> scene_pb2.Command:
    signal = signal_pb2.Signal(name=name, owner=owner, direction=direction, unit="bar", value=value_message(1.5))
    return scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=signal))


def test_a_signal_has_an_owner_that_may_be_renamed_and_removed(stepped: Stubs) -> None:
    apply(stepped, create(box("valve")), owned("pressure", "valve", signal_pb2.SIGNAL_DIRECTION_OUTPUT))
    (told,) = stepped.signal.GetSignals(GET()).signals
    assert (told.owner, told.unit, told.direction) == ("valve", "bar", signal_pb2.SIGNAL_DIRECTION_OUTPUT)
    text = stepped.scene.SaveScene(scene_pb2.SaveSceneRequest()).text
    apply(stepped, removed("pressure"), scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="valve")))
    stepped.scene.LoadScene(scene_pb2.LoadSceneRequest(text=text))
    assert stepped.signal.GetSignals(GET()).signals[0] == told
    rename = scene_pb2.UpdateNode(name="valve", node=nodes_pb2.Node(name="tap"))
    rename.update_mask.paths.append("name")
    apply(stepped, scene_pb2.Command(update_node=rename))
    assert stepped.signal.GetSignals(GET()).signals[0].owner == "tap"
    apply(stepped, scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="tap")))
    assert stepped.signal.GetSignals(GET()).signals[0].owner == ""
    unknown = refusal(lambda: apply(stepped, owned("x", "tapp", signal_pb2.SIGNAL_DIRECTION_INPUT)))
    assert unknown.reason == "UNKNOWN_NAME"


def test_a_lease_of_the_owner_guards_its_signals_but_inputs(stubs: Stubs, kernel: KernelProcess) -> None:
    load(stubs, IIWA, "arm")
    apply(
        stubs,
        owned("out", "arm", signal_pb2.SIGNAL_DIRECTION_OUTPUT),
        owned("in", "arm", signal_pb2.SIGNAL_DIRECTION_INPUT),
        owned("free", "", signal_pb2.SIGNAL_DIRECTION_OUTPUT),
    )
    holder = Holder(kernel, "arm")
    set_signals(stubs, {"in": 2.0, "free": 2.0})
    for refused in (
        refusal(lambda: set_signals(stubs, {"out": 2.0})),
        refusal(lambda: apply(stubs, removed("in"))),
        refusal(lambda: apply(stubs, owned("more", "arm", signal_pb2.SIGNAL_DIRECTION_INPUT))),
    ):
        assert refused.reason == "LEASED"
    holder.release()


def waiting(condition: motion_pb2.SignalCondition) -> motion_pb2.StartMotionRequest:
    step = motion_pb2.ProgramStep(wait_signal=motion_pb2.WaitSignalStep(condition=condition))
    return motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(steps=[step]), on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE
    )


@pytest.mark.parametrize(
    ("comparison", "before", "after"),
    [("==", 4.0, 5.0), ("!=", 5.0, 4.0), ("<", 5.0, 4.9), ("<=", 5.1, 5.0), (">", 5.0, 5.1), (">=", 4.9, 5.0)],
)
def test_a_program_waits_until_a_number_compares(stepped: Stubs, comparison: str, before: float, after: float) -> None:
    signals(stepped, "pressure", value=before)
    started = stepped.motion.StartMotion(waiting(condition("pressure", 5.0, comparison))).motion
    step(stepped, 10)
    assert motion(stepped, started.id).phase == motion_pb2.MOTION_PHASE_WAITING
    set_signals(stepped, {"pressure": after})
    step(stepped, 2)
    assert motion(stepped, started.id).phase == SUCCEEDED


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (condition("word", "a", "<"), "the signal 'word' is a text, which '<' cannot compare"),
        (condition("word", 5), "the signal 'word' is a text and takes no integer (5)"),
        (condition("count", "5"), "the signal 'count' is an integer and takes no text ('5')"),
        (condition("wrod", "a"), "did you mean 'word'"),
        (motion_pb2.SignalCondition(signal="word"), "steps[0].wait_signal.condition.value is absent"),
    ],
)
def test_conditions_that_cannot_be_are_refused(stepped: Stubs, asked: motion_pb2.SignalCondition, said: str) -> None:
    signals(stepped, "word", value="")
    signals(stepped, "count", value=0)
    with unchanged(stepped):
        assert said in refusal(lambda: stepped.motion.StartMotion(waiting(asked))).message
