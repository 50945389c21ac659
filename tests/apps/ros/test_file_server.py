"""The file server of ROS#, by the calls of its UrdfTransferFromRos and UrdfTransferToRos."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest
import roslibpy
from roslibpy.core import ServiceException
from virtualrobot import Client

from tests.api.asking import IIWA
from tests.apps.ros.bridges import bridge, roslibpy_client, told


def parameter(ros: roslibpy.Ros, name: str) -> str:
    """Return a parameter as ROS# asks for it, with its default."""
    service = roslibpy.Service(ros, "/rosapi/get_param", "rosapi_msgs/GetParam")
    answer = told(service.call(roslibpy.ServiceRequest({"name": name, "default_value": "default"})))
    return json.loads(answer["value"])


def get(ros: roslibpy.Ros, name: str) -> bytes:
    service = roslibpy.Service(ros, "/file_server/get_file", "file_server2/GetBinaryFile")
    return base64.b64decode(told(service.call(roslibpy.ServiceRequest({"name": name})))["value"])


def save(ros: roslibpy.Ros, name: str, data: bytes) -> str:
    service = roslibpy.Service(ros, "/file_server/save_file", "file_server2/SaveBinaryFile")
    request = {"name": name, "value": base64.b64encode(data).decode()}
    return told(service.call(roslibpy.ServiceRequest(request)))["name"]


def test_a_robot_goes_to_unity_and_comes_back(client: Client, tmp_path: Path) -> None:
    """It is fetched as ROS# does it, sent into another package, loaded from there, and is the same robot."""
    kept = tmp_path / "kept"
    kept.mkdir()
    arm = client.load_robot(IIWA, name="cell.arm")
    with bridge(client, files=kept) as (url, _), roslibpy_client(url) as ros:
        assert parameter(ros, "/cell/arm:robot_name") == "cell.arm"
        text = parameter(ros, "/cell/arm:robot_description")
        uris = sorted(set(re.findall(r'filename="([^"]*)"', text)))
        assert uris and all(one.startswith("package://virtualrobot/cell/arm/") for one in uris)
        for uri in uris:
            there = uri.replace("package://virtualrobot/cell/arm/", "package://unity/meshes/")
            assert save(ros, there, get(ros, uri)) == there
        back = text.replace("package://virtualrobot/cell/arm/", "meshes/")
        save(ros, "package://unity/robot.urdf", back.encode())
        assert get(ros, "package://unity/robot.urdf") == back.encode()

        with pytest.raises(ServiceException, match=r"there is no robot 'other'; known: cell\.arm"):
            parameter(ros, "/other:robot_name")
        assert told(ros.get_params()) == ["/use_sim_time"]
    again = client.load_robot(str(kept / "unity" / "robot.urdf"), name="again")
    joints = np.linspace(-0.5, 0.5, 7)
    arm.set_positions(joints)
    again.set_positions(joints)
    np.testing.assert_allclose(again.tcp, arm.tcp, atol=1e-12)
    sizes = [client.scene.bounds(one.name) for one in (arm, again)]
    assert sizes[0] is not None and sizes[1] is not None
    np.testing.assert_allclose(sizes[0], sizes[1], atol=1e-9)


def test_names_that_lead_elsewhere_are_refused(client: Client, tmp_path: Path) -> None:
    kept, secret = tmp_path / "kept", tmp_path / "secret.yaml"
    (kept / "unity").mkdir(parents=True)
    secret.write_text("secret", "utf-8")
    (kept / "unity" / "link.yaml").symlink_to(secret)
    with bridge(client, files=kept) as (url, _), roslibpy_client(url) as ros:
        for name, words in (
            ("package://unity/../../secret.yaml", "is no name of a file"),
            ("file:///etc/passwd", "is no name of a file"),
            ("package://unity/link.yaml", "leads out of the folder"),
            ("package://unity/run.sh", "files of robots end with"),
            ("package://unity/none.stl", "cannot be read: No such file"),
        ):
            with pytest.raises(ServiceException, match=words):
                get(ros, name)
        for name, words in (
            ("package://virtualrobot/arm/robot.urdf", "save below another one"),
            ("package://unity/link.yaml", "leads out of the folder"),
        ):
            with pytest.raises(ServiceException, match=words):
                save(ros, name, b"other")
    assert secret.read_text("utf-8") == "secret"


def test_without_a_folder_nothing_is_kept(client: Client) -> None:
    with bridge(client) as (url, _), roslibpy_client(url) as ros:
        with pytest.raises(ServiceException, match="started without --files FOLDER"):
            save(ros, "package://unity/robot.urdf", b"<robot/>")
