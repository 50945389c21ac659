"""servoc and what a script asks of the robot's past, load and derivatives.

Numbers come from the circle that touches the way of the tool, the ramp of the move, and differences.
"""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.ur import exchange
from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.scripts import run_script

from tests.apps.languages.urscript_robot import HOME, Played


def test_servoc_goes_along_a_line_and_on_along_the_arc_that_touches_it() -> None:
    """Up 8 cm, then to a place 5 cm up and 5 cm aside: a quarter of the circle of 5 cm around the place beside."""
    played = Played(
        """
        a = get_target_tcp_pose()
        b = pose_add(a, p[0, 0, 0.08, 0, 0, 0])
        servoc(b, a=1, v=0.1, r=0.03)
        servoc(pose_add(a, p[0, 0.05, 0.1, 0, 0, 0]), a=1, v=0.1)
        textmsg(point_dist(get_target_tcp_pose(), pose_add(a, p[0, 0.05, 0.1, 0, 0, 0])) < 0.0001)
        """
    )
    assert played.said == ["True"]
    places = played.places - played.pose(HOME)[:3, 3]
    arc = places[places[:, 1] > 1e-6]
    assert np.abs(places[places[:, 2] < 0.05][:, :2]).max() < 1e-6
    # It joins within a cycle's way (0.2 mm) behind 5 cm.
    np.testing.assert_allclose(np.linalg.norm(arc - [0.0, 0.05, 0.05], axis=1), 0.05, atol=2e-4)
    speeds = np.linalg.norm(np.diff(played.places, axis=0), axis=1) / 0.002
    moving = speeds[np.flatnonzero(speeds > 0.099)[0] : np.flatnonzero(speeds > 0.099)[-1]]
    assert moving.min() > 0.099 and speeds.max() == pytest.approx(0.1, rel=1e-2)


def test_servoc_refuses_what_is_behind_the_tool_and_does_nothing_at_its_goal() -> None:
    played = Played(
        """
        a = get_target_tcp_pose()
        servoc(a)
        textmsg("there")
        servoc(pose_add(a, p[0, 0, 0.08, 0, 0, 0]), r=0.03)
        servoc(a)
        """
    )
    assert played.said == ["there", "script:7: servoc can't turn back at once: its pose is behind the tool"]


def test_the_past_the_goal_and_the_load_are_told() -> None:
    played = Played(
        """
        thread away():
          movej([0.4, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)
        end
        run away()
        sleep(0.1)
        q = get_actual_joint_positions_history(10)
        textmsg(q[0] < get_actual_joint_positions()[0], q[0] > 0)
        goal = get_forward_kin([0.4, -1.57, 1.57, -1.57, -1.57, 0])
        textmsg(point_dist(get_target_waypoint(), goal) < 0.000001)
        textmsg(get_target_joint_accelerations()[0])
        sleep(1)
        textmsg(point_dist(get_target_waypoint(), get_target_tcp_pose()))
        set_target_payload(1.5, [0, 0, 0.1], [0.1, 0.2, 0.3, 0, 0, 0])
        textmsg(get_target_payload_inertia())
        get_actual_joint_positions_history(1000)
        """
    )
    assert played.said[:2] == ["TrueTrue", "True"]
    assert float(played.said[2]) == pytest.approx(2.0, rel=1e-6)
    assert played.said[3:5] == ["0", "[0.1, 0.2, 0.3, 0, 0, 0]"]
    assert "steps is a whole number from 0 to" in played.said[5]


def test_the_change_of_the_jacobian_is_that_of_the_differences() -> None:
    """The angular part of the last column is the axis of joint 6; joint 1 alone turns it by its speed about z."""
    played = Played(
        """
        d = get_jacobian_time_derivative([0, -1, 1, 0.3, 0.4, 0], [0.5, 0, 0, 0, 0, 0])
        j = get_jacobian([0, -1, 1, 0.3, 0.4, 0])
        textmsg(norm(d[3, 5] + 0.5 * j[4, 5]) < 0.00001, norm(d[4, 5] - 0.5 * j[3, 5]) < 0.00001)
        """
    )
    assert played.said == ["TrueTrue"]


def test_a_cycle_that_ends_by_a_fault_sets_no_registers() -> None:
    played = Played("write_output_integer_register(0, 1)\nsync()\nwrite_output_integer_register(0, 2)\ntool_contact()")
    assert played.controller.registers == {"output_int_register_0": 1}


def test_analog_outputs_are_volts_or_amperes() -> None:
    """Shares of 0 to 10 V, and of 4 to 20 mA."""
    controller = Controller(SimulatedArm(HOME))
    controller.take(
        {"standard_analog_output_mask": 3, "standard_analog_output_type": 1}
        | {"standard_analog_output_0": 0.25, "standard_analog_output_1": 0.5}
    )
    told = controller.tell()
    assert (told["standard_analog_output0"], told["standard_analog_output1"]) == (2.5, pytest.approx(0.012))
    assert told["analog_io_types"] == 0b0111


def test_a_thread_that_never_waits_ends_the_script_at_its_line_and_the_arm_stops() -> None:
    played = Played(
        """
        thread busy():
          while True:
            i = 1
          end
        end
        run busy()
        movej([2, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=0.5)
        """
    )
    (said,) = played.said
    assert said.startswith("script:") and "'busy' computes without a wait: put sync() or sleep() into its loop" in said
    for _ in range(500):
        played.controller.cycle()
    assert played.controller.program is None and not played.controller.body.read()[1].any()


def test_ten_thousand_malformed_packets_change_nothing(rng: np.random.Generator) -> None:
    """Each kind of packet with bytes drawn anew, some cut or turned: an answer, or an end in words."""
    controller = Controller(SimulatedArm(HOME))
    before = controller.tell()
    kinds = np.array([ord(kind) for kind in "VvMUOISP?"])
    for _ in range(10_000):
        session = exchange.Session(controller.rate, controller.version, set())
        body = bytes(rng.integers(0, 256, rng.integers(0, 40), dtype=np.uint8))
        whole = exchange.packet(
            int(rng.choice(kinds)), rng.choice([b"", b"actual_q,", b"input_int_register_0\x00"]) + body
        )
        data = bytearray(whole[: rng.integers(0, len(whole) + 1)])
        if len(data) > 1 and rng.random() < 0.3:
            data[rng.integers(0, 2)] = rng.integers(0, 256)
        try:
            for kind, content in exchange.packets(data):
                session.take(kind, content)
        except (ValueError, exchange.struct.error):
            continue
        controller.take(session.set)
    after = controller.tell()
    assert all(np.array_equal(np.asarray(before[name]), np.asarray(after[name])) for name in before)


def test_a_client_that_vanishes_in_servoj_is_missed_by_the_watchdog() -> None:
    controller = Controller(SimulatedArm(HOME))
    run_script(
        controller,
        """def follow():
          rtde_set_watchdog("input_int_register_24", 20, "stop")
          while True:
            q = get_target_joint_positions()
            q[5] = read_input_float_register(24)
            servoj(q)
          end
        end
        """,
    )
    for number in range(500):
        controller.take({"input_int_register_24": number, "input_double_register_24": 0.001 * number})
        controller.cycle()
    assert np.abs(controller.body.read()[1]).max() > 0.4
    cycles = 0
    while controller.program is not None:
        controller.cycle()
        cycles += 1
    # 20 Hz are missed after 50 ms; then the joints brake with END_DECELERATION.
    assert cycles == 25 and "input_int_register_24 was not written in time" in controller.words[-1][2]
    speed = float(np.abs(controller.body.read()[1]).max())
    for _ in range(round(speed / 4.0 * 500) + 100):
        controller.cycle()
    assert not controller.body.read()[1].any()
