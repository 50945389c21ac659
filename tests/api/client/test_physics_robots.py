"""Robots under physics: motions command motors, forces do the rest; the numbers are those of formulas."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, JointMotor, Robot
from virtualrobot.errors import RobotBusyError, UnknownNameError, VirtualRobotError, WrongStateError
from virtualrobot.motions.state import Phase

from tests.kernels import KernelProcess, Stubs

GRAVITY = 9.81
TICK = 0.004
LONG = 1e6
"""A timeout in seconds that never comes."""
ENGINES = ["mujoco", pytest.param("bullet", marks=pytest.mark.long)]

Load = Callable[..., Robot]


@pytest.fixture
def cell(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[Client]:
    """Return a client of a world with a floor, at the height 0."""
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.scene.add_object("floor", virtualrobot.box(20.0, 20.0, 1.0), pose=virtualrobot.pose(0.0, 0.0, -0.5))
        yield client


@pytest.fixture
def load(cell: Client, tmp_path: Path) -> Load:
    """Return what loads a robot of a text in URDF."""

    def loaded(text: str, name: str, **options: object) -> Robot:
        (tmp_path / f"{name}.urdf").write_text(text)
        return cell.load_robot(tmp_path / f"{name}.urdf", name=name, **options)  # pyright: ignore[reportArgumentType]

    return loaded


ROD = """<robot name="rod">
  <link name="post"/>
  <link name="rod">
    <inertial><origin xyz="0 0 -0.2"/><mass value="1.5"/>
      <inertia ixx="0.02" iyy="0.02" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="hinge" type="{type}">
    <origin xyz="0 0 2"/><parent link="post"/><child link="rod"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" velocity="20" effort="{effort}"/>
  </joint>
</robot>"""
MASS, LEVER, ABOUT = 1.5, 0.2, 0.02 + 1.5 * 0.2**2

CART = """<robot name="cart">
  <link name="body">
    <inertial><origin xyz="0 0 0.05"/><mass value="3.0"/>
      <inertia ixx="0.02" iyy="0.02" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  {wheels}
</robot>"""
WHEEL = """<link name="{name}">
    <inertial><mass value="0.25"/>
      <inertia ixx="0.0002" iyy="0.0003" izz="0.0002" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.05"/></geometry></collision>
  </link>
  <joint name="{name}" type="continuous">
    <origin xyz="{x} {y} 0.05"/><parent link="body"/><child link="{name}"/><axis xyz="0 1 0"/>
    <limit velocity="100" effort="100"/>
  </joint>"""
WHEELS = {
    "front_left": (0.15, 0.1),
    "front_right": (0.15, -0.1),
    "rear_left": (-0.15, 0.1),
    "rear_right": (-0.15, -0.1),
}


@pytest.fixture
def cart(load: Load) -> Robot:
    """Return a cart of 4 kg with four wheels of 50 mm, each with a motor, that stands on the floor."""
    wheels = "".join(WHEEL.format(name=name, x=x, y=y) for name, (x, y) in WHEELS.items())
    return load(CART.format(wheels=wheels), "cart", base="floating")


def place_of(client: Client, name: str) -> np.ndarray:
    return np.asarray(client.scene.pose(name))[:3, 3]


def rolled(client: Client, robot: Robot, speed: float, ticks: int) -> None:
    """Turn all wheels of the cart for some ticks, and let them come to rest."""
    with robot.stream("velocity", list(WHEELS), timeout=LONG) as stream:
        stream.send([speed] * 4, wait=True)
        client.clock.step(ticks)
        stream.send([0.0] * 4, wait=True)
        client.clock.step(150)
        stream.cancel()


def drive(client: Client, robot: Robot, twist: tuple[float, float, float], ticks: int) -> None:
    """Drive a craft for some ticks, and let it come to rest."""
    with robot.stream_twist(timeout=LONG) as stream:
        stream.send(twist, wait=True)
        client.clock.step(ticks)
        stream.send((0.0, 0.0, 0.0), wait=True)
        client.clock.step(150)
        stream.cancel()  # it would wait for ticks
    client.clock.step(2)


@pytest.mark.long
@pytest.mark.parametrize("engine", ENGINES)
def test_a_motor_tells_what_it_exerts(cell: Client, load: Load, engine: str) -> None:
    """M g l sin(q) holds the rod, which is what the inverse dynamics say, too; the state tells it while all rests."""
    rod = load(ROD.format(type="revolute", effort="5"), "rod")
    assert not len(rod.state.efforts)
    rod.set_positions({"hinge": 0.6})
    cell.physics.set(engine)
    cell.physics.enable("rod")
    cell.clock.step(300)
    held = MASS * GRAVITY * LEVER * math.sin(float(rod.positions[0]))
    assert abs(float(rod.state.efforts[0])) == pytest.approx(held, rel=0.01)
    needed = rod.solve_inverse_dynamics().efforts[0]
    np.testing.assert_allclose(rod.state.efforts, needed, rtol=0.01)
    seen = cell.clock.step(50).robots["rod"]
    np.testing.assert_allclose(seen.efforts, needed, rtol=0.01)
    told = cell.streams.sample("/robots/rod/joint_states").values["hinge/effort"]
    assert told == pytest.approx(float(needed[0]), rel=0.01)
    cell.physics.disable("rod")
    assert not len(rod.state.efforts)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_pendulum_swings_with_its_period(cell: Client, load: Load, engine: str) -> None:
    rod = load(ROD.format(type="revolute", effort="0"), "rod")
    amplitude = 0.8
    rod.set_positions({"hinge": amplitude})
    cell.physics.set(engine)
    cell.physics.set_motors("rod", {"hinge": JointMotor("free")})
    cell.physics.enable("rod")
    # The complete elliptic integral by the mean of Gauss.
    one, other = 1.0, math.cos(amplitude / 2.0)
    for _ in range(20):
        one, other = (one + other) / 2.0, math.sqrt(one * other)
    period = 2.0 * math.pi * math.sqrt(ABOUT / (MASS * GRAVITY * LEVER)) / one
    times: list[float] = []
    before = amplitude
    for tick in range(1, 700):
        cell.clock.step(1)
        now = float(rod.positions[0])
        if before > 0.0 >= now:
            times.append((tick - now / (now - before)) * TICK)
        before = now
        if len(times) == 2:
            break
    assert times[1] - times[0] == pytest.approx(period, rel=0.003)


@pytest.mark.long
@pytest.mark.parametrize("engine", ENGINES)
def test_a_spring_sags_by_the_weight_and_a_stiff_motor_does_not(cell: Client, load: Load, engine: str) -> None:
    rod = load(ROD.format(type="revolute", effort="0"), "rod")
    rod.set_positions({"hinge": 1.2})
    cell.physics.set(engine)
    cell.physics.enable("rod")
    cell.clock.step(250)
    assert float(rod.positions[0]) == pytest.approx(1.2, abs=5e-3)
    stiffness = 30.0
    cell.physics.set_motors("rod", {"hinge": JointMotor("position", stiffness=stiffness, damping=3.0)})
    cell.clock.step(500)
    angle = float(rod.positions[0])
    torque = MASS * GRAVITY * LEVER * math.sin(angle)
    assert stiffness * (1.2 - angle) == pytest.approx(torque, rel=0.01)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_motor_is_as_strong_as_its_joint_says(cell: Client, load: Load, engine: str) -> None:
    # It holds m g l sin(angle) up to the angle at which that is its greatest effort.
    effort = MASS * GRAVITY * LEVER * math.sin(0.7)
    rod = load(ROD.format(type="revolute", effort=effort), "rod")
    cell.physics.set(engine)
    for angle, holds in ((0.6, True), (0.8, False)):
        rod.set_positions({"hinge": angle})
        cell.physics.enable("rod")
        cell.clock.step(100)
        assert (abs(float(rod.positions[0]) - angle) < 0.02) is holds
        cell.physics.disable("rod")


@pytest.mark.parametrize("engine", ENGINES)
def test_joints_go_where_motions_command_them(cell: Client, load: Load, engine: str) -> None:
    rod = load(ROD.format(type="revolute", effort="0"), "rod")
    cell.physics.set(engine)
    cell.physics.enable("rod")
    motion = rod.move_joints([1.0], wait=False)
    cell.clock.run(motion)
    cell.clock.step(50)
    assert float(rod.positions[0]) == pytest.approx(1.0, abs=5e-3)
    state = rod.state
    assert state.positions == pytest.approx([1.0], abs=5e-3)


def test_a_motor_exerts_the_effort_that_it_is_told(cell: Client, load: Load) -> None:
    rod = load(ROD.format(type="continuous", effort="0"), "rod")
    cell.physics.set("mujoco", gravity=(0.0, 0.0, 0.0))
    cell.physics.enable("rod")
    with pytest.raises(WrongStateError, match="the mode 'velocity'; efforts are of the mode 'effort'"):
        cell.physics.set_efforts("rod", {"hinge": 0.1})
    cell.physics.set_motors("rod", {"hinge": JointMotor("effort")})
    cell.physics.set_efforts("rod", {"hinge": 0.1})
    cell.clock.step(100)
    assert rod.state.velocities[0] == pytest.approx(0.1 / ABOUT * 0.4, rel=1e-3)
    rod.stop()
    speed = rod.state.velocities[0]
    cell.clock.step(10)
    assert rod.state.velocities[0] == pytest.approx(speed, rel=1e-6)


def test_a_robot_falls_from_wherever_it_stands(cell: Client, cart: Robot) -> None:
    # Turned and shifted, so that the frame of its base joint is not the world's.
    cell.scene.set_pose("cart", virtualrobot.pose(1.0, 2.0, 3.0, 0.0, 0.0, 1.0))
    cell.physics.set("mujoco")
    cell.physics.enable("cart")
    cell.clock.step(50)
    fallen = GRAVITY * 0.2**2 / 2.0
    assert place_of(cell, "cart.body") == pytest.approx([1.0, 2.0, 3.0 - fallen], abs=GRAVITY * 0.2 * 1e-3)


@pytest.mark.parametrize("engine", ENGINES)
def test_wheels_roll_by_friction_as_far_as_they_turn(cell: Client, cart: Robot, engine: str) -> None:
    cell.physics.set(engine)
    cell.physics.enable("cart")
    cell.clock.step(50)
    begin = place_of(cell, "cart.body")
    rolled(cell, cart, 6.0, 500)
    gone = place_of(cell, "cart.body") - begin
    turned = cart.positions[7:]
    assert turned.mean() > 5.0
    assert gone[0] == pytest.approx(0.05 * turned.mean(), rel=0.01)
    assert gone[1:] == pytest.approx([0.0, 0.0], abs=2e-3)


@pytest.mark.parametrize("engine", ENGINES)
def test_wheels_slip_where_friction_is_too_little(cell: Client, cart: Robot, engine: str) -> None:
    cell.physics.set(engine)
    cell.physics.enable("cart")
    cell.clock.step(50)
    with cart.stream("velocity", list(WHEELS), timeout=LONG) as stream:
        stream.send([100.0] * 4, wait=True)
        cell.clock.step(100)
        begin = place_of(cell, "cart.body")[0]
        cell.clock.step(50)
        middle = place_of(cell, "cart.body")[0]
        cell.clock.step(50)
        end = place_of(cell, "cart.body")[0]
        stream.cancel()
    # All weight is on driven wheels: mu g, both surfaces having a friction of 0.5.
    accelerating = (end - 2.0 * middle + begin) / 0.2**2
    assert accelerating == pytest.approx(0.5 * GRAVITY, rel=0.05)


@pytest.mark.long
@pytest.mark.parametrize("engine", ENGINES)
def test_the_same_calls_drive_a_craft_under_physics(cell: Client, engine: str) -> None:
    ugv = cell.load_robot("model://ugv", base="floating")
    cell.physics.set(engine)
    ends = []
    for dynamic in (False, True):
        if dynamic:
            ugv.set_positions([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, *[0.0] * 4])
            cell.physics.enable("ugv")
            cell.clock.step(50)
        drive(cell, ugv, (0.3, 0.0, 0.0), 500)
        drive(cell, ugv, (0.2, 0.0, 0.5), 500)
        pose = np.asarray(cell.scene.pose("ugv.base"))
        ends.append([*pose[:3, 3], math.atan2(pose[1, 0], pose[0, 0])])
    # The wheels' rims are 4 mm wide and the caster swings: a few per cent of the turn are lost.
    assert ends[1][:3] == pytest.approx(ends[0][:3], abs=0.03)
    assert ends[1][3] == pytest.approx(ends[0][3], rel=0.05)


@pytest.mark.parametrize(
    ("height", "upside_down"),
    [(0.5, True), pytest.param(20.0, False, marks=pytest.mark.long)],
    ids=["on its back", "falling"],
)
def test_wheels_that_touch_nothing_are_told(cell: Client, height: float, upside_down: bool) -> None:
    """In real time, as `drive` is: on its back, and while it falls."""
    ugv = cell.load_robot("model://ugv", base="floating")
    cell.physics.set("mujoco")
    half = [1.0, 0.0, 0.0, 0.0] if upside_down else [0.0, 0.0, 0.0, 1.0]
    ugv.set_positions([0.0, 0.0, height, *half, *[0.0] * 4])
    cell.physics.enable("ugv")
    if upside_down:
        cell.clock.step(500)
    cell.clock.set_realtime()
    with pytest.raises(WrongStateError, match=r"the wheels of 'ugv' turned in the air: none of .*touches anything"):
        ugv.drive(0.2, 0.0, seconds=0.3)
    with pytest.raises(WrongStateError, match="turned in the air"):
        ugv.drive_path([[0.05, 0.0, 0.0]])
    cell.clock.set_stepped()
    ugv.set_positions([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, *[0.0] * 4])
    cell.clock.step(100)
    cell.clock.set_realtime()
    ugv.drive(0.2, 0.0, seconds=0.3)


def test_a_guarded_craft_drives_on_a_floor_that_its_wheels_may_touch(cell: Client) -> None:
    """And its own caster swivels below it."""
    ugv = cell.load_robot("model://ugv", base="floating")
    cell.physics.set("mujoco")
    cell.physics.enable("ugv")
    cell.clock.step(50)
    for wheel in ("left_wheel", "right_wheel", "caster_wheel"):
        cell.collisions.allowed.add("floor", f"ugv.{wheel}")
    cell.collisions.set("guard")
    motion = ugv.drive_path([[0.15, 0.0, 0.2]], wait=False)
    cell.clock.step(800)
    assert motion.phase is Phase.SUCCEEDED
    assert cell.scene.pose("ugv.base")[0, 3] == pytest.approx(0.15, abs=0.02)


def test_a_car_whose_passive_wheels_are_held_by_motors_is_refused(cell: Client) -> None:
    car = cell.load_robot("model://racecar", name="car", base="floating", pose=virtualrobot.pose(z=0.06))
    held = "motors hold its passive wheels, right_steering_hinge_joint, left_front_wheel_joint, .*'free'"
    cell.physics.enable("car")
    assert car.way([[0.1, 0.0, 0.0]]).length == pytest.approx(0.1)  # nothing moves by forces without an engine
    cell.physics.set("mujoco")
    with pytest.raises(WrongStateError, match=held):
        cell.clock.step(1, twists={"car": [0.5, 0.0, 0.3]})
    with pytest.raises(WrongStateError, match=held):
        car.drive_path([[0.1, 0.0, 0.0]])
    car.odometry().update()  # reckons as ever
    passive = ("right_steering_hinge", "left_front_wheel", "right_front_wheel", "right_rear_wheel")
    cell.physics.set_motors("car", {f"{name}_joint": JointMotor("free") for name in passive})
    begin = cell.scene.pose("car.base_link").copy()
    for _ in range(10):
        cell.clock.step(50, twists={"car": [0.5, 0.0, 0.0]})
    assert np.linalg.norm((cell.scene.pose("car.base_link") - begin)[:2, 3]) > 0.5  # of 1 m, as it speeds up and slips


def test_a_twist_that_is_not_renewed_ends(cell: Client) -> None:
    ugv = cell.load_robot("model://ugv", base="floating")
    cell.physics.set("mujoco")
    cell.physics.enable("ugv")
    cell.clock.step(10)
    stream = ugv.stream_twist(timeout=0.1)
    stream.send([0.3, 0.0, 0.0], wait=True)
    cell.clock.step(20)
    assert not stream.motion.state.phase.ended
    cell.clock.step(200)
    assert stream.motion.state.phase.ended
    assert np.abs(ugv.state.velocities).max() < 0.05


def test_where_it_is_put_reaches_the_engine(cell: Client, cart: Robot) -> None:
    cell.physics.set("mujoco")
    cell.physics.enable("cart")
    cell.clock.step(100)
    cell.history.checkpoint("standing")
    cart.set_positions([3.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0, *[0.0] * 4])
    cell.clock.step(50)
    fallen = 2.0 - GRAVITY * 0.2**2 / 2.0
    assert place_of(cell, "cart.body") == pytest.approx([3.0, 0.0, fallen], abs=3e-3)
    cell.history.restore("standing")
    cell.clock.step(50)
    assert place_of(cell, "cart.body") == pytest.approx([0.0, 0.0, 0.0], abs=2e-3)


def test_what_forces_alone_move_is_moved_by_no_motion(cell: Client, cart: Robot) -> None:
    cell.physics.set("mujoco")
    cell.physics.enable("cart")
    cell.clock.step(1)
    with pytest.raises(WrongStateError, match=r"'base/x' of 'cart' is moved by forces alone"):
        cart.jog_joint("base/x", 0.1, 0.1)
    motion = cart.move_joints({"front_left": 1.0}, wait=False)
    with pytest.raises(RobotBusyError):
        cell.physics.disable("cart")
    with pytest.raises(RobotBusyError):
        cell.physics.set("none")
    cell.clock.run(motion)
    cell.physics.disable("cart")
    height = place_of(cell, "cart.body")
    cell.clock.step(10)
    assert (place_of(cell, "cart.body") == height).all()


def test_robots_that_cannot_move_by_forces_are_refused(cell: Client, load: Load) -> None:
    cell.physics.set("mujoco")
    rod = ROD.format(type="revolute", effort="0")
    light = load(rod.replace('<mass value="1.5"/>', '<mass value="0"/>'), "light")
    with pytest.raises(VirtualRobotError, match=r"the link 'light.rod' has no mass"):
        cell.physics.enable("light")
    odd = load(rod.replace('ixx="0.02"', 'ixx="0.5"'), "odd")
    with pytest.raises(VirtualRobotError, match=r"'odd.rod' has the principal moments 0.001, 0.02 and 0.5"):
        cell.physics.enable("odd")
    negative = load(rod.replace('iyy="0.02"', 'iyy="-0.02"'), "negative")
    with pytest.raises(VirtualRobotError, match=r"'negative.rod' has a moment of inertia of -0.02"):
        cell.physics.enable("negative")
    cell.load_robot("model://ugv", base="planar")
    with pytest.raises(VirtualRobotError, match=r"'base' of 'ugv' is planar.*base floating"):
        cell.physics.enable("ugv")
    with pytest.raises(UnknownNameError, match="wheel"):
        cell.physics.set_motors("odd", {"wheel": JointMotor("free")})
    cell.scene.add_part("box", virtualrobot.box(0.1, 0.1, 0.1))
    for name in ("oddd", "box"):
        with pytest.raises(UnknownNameError, match=f"there is no robot named '{name}'"):
            cell.physics.motors(name)
        with pytest.raises(UnknownNameError, match=f"there is no robot named '{name}'"):
            cell.physics.set_motors(name, {})
    assert [light.name, odd.name, negative.name, cell.physics.status.fault] == ["light", "odd", "negative", ""]
