"""URScript on an emulated controller with an arm of its own: motion, kinematics, registers, outputs and sockets.

Numbers come from the arm's table and the laws of the moves: a ramp of constant acceleration, the circle through three
places, the Jacobian. A cycle is 2 ms.
"""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.ur.controller import Controller, SafetyMode
from virtualrobot_apps.emulators.ur.scripts import run_script

from tests.apps.languages.urscript_robot import HOME, Played
from tests.waiting import until


@pytest.fixture
def server() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        yield listening


def test_movel_goes_along_its_line_and_movec_along_its_circle() -> None:
    played = Played(
        """
        a = get_target_tcp_pose()
        b = pose_add(a, p[0, 0, 0.08, 0, 0, 0.3])
        movel(b, a=1, v=0.2)
        textmsg("line")
        c = pose_add(b, p[0.05, 0, 0.05, 0, 0, 0])
        d = pose_add(b, p[0.1, 0, 0, 0, 0, 0])
        movec(c, d, a=1, v=0.2)
        movec(d, d)
        """
    )
    assert "three places of an arc are on a line" in played.said[-1]
    start = played.pose(HOME)[:3, 3]
    places = played.places
    end = int(np.argmax(places[:, 2] > start[2] + 0.08 - 1e-9))
    line, arc = places[:end], places[end:]
    np.testing.assert_allclose(line[:, :2], np.broadcast_to(start[:2], (end, 2)), atol=1e-9)
    # The three places are on the circle of radius 5 cm around the middle of the chord; it begins where the arm has
    # settled, within 1e-5 rad of the line's end.
    centre = start + np.array([0.05, 0.0, 0.08])
    np.testing.assert_allclose(np.linalg.norm(arc - centre, axis=1), 0.05, atol=1e-6)
    speeds = np.linalg.norm(np.diff(arc, axis=0), axis=1) / 0.002
    assert speeds.max() == pytest.approx(0.2, rel=1e-3)


def test_times_of_moves_are_kept() -> None:
    """By t, or by the ramp: with v and a, way / v + v / a."""
    for move, seconds in (
        ("movej([1, -1.57, 1.57, -1.57, -1.57, 0], t=0.9)", 0.9),
        ("movej([1, -1.57, 1.57, -1.57, -1.57, 0], a=4, v=2)", 1 / 2 + 2 / 4),
        ("movel(pose_add(get_target_tcp_pose(), p[0, 0, 0.1, 0, 0, 0]), t=0.5)", 0.5),
        ("movep(pose_add(get_target_tcp_pose(), p[0, 0, 0.1, 0, 0, 0]), a=1, v=0.25)", 0.1 / 0.25 + 0.25 / 1),
    ):
        played = Played(move)
        moving = np.abs(np.diff(played.targets, axis=0)).max(axis=1) > 0.0
        assert moving.sum() * 0.002 == pytest.approx(seconds, abs=0.012), move
        assert not played.said


def test_half_the_slider_is_half_the_speed() -> None:
    controller = Controller(SimulatedArm(HOME))
    controller.slider = 0.5
    played = Played("movej([1, -1.57, 1.57, -1.57, -1.57, 0], a=4, v=1)", controller=controller)
    assert np.abs(np.diff(played.targets[:, 0])).max() / 0.002 == pytest.approx(0.5, rel=1e-6)


def test_velocities_are_kept_and_stops_slow_down_as_told() -> None:
    played = Played(
        """
        speedl([0, 0, 0.1, 0, 0, 0], 5, 0.5)
        textmsg(get_target_tcp_speed())
        stopl(0.5)
        textmsg("stopped")
        speedj([0, 0, 0, 0, 0, 0.8], 2)
        textmsg(get_target_joint_speeds())
        stopj(4)
        """
    )
    speed, stopped, joints = played.said
    assert [float(one) for one in speed.strip("[]").split(",")] == pytest.approx([0, 0, 0.1, 0, 0, 0], abs=2e-3)
    assert stopped == "stopped"
    # It returns within 1 mrad/s of the wanted speed.
    assert float(joints.strip("[]").split(",")[5]) == pytest.approx(0.8, abs=1e-3)
    rate = np.diff(played.targets[:, 5], n=2) / 0.002**2
    assert rate.min() == pytest.approx(-4.0, rel=1e-3) and rate.max() == pytest.approx(2.0, rel=1e-3)
    # The tool stops at 0.5 m/s^2: from 0.1 m/s in 0.2 s, over 1 cm.
    height = played.places[:, 2]
    way = height.max() - height[249]
    assert way == pytest.approx(0.1**2 / (2 * 0.5), abs=5e-4)


def test_servoj_follows_a_setpoint_each_cycle() -> None:
    played = Played(
        """
        q = get_target_joint_positions()
        i = 0
        while i < 100:
          i = i + 1
          q[5] = q[5] + 0.001
          servoj(q, t=0.002, lookahead_time=0.1, gain=300)
        end
        stopj(10)
        """
    )
    np.testing.assert_allclose(np.diff(played.targets[:99, 5]), 0.001, atol=1e-12)


def test_a_killed_thread_leaves_its_move_and_the_next_one_begins_at_rest() -> None:
    played = Played(
        """
        thread far():
          movej([2, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=1)
          textmsg("never")
        end
        handle = run far()
        sleep(0.6)
        kill handle
        movej([0, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=1)
        textmsg("back")
        """
    )
    assert played.said == ["back"]
    assert played.targets[:, 0].max() < 1.0 and played.targets[-1, 0] == pytest.approx(0.0, abs=1e-9)
    # Until it turns back it brakes with END_DECELERATION of the controller, and no move begins meanwhile.
    rates = np.diff(played.targets[: played.targets[:, 0].argmax(), 0], n=2) / 0.002**2
    assert rates.min() == pytest.approx(-4.0, rel=1e-3) and rates.max() == pytest.approx(3.0, rel=1e-3)


def test_kinematics_and_the_tool_are_those_of_the_controller(rng: np.random.Generator) -> None:
    played = Played(
        """
        set_tcp(p[0, 0, 0.1, 0, 0, 0])
        set_payload(1.5, [0, 0, 0.05])
        q = get_actual_joint_positions()
        x = get_forward_kin()
        textmsg(point_dist(x, get_forward_kin(q, p[0, 0, 0, 0, 0, 0])))
        textmsg(norm(get_inverse_kin(x, qnear=[0.1, -1.5, 1.5, -1.5, -1.5, 0]) - q) < 0.000001)
        textmsg(get_inverse_kin_has_solution(p[9, 0, 0, 0, 0, 0]), is_within_safety_limits(x))
        textmsg(get_tcp_offset(), point_dist(get_actual_tool_flange_pose(), get_actual_tcp_pose()))
        textmsg(get_target_payload(), get_target_payload_cog())
        y = get_inverse_kin(p[9, 0, 0, 0, 0, 0])
        """
    )
    *good, bad = played.said
    assert good == ["0.1", "True", "FalseTrue", "p[0, 0, 0.1, 0, 0, 0]0.1", "1.5[0, 0, 0.05]"]
    assert bad.startswith("script:12: no posture near")


def test_registers_and_outputs_are_shared_with_clients() -> None:
    controller = Controller(SimulatedArm(HOME))
    controller.take(
        {"input_int_register_24": -7, "input_double_register_0": 1.5, "input_bit_register_64": True}
        | {"input_bit_registers0_to_31": 1 << 5}
    )
    controller.digital_inputs = 1 << 3 | 1 << 17
    played = Played(
        """
        textmsg(read_input_integer_register(24), read_input_float_register(0))
        textmsg(read_input_boolean_register(64), read_input_boolean_register(5))
        write_output_integer_register(1, -3)
        write_output_float_register(2, 2)
        write_output_boolean_register(40, True)
        write_output_boolean_register(100, True)
        textmsg(read_output_integer_register(1), read_output_float_register(2))
        textmsg(get_standard_digital_in(3), get_tool_digital_in(1))
        set_standard_digital_out(1, True)
        set_configurable_digital_out(0, True)
        set_digital_out(9, get_digital_in(3))
        textmsg(get_digital_out(9), get_configurable_digital_out(1))
        sync()
        write_output_integer_register(48, 0)
        """,
        controller=controller,
    )
    assert played.said == [
        *("-71.5", "TrueTrue", "-32", "TrueTrue", "TrueFalse"),
        "script:16: address is a whole number from 0 to 47, not 48",
    ]
    assert controller.digital_outputs == 1 << 1 | 1 << 8 | 1 << 17
    told = controller.tell()
    assert (told["output_int_register_1"], told["output_double_register_2"]) == (-3, 2.0)
    assert (told["output_bit_registers32_to_63"], told["output_bit_register_100"]) == (1 << 8, True)


def test_flags_stay_from_script_to_script() -> None:
    controller = Controller(SimulatedArm(HOME))
    Played("set_flag(31, True)\nset_flag(0, get_flag(31))\nset_flag(31, False)", controller=controller)
    assert Played("textmsg(get_flag(0), get_flag(31))", controller=controller).said == ["TrueFalse"]


def test_the_jacobian_is_that_of_the_differences() -> None:
    played = Played(
        """
        q = get_target_joint_positions()
        d = 0.0001
        x = get_forward_kin(q)
        q[1] = q[1] + d
        y = get_forward_kin(q)
        j = get_jacobian()
        textmsg(norm((y[0] - x[0]) / d - j[0, 1]) < 0.001, norm((y[2] - x[2]) / d - j[2][1]) < 0.001)
        popup("words", blocking=True)
        """
    )
    assert played.said == [
        "TrueTrue",
        "Popup: words",
        "script:10: nobody can close a popup that blocks here: words",
    ]


def test_a_watchdog_stops_a_script_whose_client_is_silent() -> None:
    controller = Controller(SimulatedArm(HOME))
    run_script(
        controller,
        'def tried():\nrtde_set_watchdog("input_int_register_0", 10, "stop")\nwhile True:\nsync()\nend\nend\n',
    )
    for number in range(200):
        if number % 20 == 0:
            controller.take({"input_int_register_0": number})
        controller.cycle()
    assert controller.program is not None
    for _ in range(60):
        controller.cycle()
    assert controller.program is None and "input_int_register_0 was not written in time" in controller.words[-1][2]


def test_a_watchdog_pauses_a_script_whose_client_is_silent() -> None:
    controller = Controller(SimulatedArm(HOME))
    run_script(
        controller,
        """def tried():
  rtde_set_watchdog("input_int_register_0", 10)
  while True:
    write_output_integer_register(3, read_output_integer_register(3) + 1)
    sync()
  end
end
""",
    )
    for _ in range(80):  # 10 Hz are 50 cycles, from the first on
        controller.cycle()
    counted = controller.registers["output_int_register_3"]
    assert controller.paused and counted == 51
    assert [text for _, _, text in controller.words] == [
        "RTDE watchdog: input_int_register_0 was not written in time, the program is paused"
    ]
    assert controller.go_on()
    for _ in range(20):
        controller.cycle()
    assert not controller.paused and controller.registers["output_int_register_3"] == 71


def test_a_protective_stop_ends_the_script() -> None:
    played = Played("protective_stop()\nsync()\ntextmsg(1)")
    assert played.controller.safety is SafetyMode.PROTECTIVE_STOP and played.said == ["Protective stop by the program"]


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("movej([0, 0])", "q has 6 finite numbers, and this is [0, 0]"),
        ("movej([0, 0, 0, 0, 0, 0], v=0)", "v is above 0, not 0"),
        ("movel(p[9, 0, 0, 0, 0, 0])", "no posture near"),
        ("movel(get_target_tcp_pose(), r=-1)", "r is 0 or more, not -1"),
        ("servoj(get_target_joint_positions(), t=0)", "t is above 0, not 0"),
        ("speedj([9, 0, 0, 0, 0, 0])", "qd has speeds of at most 6.283 rad/s, not [9, 0, 0, 0, 0, 0]"),
        ("movej([1e200 * 1e200, 0, 0, 0, 0, 0])", "q has 6 finite numbers, and this is [inf, 0, 0, 0, 0, 0]"),
        ("speedj([0, 0, 0, 0, 0, 0], 1e200 * 1e200)", "a is a finite number, not inf"),
        ("set_payload(-1)", "m is 0 or more kg, not -1"),
        ("set_digital_out(10, True)", "n is a whole number from 0 to 9, not 10"),
        ("freedrive_mode()", "'freedrive_mode' can't be used here yet"),
        ('rtde_set_watchdog("speed", 1, "stop")', "there is no input 'speed' of RTDE"),
        ('socket_open("127.0.0.1", 0)', "port is a whole number from 1 to 65535, not 0"),
    ],
)
def test_bad_arguments_end_the_script_with_line_and_reason(statement: str, expected: str) -> None:
    (said,) = Played(f"sync()\n{statement}").said
    assert said.startswith(f"script:3: {expected}"), said


def test_what_is_wrong_with_a_script_is_told_with_its_line_and_the_running_one_goes_on() -> None:
    controller = Controller(SimulatedArm(HOME))
    run_script(controller, "def first():\nsleep(1)\nend\n")
    controller.cycle()
    run_script(controller, "def second():\n  movej([0, 0\nend\n")
    assert controller.words[-1][2] == "syntax_error_on_line:2: ',' or ']' is expected here, not the end of the line"
    assert controller.program is not None and controller.program.name == "first"


def test_a_secondary_program_runs_beside_and_takes_no_time() -> None:
    controller = Controller(SimulatedArm(HOME))
    run_script(controller, "def first():\nsleep(1)\nend\n")
    run_script(controller, "sec other():\nset_standard_digital_out(4, True)\nend\n")
    assert controller.digital_outputs == 1 << 4
    assert controller.program is not None and controller.program.name == "first"
    run_script(controller, "sec late():\nsleep(1)\nset_standard_digital_out(5, True)\nend\n")
    assert controller.words[-1][2] == "the secondary program 'late' takes time, and was ended where it waited"
    assert controller.digital_outputs == 1 << 4
    run_script(controller, "sec moving():\nmovej([0, 0, 0, 0, 0, 0])\nend\n")
    assert controller.words[-1][2] == "script:2: a secondary program (sec) can't move the robot"
    assert controller.move is None


def test_a_script_speaks_with_a_server(server: socket.socket) -> None:
    port = server.getsockname()[1]
    controller = Controller(SimulatedArm(HOME))
    run_script(
        controller,
        f"""def tried():
          textmsg("nobody ", socket_send_string("x"))
          textmsg("opened ", socket_open("127.0.0.1", {port}, "one"))
          socket_send_string("ready ", "one")
          socket_send_line([1, 2.5], "one")
          socket_send_int(-2, "one")
          socket_send_byte(65, "one")
          textmsg(socket_read_ascii_float(2, "one"))
          textmsg(socket_read_binary_integer(2, "one"))
          textmsg(socket_read_byte_list(3, "one"))
          textmsg(socket_read_line("one"))
          textmsg(socket_read_string("one", prefix="<", suffix=">"))
          textmsg(socket_read_binary_integer(2, "one", 0.01))
          socket_close("one")
          textmsg("closed ", socket_read_line("one"))
        end
        """,
    )

    def cycled() -> bool:
        controller.cycle()
        return controller.program is None

    server.settimeout(10.0)
    controller.cycle()
    peer, _ = server.accept()
    with peer:
        peer.setblocking(False)
        got = bytearray()

        def received() -> bool:
            controller.cycle()
            try:
                got.extend(peer.recv(1000))
            except BlockingIOError:
                pass
            return len(got) >= 20

        until(received)
        assert bytes(got) == b"ready [1, 2.5]\n" + struct.pack(">i", -2) + b"A"
        peer.setblocking(True)
        peer.sendall(b"(0.5, -2)" + struct.pack(">ii", 7, -8) + b"\x01\x02\xffline\r\nnoise<inner>more")
        until(cycled)
    assert controller.logged == [
        *("nobody False", "opened True", "[2, 0.5, -2]", "[2, 7, -8]", "[3, 1, 2, 255]", "line", "inner"),
        *("[0, -1, -1]", "closed "),
    ]


def test_a_server_that_is_not_there_is_told(server: socket.socket) -> None:
    port = server.getsockname()[1]
    server.close()
    assert Played(f'textmsg(socket_open("127.0.0.1", {port}))').said == ["False"]


def test_lines_blend_along_a_parabola_within_the_radius() -> None:
    """The way leaves the first line 2 cm before the corner, and passes it at r * sqrt(2) / 4, as a parabola does."""
    played = Played(
        """
        a = get_target_tcp_pose()
        b = pose_add(a, p[0, 0, 0.08, 0, 0, 0])
        c = pose_add(b, p[0, 0.08, 0, 0, 0, 0])
        movel(b, a=1, v=0.1, r=0.02)
        movel(c, a=1, v=0.1, r=0.02)
        """
    )
    assert not played.said
    corner = played.pose(HOME)[:3, 3] + [0.0, 0.0, 0.08]
    places = played.places - corner
    near = np.linalg.norm(places, axis=1)
    # A cycle is 0.2 mm of way: the parabola begins up to so much later.
    assert near.min() == pytest.approx(0.02 * np.sqrt(2.0) / 4.0, abs=1e-4)
    outside = near > 0.02
    first, second = places[outside & (places[:, 1] < 0.01)], places[outside & (places[:, 1] > 0.01)]
    assert np.abs(first[:, :2]).max() < 1e-6 and np.abs(second[:, [0, 2]]).max() < 1e-6
    # Its end has a radius, too, and nothing joins there: the way goes on to it.
    np.testing.assert_allclose(places[-1], [0.0, 0.08, 0.0], atol=1e-6)
    speeds = np.linalg.norm(np.diff(played.places, axis=0), axis=1) / 0.002
    inside = (near < 0.02)[:-1]
    assert speeds[inside].min() > 0.098 and speeds.max() == pytest.approx(0.1, rel=1e-2)


def test_joint_moves_blend_and_a_line_after_one_begins_at_its_end() -> None:
    played = Played(
        """
        movej([0.4, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=1, r=0.05)
        movej([0.4, -1.27, 1.57, -1.57, -1.57, 0], a=3, v=1, r=0.05)
        textmsg("second")
        movel(pose_add(get_target_tcp_pose(), p[0, 0, 0.02, 0, 0, 0]))
        """
    )
    assert played.said == ["second"]
    corner = played.pose(np.array([0.4, -1.57, 1.57, -1.57, -1.57, 0.0]))[:3, 3]
    near = np.linalg.norm(played.places - corner, axis=1)
    assert 0.003 < near.min() < 0.03
    assert (np.abs(np.diff(played.targets, axis=0)).max(axis=1)[: near.argmin() + 20] > 0).sum() > near.argmin()
    # The steps of the setpoint change by less than what the accelerations of both moves make of them.
    assert np.abs(np.diff(played.targets[: near.argmin() + 50], n=2, axis=0)).max() / 0.002**2 < 60.0
    end = played.pose(np.array([0.4, -1.27, 1.57, -1.57, -1.57, 0.0]))[:3, 3]
    assert np.linalg.norm(played.places - end, axis=1).min() < 1e-6


def test_a_blend_that_nothing_joins_in_time_stands_at_its_end() -> None:
    played = Played(
        """
        b = pose_add(get_target_tcp_pose(), p[0, 0, 0.05, 0, 0, 0])
        movel(b, a=1, v=0.1, r=0.02)
        textmsg("near")
        sleep(1)
        textmsg(point_dist(get_target_tcp_pose(), b) < 0.0001)
        """
    )
    assert played.said == ["near", "True"]


CONTROLLED = """def controlled():
  global mode = 0
  global goal = get_joint_positions()
  thread servo():
    while mode == 1:
      enter_critical
      q = goal
      exit_critical
      servoj(q, t=get_steptime(), lookahead_time=0.03, gain=2000)
    end
    stopj(4.0)
  end
  socket_open("127.0.0.1", PORT, "reverse")
  handle = 0
  timeout = 0.0
  while mode > -2:
    enter_critical
    got = socket_read_binary_integer(8, "reverse", timeout)
    if got[0] > 0:
      timeout = got[1] / 1000
      if mode != got[8]:
        mode = got[8]
        join handle
        if mode == 1:
          goal = get_joint_positions()
          handle = run servo()
        end
      end
      i = 0
      while i < 6:
        goal[i] = got[i + 2] / 1000000
        i = i + 1
      end
    else:
      textmsg("timed out")
      mode = -2
      kill handle
      stopj(4.0)
      halt
    end
    exit_critical
  end
end
"""
"""A script of the shape that drivers of ROS upload: setpoints by a socket, followed by a thread, with a timeout."""


def test_setpoints_by_a_socket_are_followed_each_cycle_until_they_end(server: socket.socket) -> None:
    controller = Controller(SimulatedArm(HOME))
    run_script(controller, CONTROLLED.replace("PORT", str(server.getsockname()[1])))
    server.settimeout(10.0)
    controller.cycle()
    peer, _ = server.accept()
    with peer:
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        targets = []
        for number in range(200):
            goal = np.round((HOME + np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.001 * number])) * 1e6).astype(int)
            peer.sendall(struct.pack(">8i", 20, *goal, 1))
            controller.cycle()
            targets.append(controller.target[5])
        # One setpoint a cycle, in their order; the last one is late by less than twenty.
        assert (np.diff(targets) > -1e-9).all() and len(np.unique(np.round(targets, 6))) > 150
        assert targets[-1] == pytest.approx(0.001 * 199, abs=0.02)
        for _ in range(2000):
            controller.cycle()
            if controller.program is None:
                break
    assert controller.logged == ["timed out"] and not controller.words
    np.testing.assert_array_equal(controller.body.read()[1], 0.0)
