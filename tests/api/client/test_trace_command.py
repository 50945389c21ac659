"""`virtualrobot trace`: ways of tools and parts, kept as lines."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot

from tests.api.client.conftest import Run


def segments(client: Client, name: str) -> np.ndarray:
    """Return the lines (n, 2, 3) that a node is."""
    (figure,) = client.scene.node(name).figures
    return np.frombuffer(figure._message.lines.segments.data, "<f4").reshape(-1, 2, 3)


@pytest.mark.long
def test_ways_are_kept_as_lines(run: Run, client: Client, iiwa: Robot) -> None:
    """A joint that turns leads the tool along an arc about its axis, to where the tool is then."""
    client.scene.add_object("stone", pose=virtualrobot.pose(2.0))
    iiwa.set_positions([0.0, 0.6, 0.0, -1.2, 0.0, 0.8, 0.0])
    radius = float(np.hypot(*iiwa.tcp[:2, 3]))
    client.speed_factor = 0.2
    iiwa.start(iiwa.ptp({iiwa.joint_names[0]: 1.0}))
    told = run("trace", "iiwa", "stone", "--seconds", "5")
    lines = segments(client, "trace of iiwa")
    lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    assert told == f"trace of iiwa: {lengths.sum():.3f} m\nstone has not moved\n"
    assert lengths.sum() > 0.1 and (lengths >= 0.002 - 1e-6).all()
    np.testing.assert_allclose(np.hypot(*lines[:, :, :2].reshape(-1, 2).T), radius, atol=2e-4)
    np.testing.assert_allclose(lines[1:, 0], lines[:-1, 1], atol=1e-6)
    assert np.linalg.norm(lines[-1, 1] - iiwa.tcp[:3, 3]) < 0.002 + 1e-6
    client.history.undo()
    assert "trace of iiwa" not in client.scene
