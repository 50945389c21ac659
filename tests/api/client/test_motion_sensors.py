"""Motion and contact sensors on real robots, on a real kernel whose time goes on by steps."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from scipy.spatial.transform import Rotation
from virtualrobot import Client

from tests.api.client.conftest import Run

TICK = 0.004
G = 9.81
UP = np.array([0.0, 0.0, G])
IIWA = "package://pybullet_data/kuka_iiwa/model.urdf"
PANDA = "package://pybullet_data/franka_panda/panda.urdf"


@pytest.fixture
def stepped(client: Client) -> Client:
    """Return a client of a kernel whose time goes on by steps."""
    client.clock.set_stepped()
    return client


def goal(positions: list[float]) -> dict[str, float]:
    """Return positions of the Panda's arm by joint."""
    return {f"panda_joint{i}": position for i, position in enumerate(positions, 1)}


def ticks_of(client: Client, node: str, count: int) -> list[np.ndarray]:
    """Return where a node is at each of some ticks to come."""
    poses = []
    for _ in range(count):
        client.clock.step(1)
        poses.append(client.scene.pose(node))
    return poses


def test_an_arm_that_holds_2_kg_feels_their_weight(stepped: Client, rng: np.random.Generator) -> None:
    """At rest in any posture: 19.62 N down, at the arm of the part's centre."""
    robot = stepped.load_robot(IIWA, name="iiwa")
    stepped.scene.set_joint_positions("iiwa", rng.uniform(-1.5, 1.5, 7))
    stepped.scene.add_tool("gripper", robot.flange, inertial=virtualrobot.inertial(0.5))
    sensor_pose = virtualrobot.pose(0.01, 0.02, 0.03, *rng.uniform(-1, 1, 3))
    stepped.scene.add_motion_sensor("wrist", virtualrobot.force_torque_sensor(), parent=robot.flange, pose=sensor_pose)
    part_pose = virtualrobot.pose(0.05, -0.1, 0.2)
    stepped.scene.add_part("part", virtualrobot.box(0.1, 0.1, 0.1), parent="gripper", pose=part_pose, mass=2.0)
    told = stepped.sensors["wrist"].read().value
    assert isinstance(told, virtualrobot.WrenchReading)
    sensor, part, gripper = (stepped.scene.pose(name) for name in ("wrist", "part", "gripper"))
    down = np.array([0, 0, -G])
    force = 2.5 * down
    torque = np.cross(part[:3, 3] - sensor[:3, 3], 2.0 * down) + np.cross(gripper[:3, 3] - sensor[:3, 3], 0.5 * down)
    np.testing.assert_allclose(sensor[:3, :3] @ told.force, force, atol=1e-6)
    np.testing.assert_allclose(sensor[:3, :3] @ told.torque, torque, atol=1e-6)
    stepped.scene.attach("part", "world")
    lighter = stepped.sensors["wrist"].read().value
    np.testing.assert_allclose(np.linalg.norm(lighter.force), 0.5 * G, atol=1e-6)


def test_an_inertial_unit_on_a_moving_arm(stepped: Client) -> None:
    """Against the second differences of the poses that the scene tells, and scipy's rotations."""
    panda = stepped.load_robot(PANDA, name="panda")
    stepped.scene.add_motion_sensor(
        "imu", virtualrobot.imu(rate=250.0), parent="panda.panda_link6", pose=virtualrobot.pose(0.1, 0, 0.05, 0.3)
    )
    stepped.sensors.start()
    motion = panda.move_joints(goal([0.5, -0.3, 0.4, -1.5, 0.2, 1.0, 0.3]), wait=False)
    stepped.clock.step(60)
    greatest = 0.0
    for _ in range(10):
        before, at, now = ticks_of(stepped, "imu", 3)
        told = stepped.sensors["imu"].read().value
        assert isinstance(told, virtualrobot.ImuReading)
        acceleration = (now[:3, 3] - 2 * at[:3, 3] + before[:3, 3]) / TICK**2
        turn = Rotation.from_matrix(now[:3, :3] @ before[:3, :3].T).as_rotvec() / (2 * TICK)
        np.testing.assert_allclose(told.linear_acceleration, at[:3, :3].T @ (acceleration + UP), atol=1e-6)
        # Two turns one after the other are one about their mean axis, but for a part of second order in the tick.
        np.testing.assert_allclose(told.angular_velocity, at[:3, :3].T @ turn, atol=1e-4)
        np.testing.assert_allclose(told.magnetic_field, at[:3, :3].T @ [0, 2e-5, -4.4e-5], atol=1e-12)
        greatest = max(greatest, float(np.linalg.norm(turn)), float(np.linalg.norm(acceleration)))
    assert greatest > 0.3
    motion.cancel()


def test_a_running_sensor_reads_each_tick_the_same_in_each_run(stepped: Client) -> None:
    """Noise, bias and walk come back to the bit, whoever asks in between."""
    runs = []
    for asking in (False, True):
        stepped.scene.clear()
        stepped.load_robot(PANDA, name="panda")
        noise = virtualrobot.noise(0.01, bias=0.1, bias_walk=0.1)
        stepped.scene.add_motion_sensor("imu", virtualrobot.imu(accelerometer=noise, rate=250, seed=5), parent="panda")
        stepped.scene.add_motion_sensor("encoders", virtualrobot.encoders(position=noise, seed=6), parent="panda")
        stepped.sensors.start()
        told = []
        watch = stepped.sensors.watch("imu", "encoders")
        for _ in range(20):
            stepped.clock.step(5)
            if asking:
                stepped.sensors["imu"].read()
                stepped.sensors["encoders"].read()
        latest = {}
        while len(latest) < 2 or latest["imu"].number < 100 or latest["encoders"].number < 40:
            reading = next(watch)
            latest[reading.sensor] = reading
        watch.close()  # pyright: ignore[reportAttributeAccessIssue] a generator
        assert (latest["imu"].number, latest["encoders"].number) == (100, 40)
        told += [latest["imu"].value.linear_acceleration, latest["encoders"].value.positions]
        told += [latest["encoders"].value.velocities]
        runs.append(np.concatenate(told))
    np.testing.assert_array_equal(*runs)
    assert np.abs(runs[0][2] - G) > 1e-6


def test_encoders_and_pose_follow_a_moving_arm(stepped: Client) -> None:
    panda = stepped.load_robot(PANDA, name="panda")
    stepped.scene.add_motion_sensor("encoders", virtualrobot.encoders(["panda_joint1"], rate=250), parent="panda")
    stepped.scene.add_motion_sensor("gps", virtualrobot.pose_sensor(rate=250.0), parent="panda.panda_link4")
    stepped.sensors.start()
    motion = panda.move_joints(goal([1.0, 0, 0, -1.0, 0, 1.0, 0]), wait=False)
    stepped.clock.step(80)
    before, at, now = ticks_of(stepped, "gps", 3)
    pose, joints = stepped.sensors["gps"].read().value, stepped.sensors["encoders"].read().value
    assert isinstance(pose, virtualrobot.PoseReading) and isinstance(joints, virtualrobot.EncoderReading)
    np.testing.assert_allclose(pose.world_t_node, now, atol=1e-12)
    slope = (3 * now[:3, 3] - 4 * at[:3, 3] + before[:3, 3]) / (2 * TICK)
    np.testing.assert_allclose(pose.linear_velocity, slope, atol=1e-9)
    assert joints.joint_names == ("panda_joint1",)
    assert joints.positions[0] == pytest.approx(panda.positions[panda.joint_names.index("panda_joint1")], abs=1e-12)
    assert joints.velocities[0] == pytest.approx(np.linalg.norm(slope[:2]) / np.hypot(*now[:2, 3]), rel=0.2)
    motion.cancel()


def test_a_finger_touches_a_part(stepped: Client) -> None:
    """The Panda's fingers close on a bar of 2 cm between them: near first, then touching, then it is held and felt."""
    stepped.load_robot(PANDA, name="panda")
    scene = stepped.scene
    scene.set_joint_positions("panda", {"panda_joint4": -1.5, "panda_finger_joint1": 0.04})
    hand = scene.pose("panda.panda_hand")
    scene.add_part("bar", virtualrobot.box(0.05, 0.02, 0.02), pose=hand @ virtualrobot.pose(0, 0, 0.1))
    skin = virtualrobot.contact_sensor(max_range=0.02)
    scene.add_contact_sensor("left", skin, parent="panda.panda_leftfinger")
    sensor = stepped.sensors["left"]
    assert sensor.read().value == ()
    distances = []
    for opening in (0.025, 0.015):
        scene.set_joint_positions("panda", {"panda_finger_joint1": opening})
        (near,) = sensor.read().value
        assert isinstance(near, virtualrobot.Contact)
        assert (near.element, near.other) == ("panda.panda_leftfinger", "bar")
        assert near.normal is None
        assert near.distance == pytest.approx(np.linalg.norm(near.point - near.other_point))
        # The bar's face is 1 cm from the middle, on the left finger's side.
        assert (np.linalg.inv(hand) @ [*near.other_point, 1.0])[1] == pytest.approx(0.01, abs=1e-6)
        distances.append(near.distance)
    assert distances[0] - distances[1] == pytest.approx(0.01, abs=1e-6)
    scene.set_joint_positions("panda", {"panda_finger_joint1": 0.015 - distances[1] - 1e-4})
    touching = sensor.read().value
    assert touching and all(one.distance == 0.0 and one.other == "bar" for one in touching)
    assert touching[0].normal @ -hand[:3, 1] == pytest.approx(1.0, abs=1e-3)
    scene.attach("bar", "panda.panda_hand")
    assert len(sensor.read().value) == len(touching)
    scene.rename("bar", "rod")
    assert sensor.read().value[0].other == "rod"


def test_a_sensor_that_names_what_is_not_there_has_a_fault(stepped: Client) -> None:
    stepped.scene.add_object("box", virtualrobot.box(1, 1, 1))
    stepped.scene.add_contact_sensor("skin", virtualrobot.contact_sensor("bx"))
    with pytest.raises(virtualrobot.UnknownNameError, match="no node named 'bx'; did you mean 'box'"):
        stepped.sensors["skin"].read()
    stepped.sensors.start("skin")
    stepped.clock.step(50)
    assert stepped.sensors.status("skin").state == "fault"
    assert "no node named 'bx'" in stepped.sensors.status("skin").fault
    stepped.scene.add_motion_sensor("encoders", virtualrobot.encoders(), parent="box")
    with pytest.raises(virtualrobot.WrongStateError, match="on no robot"):
        stepped.sensors["encoders"].read()


def test_the_command_line_tells_what_they_say(stepped: Client, run: Run) -> None:
    robot = stepped.load_robot(IIWA, name="iiwa")
    scene = stepped.scene
    scene.add_tool("gripper", robot.flange, inertial=virtualrobot.inertial(0.5))
    scene.add_object("ball", virtualrobot.sphere(0.1), pose=virtualrobot.pose(1.0))
    scene.add_object("near", virtualrobot.sphere(0.1), pose=virtualrobot.pose(1.5))
    scene.add_object("in", virtualrobot.sphere(0.1), pose=virtualrobot.pose(1.0, 0.1))
    scene.add_motion_sensor("wrist", virtualrobot.force_torque_sensor(), parent=robot.flange)
    scene.add_motion_sensor("imu", virtualrobot.imu(), parent="ball")
    scene.add_motion_sensor("gps", virtualrobot.pose_sensor(), parent="ball")
    scene.add_motion_sensor("encoders", virtualrobot.encoders(["lbr_iiwa_joint_1"]), parent="iiwa")
    scene.add_contact_sensor("skin", virtualrobot.contact_sensor("ball", max_range=0.4))
    assert "(0, 0, -4.905) N" in run("sensor", "read", "wrist")
    assert "(0, 0, 0) rad/s, (0, 0, 9.81) m/s^2, (0, 2e-05, -4.4e-05) T" in run("sensor", "read", "imu")
    assert "(1, 0, 0) m, (0, 0, 0) m/s" in run("sensor", "read", "gps")
    assert "lbr_iiwa_joint_1 0" in run("sensor", "read", "encoders")
    assert "'imu' is a motion_sensor" in run("sensor", "read", "imu", "--out", "imu.csv", code=2)
    said = run("sensor", "read", "skin")
    assert "1 pairs touch, 1 are near" in said
    assert "ball touches in at (1, 0.05, 0)" in said
    assert "ball 0.3 m from near at (1.1, 0, 0)" in said
    scene.remove("in")
    scene.remove("near")
    assert "nothing near" in run("sensor", "read", "skin")


def test_settings_that_mean_nothing_are_refused() -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match="counts_per_turn"):
        virtualrobot.encoders(counts_per_turn=-1)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="the region has 3 finite numbers"):
        virtualrobot.contact_sensor(region=(1, 2))
