"""`virtualrobot trace`: ways of tools and parts, kept as lines."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot

from tests.api.client.conftest import Run
from tests.api.reading import values


def segments(client: Client, name: str) -> np.ndarray:
    """Return the lines (n, 2, 3) that a node is."""
    (figure,) = client.scene.node(name).figures
    return values(figure._message.lines.segments)


@pytest.mark.long
def test_ways_are_kept_as_lines(run: Run, client: Client, iiwa: Robot) -> None:
    """A joint that turns leads the tool along an arc about its axis."""
    client.scene.add_object("stone", pose=virtualrobot.pose(2.0))
    iiwa.set_positions([0.0, 0.6, 0.0, -1.2, 0.0, 0.8, 0.0])
    radius = float(np.hypot(*iiwa.tcp[:2, 3]))
    client.speed_factor = 0.04  # 11 s to 1 rad
    motion = iiwa.start(iiwa.ptp({iiwa.joint_names[0]: 1.0}), wait=False)
    told = run("trace", "iiwa", "stone", "--seconds", "3")
    motion.cancel()
    lines = segments(client, "trace of iiwa")
    lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    assert told == f"trace of iiwa: {lengths.sum():.3f} m\nstone has not moved\n"
    assert lengths.sum() > 0.02 and (lengths >= 0.002 - 1e-6).all()
    np.testing.assert_allclose(np.hypot(*lines[:, :, :2].reshape(-1, 2).T), radius, atol=2e-4)
    np.testing.assert_allclose(lines[1:, 0], lines[:-1, 1], atol=1e-6)
    client.history.undo()
    assert "trace of iiwa" not in client.scene
