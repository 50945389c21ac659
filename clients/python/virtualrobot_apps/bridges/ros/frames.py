"""Frames of ROS as poses in a kernel's world."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client

from virtualrobot_apps.bridges.ros.mapping.names import FrameNames


def world_t_frame(client: Client, frame: str, *, bare: bool) -> NDArray[np.float64] | None:
    """Return where a frame is now, 4x4; no name is the world's. None where there is no such frame; `bare` as there."""
    if frame in ("", "world"):
        return np.eye(4)
    nodes = client.scene.nodes()
    frames = FrameNames((one.name for one in nodes if one.kind == "robot"), bare=bare)
    found = [one.name for one in nodes if frames(one.name) == frame]
    return client.scene.pose(found[0]) if found else None
