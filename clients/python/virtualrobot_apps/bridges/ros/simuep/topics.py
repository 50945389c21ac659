"""Topics and services of SimUEP-Robotics on a hub: what the scene file names, under its prefix.

Source: A Robotics Framework for Planning the Offshore Robotizing Using Virtual Reality Techniques (OTC Brasil 2013),
table 1 and figure 3. The document names no types of services: lines are drawn by `virtualrobot_msgs/DrawLines`, sensors
are enabled by `virtualrobot_msgs/EnableSensor`, and a camera gets its `sensor_msgs/SetCameraInfo`.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError
from virtualrobot.recording import topics as streams
from virtualrobot.scene.figures import Figure, lines
from virtualrobot.sensors.cameras import CameraSettings
from virtualrobot.v1 import sensing_pb2

from virtualrobot_apps.bridges.ros.bridge_file import Choice, Entry
from virtualrobot_apps.bridges.ros.frames import world_t_frame
from virtualrobot_apps.bridges.ros.hub import Hub, Refused, Service, Topic
from virtualrobot_apps.bridges.ros.in_order import InOrder
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue, matrix_of
from virtualrobot_apps.bridges.ros.mapping.names import FrameNames, topic_name
from virtualrobot_apps.bridges.ros.messages.types import make
from virtualrobot_apps.bridges.ros.simuep.scene import RobotTopics, SimuepScene, feeling_name

JOINT_STATE, POSE = "sensor_msgs/msg/JointState", "geometry_msgs/msg/PoseStamped"
SERVICES = {
    "draw3DLines": "virtualrobot_msgs/srv/DrawLines",
    "enableSensor": "virtualrobot_msgs/srv/EnableSensor",
    "cameraInfo": "sensor_msgs/srv/SetCameraInfo",
}
TYPES = {
    "joint": JOINT_STATE,
    "collision": "sensor_msgs/msg/PointCloud2",
    "proximity": "std_msgs/msg/String",
    "laser": "sensor_msgs/msg/LaserScan",
    "camera": "sensor_msgs/msg/Image",
}
"""Types of what a robot tells, by kind; source: table 1."""

_LINE_STRIP, _LINE_LIST = 4, 5
_ADD, _DELETE, _DELETE_ALL = 0, 2, 3
"""Types and actions of markers; source: visualization_msgs/Marker."""

_DISTORTIONS = {"plumb_bob": 5, "rational_polynomial": 8, "equidistant": 4, "": 0}


def choice_of(scene: SimuepScene, auto: bool) -> Choice:
    """Return which streams become the topics of a scene; with `auto` all others have conventional names."""
    return Choice(auto, tuple(entry for robot in scene.robots for entry in _entries(scene.prefix, robot)))


def _entries(prefix: str, robot: RobotTopics) -> Iterator[Entry]:
    for one in robot.sensors:
        match one.kind:
            case "joint":
                stream = streams.joint_states(robot.robot)
            case "laser":
                stream = streams.sensor(f"{robot.robot}.{one.sensor}", "scan")
            case "camera":
                stream = streams.sensor(f"{robot.robot}.{one.sensor}", "color")
            case _:
                stream = streams.sensor(feeling_name(robot.robot, one.kind), "reading")
        name = topic_name(prefix, robot.robot, one.name)
        yield Entry(name, TYPES[one.kind], stream, False, True, one.place)


def lines_of(scene: SimuepScene) -> Iterator[tuple[str, str, str]]:
    """Yield name, type, and what it is of, of each topic that robots hear, and of each service."""
    for robot in scene.robots:
        for one in robot.actuators:
            name = topic_name(scene.prefix, robot.robot, one.name)
            yield name, JOINT_STATE if one.kind == "joint" else POSE, f"to {robot.robot}"
    for kind, name in scene.services.items():
        yield topic_name(scene.prefix, name), SERVICES[kind], "service"


class SimuepTopics:
    """Actuators and services of a scene on a hub."""

    def __init__(self, client: Client, hub: Hub, scene: SimuepScene, say: Callable[[str], None]) -> None:
        """Hear nothing yet."""
        self._client, self._hub, self._scene = client, hub, scene
        loop = asyncio.get_running_loop()
        self._say = partial(loop.call_soon_threadsafe, say)
        self._changes = InOrder("commands", self._work)
        self._drawn: set[str] = set()

    def serve(self) -> None:
        """Add the topics that robots hear, and the services."""
        for robot in self._scene.robots:
            for one in robot.actuators:
                name = topic_name(self._scene.prefix, robot.robot, one.name)
                type, set_it = (JOINT_STATE, self._set_joints) if one.kind == "joint" else (POSE, self._set_pose)
                take = partial(self._take, name, partial(set_it, robot.robot))
                self._hub.declare(Topic(name, type, take=take))
        answers = {
            "draw3DLines": self._draw,
            "enableSensor": self._enable,
            "cameraInfo": self._set_camera,
        }
        for kind, name in self._scene.services.items():
            words = "status_message" if kind == "cameraInfo" else "message"
            answer = partial(self._answered, f"{SERVICES[kind]}_Response", words, answers[kind])
            self._hub.serve(Service(topic_name(self._scene.prefix, name), SERVICES[kind], answer))

    def _take(self, name: str, set_it: Callable[[RosValue], None], value: RosValue, refused: Refused) -> None:
        self._changes.put((name, set_it, value, refused))

    def _work(self, change: tuple[str, Callable[[RosValue], None], RosValue, Refused]) -> None:
        name, set_it, value, refused = change
        try:
            set_it(value)
        except (VirtualRobotError, ValueError) as error:
            self._say(f"{name}: {error}")
            refused(str(error))

    def _answered(self, type: str, words: str, work: Callable[[RosValue], str], asked: RosValue) -> Awaitable[RosValue]:
        async def answer() -> RosValue:
            try:
                said, done = await asyncio.to_thread(work, asked), True
            except (VirtualRobotError, ValueError) as error:
                said, done = str(error), False
            return make(type, **{"success": done, words: said})

        return answer()

    def _set_joints(self, robot: str, value: RosValue) -> None:
        positions = [float(one) for one in value.position]
        if len(value.name) != len(positions) or not all(map(math.isfinite, positions)):
            raise ValueError(f"'position' has a finite number for each of the {len(value.name)} names")
        self._client.scene.set_joint_positions(robot, dict(zip(value.name, positions, strict=True)))

    def _set_pose(self, robot: str, value: RosValue) -> None:
        self._client.scene.set_pose(robot, self._in_world(value.header.frame_id, value.pose))

    def _in_world(self, frame: str, pose: RosValue) -> NDArray[np.float64]:
        return world_t_frame(self._client, frame, bare=False) @ matrix_of(pose)

    def _draw(self, asked: RosValue) -> str:
        """Draw the lines of markers: one of a namespace and id takes the place of the one before."""
        scene = self._client.scene
        for one in asked.markers.markers:
            name = f"lines {one.ns} {one.id}"[:200]
            gone = self._drawn if one.action == _DELETE_ALL else self._drawn & {name}
            figures = _figures(one) if one.action == _ADD else []
            if one.action not in (_ADD, _DELETE, _DELETE_ALL):
                raise ValueError(f"'action' is 0 (add), 2 (delete) or 3 (delete all), not {one.action}")
            pose = self._in_world(one.header.frame_id, one.pose) if figures else None
            with scene.batch() as batch:
                for before in sorted(gone):
                    batch.remove(before)
                if figures:
                    batch.add_annotation(name, figures, pose=pose)
            self._drawn -= gone
            self._drawn |= {name} if figures else set()
        return f"{len(self._drawn)} lines are drawn"

    def _enable(self, asked: RosValue) -> str:
        names = {topic_name(one): one for one in self._client.sensors}
        name = asked.name if asked.name in names.values() else names.get(topic_name(asked.name))
        if name is None:
            known = ", ".join(sorted(names.values())) or "none"
            raise ValueError(f"there is no sensor {asked.name[:80]!r}; known: {known}")
        (self._client.sensors.start if asked.enable else self._client.sensors.stop)(name)
        return f"{name} reads" if asked.enable else f"{name} reads while somebody listens"

    def _set_camera(self, asked: RosValue) -> str:
        """Give a camera, told by its frame, another size, camera matrix and distortion."""
        scene, info = self._client.scene, asked.camera_info
        nodes = scene.nodes()
        frames = FrameNames(one.name for one in nodes if one.kind == "robot")
        cameras = {frames(one.name): one for one in nodes if one.kind == "camera_sensor"}
        node = cameras.get(info.header.frame_id)
        if node is None:
            known = ", ".join(sorted(cameras)) or "none"
            raise ValueError(f"'header.frame_id' is that of a camera ({known}), not {info.header.frame_id[:80]!r}")
        message = sensing_pb2.CameraSensor()
        message.CopyFrom(node._message.camera_sensor)
        _calibrate(message, info)
        with scene.batch() as batch:
            batch.remove(node.name)
            batch.add_camera(
                node.name, CameraSettings(message), node.figures, pose=node.parent_t_node, parent=node.parent
            )
        return f"{node.name} has {info.width}x{info.height} pixels"


def _figures(marker: RosValue) -> list[Figure]:
    """Return the lines of a marker, in its frame."""
    if marker.type not in (_LINE_STRIP, _LINE_LIST):
        raise ValueError(f"a marker of lines has the type 4 (strip) or 5 (list), not {marker.type}")
    points = np.array([[one.x, one.y, one.z] for one in marker.points], float).reshape(-1, 3)
    if len(points) < 2 or not np.isfinite(points).all():
        raise ValueError("lines have two points or more, of finite numbers")
    if marker.type == _LINE_LIST:
        if len(points) % 2:
            raise ValueError(f"a list of lines has two points for each, not {len(points)}")
        segments = points.reshape(-1, 2, 3)
    else:
        segments = np.stack([points[:-1], points[1:]], axis=1)
    color = [min(max(float(part), 0.0), 1.0) for part in (marker.color.r, marker.color.g, marker.color.b)]
    return [lines(segments, color=color)]


def _calibrate(camera: sensing_pb2.CameraSensor, info: RosValue) -> None:
    """Give a camera the size, matrix and distortion of a `sensor_msgs/CameraInfo`."""
    model = info.distortion_model
    if model not in _DISTORTIONS:
        known = ", ".join(filter(None, _DISTORTIONS))
        raise ValueError(f"'distortion_model' is {known} or empty, not {model[:40]!r}")
    numbers, matrix = np.array(info.d, float), np.array(info.k, float)
    if len(numbers) not in (0, _DISTORTIONS[model]) or not np.isfinite(numbers).all():
        raise ValueError(f"'d' has {_DISTORTIONS[model]} finite numbers for {model or 'no model'}, not {len(numbers)}")
    if not np.isfinite(matrix).all() or not (matrix[0] > 0.0 and matrix[4] > 0.0):
        raise ValueError("'k' is a camera matrix: finite, with focal lengths above 0")
    if not (0 < info.width and 0 < info.height):
        raise ValueError("'width' and 'height' are above 0")
    camera.width, camera.height = info.width, info.height
    fisheye = model == "equidistant"
    camera.projection = sensing_pb2.CAMERA_PROJECTION_FISHEYE if fisheye else sensing_pb2.CAMERA_PROJECTION_PINHOLE
    camera.intrinsics.CopyFrom(sensing_pb2.CameraIntrinsics(fx=matrix[0], fy=matrix[4], cx=matrix[2], cy=matrix[5]))
    camera.ClearField("horizontal_field_radians")  # the matrix says it
    del camera.distortion[:]
    camera.distortion.extend(numbers.tolist() if numbers.any() else [])
