"""Messages of ROS: types by their hashes, values from JSON and CBOR and back, what is refused and in which words."""

from __future__ import annotations

import json
import math

import cbor2
import numpy as np
import pytest
from virtualrobot_apps.bridges.ros.messages import types
from virtualrobot_apps.bridges.ros.messages.cbor import to_cbor
from virtualrobot_apps.bridges.ros.messages.message import Message
from virtualrobot_apps.bridges.ros.messages.types import UnknownTypeError, known, of_kind
from virtualrobot_apps.bridges.ros.messages.values import FieldError, default, from_plain, to_plain
from virtualrobot_apps.bridges.ros.rosbridge.wire import decoded

HASHES = {
    # As ROS 2 Jazzy's own generator has written them, beside the definitions: std_srvs, sensor_msgs, nav_msgs,
    # geometry_msgs and trajectory_msgs 5.3.6, rosgraph_msgs and action_msgs 2.0.3.
    "std_srvs/srv/Trigger_Request": "d010825374ce8918e72bfd826c82603e60f45419e932ea976f807b74a863a199",
    "std_srvs/srv/SetBool_Response": "d0814e7f7b4880ab77e9c57426c7aa1562ab69f11eef8e2e968812f9cbd0b059",
    "sensor_msgs/msg/JointState": "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
    "sensor_msgs/msg/LaserScan": "64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
    "sensor_msgs/msg/PointCloud2": "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5",
    "sensor_msgs/msg/CameraInfo": "b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275",
    "sensor_msgs/msg/Image": "d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47",
    "sensor_msgs/msg/Imu": "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b",
    "nav_msgs/msg/Odometry": "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    "rosgraph_msgs/msg/Clock": "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564",
    "geometry_msgs/msg/TransformStamped": "0a241f87d04668d94099cbb5ba11691d5ad32c2f29682e4eb5653424bd275206",
    "geometry_msgs/msg/Twist": "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    "trajectory_msgs/msg/JointTrajectory": "179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e",
    "action_msgs/srv/CancelGoal_Response": "35e682cf3f510e83c70a82a4aac888496dedee56773bf9d8e5e0aa81f9e1c960",
    # control_msgs 5, in the headers that are generated of it.
    "control_msgs/action/FollowJointTrajectory_Goal": (
        "8a9060704b269608f5a340934cc26e66869dd14bdac29e2e7fd9ec8b9882d205"
    ),
    "control_msgs/action/FollowJointTrajectory_Result": (
        "8002e99ed2c14c6faa522f2a93c26d744c5982f254f9e98ff9c6f19789bdb220"
    ),
    "control_msgs/action/FollowJointTrajectory_Feedback": (
        "3fd0aaecf71725121ae1ff7f01098a5e0da581e672be18a6b2c286cb43d96b49"
    ),
    "control_msgs/action/FollowJointTrajectory_SendGoal_Request": (
        "179c93691f1f6d1d115881ff88c3917b7cc6eac2ba4bf56766cc7c4389e19ef1"
    ),
    "control_msgs/action/FollowJointTrajectory_SendGoal_Response": (
        "e6a48ba740ae254500129a877f0b071be8663a115da1a539b74599cc97921fbf"
    ),
    "control_msgs/action/FollowJointTrajectory_GetResult_Request": (
        "ecf7ea8463d3beec7084bca75216d0b01b87b6e1e4e09679bb26093041efcbe9"
    ),
    "control_msgs/action/FollowJointTrajectory_GetResult_Response": (
        "08eefbaa146ce02ba45898d5e99160afd6c4c54a30d159aee0f2ca6035b1580f"
    ),
    # simulation_interfaces 2.0 and moveit_msgs, in the sources that are generated of them.
    "moveit_msgs/msg/CollisionObject": "74b0acd6d56be032bf4f764b2c2633f50588b5fb2bd71e97206c59052747cf7e",
    "simulation_interfaces/msg/EntityFilters": "8e7b12e8ea062f14c55de4877221fe1b7cd9749665a7ad8a4ab855fc4b148303",
    "simulation_interfaces/msg/EntityState": "2e0464a85eb80a939025075d6c20761eca6a4cb9d6baf2c0ba373467c8b598d0",
    "simulation_interfaces/srv/SpawnEntity_Request": (
        "9bc04fe30d4844466c57b7b090fd7e9aa426995f3eb6ff9a726826ab7223e1fd"
    ),
    "simulation_interfaces/srv/SpawnEntity_Response": (
        "be8c9fc03b6faaf95570949c80195c8ca75dd99f7efc23262309d497b2923982"
    ),
    "simulation_interfaces/srv/GetSimulationState_Response": (
        "dc80ce852a5ab04c2b23cdd47910cee1bcc46e0f1931cac85825e6916b15517f"
    ),
    "simulation_interfaces/srv/GetAvailableWorlds_Request": (
        "6335180e35038ba62eb2bae3d1c1bacd4b7791209137eacbddfee12629bf6c3a"
    ),
    "simulation_interfaces/srv/LoadWorld_Response": (
        "7bab3265c2461d98a44dd04830c5dc997b3d8605c50861824066246c96a7716e"
    ),
}


@pytest.mark.parametrize("name", [*HASHES])
def test_types_are_those_of_the_packages_by_their_hash(name: str) -> None:
    assert types.hash_of(name) == f"RIHS01_{HASHES[name]}"


@pytest.mark.parametrize("name", sorted(types.STORE.types))
def test_each_type_goes_through_each_encoding_and_back(name: str) -> None:
    message = Message(name, default(name))
    assert message.json == json.dumps(to_plain(message.value), separators=(",", ":"))
    assert Message.from_cdr(name, message.cdr).json == message.json
    assert Message(name, from_plain(name, json.loads(message.json))).cdr == message.cdr
    told = decoded(b"\xa1" + cbor2.dumps("msg") + b"".join(message.cbor_parts))["msg"]
    assert Message(name, from_plain(name, told)).cdr == message.cdr


def test_numbers_keep_all_bits(rng: np.random.Generator) -> None:
    numbers = rng.standard_normal(200) * 10.0 ** rng.uniform(-300, 300, 200)
    state = from_plain("sensor_msgs/msg/JointState", {"position": numbers.tolist(), "name": ["a"]})
    message = Message("sensor_msgs/msg/JointState", state)
    assert json.loads(message.json)["position"] == numbers.tolist()
    typed = cbor2.loads(b"".join(message.cbor_parts))["position"]
    assert (typed.tag, typed.value) == (86, numbers.astype("<f8").tobytes())  # RFC 8746: 86 is float64, little-endian
    assert to_plain(Message.from_cdr(message.type, message.cdr).value)["position"] == numbers.tolist()


def test_cbor_is_that_of_another_writer(rng: np.random.Generator) -> None:
    # cbor2 writes the same bytes for plain values.
    whole = [int(sign * 2**bits + step) for bits in range(63) for sign in (-1, 1) for step in (-1, 0, 1)]
    plain = {
        "whole": whole,
        "most": 2**64 - 1,
        "numbers": rng.standard_normal(20).tolist(),
        "n": None,
        "b": [True, False],
    }
    plain |= {
        "texts": ["x" * count for count in (0, 23, 24, 255, 256, 65_536)],
        "data": b"ab" * 40_000,
        "nested": {"a": []},
    }
    assert to_cbor(plain) == cbor2.dumps(plain)
    with pytest.raises(TypeError, match="an integer of more than 64 bits"):
        to_cbor(2**64)
    with pytest.raises(TypeError, match="set has no form in CBOR"):
        to_cbor({1})


@pytest.mark.parametrize(
    "name", ["int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64"]
)
def test_typed_arrays_are_read_as_they_were(name: str, rng: np.random.Generator) -> None:
    numbers = rng.integers(0, 100, 50).astype(name)
    for array in (numbers, numbers[::2], numbers.astype(numbers.dtype.newbyteorder(">")), numbers[:0]):
        np.testing.assert_array_equal(decoded(to_cbor({"data": array}))["data"], array)


def test_what_json_has_no_number_for_is_null() -> None:
    scan = from_plain("sensor_msgs/msg/LaserScan", {"ranges": [1.5, None], "range_max": 3.5})
    assert math.isnan(scan.ranges[1])
    scan.ranges = np.array([1.5, np.inf, np.nan], np.float32)
    assert to_plain(scan)["ranges"] == [1.5, None, None]
    message = Message("sensor_msgs/msg/LaserScan", scan)
    assert '"ranges":[1.5,null,null]' in message.json
    assert '"ranges":[1.5,Infinity,NaN]' in message.json_with_infinity
    scan.range_max, scan.range_min, scan.header.frame_id = np.float64(np.inf), np.float32(0.5), 'a\n"ü'
    found = json.loads(Message("sensor_msgs/msg/LaserScan", scan).json)
    assert (found["range_max"], found["range_min"], found["header"]["frame_id"]) == (None, 0.5, 'a\n"ü')


def test_ways_of_writing_of_other_clients_are_understood() -> None:
    # roslib 1 and ROS# write the names of ROS 1: secs and nsecs, and seq in headers.
    header = {"seq": 7, "stamp": {"secs": 3, "nsecs": 4}, "frame_id": "map"}
    found = from_plain("std_msgs/msg/Header", header)
    assert (found.stamp.sec, found.stamp.nanosec, found.frame_id) == (3, 4, "map")
    assert from_plain("sensor_msgs/msg/Image", {"data": "AQL/"}).data.tolist() == [1, 2, 255]
    assert from_plain("std_msgs/msg/Int32", {"data": 5.0}).data == 5  # JavaScript knows one kind of numbers
    assert known("std_msgs/String") == "std_msgs/msg/String"
    assert of_kind("std_srvs/SetBool", "srv") == "std_srvs/srv/SetBool"


@pytest.mark.parametrize(
    ("type", "value", "words"),
    [
        ("sensor_msgs/msg/JointState", {"positions": []}, "has no field 'positions'; it has header, name, position"),
        ("sensor_msgs/msg/JointState", {"position": [1, "x"]}, r"position\[1\]: float64 belongs here, not 'x'"),
        ("sensor_msgs/msg/JointState", {"position": [10**400]}, r"position\[0\]: float64 belongs here"),
        ("sensor_msgs/msg/JointState", {"position": {}}, "position: a list of float64 belongs here, not an object"),
        ("sensor_msgs/msg/JointState", {"name": [None]}, r"name\[0\]: string belongs here, not None"),
        ("sensor_msgs/msg/JointState", {"header": {"stamp": {"sec": 2**31}}}, "header.stamp.sec: int32 belongs here"),
        ("sensor_msgs/msg/JointState", {"header": [1]}, "header: an object belongs here, not a list"),
        ("sensor_msgs/msg/Image", {"data": "no base64!"}, "data: bytes belong here"),
        (
            "sensor_msgs/msg/Imu",
            {"orientation_covariance": [1.0]},
            "orientation_covariance: 9 values belong here, not 1",
        ),
        ("std_msgs/msg/Bool", {"data": 1}, "data: bool belongs here, not 1"),
        ("std_msgs/msg/Int8", {"data": True}, "data: int8 belongs here, not True"),
        ("std_msgs/msg/String", {"data": "a\0b"}, "data: string belongs here"),
        ("std_msgs/msg/Float32", {"data": 1e39}, r"data: float32 belongs here, not 1e\+39"),
        ("std_msgs/msg/Empty", {"x": 1}, "has no field 'x'; it has none"),
        ("std_msgs/msg/Empty", 5, "an object belongs here, not 5"),
    ],
)
def test_values_that_do_not_fit_are_named(type: str, value: object, words: str) -> None:
    with pytest.raises(FieldError, match=words):
        from_plain(type, value)


def test_unknown_types_are_named_with_the_nearest_one() -> None:
    with pytest.raises(
        UnknownTypeError, match="'sensor_msgs/JointStates' is not known; did you mean 'sensor_msgs/msg/J"
    ):
        known("sensor_msgs/JointStates")
    with pytest.raises(
        UnknownTypeError, match="srv type 'std_srvs/SetBol' is not known; did you mean 'std_srvs/srv/SetB"
    ):
        of_kind("std_srvs/SetBol", "srv")
    with pytest.raises(UnknownTypeError, match="'5' is not known"):
        known(5)
