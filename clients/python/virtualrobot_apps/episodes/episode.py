"""A demonstration in an MCAP file: what a robot did, and what the cell's signals and cameras told meanwhile."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, MissingFileError, WrongStateError
from virtualrobot.recording import topics

Floats = NDArray[np.float64]

SIGNALS, SENSORS, ROBOTS = "/signals/", "/sensors/", "/robots/"
COLOR = "/color"
NANO = 1e-9


@dataclass(eq=False)
class Track:
    """Values over time: `times` in s of simulation time, ascending, and a value for each."""

    times: list[float] = field(default_factory=list)
    values: list[Any] = field(default_factory=list)

    def add(self, time: float, value: object) -> None:
        """Add a value; of two at one time the later one counts."""
        if self.times and time <= self.times[-1]:
            self.times.pop()
            self.values.pop()
        self.times.append(time)
        self.values.append(value)

    def at(self, times: Floats) -> list[Any]:
        """Return the newest value at each of these times (n,); before the first one that."""
        places = np.searchsorted(self.times, times + NANO, side="right") - 1
        return [self.values[max(place, 0)] for place in places]


@dataclass(frozen=True, eq=False)
class Episode:
    """A demonstration.

    Attributes:
        robot: whose it is.
        joints: names of its coordinates.
        positions: of these, rad or m: (k,) at each time.
        commanded: the same as it was commanded, of a robot whose joints are measured; else empty.
        poses: of the tool centre point in the world, x, y, z and a quaternion x, y, z, w: (7,) at each time.
        signals: numbers and truth values by the names of signals.
        pictures: (height, width, 3) by the names of cameras, encoded as they were recorded.
    """

    robot: str
    joints: tuple[str, ...]
    positions: Track
    commanded: Track
    poses: Track
    signals: dict[str, Track]
    pictures: dict[str, Track]

    @property
    def begin(self) -> float:
        """Time at which all of it is known, s."""
        known = (self.positions, self.poses, *self.signals.values(), *self.pictures.values())
        return max(track.times[0] for track in known if track.times)

    @property
    def end(self) -> float:
        """Time of the last thing that was told, s."""
        return max(track.times[-1] for track in (self.positions, *self.pictures.values()) if track.times)

    def times(self, fps: float) -> Floats:
        """Return times (n,), s, of frames at a rate, from the begin to the end."""
        return self.begin + np.arange(int((self.end - self.begin) * fps + 1.0 + NANO)) / fps


def topics_of(robot: str) -> list[str]:
    """Return the topics that a demonstration of a robot has."""
    return [*topics.of_robot(robot), f"{SIGNALS}*", f"{SENSORS}*{COLOR}"]


def read_episode(file: Path, robot: str = "") -> Episode:
    """Return the demonstration in an MCAP file, of the robot that it is of, or of one of several.

    Raises:
        MissingFileError: when the file can't be read.
        MalformedFileError: when it is no whole MCAP file.
        InvalidArgumentError: when it has no robot of that name, or several and none is named.
        WrongStateError: without the libraries that read it.
    """
    try:
        from mcap.exceptions import McapError
        from mcap.reader import make_reader
    except ImportError:
        raise WrongStateError("demonstrations are MCAP files: pip install 'virtualrobot[record]'") from None
    try:
        data = file.read_bytes()
    except OSError as error:
        raise MissingFileError(f"{file} cannot be read: {error.strerror or error}") from None
    try:
        messages = [
            (channel.topic, message.log_time * NANO, schema.name if schema else "", message.data)
            for schema, channel, message in make_reader(io.BytesIO(data)).iter_messages()
        ]
    except McapError as error:
        raise MalformedFileError(f"{file} is no whole MCAP file: {error}") from None
    robots = {topic.split("/")[2] for topic, *_ in messages if topic == topics.joint_states(topic.split("/")[2])}
    if robot not in robots and (robot or len(robots) != 1):
        known = ", ".join(sorted(robots)) or "none"
        said = f"{robot!r} is not among them" if robot else "say which one is meant"
        raise InvalidArgumentError(f"{file} has the robots {known}; {said}")
    return _gathered(robot or robots.pop(), messages)


def _gathered(robot: str, messages: list[tuple[str, float, str, bytes]]) -> Episode:
    from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
    from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
    from virtualrobot.v1 import signal_pb2

    joints: tuple[str, ...] = ()
    found = Episode(robot, joints, Track(), Track(), Track(), {}, {})
    for topic, time, schema, data in messages:
        if topic in (topics.joint_states(robot), topics.commanded_joint_states(robot)):
            states = JointStates.FromString(data).joints
            joints = joints or tuple(one.name for one in states)
            track = found.positions if topic == topics.joint_states(robot) else found.commanded
            track.add(time, [one.position for one in states])
        elif topic == topics.tool_center_point(robot):
            pose = PoseInFrame.FromString(data).pose
            p, q = pose.position, pose.orientation
            found.poses.add(time, [p.x, p.y, p.z, q.x, q.y, q.z, q.w])
        elif topic.startswith(SIGNALS):
            value = signal_pb2.Signal.FromString(data).value
            kind = value.WhichOneof("kind")
            if kind in ("boolean", "integer", "number"):
                name = topic.removeprefix(SIGNALS)
                found.signals.setdefault(name, Track()).add(time, float(getattr(value, kind)))
        elif topic.startswith(SENSORS) and topic.endswith(COLOR):
            camera = topic.removeprefix(SENSORS).removesuffix(COLOR)
            found.pictures.setdefault(camera, Track()).add(time, (schema, data))
    return Episode(robot, joints, found.positions, found.commanded, found.poses, found.signals, found.pictures)


def pixels_of(recorded: tuple[str, bytes]) -> NDArray[np.uint8]:
    """Return the pixels (height, width, 3) of a picture as it was recorded."""
    from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
    from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

    schema, data = recorded
    if schema == CompressedImage.DESCRIPTOR.full_name:
        from PIL import Image

        with Image.open(io.BytesIO(CompressedImage.FromString(data).data)) as image:
            return np.asarray(image.convert("RGB"))
    raw = RawImage.FromString(data)
    return np.frombuffer(raw.data, np.uint8).reshape(raw.height, raw.step)[:, : 3 * raw.width].reshape(-1, raw.width, 3)


def files_in(folder: Path) -> Iterator[Path]:
    """Yield the demonstrations of a folder by their numbers."""
    yield from sorted(folder.glob("episode-*.mcap"))


def next_file(folder: Path) -> Path:
    """Return the file of the next demonstration in a folder."""
    last = max((int(one.stem.rpartition("-")[2]) for one in files_in(folder)), default=-1)
    return folder / f"episode-{last + 1:06d}.mcap"
