"""The emulated controller of Universal Robots: programs with ur-rtde run against it and the twin, unchanged."""

from __future__ import annotations

import contextlib
import socket
import struct
import tracemalloc
from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.geometry import rotation_vector_of
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.command import emulate
from virtualrobot_apps.emulators.ur import dashboard, kinematics
from virtualrobot_apps.emulators.ur.controller import Controller, RobotMode, Runtime, SafetyMode
from virtualrobot_apps.emulators.ur.kinematics import MODELS, NoPosture
from virtualrobot_apps.emulators.ur.lengths import model_of
from virtualrobot_apps.emulators.ur.orders import obey
from virtualrobot_apps.emulators.ur.scripts import run_script
from virtualrobot_apps.emulators.ur.server import Server

from tests.apps.ur_programs import MORE, MOVES, PATHS, told
from tests.drivers.peers import ADDRESS
from tests.drivers.ur_controllers import ControllerProcess, host
from tests.kernels import KernelProcess, Stubs
from tests.tiers import Draws
from tests.waiting import until

HOME = np.array([0.0, -1.57, 1.57, -1.57, -1.57, 0.0])


def made() -> Controller:
    return Controller(SimulatedArm(HOME))


def play(controller: Controller, script: str) -> None:
    """Run a script to its end."""
    run_script(controller, script)
    for _ in range(20000):
        controller.cycle()
        if controller.program is None and not controller.moving:
            return
    raise AssertionError(f"{script!r} has no end")


@pytest.fixture(scope="module")
def process() -> Iterator[ControllerProcess]:
    running = ControllerProcess(host=host(1))
    yield running
    running.kill()


@pytest.mark.parametrize("name", MODELS)
def test_the_inverse_and_the_jacobian_belong_to_the_forward(name: str, rng: np.random.Generator, draws: Draws) -> None:
    model, tcp = MODELS[name], kinematics.matrix_of(np.array([0.01, -0.02, 0.1, 0.2, 0.1, -0.3]))
    for _ in range(draws(10)):
        # Away from stretched elbow and wrist, where postures meet.
        positions = rng.uniform(-2.5, 2.5, 6)
        positions[[2, 4]] = rng.choice([-1.0, 1.0], 2) * rng.uniform(0.6, 2.4, 2)
        pose = kinematics.forward(model, positions, tcp)
        found = kinematics.inverse(model, pose, positions + rng.uniform(-0.05, 0.05, 6), tcp)
        np.testing.assert_allclose(kinematics.forward(model, found, tcp), pose, atol=1e-8)
        slope = kinematics.jacobian(model, positions, tcp)
        for joint, step in enumerate(1e-6 * np.eye(6)):
            after = kinematics.forward(model, positions + step, tcp)
            turn = rotation_vector_of(after[:3, :3] @ pose[:3, :3].T)
            moved = np.concatenate([after[:3, 3] - pose[:3, 3], turn]) / 1e-6
            np.testing.assert_allclose(slope[:, joint], moved, atol=1e-5)
    with pytest.raises(NoPosture, match="no posture near"):
        kinematics.inverse(model, kinematics.matrix_of(np.array([9.0, 0.0, 0.0, 0.0, 0.0, 0.0])), HOME)


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.long] * (name != "ur5")) for name in MODELS])
def test_poses_are_those_of_the_model_in_the_catalogue(
    name: str, kernel: KernelProcess, stubs: Stubs, rng: np.random.Generator
) -> None:
    with virtualrobot.connect(kernel.address) as client:
        arm = client.load_robot(f"model://{name}", name="arm")
        assert model_of(arm) == name
        for _ in range(3):
            positions = rng.uniform(-3.0, 3.0, 6)
            arm.set_positions(positions)
            here = kinematics.forward(MODELS[name], positions)
            np.testing.assert_allclose(arm.tcp, here, atol=2e-3)


def test_an_arm_whose_joints_turn_less_is_no_model(kernel: KernelProcess, stubs: Stubs) -> None:
    with virtualrobot.connect(kernel.address) as client:
        assert model_of(client.load_robot("model://irb120", name="arm")) is None


@pytest.mark.long
def test_a_program_with_ur_rtde_moves_an_arm(process: ControllerProcess) -> None:
    said = told(MOVES, process.host)
    start, pose = said["start"]
    np.testing.assert_allclose(start, HOME, atol=1e-6)
    model = MODELS["ur5e"]
    np.testing.assert_allclose(kinematics.matrix_of(np.array(pose)), kinematics.forward(model, HOME), atol=1e-6)
    done, joints = said["moveJ"]
    assert done
    np.testing.assert_allclose(joints, [0.2, -1.4, 1.4, -1.5, -1.4, 0.1], atol=1e-3)
    done, joints, there, asked = said["moveL"]
    assert done
    np.testing.assert_allclose(there, asked, atol=2e-3)
    np.testing.assert_allclose(joints, said["inverse"], atol=1e-3)
    done, joints, asked = said["servoJ"]
    assert done and said["servoStop"]
    np.testing.assert_allclose(joints, asked, atol=1e-3)


@pytest.mark.long
def test_a_program_with_ur_rtde_moves_along_paths_and_jogs() -> None:
    """Paths with blends are lines that the library puts into its script, and so is a function of the program's own."""
    process = ControllerProcess(host=host(3))
    try:
        said = told(PATHS, process.host)
    finally:
        process.kill()
    done, there, asked = said["moveL"]
    assert done
    np.testing.assert_allclose(kinematics.matrix_of(np.array(there)), kinematics.matrix_of(np.array(asked)), atol=1e-3)
    done, joints = said["moveJ"]
    assert done
    np.testing.assert_allclose(joints, HOME, atol=1e-3)
    started, stopped, way = said["jog"]
    assert started and stopped and 0.019 < way[2] < 0.05
    np.testing.assert_allclose(way[:2], 0.0, atol=1e-3)
    done, speed, stopped = said["speedL"]
    assert done and stopped
    np.testing.assert_allclose(speed, [0.0, 0.0, 0.1, 0.0, 0.0, 0.0], atol=5e-3)
    assert said["within"] == [False, True] and said["forces"] == [0.0] * 6 and said["custom"]


@pytest.mark.long
def test_a_program_with_ur_rtde_does_all_else() -> None:
    process = ControllerProcess(host=host(2))
    try:
        said = told(MORE, process.host)
    finally:
        process.kill()
    assert said["speedJ"][0] and said["speedJ"][2]
    np.testing.assert_allclose(said["speedJ"][1], [0.0] * 5 + [0.3], atol=0.011)
    started, progress, went, speed, steady = said["stopJ"]
    assert started and progress >= 0 and 0.0 < went < 0.9 and speed < 1e-3 and steady
    assert said["setTcp"] == [True, [0.0, 0.0, pytest.approx(0.1), 0.0, 0.0, 0.0]] and said["setPayload"]
    np.testing.assert_allclose(*said["forward"], atol=1e-6)
    assert said["outputs"][:2] == [True, True] and said["outputs"][2] & 0b1000
    assert said["status"] == [3, True, SafetyMode.NORMAL]
    assert said["stopScript"] is False and said["reuploadScript"] == [True, True]
    assert said["protective"] == [True, SafetyMode.PROTECTIVE_STOP, False]


@pytest.mark.long
def test_a_program_with_ur_rtde_moves_the_twin(kernel: KernelProcess, stubs: Stubs) -> None:
    with virtualrobot.connect(kernel.address) as client:
        arm = client.load_robot("model://ur5e", name="arm")
        arm.set_positions(HOME)
        process = ControllerProcess("arm", "--address", kernel.address, host=host(2))
        try:
            said = told(MOVES, process.host)
            done, joints, asked = said["servoJ"]
            assert done and said["moveJ"][0] and said["moveL"][0] and said["servoStop"]
            np.testing.assert_allclose(joints, asked, atol=1e-3)
            np.testing.assert_allclose(arm.positions, asked, atol=1e-3)
            np.testing.assert_allclose(said["moveL"][2], said["moveL"][3], atol=2e-3)
            np.testing.assert_allclose(arm.tcp[:3, 3], said["moveL"][2][:3], atol=2e-3)
        finally:
            process.kill()


def test_lines_of_script_have_an_effect(rng: np.random.Generator) -> None:
    controller = made()
    play(controller, "movej([0.1, -1.5, 1.5, -1.5, -1.5, 0.2], a=3.0, v=2.0)\n")
    np.testing.assert_allclose(controller.body.read()[0], [0.1, -1.5, 1.5, -1.5, -1.5, 0.2], atol=2e-5)
    pose = kinematics.pose_of(kinematics.forward(controller.model, controller.body.read()[0]))
    pose[2] += 0.02
    play(controller, f"def mine():\n  movel(p{pose.tolist()}, 1.2, 0.25)\n  set_digital_out(2, True)\nend\n")
    here = kinematics.forward(controller.model, controller.body.read()[0])
    np.testing.assert_allclose(kinematics.pose_of(here), pose, atol=1e-4)
    assert controller.digital_outputs == 0b100
    run_script(controller, "set_tcp(p[1, 2])\n")
    said = "syntax_error_on_line:1: 'p' is never given a value; a pose p[x, y, z, rx, ry, rz] has 6 numbers"
    assert controller.words == [(210, 0, said)]
    controller.words.clear()
    run_script(controller, "movel(p[9, 0, 0, 0, 0, 0], 1, 1)\n")
    controller.cycle()
    assert "no posture near" in controller.words[0][2] and not controller.moving


def test_the_dashboard_answers() -> None:
    controller = made()

    def asked(line: str) -> str:
        return dashboard.answer(controller, line)

    assert asked("PolyscopeVersion").startswith("URSoftware 5.26.0.0")
    assert (asked("robotmode"), asked("safetymode")) == ("Robotmode: RUNNING", "Safetymode: NORMAL")
    assert (asked("load a.urp"), asked("play")) == ("File not found: a.urp", "Failed to execute: play")
    assert asked("pause") == "Failed to execute: pause"
    assert asked("dance") == 'could not understand: "dance"'
    assert (asked("popup Door open"), asked("addToLog night")) == ("showing popup", "Added log message")
    assert controller.logged == ["popup: Door open", "night"]
    run_script(controller, "movej([1, -1.5, 1.5, -1.5, -1.5, 0], a=3.0, v=2.0)\n")
    for _ in range(100):
        controller.cycle()
    assert asked("running") == "Program running: true" and np.abs(controller.body.read()[1]).max() > 0.3
    assert asked("stop") == "Stopped" and asked("programState") == "STOPPED <unnamed>"
    for _ in range(300):
        controller.cycle()
    np.testing.assert_array_equal(controller.body.read()[1], 0.0)
    assert asked("power off") == "Powering off" and controller.mode is RobotMode.POWER_OFF
    run_script(controller, "movej([0, -1.5, 1.5, -1.5, -1.5, 0], a=3.0, v=2.0)\n")
    assert controller.program is None and "the robot is POWER_OFF" in controller.words[-1][2]
    asked("power on")
    for _ in range(60):
        controller.cycle()
    assert controller.mode is RobotMode.IDLE
    asked("brake release")
    for _ in range(60):
        controller.cycle()
    assert controller.mode is RobotMode.RUNNING
    controller.protective_stop("Collision")
    assert asked("safetystatus") == "Safetystatus: PROTECTIVE_STOP"
    asked("unlock protective stop")
    assert controller.safety is SafetyMode.NORMAL


@pytest.mark.parametrize(
    ("script", "path"),
    [
        ("def mine():\n  movej([0.5, -1.57, 1.57, -1.57, -1.57, 0], a=2, v=1)\nend\n", True),
        ("def mine():\n  while True:\n    speedj([0.5, 0, 0, 0, 0, 0], 4, 0.01)\n  end\nend\n", False),
        (
            "def mine():\n  i = 0\n  while True:\n    servoj([i * 0.001, -1.57, 1.57, -1.57, -1.57, 0])\n"
            "    i = i + 1\n  end\nend\n",
            False,
        ),
    ],
)
def test_the_dashboard_pauses_a_program_and_lets_it_go_on(script: str, path: bool) -> None:
    controller = made()

    def cycles(count: int) -> np.ndarray:
        for _ in range(count):
            controller.cycle()
        return controller.body.read()[0]

    run_script(controller, script)
    begin = cycles(100)
    assert np.abs(controller.body.read()[1]).max() > 0.1
    assert dashboard.answer(controller, "pause") == "Pausing program"
    assert dashboard.answer(controller, "programState") == "PAUSED mine"
    assert dashboard.answer(controller, "running") == "Program running: false"
    assert controller.tell()["runtime_state"] == Runtime.PAUSED
    there = cycles(300)
    assert there[0] > begin[0] + 0.001  # it brakes, and doesn't stand at once
    np.testing.assert_array_equal(cycles(50), there)
    assert dashboard.answer(controller, "play") == "Starting program"
    assert dashboard.answer(controller, "play") == "Failed to execute: play"
    assert cycles(100)[0] > there[0] + 0.001 and dashboard.answer(controller, "programState") == "PLAYING mine"
    if path:
        np.testing.assert_allclose(cycles(1000), [0.5, *HOME[1:]], atol=2e-5)
        assert controller.program is None
    else:
        dashboard.answer(controller, "pause")
        dashboard.answer(controller, "stop")
        assert not controller.paused and dashboard.answer(controller, "programState") == "STOPPED <unnamed>"


def test_the_dashboard_shuts_the_controller_down() -> None:
    server = Server(made(), ADDRESS)
    try:
        with socket.create_connection((ADDRESS, 29999)) as connection, connection.makefile("rb") as lines:
            connection.sendall(b"shutdown\n")
            server.run(lambda: False)  # ends by itself
            assert [lines.readline(), lines.readline()] == [
                b"Connected: Universal Robots Dashboard Server\n",
                b"Shutting down\n",
            ]
        assert server.controller.off and server.controller.mode is RobotMode.POWER_OFF
    finally:
        server.close()


def test_orders_are_obeyed_or_refused_in_words() -> None:
    controller = made()
    assert obey(controller, "input 3 on\n") == obey(controller, "speed 0.25\n") == obey(controller, "\n") == ""
    assert (controller.digital_inputs, controller.slider) == (0b1000, 0.25)
    assert obey(controller, "emergency stop\n") == "" and controller.safety is SafetyMode.ROBOT_EMERGENCY_STOP
    obey(controller, "release\n")
    assert (controller.safety, controller.mode) == (SafetyMode.NORMAL, RobotMode.POWER_OFF)
    assert obey(controller, "speed 7\n") == "speed is a share from 0 to 1, not 7"
    assert obey(controller, "jump\n").startswith("'jump' is none of protective stop, ")
    assert "is none of" in obey(controller, "input 18 on\n")


def test_what_the_kernel_refuses_is_a_protective_stop() -> None:
    arm = SimulatedArm(HOME)
    controller = Controller(arm)
    play(controller, "movej([0, -1.57, 1.57, -1.57, -1.57, 7.0], a=15.0, v=3.0)\n")
    assert controller.safety is SafetyMode.PROTECTIVE_STOP
    assert any("joint joint_6 would be at" in text for _, _, text in controller.words)


def test_a_script_comes_in_pieces_and_its_log_and_faults_are_told() -> None:
    controller = made()
    server = Server(controller, ADDRESS)
    try:
        with socket.create_connection((ADDRESS, 30002)) as connection:
            connection.setblocking(False)
            got = bytearray()

            def told(words: bytes) -> bool:
                server.cycle()
                with contextlib.suppress(BlockingIOError):
                    got.extend(connection.recv(65536))
                return words in got

            script = b"# mine\ndef mine():\n  textmsg(get_steptime())\n  sleep(10)\nend\nrun program\n"
            connection.sendall(script[:40])
            for _ in range(5):
                server.cycle()
            assert controller.program is None
            connection.sendall(script[40:])
            until(lambda: told(b"0.002"))
            assert controller.program is not None and controller.program.name == "mine"
            connection.sendall(b"movj([1, 2])\n")
            until(lambda: told(b"syntax_error_on_line:1: there is no function 'movj'; did you mean 'movej'?"))
            assert controller.program is not None
            connection.sendall(b'def mine():\n  textmsg("so far")\n  textmsg([1][2])\nend\n')
            until(lambda: told(b"script:3: the index 2 is outside 0 to 0"))
            assert b"so far" in got[: got.index(b"script:3")]
            assert controller.program is None
    finally:
        server.close()


def test_a_script_waits_until_its_popup_is_closed() -> None:
    controller = made()
    controller.attended = True
    for close in (lambda: dashboard.answer(controller, "close popup"), lambda: obey(controller, "close popup")):
        controller.logged.clear()
        run_script(controller, 'popup("ready?", "Cell", False, False, blocking=True)\n')
        for _ in range(50):
            controller.cycle()
        assert controller.logged == ["Cell: ready?"] and controller.program is not None
        close()
        for _ in range(2):
            controller.cycle()
        assert controller.program is None and not controller.words
    run_script(controller, 'popup("ready?", blocking=True)\n')
    controller.cycle()
    controller.end_program()
    assert not controller.popup


def test_nonsense_ends_a_connection_and_nothing_else() -> None:
    said: list[str] = []
    server = Server(made(), ADDRESS, said.append)
    try:
        for data in (b"\0\1V", b"\0\3O", b"\0\4O\0", b"\0\5U\7\7", b"\xff\xff" * 3):
            with socket.create_connection((ADDRESS, 30004)) as program:
                program.sendall(data)
                for _ in range(3):
                    server.cycle()
        with socket.create_connection((ADDRESS, 30002)) as program:
            program.sendall(b"movej(])\n")
            for _ in range(3):
                server.cycle()
        assert server.controller.cycles == 18 and said == ["syntax_error_on_line:1: a value is expected here, not ']'"]
        with pytest.raises(OSError, match="in use"):
            Server(made(), ADDRESS)
    finally:
        server.close()


def malformed(rng: np.random.Generator) -> bytes:
    """Return a packet of RTDE that is none: of wrong size, cut off, of no kind, with a body that doesn't fit."""
    kind = int(rng.choice(list(b"VvMUOISP")))
    body = [
        rng.bytes(int(rng.integers(0, 60))),
        struct.pack(">d", float(rng.choice([np.nan, np.inf, -1.0, 0.0]))) + b"actual_q,nothing,,",
        b"input_int_register_0,input_int_register_999,timestamp",
        bytes((int(rng.integers(0, 256)),)) + struct.pack(">d", np.nan),
    ][int(rng.integers(4))]
    size = int(rng.choice([0, 1, 2, 3, 3 + len(body), 4 + len(body), 65535]))
    return struct.pack(">HB", size, kind) + body


@pytest.mark.long
def test_ten_thousand_malformed_packets_break_nothing(rng: np.random.Generator) -> None:
    """A client that was there before is told in each cycle, and what the flood has taken is given back."""
    server, at_once = Server(made(), ADDRESS), 50
    try:
        with socket.create_connection((ADDRESS, 30004)) as bystander, bystander.makefile("rb") as told:
            bystander.sendall(struct.pack(">HBd", 11 + 9, ord("O"), 500.0) + b"timestamp" + b"\0\3S")
            server.cycle()
            assert told.read(3 + 1 + 6 + 3 + 1).endswith(b"S\1")
            grown, seen = [], server.controller.cycles - 1
            tracemalloc.start()
            for number in range(10_000 // at_once):
                with contextlib.ExitStack() as stack:
                    for _ in range(at_once):
                        connection = stack.enter_context(socket.create_connection((ADDRESS, 30004)))
                        connection.sendall(malformed(rng))
                    server.cycle()
                server.cycle()  # they are gone
                while seen < server.controller.cycles:
                    seen += 1
                    assert told.read(12) == struct.pack(">HBBd", 12, ord("U"), 1, seen * 0.002)
                if number in (99, 199):
                    grown.append(tracemalloc.get_traced_memory()[0])
            assert len(server.clients) == 1 and grown[1] - grown[0] < 100_000
    finally:
        tracemalloc.stop()
        server.close()


def test_a_number_that_is_none_is_told_once_and_changes_nothing() -> None:
    """Packets after it count: the client is there still."""
    said: list[str] = []
    server = Server(made(), ADDRESS, said.append)
    try:
        with socket.create_connection((ADDRESS, 30004)) as program:
            names = b"speed_slider_mask,speed_slider_fraction"
            program.sendall(struct.pack(">HB", 3 + len(names), ord("I")) + names)
            for fraction in (np.nan, np.nan, 0.5, np.nan):
                program.sendall(struct.pack(">HBBId", 16, ord("U"), 1, 1, fraction))
            until(lambda: server.cycle() or server.controller.slider == 0.5)
            server.cycle()
        assert said == ["RTDE: speed_slider_fraction is a finite number, not nan; packets with it are left out"]
        assert server.controller.slider == 0.5
    finally:
        server.close()


_TO_NOWHERE = """
said["nowhere"] = [control.moveJ([float("nan")] * 6, 1.0, 1.0), control.isProgramRunning(), receive.isConnected()]
said["anew"] = control.reuploadScript()
while not control.isProgramRunning():
    time.sleep(0.002)
said["somewhere"] = control.moveJ([0.0, -1.5, 1.5, -1.57, -1.57, 0.0], 1.0, 1.0)
"""


@pytest.mark.long
def test_a_program_that_moves_to_no_number_ends_its_script(process: ControllerProcess) -> None:
    """The script ends where it reads the register, so the library says False, and its connection is as it was."""
    assert told(_TO_NOWHERE, process.host) == {"nowhere": [False, False, True], "anew": True, "somewhere": True}


def test_wrong_options_are_told() -> None:
    done = CliRunner().invoke(emulate, ["ur", "--host", "192.0.2.1"])
    assert done.exit_code == 1 and "the ports 29999 to 30004 of 192.0.2.1 can't be had" in done.output
    assert CliRunner().invoke(emulate, ["ur", "--model", "ur4"]).exit_code == 2
    with pytest.raises(ValueError, match="six joints that turn, not 5"):
        Controller(SimulatedArm([0.0] * 5))
