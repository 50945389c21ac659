"""Sensors of URDF files: real ones, old ones, broken ones."""

from __future__ import annotations

import math

import numpy as np
from virtualrobot_kernel.world.sensing import CameraSensor, Fan, ForceTorqueSensor, MotionSensor, RangeSensor
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.unit.formats.models import DATA, load, read_text

ARM = (
    '<link name="base"/><link name="tip"/><joint name="wrist" type="continuous"><parent link="base"/>'
    '<child link="tip"/></joint>'
)


def sensors(text: str) -> tuple[dict[str, NodeSpec], tuple[str, ...]]:
    """Return the sensors of a robot `it` by name, and the warnings."""
    model = read_text(f'<robot name="it">{ARM}{text}</robot>')
    return {node.name: node for node in model.nodes if node.kind not in (Kind.ROBOT, Kind.LINK)}, model.warnings


def test_those_of_the_racecar() -> None:
    """The numbers are those in the file of pybullet_data: a Hokuyo of 270 degrees, a ZED camera, gaussian noise."""
    model, _ = load(DATA / "racecar/racecar.urdf")
    nodes = {node.name: node for node in model.nodes}
    scanner = nodes["racecar.hokuyo_sensor"]
    assert scanner.parent == "racecar.laser" and isinstance(scanner.data, RangeSensor)
    fan = scanner.data.pattern
    assert isinstance(fan, Fan) and fan.count == 1081
    np.testing.assert_allclose([fan.start_angle_radians, fan.end_angle_radians], np.radians([-135, 135]), atol=1e-9)
    assert (scanner.data.rate_hertz, scanner.data.min_range_meters, scanner.data.max_range_meters) == (40.0, 0.1, 10.0)
    assert scanner.data.sensor_model == "laser" and not scanner.running
    assert (scanner.data.sensor_model_settings or {})["deviation_meters"] == 0.01
    np.testing.assert_allclose(scanner.parent_t_node[:3, 3], [0, 0, 0.0124])
    zed = nodes["racecar.zed_camera_left_sensor"]
    assert zed.parent == "racecar.camera_link" and isinstance(zed.data, CameraSensor)
    # The file says where its angle comes from: 2 atan(320 / 687.8).
    assert math.isclose(zed.data.horizontal_field_radians, 2.0 * math.atan(320 / 687.8065795898438))
    assert (zed.data.width, zed.data.height, zed.data.rate_hertz, zed.data.color_noise) == (640, 480, 30.0, 0.007)
    np.testing.assert_allclose(zed.parent_t_node[:3, 2], [1, 0, 0], atol=1e-15)


def test_a_prefix_that_nobody_declared() -> None:
    """TinyXML, by which Gazebo read URDF, took prefixes as they came."""
    found, warnings = sensors(
        '<gazebo reference="tip"><sensor:ray name="laser"><rayCount>5</rayCount><minAngle>-90</minAngle>'
        "<maxAngle>90</maxAngle><maxRange>3</maxRange></sensor:ray></gazebo>"
    )
    data = found["it.laser"].data
    assert not warnings and isinstance(data, RangeSensor)
    assert data.pattern == Fan(5, -math.pi / 2, math.pi / 2)


def test_a_prefix_of_drake_s_that_nobody_declared_is_passed_over() -> None:
    robot = read_text('<robot name="it"><link name="a"/><drake:collision_filter_group name="b"/></robot>').nodes[0]
    assert robot.name == "it"


def test_a_force_sensor_of_a_joint_is_fixed_to_its_child() -> None:
    found, _ = sensors('<gazebo reference="wrist"><sensor name="ft" type="force_torque"/></gazebo>')
    node = found["it.ft"]
    assert node.parent == "it.tip" and isinstance(node.data, MotionSensor)
    assert isinstance(node.data.kind, ForceTorqueSensor)


def test_names_are_unique_among_links_too() -> None:
    tag = '<sensor name="tip" type="imu"/>'
    found, _ = sensors(f'<gazebo reference="tip">{tag}</gazebo><gazebo reference="base">{tag}</gazebo>')
    assert {name: node.parent for name, node in found.items()} == {"it.tip_2": "it.tip", "it.tip_3": "it.base"}


def test_what_cannot_be_read_is_told_with_its_line() -> None:
    found, warnings = sensors(
        '\n<gazebo reference="tip">\n<sensor name="odd" type="logical_camera"/></gazebo>'
        '\n<gazebo reference="nowhere"><sensor name="a" type="imu"/></gazebo>'
        '\n<gazebo><sensor name="b" type="imu"/><static>true</static></gazebo>'
        '\n<gazebo reference="tip"><sensor name="big" type="camera"><camera><image><width>90000</width><height>90000'
        "</height></image></camera></sensor></gazebo>"
        '\n<gazebo reference="tip"><sensor name="aside" type="imu"><pose relative_to="base">1 0 0 0 0 0</pose></sensor>'
        "</gazebo>"
    )
    assert list(found) == ["it.aside"]
    expected = [
        "model.urdf:3: sensor 'odd': it is left out: its type 'logical_camera' is none of",
        "model.urdf:4: gazebo: reference='nowhere' is no link; its sensors are left out",
        "model.urdf:5: gazebo: there is no reference to a link; its sensors are left out",
        "model.urdf:6: sensor 'big': it is left out: big has 90000 x 90000 pixels; at most",
        "model.urdf:7: sensor 'aside': its pose counts from 'base'; here it counts from 'tip'",
    ]
    for warning, begin in zip(warnings, expected, strict=True):
        assert warning.startswith(begin), warning
