"""Frames of ROS as poses in a kernel's world."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot._wire.names import did_you_mean

from virtualrobot_apps.bridges.ros.mapping.names import FrameNames


def world_t_frame(client: Client, frame: str, *, bare: bool) -> NDArray[np.float64]:
    """Return where a frame is now, 4x4; no name is the world's; `bare` as in FrameNames.

    Raises:
        ValueError: when there is no such frame.
    """
    if frame in ("", "world"):
        return np.eye(4)
    nodes = client.scene.nodes()
    frames = FrameNames((one.name for one in nodes if one.kind == "robot"), bare=bare)
    found = [one.name for one in nodes if frames(one.name) == frame]
    if not found:
        near = did_you_mean(frame[:100], [frames(one.name) for one in nodes])
        raise ValueError(f"there is no frame {frame[:80]!r}{near}")
    return client.scene.pose(found[0])
