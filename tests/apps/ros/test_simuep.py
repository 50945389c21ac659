"""A scene of SimUEP-Robotics in a kernel, and its topics and services with roslibpy."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import roslibpy
from virtualrobot import Client, MissingFileError
from virtualrobot_apps.bridges.ros.bridge import RosBridge
from virtualrobot_apps.bridges.ros.simuep.loading import load_simuep
from virtualrobot_apps.bridges.ros.simuep.topics import choice_of

from tests.apps.ros.bridges import Heard, bridge, roslibpy_client, told
from tests.waiting import until

URDF = """<robot name="robot" xmlns:sensor="http://playerstage.sourceforge.net/gazebo/xmlschema/#sensor">
  <link name="baseLink">
    <visual><geometry><sphere radius="0.2"/></geometry></visual>
    <collision><geometry><sphere radius="0.2"/></geometry></collision>
  </link>
  <link name="link1">
    <visual><origin rpy="0 0 0" xyz="0 0 0.45"/><geometry><cylinder length="0.6" radius="0.15"/></geometry></visual>
    <inertial><mass value="10"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  </link>
  <link name="link2">
    <visual>
      <origin rpy="0 -1.5708 0" xyz="0.15 0 0"/><geometry><cylinder length="0.3" radius="0.10"/></geometry>
    </visual>
    <collision><origin xyz="0.15 0 0"/><geometry><box size="0.3 0.2 0.2"/></geometry></collision>
  </link>
  <joint name="joint1" type="revolute">
    <parent link="baseLink"/><child link="link1"/>
    <limit effort="1000.0" lower="-1.5708" upper="1.5708" velocity="0.5"/>
  </joint>
  <joint name="joint2" type="prismatic">
    <parent link="link1"/><child link="link2"/><origin rpy="0 -1.5708 0" xyz="0 0 0.45"/>
    <limit effort="1000.0" lower="0" upper="0.3" velocity="0.5"/>
  </joint>
  <gazebo reference="baseLink">
    <sensor:camera name="linkCamera1">
      <imageSize>64 48</imageSize><imageFormat>R8G8B8</imageFormat><hfov>0.7853982</hfov><nearClip>0.01</nearClip>
      <farClip>4.5</farClip><updateRate>10</updateRate>
    </sensor:camera>
  </gazebo>
</robot>"""
"""Table 2 of the document and the camera of its figure 5, smaller and quicker, with shapes that collide."""

SCENE = """<scene>
  <physicsSettings updateFrequency="1000" gravity="0 0 -9.81"/>
  <envObjects>
    <envObject name="wall"><transform position="2 0 0"/><boundingBox size="0.1 1 1"/></envObject>
  </envObjects>
  <robots prefix="SimUEP">
    <services>
      <draw3DLines name="drawPathService"/>
      <enableSensor name="enableSensorService"/>
      <cameraInfo name="setCameraInfoService"/>
    </services>
    <robot name="slider">
      <urdf fileName="urdfs/robot.urdf"/>
      <transform position="0 0 1" rotation="0 0 0" scale="1 1 1"/>
      <actuators>
        <joint><topicName name="jointState"/></joint>
        <pose><topicName name="pose"/></pose>
      </actuators>
      <sensors>
        <joint><topicName name="jointStateReal"/></joint>
        <proximity><topicName name="proximity"/><range value="0.10"/></proximity>
        <collision><topicName name="collision"/></collision>
        <camera name="linkCamera1"><topicName name="camera1"/></camera>
      </sensors>
    </robot>
  </robots>
</scene>"""


def service(ros: roslibpy.Ros, name: str, type: str, /, **request: object) -> dict[str, object]:
    return told(roslibpy.Service(ros, name, type).call(roslibpy.ServiceRequest(request)))


def test_a_scene_speaks_by_the_names_of_its_file(client: Client, tmp_path: Path) -> None:
    (tmp_path / "urdfs").mkdir()
    (tmp_path / "urdfs" / "robot.urdf").write_text(URDF, "utf-8")
    file = tmp_path / "scene.xml"
    file.write_text(SCENE, "utf-8")
    scene = load_simuep(client, file)
    assert [one.name for one in tmp_path.iterdir() if one.suffix == ".yaml"] == []
    told_lines = RosBridge(client, [], choice_of(scene, False), simuep=scene).check()
    assert any(line.split()[:2] == ["/SimUEP/slider/proximity", "std_msgs/msg/String"] for line in told_lines)
    assert any(line.split()[:2] == ["/SimUEP/slider/pose", "geometry_msgs/msg/PoseStamped"] for line in told_lines)
    with (
        bridge(client, choice_of(scene, False), simuep=scene) as (url, said),
        roslibpy_client(url) as ros,
    ):
        joints = Heard(ros, "/SimUEP/slider/jointStateReal", "sensor_msgs/JointState")
        assert joints.next()["name"] == ["joint1", "joint2"]
        command = roslibpy.Topic(ros, "/SimUEP/slider/jointState", "sensor_msgs/JointState")
        command.publish({"name": ["joint1", "joint2"], "position": [0.25, 0.125]})
        joints.until(lambda one: one["position"] == [0.25, 0.125])
        command.publish({"name": ["joint1"], "position": []})
        until(lambda: any("'position' has a finite number for each of the 1 names" in one for one in said))

        pose = roslibpy.Topic(ros, "/SimUEP/slider/pose", "geometry_msgs/PoseStamped")
        # Its sphere of 0.2 m ends 0.05 m before the wall, whose face is at 1.95 m.
        pose.publish({"header": {"frame_id": "world"}, "pose": {"position": {"x": 1.7, "y": 0.0, "z": 0.0}}})
        near = Heard(ros, "/SimUEP/slider/proximity", "std_msgs/String")
        assert near.next() == {"data": "baseLink"}
        assert client.scene.pose("slider")[0, 3] == 1.7

        pose.publish({"header": {"frame_id": "world"}, "pose": {"position": {"x": 1.8, "y": 0.0, "z": 0.0}}})
        touching = Heard(ros, "/SimUEP/slider/collision", "sensor_msgs/PointCloud2")
        assert touching.until(lambda one: one["width"] > 0)[-1]["header"]["frame_id"] == "world"

        _draws(ros, client)
        answer = service(
            ros, "/SimUEP/enableSensorService", "virtualrobot_msgs/EnableSensor", name="slider.proximity", enable=True
        )
        assert answer["success"] and client.sensors["slider.proximity"].status.state == "running"
        wrong = service(ros, "/SimUEP/enableSensorService", "virtualrobot_msgs/EnableSensor", name="eye", enable=True)
        assert not wrong["success"] and "there is no sensor 'eye'; known: " in str(wrong["message"])
        _sees(ros)


def _draws(ros: roslibpy.Ros, client: Client) -> None:
    """A path is drawn, drawn anew, and goes."""
    name, type = "/SimUEP/drawPathService", "virtualrobot_msgs/DrawLines"
    points = [{"x": 0.0, "y": 0.0, "z": 0.0}, {"x": 1.0, "y": 0.0, "z": 0.0}, {"x": 1.0, "y": 1.0, "z": 0.0}]
    marker = {"ns": "path", "id": 7, "type": 4, "action": 0, "points": points, "color": {"r": 1.0, "a": 1.0}}
    for _ in range(2):
        answer = service(ros, name, type, markers={"markers": [marker]})
        assert answer["success"], answer
        assert [one.name for one in client.scene.nodes("annotation")] == ["lines path 7"]
    wrong = service(ros, name, type, markers={"markers": [marker | {"type": 5}]})
    assert (wrong["success"], wrong["message"]) == (False, "a list of lines has two points for each, not 3")
    assert service(ros, name, type, markers={"markers": [{"action": 3}]})["success"]
    assert not client.scene.nodes("annotation")


def _sees(ros: roslibpy.Ros) -> None:
    """The camera has the size of the document's settings, and then those that the service gives it."""
    pictures = Heard(ros, "/SimUEP/slider/camera1", "sensor_msgs/Image")
    assert (pictures.next()["width"], pictures.next()["height"]) == (64, 48)
    info = {
        "header": {"frame_id": "slider/linkCamera1"},
        "width": 32,
        "height": 16,
        "distortion_model": "plumb_bob",
        "d": [0.0] * 5,
        "k": [20.0, 0.0, 16.0, 0.0, 20.0, 8.0, 0.0, 0.0, 1.0],
    }
    name, type = "/SimUEP/setCameraInfoService", "sensor_msgs/SetCameraInfo"
    answer = service(ros, name, type, camera_info=info)
    assert answer["success"], answer
    pictures.until(lambda one: (one["width"], one["height"]) == (32, 16))
    wrong = service(ros, name, type, camera_info=info | {"k": [0.0] * 9})
    assert (wrong["success"], wrong["status_message"]) == (
        False,
        "'k' is a camera matrix: finite, with focal lengths above 0",
    )


def test_what_moves_by_forces_falls(steps: Client, tmp_path: Path) -> None:
    """A box of 1 kg under the Moon's gravity: g t^2 / 2 after half a second."""
    file = tmp_path / "moon.xml"
    file.write_text(
        """<scene><physicsSettings updateFrequency="1000" gravity="0 0 -1.62"/><envObjects>
        <envObject name="box"><transform position="0 0 5"/><boundingBox size="0.1 0.1 0.1"/><physics mass="1"/>
        </envObject></envObjects></scene>""",
        "utf-8",
    )
    load_simuep(steps, file)
    start, clock = steps.scene.pose("box")[2, 3], steps.clock
    clock.step(round(0.5 / clock.read().tick_length))
    fallen = start - steps.scene.pose("box")[2, 3]
    assert fallen == pytest.approx(1.62 * 0.5**2 / 2, rel=0.02)
    np.testing.assert_allclose(steps.scene.pose("box")[:2, 3], 0.0, atol=1e-9)


def test_a_file_that_is_not_there_is_named_by_the_scene(client: Client, tmp_path: Path) -> None:
    (file := tmp_path / "scene.xml").write_text(SCENE, "utf-8")
    with pytest.raises(MissingFileError, match=f"'urdfs/robot.urdf', named by {re.escape(str(file))}, is not there"):
        load_simuep(client, file)


@pytest.mark.long
def test_robots_of_the_document_come_by_name(client: Client, tmp_path: Path) -> None:
    """Those of its figures: the two-armed one, the vehicle, the crane, the arm and the one under water."""
    names = {"sda10": 2.0, "seekur": 4.0, "pedestal_crane": 20.0, "puma560": -2.0, "bluerov2_heavy": -4.0}
    robots = "".join(
        f"""<robot name="{name}">
          <urdf fileName="model://{name}"/>
          <transform position="0 {y} 0"/>
          <actuators>
            <joint><topicName name="jointState"/></joint>
            <pose><topicName name="pose"/></pose>
          </actuators>
        </robot>"""
        for name, y in names.items()
    )
    file = tmp_path / "scene.xml"
    file.write_text(f'<scene><robots prefix="SimUEP">{robots}</robots></scene>', "utf-8")
    scene = load_simuep(client, file)
    assert sorted(client.robots) == sorted(names)
    with bridge(client, choice_of(scene, False), simuep=scene) as (url, _), roslibpy_client(url) as ros:
        arms = roslibpy.Topic(ros, "/SimUEP/sda10/jointState", "sensor_msgs/JointState")
        arms.publish({"name": ["left_l", "right_u"], "position": [0.5, -0.25]})
        crane = roslibpy.Topic(ros, "/SimUEP/pedestal_crane/jointState", "sensor_msgs/JointState")
        crane.publish({"name": ["luffing", "hoisting"], "position": [1.0, 5.0]})
        vehicle = roslibpy.Topic(ros, "/SimUEP/seekur/pose", "geometry_msgs/PoseStamped")
        vehicle.publish({"header": {"frame_id": "world"}, "pose": {"position": {"x": 3.0, "y": 1.0, "z": 0.0}}})
        until(lambda: client.scene.pose("seekur")[:3, 3].tolist() == [3.0, 1.0, 0.0])
        until(lambda: client.robot("pedestal_crane").state.positions.tolist() == [0.0, 1.0, 5.0])
        told_now = dict(zip(client.robot("sda10").joint_names, client.robot("sda10").positions.tolist(), strict=True))
        assert (told_now["left_l"], told_now["right_u"]) == (0.5, -0.25)
