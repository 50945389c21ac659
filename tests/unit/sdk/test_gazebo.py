"""Gazebo's sensor tags; formats are those of http://sdformat.org/spec and of Gazebo before 1.0."""

from __future__ import annotations

import base64
import math
from xml.etree import ElementTree

import numpy as np
import pytest
from virtualrobot_sdk.gazebo import SensorTag, read_sensor, sensor_tags

OLD = 'xmlns:sensor="http://playerstage.sourceforge.net/gazebo/xmlschema/#sensor"'


def read(text: str) -> tuple[list[SensorTag], list[str]]:
    """Return the sensors of a link's children and the warnings."""
    warnings: list[str] = []
    tags = sensor_tags(ElementTree.fromstring(f"<link {OLD}>{text}</link>"))
    return [one for tag in tags for one in read_sensor(tag, lambda _, why: warnings.append(why))], warnings


def one(text: str) -> SensorTag:
    (sensor,), warnings = read(text)
    assert not warnings, warnings
    return sensor


def lidar(scan: str, after: str = "", kind: str = "gpu_lidar") -> str:
    tag = "ray" if "ray" in kind else "lidar"
    return f'<sensor name="s" type="{kind}"><{tag}><scan>{scan}</scan>{after}</{tag}></sensor>'


def axis(name: str, samples: int, least: float, most: float) -> str:
    return (
        f"<{name}><samples>{samples}</samples><min_angle>{least!r}</min_angle><max_angle>{most!r}</max_angle></{name}>"
    )


@pytest.mark.parametrize("kind", ["ray", "gpu_ray", "lidar", "gpu_lidar"])
def test_a_fan_with_its_range_and_noise(kind: str) -> None:
    after = (
        "<range><min>0.1</min><max>30</max><resolution>0.02</resolution></range>"
        "<noise><type>gaussian</type><mean>0.003</mean><stddev>0.01</stddev></noise>"
    )
    sensor = one(lidar(axis("horizontal", 640, -1.5, 1.25), after, kind))
    assert sensor.kind == "range_sensor" and sensor.name == "s"
    assert sensor.values == {
        "pattern": {"fan": {"count": 640, "start_angle_radians": -1.5, "end_angle_radians": 1.25}},
        "min_range_meters": 0.1,
        "max_range_meters": 30.0,
        "sensor_model": "laser",
        "sensor_model_settings": {
            "deviation_meters": 0.01,
            "noise_limit": "none",
            "resolution_meters": 0.02,
            "bias_meters": 0.003,
        },
    }


def test_without_noise_and_steps_the_readings_are_true() -> None:
    after = "<range><min>0.08</min><max>inf</max></range>"
    values = one(lidar(axis("horizontal", 1, 0.0, 0.0), after)).values
    assert values == {"pattern": {"beam": {}}, "min_range_meters": 0.08, "max_range_meters": 1e6}


def test_several_rows_around_are_a_spinning_head() -> None:
    sensor = one(lidar(axis("horizontal", 1801, -math.pi, math.pi) + axis("vertical", 16, -0.26, 0.26)))
    spinning = sensor.values["pattern"]["spinning"]
    # Gazebo casts the first and the last of a full turn, which are one.
    assert spinning["columns"] == 1800
    np.testing.assert_allclose(spinning["elevations_radians"], np.linspace(-0.26, 0.26, 16))


def test_other_rows_are_beams_one_by_one() -> None:
    sensor = one(lidar(axis("horizontal", 5, -0.5, 0.7) + axis("vertical", 3, 0.1, 0.4)))
    array = sensor.values["pattern"]["free"]["directions"]
    beams = np.frombuffer(base64.b64decode(array["data"]), "<f4").reshape(array["shape"])
    assert beams.shape == (15, 3)
    np.testing.assert_allclose(np.arctan2(beams[:, 1], beams[:, 0]), np.tile(np.linspace(-0.5, 0.7, 5), 3), atol=1e-6)
    np.testing.assert_allclose(np.arcsin(beams[:, 2]), np.repeat(np.linspace(0.1, 0.4, 3), 5), atol=1e-6)


def test_an_old_laser_in_degrees_and_one_in_radians() -> None:
    """Gazebo before 1.0 took degrees (its hokuyo: 90); the URDF of the SimUEP-Robotics paper has radians."""
    beams = "<rayCount>512</rayCount>"
    for least, most in (("-0.6981317", "0.6981317"), ("-40", "40")):
        angles = f"<minAngle>{least}</minAngle><maxAngle>{most}</maxAngle>"
        reach = "<minRange>0.1</minRange><maxRange>3.0</maxRange><resRange>0.03490658</resRange>"
        text = f'<sensor:ray name="laser">{beams}{angles}{reach}<updateRate>0.2</updateRate></sensor:ray>'
        sensor = one(text)
        fan = sensor.values["pattern"]["fan"]
        assert fan["count"] == 512 and sensor.values["rate_hertz"] == 0.2
        np.testing.assert_allclose([fan["start_angle_radians"], fan["end_angle_radians"]], [-0.6981317, 0.6981317])
        assert sensor.values["sensor_model_settings"]["resolution_meters"] == 0.03490658


def test_an_old_camera() -> None:
    """As in the SimUEP-Robotics paper."""
    sensor = one(
        '<sensor:camera name="c"><imageSize>512 512</imageSize><imageFormat>R8G8B8</imageFormat><hfov>0.7853982</hfov>'
        "<nearClip>0.01</nearClip><farClip>4.5</farClip><updateRate>0.25</updateRate></sensor:camera>"
    )
    assert sensor.kind == "camera_sensor"
    assert sensor.values == {
        "width": 512,
        "height": 512,
        "horizontal_field_radians": 0.7853982,
        "near_meters": 0.01,
        "far_meters": 4.5,
        "rate_hertz": 0.25,
    }


def camera(inside: str, kind: str = "camera", before: str = "") -> str:
    return f'<sensor name="c" type="{kind}">{before}<camera>{inside}</camera></sensor>'


def test_a_camera_looks_along_x_of_its_tag() -> None:
    sensor = one(camera("<pose>0 0 0.5 0 0 0</pose>", before="<pose>1 0 0 0 0 1.5707963267948966</pose>"))
    right, down, forward, place = sensor.link_t_sensor[:3].T
    # The tag's x is the link's y: that is where it looks; its y, the left of the picture, is the link's -x.
    np.testing.assert_allclose(forward, [0.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(right, [1.0, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(down, [0.0, 0.0, -1.0], atol=1e-15)
    np.testing.assert_allclose(place, [1.0, 0.0, 0.5], atol=1e-15)


def test_a_camera_with_everything() -> None:
    inside = (
        "<horizontal_fov>1.2</horizontal_fov><image><width>800</width><height>600</height></image>"
        "<clip><near>0.02</near><far>300</far></clip><noise><type>gaussian</type><stddev>0.007</stddev></noise>"
        "<distortion><k1>-0.25</k1><k2>0.12</k2><k3>0.01</k3><p1>-0.0003</p1><p2>0.0004</p2>"
        "<center>0.5 0.5</center></distortion>"
    )
    values = one(camera(inside)).values
    assert values["distortion"] == [-0.25, 0.12, -0.0003, 0.0004, 0.01]
    assert (values["width"], values["height"], values["horizontal_field_radians"]) == (800, 600, 1.2)
    assert (values["near_meters"], values["far_meters"], values["color_noise"]) == (0.02, 300.0, 0.007)
    lens = "<lens><intrinsics><fx>500</fx><fy>501</fy><cx>320</cx><cy>240</cy><s>0</s></intrinsics></lens>"
    values = one(camera(inside + lens)).values
    assert values["intrinsics"] == {"fx": 500.0, "fy": 501.0, "cx": 320.0, "cy": 240.0}
    assert "horizontal_field_radians" not in values


@pytest.mark.parametrize(
    ("kind", "images"),
    [("depth", ["COLOR", "DEPTH"]), ("depth_camera", ["DEPTH"]), ("rgbd_camera", ["COLOR", "DEPTH"]), ("camera", [])],
)
def test_what_a_camera_takes(kind: str, images: list[str]) -> None:
    assert one(camera("", kind)).values.get("images", []) == [f"IMAGE_KIND_{image}" for image in images]


def test_several_eyes_are_several_cameras() -> None:
    found, warnings = read(
        '<sensor name="eyes" type="multicamera"><update_rate>30</update_rate><camera name="left"/>'
        '<camera name="right"><pose>0 -0.07 0 0 0 0</pose></camera></sensor>'
    )
    assert not warnings and [sensor.name for sensor in found] == ["eyes_left", "eyes_right"]
    np.testing.assert_allclose(found[1].link_t_sensor[:3, 3], [0.0, -0.07, 0.0])
    assert all(sensor.values["rate_hertz"] == 30.0 for sensor in found)


def imu_axis(deviation: float, walk: float = 0.0) -> str:
    return "".join(
        f'<{axis}><noise type="gaussian"><mean>0</mean><stddev>{deviation}</stddev><bias_stddev>0.1</bias_stddev>'
        f"<dynamic_bias_stddev>{walk}</dynamic_bias_stddev></noise></{axis}>"
        for axis in "xyz"
    )


def test_an_inertial_unit() -> None:
    text = (
        '<sensor name="i" type="imu"><update_rate>200</update_rate><imu>'
        f"<angular_velocity>{imu_axis(2e-4, 1e-5)}</angular_velocity>"
        f"<linear_acceleration>{imu_axis(1.7e-2)}</linear_acceleration></imu></sensor>"
    )
    sensor = one(text)
    assert sensor.kind == "motion_sensor"
    assert sensor.values == {
        "rate_hertz": 200.0,
        "imu": {
            "gyroscope": {"standard_deviation": 2e-4, "bias_standard_deviation": 0.1, "bias_walk": 1e-5},
            "accelerometer": {"standard_deviation": 1.7e-2, "bias_standard_deviation": 0.1},
        },
    }
    (sensor,), (warning,) = read(text.replace("0.0002", "0.5", 1))
    assert sensor.values["imu"]["gyroscope"]["standard_deviation"] == 0.5
    assert warning == "the axes of <angular_velocity> have different noise; the greatest is taken for all"


def test_the_other_kinds() -> None:
    found, warnings = read(
        '<sensor name="a" type="contact"><contact><collision>c</collision></contact></sensor>'
        '<sensor name="b" type="force_torque"><force_torque><frame>child</frame></force_torque></sensor>'
        '<sensor name="c" type="navsat"><navsat><position_sensing><horizontal><noise type="gaussian"><stddev>0.5'
        "</stddev></noise></horizontal></position_sensing></navsat></sensor>"
        '<sensor name="d" type="magnetometer"/><sensor name="e" type="altimeter"/>'
        '<sensor name="f" type="sonar"><sonar><min>0.02</min><max>4</max><radius>1</radius></sonar></sensor>'
    )
    assert not warnings
    kinds = ["contact_sensor", *["motion_sensor"] * 4, "range_sensor"]
    assert [sensor.kind for sensor in found] == kinds
    assert found[1].values == {"force_torque": {"include_parent": True}}
    assert found[2].values == {"pose": {"position": {"standard_deviation": 0.5}}}
    sonar = found[5].values
    assert sonar["sensor_model"] == "ultrasonic"
    assert sonar["sensor_model_settings"]["half_angle_radians"] == pytest.approx(math.atan2(1, 4))


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (
            '<sensor name="s" type="wireless_receiver"/>',
            "it is left out: its type 'wireless_receiver' is none of ray",
        ),
        ('<sensor name="s"/>', "its type '' is none of"),
        ('<sensor name="s" type="ray"/>', "it has neither <ray> nor <lidar>"),
        ('<sensor name="s" type="camera"/>', "it has no <camera>"),
        (lidar(axis("horizontal", 0, 0.0, 1.0)), "<samples> is 0; it must be a whole number from 1"),
        (lidar(axis("horizontal", 9, 1.0, -1.0)), "the angles go from 1 to -1"),
        (lidar(axis("horizontal", 3000, -1.0, 1.0) + axis("vertical", 3000, -1.0, 1.0)), "9,000,000 beams; at most"),
        (lidar("", "<range><min>2</min><max>1</max></range>"), "it would see from 2 m to 1 m"),
        (lidar("", "<range><min>-2</min><max>1</max></range>"), "the range -2 to 1 m"),
        (camera("<horizontal_fov>3.2</horizontal_fov>"), "the field of view of 3.2 rad must be from 0 to below 3.142"),
        (camera("<image><width>${w}</width></image>"), "<width> is '${w}', which is no number"),
        (camera("", before="<pose>1 2</pose>"), "<pose> has 2 numbers, expected 6"),
        (camera("", before="<update_rate>-1</update_rate>"), "<update_rate> is -1; it must be a number not below 0"),
    ],
)
def test_what_cannot_be_read_is_told_and_left_out(text: str, why: str) -> None:
    found, (warning,) = read(text)
    assert not found and why in warning
