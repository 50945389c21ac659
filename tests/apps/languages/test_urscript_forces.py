"""Force mode: a tool pushes as it shall, on springs by Hooke's law, under physics, and by ur-rtde.

Numbers come from the springs, from weights m g, from friction's law, and from velocity = force / damping.
"""

from __future__ import annotations

import socket
from collections.abc import Callable

import numpy as np
import pytest
import virtualrobot
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.ur import kinematics
from virtualrobot_apps.emulators.ur.controller import HARD_DECELERATION, PAUSE_SECONDS, Controller, SafetyMode
from virtualrobot_apps.emulators.ur.forces import Payload
from virtualrobot_apps.emulators.ur.kinematics import Floats
from virtualrobot_apps.emulators.ur.lengths import turn_of_flange

from tests.apps.languages.urscript_robot import HOME, Played
from tests.apps.ur_programs import told
from tests.drivers.ur_controllers import ControllerProcess, host
from tests.kernels import KernelProcess, Stubs

_NOTHING = np.zeros(6)
_MODE = "force_mode(p[0, 0, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], [0, 0, -10, 0, 0, 0], 2, [0.1, 0.1, 0.1, 1, 1, 1])"
_WAIT = """
n = 0
while n < {cycles}:
  sync()
  n = n + 1
end
"""


class Pushed(Played):
    """A controller whose tool is pushed by a law: force and torque (6,) about the TCP along the base's axes.

    `felt` (n, 6) is what pushed in each cycle; the law is given the pose (4, 4) of the TCP.
    """

    def __init__(self, statements: str, law: Callable[[Floats], Floats], cycles: int = 4000) -> None:
        """Play statements after RTDE was asked to tell forces."""
        controller = Controller(SimulatedArm(HOME))
        felt = []

        def advance(seconds: float, go_on: Callable[[float], None] = controller.body.advance) -> None:
            go_on(seconds)
            base_t_flange = controller.base_t_flange
            wrench = law(base_t_flange @ controller.tcp)
            felt.append(wrench)
            turn = base_t_flange[:3, :3].T
            force = turn @ wrench[:3]
            about = turn @ wrench[3:] + np.cross(controller.tcp[:3, 3], force)
            controller.take({"external_force_torque": (*force, *about)})

        controller.body.advance = advance  # type: ignore[method-assign]
        super().__init__(f"ft_rtde_input_enable(True)\n{statements}", cycles, controller)
        self.felt = np.array(felt)


def _floor(below: float, stiffness: float, friction: float = 0.0) -> Callable[[Floats], Floats]:
    """Return the law of a floor that is so far (m) below the tool at home, a spring (N/m)."""
    height = Controller(SimulatedArm(HOME)).base_t_flange[2, 3] - below

    def law(base_t_tcp: Floats) -> Floats:
        force = stiffness * max(height - base_t_tcp[2, 3], 0.0)
        return np.array([-friction * force, 0.0, force, 0.0, 0.0, 0.0])

    return law


@pytest.mark.parametrize("stiffness", [2e3, 5e4, 1e6])
def test_a_tool_pushes_as_it_shall_however_stiff_the_floor_is(stiffness: float) -> None:
    pushed = Pushed(_MODE + _WAIT.format(cycles=1500), _floor(0.003, stiffness))
    assert pushed.said == []
    assert np.abs(pushed.felt[-200:, 2] - 10.0).max() < 0.2
    down = pushed.places - pushed.places[0]
    assert down[-1, 2] == pytest.approx(-0.003 - 10.0 / stiffness, abs=1e-4)
    assert np.abs(down[:, :2]).max() < 1e-7


@pytest.mark.parametrize("stiffness", [2e3, 2e4])
def test_noise_of_the_sensor_is_no_stiffness(rng: np.random.Generator, stiffness: float) -> None:
    """Of 2 N: the floor rises by half the force's way, and the mean force is soon what it shall be."""
    cycles, floors = 0, [_floor(0.002, stiffness), _floor(0.002 - 5.0 / stiffness, stiffness)]

    def law(base_t_tcp: Floats) -> Floats:
        nonlocal cycles
        cycles += 1
        felt = floors[cycles > 1500](base_t_tcp)
        return felt + (felt[2] > 0.0) * rng.normal(0.0, 2.0) * np.eye(6)[2]

    pushed = Pushed(_MODE + _WAIT.format(cycles=3000), law)
    assert np.mean(pushed.felt[1000:1500, 2]) == pytest.approx(10.0, abs=1.0)
    assert np.mean(pushed.felt[2500:, 2]) == pytest.approx(10.0, abs=1.0)


@pytest.mark.parametrize(
    ("settings", "limit", "speed"),
    [
        ("", 0.1, 10.0 / 200.0),
        ("force_mode_set_gain_scaling(0.5)", 0.1, 5.0 / 200.0),
        ("force_mode_set_damping(0.05)", 0.1, 5.0 / 200.0),
        ("", 0.03, 0.03),
    ],
)
def test_in_the_air_the_tool_goes_at_the_speed_of_its_damping_within_the_limit(
    settings: str, limit: float, speed: float
) -> None:
    mode = _MODE.replace("0.1, 0.1, 0.1", f"9, 9, {limit}")
    pushed = Pushed(f"{settings}\n{mode}" + _WAIT.format(cycles=300), lambda _: _NOTHING)
    steps = np.diff(pushed.places[150:280, 2]) / pushed.controller.dt
    np.testing.assert_allclose(steps, -speed, rtol=1e-4)


def test_a_move_goes_along_the_other_axes_while_the_tool_pushes_and_friction_turns_nothing() -> None:
    rise = "p[0.04, 0.02, 0.03, 0, 0, 0]"
    pushed = Pushed(
        f"""
        here = get_target_tcp_pose()
        {_MODE}
        {_WAIT.format(cycles=500)}
        movel(pose_add(here, {rise}), a=0.5, v=0.1)
        textmsg("there")
        """,
        _floor(0.001, 2e4, friction=0.3),
        8000,
    )
    assert pushed.said == ["there"]
    way = pushed.places[-1] - pushed.places[0]
    np.testing.assert_allclose(way[:2], [0.04, 0.02], atol=1e-6)
    assert way[2] == pytest.approx(-0.0015, abs=1e-4)  # the move's rise is not done along the axis that gives way
    moving = pushed.felt[500:-100]
    assert np.abs(moving[:, 2] - 10.0).max() < 1.0
    turned = pushed.pose(pushed.targets[-1])[:3, :3].T @ pushed.pose(pushed.targets[0])[:3, :3]
    np.testing.assert_allclose(turned, np.eye(3), atol=1e-6)


def test_a_move_goes_on_beside_its_line_where_the_mode_ends_meanwhile() -> None:
    pushed = Pushed(
        f"""
        thread away():
          movel(pose_add(get_target_tcp_pose(), p[0, 0.05, 0, 0, 0, 0]), a=0.5, v=0.05)
          textmsg("there")
        end
        {_MODE}
        mover = run away()
        {_WAIT.format(cycles=200)}
        end_force_mode()
        join mover
        """,
        lambda _: _NOTHING,
    )
    assert pushed.said == ["there"]
    way = pushed.places - pushed.places[0]
    assert way[-1, 1] == pytest.approx(0.05, abs=1e-5)
    assert np.ptp(way[300:, 2]) < 1e-9 and way[-1, 2] < -0.005
    assert pushed.controller.compliance is None


@pytest.mark.parametrize(
    ("kind", "frame", "axis", "expected"),
    [
        # Type 1: y points from the tool to the frame's origin, which is 0.2 m beside it along x.
        (1, "p[0.2, 0, 0, 0, 0, 0]", 1, [1.0, 0.0, 0.0]),
        # Type 2: a frame that is turned by 90 degrees about z has its x along the base's y.
        (2, "p[0, 0, 0, 0, 0, 1.5707963267948966]", 0, [0.0, 1.0, 0.0]),
    ],
)
def test_axes_are_those_of_the_frames_type(kind: int, frame: str, axis: int, expected: list[float]) -> None:
    chosen, wrench = [0] * 6, [0.0] * 6
    chosen[axis], wrench[axis] = 1, 10.0
    pushed = Pushed(
        f"""
        here = get_target_tcp_pose()
        place = {frame}
        at = p[here[0] + place[0], here[1] + place[1], here[2] + place[2], place[3], place[4], place[5]]
        force_mode(at, {chosen}, {wrench}, {kind}, [0.1, 0.1, 0.1, 1, 1, 1])
        {_WAIT.format(cycles=200)}
        """,
        lambda _: _NOTHING,
    )
    way = pushed.places[150] - pushed.places[0]
    np.testing.assert_allclose(way / np.linalg.norm(way), expected, atol=1e-6)


def test_across_its_way_a_tool_gives_way_in_type_3() -> None:
    """Its x is along the way in the plane, so y is across it: a push of 10 N across moves it at 0.05 m/s."""
    pushed = Pushed(
        f"""
        {_MODE.replace("[0, 0, 1, 0, 0, 0], [0, 0, -10, 0, 0, 0], 2", "[0, 1, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0], 3")}
        movel(pose_add(get_target_tcp_pose(), p[0.05, 0, 0, 0, 0, 0]), a=0.5, v=0.02)
        """,
        lambda _: np.array([0.0, 10.0, 0.0, 0.0, 0.0, 0.0]),
    )
    way = pushed.places[1200] - pushed.places[700]
    np.testing.assert_allclose(way, [0.02, 0.05, 0.0], atol=2e-4)


def test_a_tool_turns_until_no_torque_is_left() -> None:
    """A torsion spring about the base's z, 20 Nm/rad, that is at rest at 0.1 rad: 10 Nm s/rad are 0.5 s for e to 1."""
    start = Controller(SimulatedArm(HOME)).base_t_flange

    def law(base_t_tcp: Floats) -> Floats:
        turned = base_t_tcp[:3, :3] @ start[:3, :3].T
        return np.array([0.0, 0.0, 0.0, 0.0, 0.0, -20.0 * (np.arctan2(turned[1, 0], turned[0, 0]) - 0.1)])

    mode = "force_mode(p[0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 0, 0], 2, [1, 1, 1, 1, 1, 1])"
    pushed = Pushed(f"set_tcp(p[0, 0, 0.1, 0, 0, 0])\n{mode}" + _WAIT.format(cycles=1500), law)
    assert abs(pushed.felt[-1, 5]) < 0.02
    np.testing.assert_allclose(pushed.places[-1], pushed.places[5], atol=1e-6)  # about the TCP


def test_forces_are_told_in_the_bases_frame_less_payload_and_zero() -> None:
    """A sensor of 1 kg, 5 cm off, and a payload of 2 kg: of what is told there, what they weigh is taken off."""
    controller = Controller(SimulatedArm(HOME))
    turn = controller.base_t_flange[:3, :3]
    weight = turn.T @ np.array([0.0, 0.0, -9.81])
    center, place = np.array([0.0, 0.0, 0.08]), np.array([0.0, 0.0, 0.05])
    push = turn.T @ np.array([3.0, -2.0, 7.0])
    force = push + 3.0 * weight
    # About where the sensor measures: the push at the TCP, 15 cm out, the payload, and the sensor's mass at 2 cm.
    about = (
        np.cross(np.array([0.0, 0.0, 0.15]) - place, push)
        + np.cross(center - place, 2.0 * weight)
        + np.cross(np.array([0.0, 0.0, 0.02]) - place, weight)
    )
    controller.take({"external_force_torque": (*force, *about)})
    statements = """
    set_tcp(p[0, 0, 0.15, 0, 0, 0])
    set_payload(2.0, [0, 0, 0.08])
    ft_rtde_input_enable(True, 1.0, [0, 0, 0.05], [0, 0, 0.02])
    told = get_tcp_force()
    write_output_float_register(0, told[0])
    write_output_float_register(1, told[1])
    write_output_float_register(2, told[2])
    write_output_float_register(3, norm([told[3], told[4], told[5]]))
    write_output_float_register(4, force())
    sync()
    zero_ftsensor()
    write_output_float_register(5, force())
    sync()
    """
    played = Played(statements, controller=controller)
    assert played.said == []
    names = [f"output_double_register_{number}" for number in range(6)]
    registers = np.array([played.controller.registers[name] for name in names], dtype=np.float64)
    np.testing.assert_allclose(registers, [3.0, -2.0, 7.0, 0.0, np.sqrt(62.0), 0.0], atol=1e-9)


@pytest.mark.parametrize(
    ("statements", "paused"),
    [
        ("ft_rtde_input_enable(True)", True),
        ("ft_rtde_input_enable(True)\nft_rtde_input_enable(False)", False),
        ('rtde_set_watchdog("input_int_register_0", 0.1)\nft_rtde_input_enable(True)', False),
    ],
)
def test_a_script_pauses_where_forces_are_not_told_ten_times_a_second(statements: str, paused: bool) -> None:
    played = Played(statements + _WAIT.format(cycles=200), 100)
    assert played.controller.paused is paused
    words = "RTDE watchdog: external_force_torque was not written in time, the program is paused"
    assert played.said == [words] * paused


def test_a_wrench_is_told_in_another_frame() -> None:
    """A force of 2 N along y at the origin has, about a point 1 m along x, a torque of -2 Nm about z."""
    played = Played("textmsg(wrench_trans(p[1, 0, 0, 0, 0, 0], [0, 2, 0, 0, 0, 0]))")
    assert played.said == ["[0, 2, 0, 0, 0, -2]"]


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        (_MODE, "'force_mode' needs forces, and an arm without a kernel feels nothing"),
        ("zero_ftsensor()", "'zero_ftsensor' needs forces, and an arm without a kernel feels nothing"),
        (_MODE.replace("[0, 0, 1,", "[0, 0, 2,"), "selection_vector has 0 and 1 alone, and this is [0, 0, 2, 0, 0, 0]"),
        (_MODE.replace(", 2, [", ", 4, ["), "type is 1, 2 or 3, not 4"),
        (_MODE.replace("[0.1,", "[-0.1,"), "limits are 0 or more, and this is [-0.1, 0.1, 0.1, 1, 1, 1]"),
        (_MODE.replace("-10", "1e200 * 1e200"), "wrench has 6 finite numbers, and this is [0, 0, inf, 0, 0, 0]"),
        ("force_mode_set_damping(1.5)", "damping is 0 to 1, not 1.5"),
        ("force_mode_set_gain_scaling(0)", "scaling is above 0 and at most 2, not 0"),
        ("ft_rtde_input_enable(1)", "enable is True or False, not 1"),
        ("ft_rtde_input_enable(True, -1)", "sensor_mass is 0 or more, not -1"),
    ],
)
def test_what_can_not_be_done_ends_the_script_with_the_reason(statement: str, expected: str) -> None:
    (said,) = Played(f"sync()\n{statement}").said
    assert said.startswith(f"script:3: {expected}"), said


def test_a_tool_that_leaves_the_arms_reach_stops_it() -> None:
    mode = _MODE.replace("-10", "1000").replace("0.1, 0.1, 0.1", "1, 1, 1")
    pushed = Pushed(mode + _WAIT.format(cycles=4000), lambda _: _NOTHING)
    assert pushed.controller.safety is SafetyMode.PROTECTIVE_STOP
    assert pushed.said[0].startswith("no posture near")


@pytest.mark.parametrize("end", ["sync()", "protective_stop()"])
def test_the_mode_ends_with_the_program_and_the_tool_slows_down(end: str) -> None:
    pushed = Pushed(f"{_MODE}{_WAIT.format(cycles=200)}\n{end}", lambda _: _NOTHING)
    velocities = [pushed.controller.velocity]
    for _ in range(500):
        velocities.append(pushed.controller.velocity)
        pushed.controller.cycle()
    before = pushed.controller.target
    for _ in range(100):
        pushed.controller.cycle()
    assert pushed.controller.compliance is None and not pushed.controller.moving
    np.testing.assert_array_equal(pushed.controller.target, before)
    changes = np.abs(np.diff(velocities, axis=0)) / pushed.controller.dt
    assert np.abs(velocities[0]).max() > 0.1 and changes.max() <= HARD_DECELERATION + 1e-6
    np.testing.assert_array_equal(velocities[-1], 0.0)


@pytest.mark.parametrize("move", ["", "movel(pose_add(get_target_tcp_pose(), p[0.05, 0, 0, 0, 0, 0]), a=1, v=0.05)"])
def test_the_tool_stands_while_the_program_is_paused(move: str) -> None:
    """At 0.05 m/s it comes to rest in a quarter of a second, and goes on as fast as before."""
    pushed = Pushed(f"{_MODE}{_WAIT.format(cycles=100)}{move}{_WAIT.format(cycles=5000)}", lambda _: _NOTHING, 200)
    controller, depths = pushed.controller, []
    for number in range(1500):
        if number == 100:
            assert controller.pause()
        elif number == 1000:
            assert controller.go_on()
        controller.cycle()
        depths.append(pushed.pose(controller.target)[2, 3])
    assert depths[99] - depths[1000] == pytest.approx(0.05 * PAUSE_SECONDS / 2.0, rel=0.02)
    assert np.ptp(depths[300:1000]) < 1e-9
    np.testing.assert_allclose(np.diff(depths[1300:]) / controller.dt, -0.05, rtol=1e-3)


def test_the_payloads_weight_is_that_of_its_mass_about_the_flange() -> None:
    weight = Payload(2.0, np.array([0.1, 0.0, 0.0])).weight(np.array([0.0, 0.0, -9.81]))
    np.testing.assert_allclose(weight, [0.0, 0.0, -19.62, 0.0, 1.962, 0.0])


@pytest.mark.parametrize("model", ["ur3e", "ur5e", "ur10e"])
def test_the_flange_of_a_robot_is_turned_as_the_models(client: virtualrobot.Client, model: str) -> None:
    """By the tables of the data sheet the tool goes as the robot's: its flange's turn is one of quarter turns."""
    arm = client.load_robot(f"model://{model}", name="arm")
    turn = turn_of_flange(arm, kinematics.MODELS[model])
    np.testing.assert_allclose(np.abs(turn).max(axis=0), 1.0, atol=2e-3)
    assert np.linalg.det(turn) == pytest.approx(1.0)


def _cell(client: virtualrobot.Client) -> virtualrobot.Robot:
    """Make a cell: a UR5e with a tool of 0.5 kg and a sensor, above a soft block of 1 kg on a table."""
    client.clock.set_realtime()
    arm = client.load_robot("model://ur5e", name="arm")
    arm.set_positions(HOME)
    scene, (x, y, height) = client.scene, arm.tcp[:3, 3]
    scene.add_motion_sensor("wrist", virtualrobot.force_torque_sensor(rate=250), parent=arm.flange)
    scene.add_part("tool", virtualrobot.cylinder(0.02, 0.1), pose=virtualrobot.pose(x, y, height - 0.05), mass=0.5)
    scene.attach("tool", arm.flange)
    scene.add_object("table", virtualrobot.box(0.5, 0.5, 0.02), pose=virtualrobot.pose(x, y, height - 0.24))
    soft = virtualrobot.box(0.1, 0.1, 0.1).with_surface(stiffness=5000, damping=50)
    scene.add_part("block", soft, pose=virtualrobot.pose(x, y, height - 0.18), mass=1.0, dynamic=True)
    client.physics.set("bullet")
    return arm


_PUSH = """
said["zero"] = [control.setPayload(0.5, [0.0, 0.0, 0.05]), control.zeroFtSensor()]
control.setTcp([0.0, 0.0, 0.1, 0.0, 0.0, 0.0])
def pushes(wanted):
    # half a second in which the force is near what is wanted, in the mean
    values = []
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        values = [*values[-249:], receive.getActualTCPForce()[2]]
        if len(values) == 250 and abs(sum(values) / 250 - wanted) < 1.0:
            break
        time.sleep(0.002)
    return sum(values) / len(values)
down = [0.0] * 6, [0, 0, 1, 0, 0, 0], [0.0, 0.0, -15.0, 0.0, 0.0, 0.0], 2, [0.1] * 6
said["mode"] = [control.forceMode(*down), pushes(15.0)]
down[2][2] = -8.0
said["mode"] += [control.forceMode(*down), pushes(8.0)]
said["stop"] = control.forceModeStop()
pose = receive.getActualTCPPose()
pose[2] += 0.05
said["up"] = [control.moveL(pose, 0.1, 0.5), pushes(0.0), control.isProgramRunning()]
"""


@pytest.mark.long
def test_a_program_with_ur_rtde_pushes_on_a_block_under_physics(kernel: KernelProcess, stubs: Stubs) -> None:
    with virtualrobot.connect(kernel.address) as client:
        arm = _cell(client)
        height = arm.tcp[2, 3]
        process = ControllerProcess("arm", "--address", kernel.address, host=host(4))
        try:
            said = told(_PUSH, process.host)
        finally:
            process.kill()
        assert said["zero"] == [True, True]
        assert said["mode"][::2] == [True, True]
        assert said["mode"][1] == pytest.approx(15.0, abs=1.0) and said["mode"][3] == pytest.approx(8.0, abs=1.0)
        assert said["stop"] is True
        assert said["up"] == [True, pytest.approx(0.0, abs=1.0), True]
        # The block's top is 13 cm below the flange, and 3 cm below the tool's end; it has gone up 5 cm from there.
        assert height - arm.tcp[2, 3] == pytest.approx(-0.02, abs=0.005)


@pytest.mark.long
def test_without_physics_or_a_sensor_it_says_what_would_help(kernel: KernelProcess, stubs: Stubs) -> None:
    with virtualrobot.connect(kernel.address) as client:
        _cell(client)
        client.scene.remove("wrist")
        process = ControllerProcess("arm", "--address", kernel.address, host=host(4))
        try:
            for engine, words in (
                ("none", b"no forces are known where physics are off; client.physics.set('mujoco')"),
                ("mujoco", b"'arm' has no force and torque sensor on its flange; scene.add_motion_sensor('wrist'"),
            ):
                client.physics.set(engine)
                with socket.create_connection((process.host, 30002), timeout=60.0) as program:
                    program.sendall(f"def push():\n  {_MODE}\nend\n".encode())
                    heard = b""
                    while words not in heard:
                        heard += program.recv(4096)
        finally:
            process.kill()


@pytest.mark.long
def test_force_mode_ends_where_physics_are_switched_off(kernel: KernelProcess, stubs: Stubs) -> None:
    with virtualrobot.connect(kernel.address) as client:
        _cell(client)
        process = ControllerProcess("arm", "--address", kernel.address, host=host(4))
        try:
            with socket.create_connection((process.host, 30002), timeout=60.0) as program:
                script = f'def push():\n{_MODE}\ntextmsg("it pushes")\nwhile True:\n  sync()\nend\nend\n'
                program.sendall(script.replace("-10", "0").encode())
                heard = b""
                while b"it pushes" not in heard:
                    heard += program.recv(4096)
                client.physics.set("none")
                while b"the force mode ends: no forces are known where physics are off" not in heard:
                    heard += program.recv(4096)
        finally:
            process.kill()
