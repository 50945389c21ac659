"""`virtualrobot view`: sides and points from which the viewer, pictures and films look."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client

from tests.api.client.conftest import Run


def test_views_are_told_and_set(run: Run, client: Client) -> None:
    assert run("view") == "the world is framed\n"
    client.scene.add_object("table", pose=virtualrobot.pose(1.0, 2.0, 0.5))

    # From a side of the world's frame, so far away; what isn't said stays.
    assert run("view", "top", "--at", "table", "--distance", "2") == (
        "from 1.0000 2.0000 2.5000 at 1.0000 2.0000 0.5000\n"
    )
    assert run("view", "front") == "from 1.0000 0.0000 0.5000 at 1.0000 2.0000 0.5000\n"
    run("view", "--at", "table:0,0,0.5")
    now = client.view.read()
    np.testing.assert_allclose(now.camera_target, [1.0, 2.0, 1.0])
    np.testing.assert_allclose(now.camera_position - now.camera_target, [0.0, -2.0, 0.0], atol=1e-12)

    # From a point, with the field of view as it was.
    client.view.set_camera([3, 0, 0], field_of_view=0.4)
    assert run("view", "--from", "0,-5,1") == "from 0.0000 -5.0000 1.0000 at 0.0000 0.0000 0.0000\n"
    assert client.view.read().field_of_view == pytest.approx(0.4)
    assert run("view") == "from 0.0000 -5.0000 1.0000 at 0.0000 0.0000 0.0000\n"


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("above",), 2, "'above'"),
        (("top", "--from", "1,2,3"), 2, "--from says all"),
        (("--distance", "0"), 2, "0"),
        (("--from", "1,2"), 2, "3 are wanted"),
        (("--from", "0,0,0", "--at", "world"), 1, "at its own target"),
        (("top", "--at", "nobody"), 1, "nobody"),
    ],
)
def test_what_is_no_view_changes_nothing(
    run: Run, client: Client, arguments: tuple[str, ...], code: int, words: str
) -> None:
    client.view.set_camera([3, 0, 0])
    before = client.view.read()
    assert words in run("view", *arguments, code=code)
    after = client.view.read()
    np.testing.assert_array_equal(before.camera_position, after.camera_position)
    np.testing.assert_array_equal(before.camera_target, after.camera_target)
