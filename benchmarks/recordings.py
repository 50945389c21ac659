"""Cost of recording a tick at the client: 160 transforms that all move, from the kernel's message to an MCAP file.

Compared with foxglove-sdk, which is written in Rust, told the same transforms, and with the bare writer, given bytes.
"""

from __future__ import annotations

import io
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import foxglove  # pyright: ignore[reportMissingImports] only the extra `bench` has it
import numpy as np
from foxglove.channels import FrameTransformsChannel  # pyright: ignore[reportMissingImports]
from foxglove.messages import (  # pyright: ignore[reportMissingImports]
    FrameTransform,
    FrameTransforms,
    Quaternion,
    Timestamp,
    Vector3,
)
from mcap.writer import Writer
from numpy.typing import NDArray
from virtualrobot._wire.messages import array_message
from virtualrobot.recording.mcap_file import McapFile
from virtualrobot.recording.stamps import nanoseconds, time_of
from virtualrobot.recording.transforms import Transforms
from virtualrobot.v1 import geometry_pb2, nodes_pb2, scene_pb2

from benchmarks.rows import Row, row

ARMS, LINKS = 20, 8
TICKS, ROUNDS = 500, 5


def run() -> list[Row]:
    """Measure; each number is the best of some rounds, since other work of the machine only adds."""
    changes, rows = moving()
    ours = best(lambda: recorded(changes))
    sdk = best(lambda: by_sdk(rows))
    bare = best(bare_writer(changes))
    note = f"{ARMS * LINKS} transforms, all move"
    return [
        row("recorded tick", ours, sdk, "foxglove-sdk", "us", 1.0, note),
        row("recorded tick", ours, bare, "mcap's writer, bytes given", "us", None, note),
    ]


def best(measure: Callable[[], float]) -> float:
    """Return the least of some rounds, in microseconds a tick."""
    return min(measure() for _ in range(ROUNDS)) / TICKS * 1e6


def moving() -> tuple[list[scene_pb2.WatchSceneResponse], NDArray[np.float64]]:
    """Return what a watch tells of arms whose links all move, and where these are: (ticks, links, 7)."""
    count = ARMS * LINKS
    angles = np.arange(TICKS)[:, None] * 1e-3 * (1 + np.arange(count) % LINKS) + np.arange(count) * 0.01
    rows = np.zeros((TICKS, count, 7))
    rows[..., 0], rows[..., 1], rows[..., 2] = np.cos(angles), np.sin(angles), np.arange(count) * 0.1
    rows[..., 5], rows[..., 6] = np.sin(angles / 2.0), np.cos(angles / 2.0)
    nodes = [nodes_pb2.Node(uid=1, name="world")]
    for number in range(count):
        arm, link = divmod(number, LINKS)
        parent = f"arm{arm}.link_{link - 1}" if link else "world"
        nodes.append(nodes_pb2.Node(uid=number + 2, name=f"arm{arm}.link_{link}", parent=parent))
    world = np.concatenate([np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (TICKS, 1, 1)), rows], axis=1)
    changes = []
    for tick in range(TICKS):
        first = 1 if tick else 0
        changes.append(
            scene_pb2.WatchSceneResponse(
                stamp=geometry_pb2.Stamp(tick=tick, tick_nanoseconds=4_000_000),
                nodes=() if tick else nodes,
                moved_uids=range(first + 1, count + 2),
                world_t_node=array_message(world[tick, first:]),
            )
        )
    return changes, rows


def recorded(changes: list[scene_pb2.WatchSceneResponse]) -> float:
    """Return how long recording all changes takes."""
    file, transforms = McapFile(io.BytesIO(), {}), Transforms()
    start = time.perf_counter()
    for change in changes:
        for topic, message in transforms.update(change, time_of(change.stamp)):
            file.write(topic, message, nanoseconds(change.stamp))
    file.close()
    return time.perf_counter() - start


def by_sdk(rows: NDArray[np.float64]) -> float:
    """Return how long foxglove-sdk takes."""
    with tempfile.TemporaryDirectory() as folder, foxglove.open_mcap(Path(folder) / "run.mcap"):
        channel = FrameTransformsChannel(f"/transforms/{time.monotonic_ns()}")
        start = time.perf_counter()
        for tick, poses in enumerate(rows.tolist()):
            stamp = Timestamp(0, 1000 * tick)
            channel.log(
                FrameTransforms(
                    transforms=[
                        FrameTransform(
                            timestamp=stamp,
                            parent_frame_id="world",
                            child_frame_id=f"arm{number // LINKS}.link_{number % LINKS}",
                            translation=Vector3(x=x, y=y, z=z),
                            rotation=Quaternion(x=qx, y=qy, z=qz, w=qw),
                        )
                        for number, (x, y, z, qx, qy, qz, qw) in enumerate(poses)
                    ]
                )
            )
        seconds = time.perf_counter() - start
        channel.close()
    return seconds


def bare_writer(changes: list[scene_pb2.WatchSceneResponse]) -> Callable[[], float]:
    """Return what measures how long the writer takes for the same bytes, made before."""
    transforms = Transforms()
    messages = [
        [message.SerializeToString() for _, message in transforms.update(change, time_of(change.stamp))]
        for change in changes
    ]

    def measure() -> float:
        writer = Writer(io.BytesIO())
        writer.start()
        channel = writer.register_channel("/transforms", "protobuf", 0)
        start = time.perf_counter()
        for tick, parts in enumerate(messages):
            for part in parts:
                writer.add_message(channel, tick, part, tick)
        writer.finish()
        return time.perf_counter() - start

    return measure
