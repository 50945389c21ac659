"""World of tests of physics: a floor, and where what falls onto it is."""

from __future__ import annotations

import numpy as np
import virtualrobot
from virtualrobot import Client


def floor(client: Client, **surface: float) -> None:
    """Put a floor whose top is at the height 0, with this surface."""
    figure = virtualrobot.box(10.0, 10.0, 1.0).with_surface(**surface)
    client.scene.add_object("floor", figure, pose=virtualrobot.pose(0.0, 0.0, -0.5))


def place(client: Client, name: str) -> np.ndarray:
    """Return where a node is in the world, (3,) in m."""
    return np.asarray(client.scene.pose(name))[:3, 3]
