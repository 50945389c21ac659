"""The bridge to ROS by DDS: joints at 500 ticks a second, and pictures, beside a bare writer of Cyclone DDS.

A message counts when this process, which is another one than the bridge, has decoded it. The bare writer sends the same
bytes as often; what a bare bridge takes to hear the kernel is told in `ros` and `ros_loads`.
"""

from __future__ import annotations

import os
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import virtualrobot
from cyclonedds.domain import DomainParticipant
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from virtualrobot_apps.bridges.ros.dds.types import Heard, hashed, idl_type, quality
from virtualrobot_apps.bridges.ros.messages.types import STORE

from benchmarks.processes import kernel, process
from benchmarks.ros import core
from benchmarks.ros_loads import HEIGHT, HERTZ, PICTURES, TICKS, WARM, WARM_PICTURES, WIDTH, later_than, own_arrivals
from benchmarks.rows import Row, row

DOMAIN = 71
JOINTS, IMAGE = "sensor_msgs/msg/JointState", "sensor_msgs/msg/Image"
LOOPBACK = (
    '<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="lo"/></Interfaces>'
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    '<Peers><Peer Address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>'
)
SECONDS = 120.0

BARE = """
import sys, time
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from virtualrobot_apps.bridges.ros.dds.types import hashed, idl_type, quality

name, type, file, period = sys.argv[1:5]
data, made = open(file, "rb").read(), idl_type(type, raw=True)
participant = DomainParticipant(int(sys.argv[5]))
writer = DataWriter(participant, Topic(participant, name, made), qos=quality(latched=False, depth=100) + hashed(type))
print("writing", flush=True)
due = time.monotonic()
while True:
    writer.write(made(data))
    due += float(period)
    time.sleep(max(0.0, due - time.monotonic()))
"""


class Arrivals:
    """Messages of a topic as they come: when, by their stamps (ns), and the last one's bytes."""

    def __init__(self, participant: DomainParticipant, name: str, type: str) -> None:
        """Read from now on."""
        self.came: dict[int, float] = {}
        self.data, self.count, self._type = b"", 0, type
        self._changed = threading.Condition()
        self._listener = Heard(self._hear)
        place = Topic(participant, name, idl_type(type, raw=True))
        self._reader = DataReader(
            participant, place, qos=quality(latched=False, depth=100) + hashed(type), listener=self._listener
        )

    def _hear(self, cdr: bytes, _: int) -> None:
        stamp: Any = STORE.deserialize_cdr(cdr, self._type).header.stamp  # pyright: ignore[reportAttributeAccessIssue]
        with self._changed:
            self.came[stamp.sec * 1_000_000_000 + stamp.nanosec] = time.perf_counter()
            self.data, self.count = cdr, self.count + 1
            self._changed.notify_all()

    def milliseconds(self, pid: int, count: int, warm: int) -> float:
        """Return what a process takes of a core for each of so many messages (ms), after the first ones."""
        with self._changed:
            assert self._changed.wait_for(lambda: self.count >= warm, SECONDS), "no messages come"
            spent, begin = core(pid), self.count
            assert self._changed.wait_for(lambda: self.count >= begin + count, SECONDS), "no more messages come"
            return 1e3 * (core(pid) - spent) / (self.count - begin)


def measured(
    client: virtualrobot.Client,
    domain: int,
    topic: str,
    type: str,
    stream: str,
    count: int,
    warm: int,
    name: str,
    budget: float,
) -> list[Row]:
    """Measure one topic of a bridge in a domain, and then a bare writer of the same bytes."""
    participant = DomainParticipant(domain)
    command = [str(Path(sys.executable).with_name("virtualrobot")), "--address", client.address, "ros", "--port", "0"]
    with (
        process([*command, "--dds", "--domain", str(domain)], "DDS domain") as (_, bridge),
        own_arrivals(client, stream) as own,
    ):
        ours = Arrivals(participant, f"rt{topic}", type)
        spent = ours.milliseconds(bridge.pid, count, warm)
    later = later_than(own, ours.came)
    seconds = float(np.mean(np.diff(sorted(ours.came.values()))[warm:]))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "message"
        file.write_bytes(ours.data)
        command = [sys.executable, "-c", BARE, "rt/bare", type, str(file), str(seconds), str(domain)]
        with process(command, "writing") as (_, bare):
            others = Arrivals(participant, "rt/bare", type)
            sending = others.milliseconds(bare.pid, count, warm)
    peer, unit = "Cyclone DDS, the same bytes", "ms of a core"
    period = 1e3 * seconds
    return [
        row(f"{name}: later than by the kernel's client", float(np.median(later)), period, "a period", "ms, p50", None),
        row(f"{name}: the bridge, with what it hears of the kernel, a message", spent, sending, peer, unit, budget),
    ]


def run() -> list[Row]:
    """Measure both."""
    os.environ["CYCLONEDDS_URI"] = LOOPBACK
    with kernel("--headless", "--tick-milliseconds", "2") as (address, _), virtualrobot.connect(address) as client:
        arm = client.load_robot("model://kr6_r700", name="arm")
        settings = virtualrobot.camera(WIDTH, HEIGHT, rate=HERTZ)
        client.scene.add_camera("eye", settings, pose=virtualrobot.looking_at([2, 0, 1], [0, 0, 0.5]))
        arm.move_joints({"joint_a1": 2.0}, speed_factor=0.01, wait=False)  # for longer than this takes
        joints = ("/arm/joint_states", JOINTS, "/robots/arm/joint_states", TICKS, WARM, "joints at 500 Hz by DDS", 1.1)
        rows = measured(client, DOMAIN, *joints)
        arm.stop()
        name = f"pictures of {WIDTH}x{HEIGHT} by DDS"
        pictures = ("/eye/image_raw", IMAGE, "/sensors/eye/color", PICTURES, WARM_PICTURES, name, 1.3)
        return [*rows, *measured(client, DOMAIN + 1, *pictures)]
