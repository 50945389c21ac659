"""Streams of setpoints through the client: what a program writes, and what it is told when its joints stop."""

from __future__ import annotations

import threading

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Phase, Robot

from tests.api.client.conftest import IIWA
from tests.api.client.test_motion import BENT

FIRST = "lbr_iiwa_joint_1"
LONG = 1e6


def ended(stream: virtualrobot.SetpointStream) -> Phase:
    """Return how a stream's motion has ended."""
    waiting = threading.Event()
    for _ in range(3000):
        if stream.motion.phase.ended:
            return stream.motion.phase
        waiting.wait(0.01)
    raise AssertionError(f"{stream} has not ended")


def test_positions_are_followed_to_the_last_one(client: Client, iiwa: Robot) -> None:
    waiting = threading.Event()
    with iiwa.stream(timeout=LONG) as stream:
        assert stream.joint_names == tuple(iiwa.joint_names)
        for place in np.linspace(0.0, 1.0, 50):
            stream.send(np.multiply(BENT, 0.1 * place))
            waiting.wait(0.01)
    assert stream.motion.phase is Phase.SUCCEEDED
    assert np.array_equal(iiwa.positions, np.multiply(BENT, 0.1))
    assert np.array_equal(stream.state.positions, iiwa.positions)
    assert not stream.state.velocities.any()


def test_a_proportional_controller_reaches_its_goal(client: Client, iiwa: Robot) -> None:
    with iiwa.stream("velocity", [FIRST], timeout=LONG) as stream:
        for state in stream:
            error = 0.4 - state.positions[0]
            if abs(error) < 1e-3:
                break
            stream.send({FIRST: 4.0 * error})
    assert iiwa.positions[0] == pytest.approx(0.4, abs=5e-3)
    assert not iiwa.positions[1:].any()


def test_joints_that_are_not_named_keep_their_setpoint(client: Client, iiwa: Robot) -> None:
    client.clock.set_stepped()
    stream = iiwa.stream("velocity", timeout=LONG)
    stream.send({FIRST: 0.1}, wait=True)
    stream.send({"lbr_iiwa_joint_3": -0.1}, wait=True)
    client.clock.step(100)
    assert np.allclose(iiwa.state.velocities, [0.1, 0, -0.1, 0, 0, 0, 0])
    client.clock.set_realtime()
    stream.close()


def test_a_block_that_cancels_its_stream_ends_without_an_error(iiwa: Robot) -> None:
    with iiwa.stream("velocity", [FIRST], timeout=LONG) as stream:
        stream.send([0.1])
        stream.cancel("seen enough")
    assert ended(stream) is Phase.CANCELLED
    assert (stream.motion.state.end_cause, stream.motion.state.end_reason) == ("call", "seen enough")


def test_a_program_that_steps_the_clock_knows_when_its_setpoints_count(client: Client, iiwa: Robot) -> None:
    runs = []
    client.clock.set_stepped()
    for _ in range(2):
        places = []
        stream = iiwa.stream("position", [FIRST], timeout=LONG)
        for tick in range(50):
            stream.send([0.001 * tick], wait=True)
            client.clock.step(1)
            places.append(iiwa.positions[0])
        stream.cancel()
        runs.append(places)
        client.clock.set_realtime()
        ended(stream)
        client.clock.set_stepped()
        iiwa.set_positions({FIRST: 0.0})
    assert runs[0] == runs[1]
    assert runs[0][-1] > 0.03


def test_a_refused_setpoint_is_raised(client: Client, iiwa: Robot) -> None:
    client.clock.speed_factor = 0.02  # a quarter of a second after its start the stream could be there
    stream = iiwa.stream("position", [FIRST], timeout=LONG)
    with pytest.raises(virtualrobot.LimitError, match="'lbr_iiwa_joint_1' would go from 0 to 2") as refused:
        stream.send([2.0], wait=True)
    assert refused.value.metadata["joint"] == FIRST
    with pytest.raises(virtualrobot.LimitError):
        stream.send([0.0])
    assert ended(stream) is Phase.ABORTED
    with pytest.raises(virtualrobot.LimitError), iiwa.stream("velocity", [FIRST], timeout=LONG) as stream:
        stream.send([1e6])
    assert ended(stream) is Phase.ABORTED
    stream = iiwa.stream("velocity", [FIRST], timeout=LONG)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="not nan"):
        stream.send([float("nan")], wait=True)


def test_what_the_library_refuses_itself_stops_nothing(client: Client, iiwa: Robot) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match="'speed'"):
        iiwa.stream("speed")
    with pytest.raises(virtualrobot.InvalidArgumentError, match="needs joints"):
        iiwa.stream(joints=[])
    with iiwa.stream("velocity", [FIRST], timeout=LONG) as stream:
        with pytest.raises(virtualrobot.UnknownNameError, match="not 'elbow'"):
            stream.send({"elbow": 1.0})
        with pytest.raises(virtualrobot.InvalidArgumentError, match=r"not the shape \(2,\)"):
            stream.send([0.0, 0.0])
    assert stream.motion.phase is Phase.SUCCEEDED
    with pytest.raises(virtualrobot.VirtualRobotError, match="is closed"):
        stream.send([0.0])


def test_silence_aborts_and_the_program_is_told(client: Client, iiwa: Robot) -> None:
    stream = iiwa.stream("velocity", [FIRST], timeout=0.1)
    stream.send([0.1])
    assert ended(stream) is Phase.ABORTED
    with pytest.raises(virtualrobot.MotionAbortedError, match=r"no setpoint came for 0\.1 s"):
        for _ in stream:
            pass
    with pytest.raises(virtualrobot.MotionAbortedError):
        stream.close()


def test_a_block_that_fails_stops_the_joints(client: Client, iiwa: Robot) -> None:
    with pytest.raises(ZeroDivisionError), iiwa.stream("velocity", [FIRST], timeout=LONG) as stream:
        stream.send([0.3], wait=True)
        raise ZeroDivisionError
    assert ended(stream) is Phase.CANCELLED
    assert "failed" in stream.motion.state.end_reason
    assert "1" in repr(stream)


def test_a_lease_lets_its_client_stream(client: Client, iiwa: Robot) -> None:
    with iiwa.lease(), iiwa.stream("velocity", [FIRST], timeout=LONG) as stream:
        stream.send([0.1])
    assert stream.motion.phase is Phase.SUCCEEDED


def test_a_joint_of_several_coordinates_is_sent_by_its_name(client: Client) -> None:
    agv = client.load_robot(IIWA, name="agv", base="planar")
    with agv.stream(timeout=LONG) as stream:
        stream.send({"base": [0.01, -0.02, 0.03], FIRST: 0.02})
        stream.send({"base/x": 0.015})
    np.testing.assert_allclose(agv.positions[:4], [0.015, -0.02, 0.03, 0.02], atol=1e-9)
    with agv.stream(timeout=LONG) as stream:
        for wrong, words in (
            ({"base": [0.0, 0.0]}, r"has 3 values \(base/x, base/y, base/theta\)"),
            ({"base": "abc"}, r"setpoint\['base'\] is 'abc'; it must be a number"),
            ("abc", "setpoint is 'abc'"),
        ):
            with pytest.raises(virtualrobot.InvalidArgumentError, match=words):
                stream.send(wrong)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
