"""Table of the streams of a world: what there is to hear and to tell, under the names that recordings have."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from virtualrobot._wire.services import Services
from virtualrobot.recording import topics
from virtualrobot.recording.joints import Coordinate, coordinates
from virtualrobot.v1 import kernel_pb2, nodes_pb2, robot_pb2, scene_pb2, sensing_pb2, sensor_pb2, signal_pb2

OUT, IN, BOTH = "out", "in", "both"
"""Directions of streams: the world tells it, hears it, or does both."""

TOOL_STREAMS = {"tool_twist": "twist", "tool_pose": "pose"}
"""Modes of setpoints of a tool centre point, by what their streams tell."""

MOTIONS_HERTZ = 20.0
"""Greatest rate at which motions are told."""

_READINGS = {
    "imu": ("ImuReading", "rad/s, m/s^2, T"),
    "encoders": ("EncoderReading", "rad, m, per s"),
    "pose": ("PoseReading", "m, m/s"),
    "force_torque": ("WrenchReading", "N, N m"),
}
_PICTURES = {
    sensing_pb2.IMAGE_KIND_UNSPECIFIED: "color",
    sensing_pb2.IMAGE_KIND_COLOR: "color",
    sensing_pb2.IMAGE_KIND_DEPTH: "depth",
    sensing_pb2.IMAGE_KIND_SEGMENTATION: "segmentation",
    sensing_pb2.IMAGE_KIND_NORMALS: "normals",
}
_PICTURE_UNITS = {"depth": "m", "color": "0 to 255", "segmentation": "places in a list", "normals": "1"}


@dataclass(frozen=True, slots=True)
class Stream:
    """A stream: a row of the table.

    Attributes:
        name: its name, such as `/robots/arm/joint_states`.
        type: what it tells: the name of a message of the contract, or `Twist` and `JointValues` of what is only heard.
        rate: how often a second of simulation time; None: when something changes.
        unit: of its numbers.
        frame: in whose frame they are; empty where they are in none.
        direction: `out`, `in` or `both`, as the world has it.
        watch: which watch of the contract tells it: `robots`, `scene`, `signals`, `readings`, `motions`, `collisions`,
            or none.
        about: the robot, node, signal or sensor that it is about.
        content: what of that, such as `joint_states`, `pose`, `scan`.
    """

    name: str
    type: str
    rate: float | None
    unit: str
    frame: str
    direction: str
    watch: str
    about: str
    content: str


def table(services: Services) -> list[Stream]:
    """Return the streams that a world has now: clock, robots, nodes, sensors, signals, motions, collisions."""
    clock = services.kernel.GetClock(kernel_pb2.GetClockRequest()).clock
    every_tick = 1e9 / clock.tick_nanoseconds
    nodes = services.scene.GetScene(scene_pb2.GetSceneRequest()).nodes
    rates = {one.name: one.rate_hertz for one in services.sensor.ListSensors(sensor_pb2.ListSensorsRequest()).sensors}
    signals = services.signal.GetSignals(signal_pb2.GetSignalsRequest()).signals
    found = [Stream("/clock", "Stamp", every_tick, "s", "", OUT, "robots", "", "clock")]
    for node in nodes:
        kind = node.WhichOneof("kind")
        if kind == "robot":
            robot = services.robot.GetRobot(robot_pb2.GetRobotRequest(name=node.name))
            found += _of_robot(node, robot, every_tick)
        elif kind in ("range_sensor", "camera_sensor", "contact_sensor", "motion_sensor"):
            found += _of_sensor(services, node, rates.get(node.name, 0.0))
    found += [_of_signal(one) for one in signals]
    found += [
        Stream(f"/nodes/{node.name}/pose", "Pose", every_tick, "m", "world", OUT, "scene", node.name, "pose")
        for node in nodes
        if node.name != "world"
    ]
    found += [
        Stream(topics.TRANSFORMS, "FrameTransforms", every_tick, "m", "", OUT, "scene", "", "transforms"),
        Stream(topics.FIXED_TRANSFORMS, "FrameTransforms", None, "m", "", OUT, "scene", "", "transforms"),
    ]
    found.append(Stream(topics.MOTIONS, "Motion", MOTIONS_HERTZ, "s", "", OUT, "motions", "", "motions"))
    found.append(Stream(topics.COLLISIONS, "CollisionEvent", None, "m", "world", OUT, "collisions", "", "collisions"))
    return found


def chosen(streams: Iterable[Stream], patterns: Iterable[str]) -> list[Stream]:
    """Return the streams that names or patterns such as `/robots/*` choose, each once, in the table's order.

    Raises:
        UnknownNameError: for what chooses none, with the nearest names.
    """
    streams = list(streams)
    selection = topics.Selection(patterns)
    found = [one for one in streams if one.name in selection]
    if unmet := selection.unmet():
        selection.check([one.name for one in streams])
        from virtualrobot.errors import UnknownNameError

        raise UnknownNameError("; ".join(unmet))
    return found


def base_joint(node: nodes_pb2.Node, joints: Iterable[robot_pb2.JointDescription]) -> robot_pb2.JointDescription | None:
    """Return the joint by which a robot's base moves: that of the craft, or the first planar or floating one."""
    moving = [one for one in joints if one.coordinate_count > 1]
    named = [one for one in moving if one.name == node.robot.craft.base_joint]
    return (named or moving or [None])[0]


def _of_robot(node: nodes_pb2.Node, robot: robot_pb2.GetRobotResponse, every_tick: float) -> Iterator[Stream]:
    name, joints = node.name, list(robot.joints)
    units = ", ".join(_units(coordinates(joints)))
    states, tcp = topics.joint_states(name), topics.tool_center_point(name)
    yield Stream(states, "RobotState", every_tick, units, "", OUT, "robots", name, "joint_states")
    yield Stream(
        topics.commanded_joint_states(name), "RobotState", every_tick, units, "", OUT, "robots", name, "commanded"
    )
    yield Stream(tcp, "Pose", every_tick, "m", "world", OUT, "robots", name, "tcp")
    if base_joint(node, joints) is not None:
        yield Stream(
            f"/robots/{name}/base", "RobotState", every_tick, "m, rad, per s", "world", OUT, "robots", name, "base"
        )
    for mode, unit in (("position", units), ("velocity", ", ".join(f"{one}/s" for one in _units(coordinates(joints))))):
        yield Stream(f"/robots/{name}/command/{mode}", "JointValues", None, unit, "", IN, "", name, mode)
    if robot.chain_joints:
        for content, unit, type in (("tool_twist", "m/s, rad/s", "Twist"), ("tool_pose", "m", "Pose")):
            yield Stream(f"/robots/{name}/command/{content}", type, None, unit, name, IN, "", name, content)
    if node.robot.HasField("craft"):
        yield Stream(f"/robots/{name}/command/twist", "Twist", None, "m/s, rad/s", name, IN, "", name, "twist")


def _units(found: Iterable[Coordinate]) -> list[str]:
    return list(dict.fromkeys(one.unit for one in found if one.unit))


def _of_sensor(services: Services, node: nodes_pb2.Node, rate: float) -> Iterator[Stream]:
    name, kind = node.name, node.WhichOneof("kind")

    def stream(content: str, type: str, unit: str) -> Stream:
        return Stream(topics.sensor(name, content), type, rate, unit, name, OUT, "readings", name, content)

    if kind == "range_sensor":
        flat = topics.scan_angles(pattern_of(services, node.range_sensor)) is not None
        yield stream("scan" if flat else "points", "RangeReading", "m")
    elif kind == "camera_sensor":
        sides = ("", "right_") if node.camera_sensor.stereo_baseline_meters else ("",)
        for image in node.camera_sensor.images or [sensing_pb2.IMAGE_KIND_COLOR]:
            for side in sides:
                yield stream(f"{side}{_PICTURES[image]}", "Image", _PICTURE_UNITS[_PICTURES[image]])
        yield stream("camera_info", "CameraReading", "px")
    elif kind == "contact_sensor":
        yield stream("reading", "ContactReading", "m")
    else:
        yield stream("reading", *_READINGS[node.motion_sensor.WhichOneof("kind") or "imu"])


def pattern_of(services: Services, sensor: sensing_pb2.RangeSensor) -> sensing_pb2.ScanPattern:
    """Return where the beams of a range sensor go, by itself or by its device."""
    own, device = settings_of(services, sensor)
    return own.pattern if own.HasField("pattern") or not own.preset else device.pattern


def settings_of(
    services: Services, sensor: sensing_pb2.RangeSensor
) -> tuple[sensing_pb2.RangeSensor, sensing_pb2.RangeSensor]:
    """Return the settings of a range sensor, and those of its device, which count where it has none; empty without."""
    if not sensor.preset:
        return sensor, sensing_pb2.RangeSensor()
    presets = services.sensor.ListSensorPresets(sensor_pb2.ListSensorPresetsRequest()).presets
    device = next((one.sensor for one in presets if one.name == sensor.preset), sensing_pb2.RangeSensor())
    return sensor, device


def _of_signal(signal: signal_pb2.Signal) -> Stream:
    return Stream(topics.signal(signal.name), "Signal", None, signal.unit, "", BOTH, "signals", signal.name, "signal")
