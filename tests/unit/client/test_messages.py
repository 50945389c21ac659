"""Arrays, poses, colours and figures as messages and back."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import virtualrobot
from virtualrobot._wire import messages as wire
from virtualrobot.motions import moves
from virtualrobot.scene import figures
from virtualrobot.tables import scene_tree
from virtualrobot.v1 import geometry_pb2, nodes_pb2


@pytest.mark.parametrize("dtype", ["<f8", "<f4", "<i4", "u1"])
def test_arrays_come_back(rng: np.random.Generator, dtype: str) -> None:
    for shape in [(5,), (3, 4), (2, 3, 4), (0, 3)]:
        array = rng.integers(0, 255, shape).astype(dtype)
        again = wire.array_of(wire.array_message(array, dtype))
        assert again.dtype == array.dtype
        np.testing.assert_array_equal(again, array)
    # A transposed view is stored in C order all the same.
    matrix = np.arange(12.0).reshape(3, 4).T
    np.testing.assert_array_equal(wire.array_of(wire.array_message(matrix)), matrix)
    assert wire.array_of(geometry_pb2.NumericArray()).size == 0


def test_poses_come_back(rng: np.random.Generator) -> None:
    matrix = virtualrobot.pose(*rng.uniform(-3, 3, 6))
    np.testing.assert_allclose(wire.pose_of(wire.pose_message(matrix)), matrix, atol=1e-12)
    np.testing.assert_array_equal(wire.pose_of(geometry_pb2.Pose()), np.eye(4))


def test_colors() -> None:
    assert wire.color_message("#ff0080") == geometry_pb2.Color(red=1.0, green=0.0, blue=128 / 255)
    assert wire.color_message((0.25, 0.5, 1.0, 0.5)) == geometry_pb2.Color(red=0.25, green=0.5, blue=1.0, alpha=0.5)
    assert wire.color_message("White") == geometry_pb2.Color(red=1, green=1, blue=1)
    for bad in ("mauve", "ff0000", "#ff00", "#gggggg", (1, 2, 3), (1, 1), (np.nan, 0, 0)):
        with pytest.raises(virtualrobot.InvalidArgumentError, match="colour"):
            wire.color_message(bad)


def test_settings_come_back(tmp_path: Path) -> None:
    settings = {
        "gain": 0.5,
        "count": 3,
        "method": "newton",
        "on": True,
        "none": None,
        "weights": [1, 2.5, [True]],
        "arguments": {"prefix": "left_", "inner": {}},
    }
    assert wire.settings_of(wire.settings_message(settings)) == settings
    given = {"a": np.array([[1.0, 2.0]]), "b": np.float32(0.5), "c": np.bool_(True), "d": (1,), "e": tmp_path}
    assert wire.settings_of(wire.settings_message(given)) == {
        "a": [[1, 2]],
        "b": 0.5,
        "c": True,
        "d": [1],
        "e": str(tmp_path),
    }


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"gain": np.nan}, "'gain' is nan"),
        ({"a": {"b": [1, math.inf]}}, r"'a\.b\[1\]' is inf"),
        ({"when": {1, 2}}, r"'when' is \{1, 2\}; it must be a finite number, text"),
        ([1], r"settings are a dictionary, not \[1\]"),
    ],
)
def test_settings_that_are_none_are_refused(settings: Any, message: str) -> None:  # noqa: ANN401 what it must not be
    with pytest.raises(virtualrobot.InvalidArgumentError, match=message):
        wire.settings_message(settings)


def test_figures() -> None:
    box = virtualrobot.box(1, 2, 3, color="red", pose=virtualrobot.pose(z=1.5), roles=["visual"])._message
    assert (box.box.size.x, box.box.size.y, box.box.size.z) == (1, 2, 3)
    assert box.node_t_figure.position.z == 1.5
    assert list(box.roles) == [nodes_pb2.FIGURE_ROLE_VISUAL]
    path = figures.lines([[0, 0, 0], [1, 0, 0], [1, 1, 0]])._message
    np.testing.assert_array_equal(wire.array_of(path.lines.segments), [[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [1, 1, 0]]])
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"\(n, 3\)"):
        figures.points([1, 2, 3])
    with pytest.raises(virtualrobot.InvalidArgumentError, match="colours have the shape"):
        figures.points(np.zeros((2, 3)), colors=np.full((2, 3), 256))
    with pytest.raises(virtualrobot.InvalidArgumentError, match="'visible' is no role"):
        virtualrobot.sphere(1, roles=["visible"])
    with pytest.raises(virtualrobot.InvalidArgumentError, match="the size of a box"):
        virtualrobot.box(1, np.nan, 1)


def test_a_trajectory_of_another_shape_is_refused() -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"\(3, 2\), not \(3, 1\)"):
        moves.trajectory(["a", "b"], [0, 1, 2], np.zeros((3, 1)), None, {})
    with pytest.raises(virtualrobot.InvalidArgumentError, match="velocities"):
        moves.trajectory(["a"], [0, 1], np.zeros((2, 1)), np.zeros((3, 1)), {})


@pytest.mark.parametrize("name", ["velocity", "acceleration"])
def test_none_is_the_default_and_0_is_none(name: str) -> None:
    default = moves.linear(np.eye(4), None, {name: None})  # pyright: ignore[reportArgumentType]
    assert default == moves.linear(np.eye(4), None, {})
    assert (default.max_velocity_meters_per_second, default.goal.reference) == (0.0, "world")
    with pytest.raises(virtualrobot.InvalidArgumentError, match=f"{name} is 0.0; it must not be 0, and None means"):
        moves.linear(np.eye(4), None, {name: 0.0})  # pyright: ignore[reportArgumentType]


def test_the_tree_is_drawn_with_kinds() -> None:
    nodes = [
        nodes_pb2.Node(name="world", world=nodes_pb2.World()),
        nodes_pb2.Node(name="arm", parent="world", robot=nodes_pb2.Robot()),
        nodes_pb2.Node(name="arm.base", parent="arm", link=nodes_pb2.Link()),
        nodes_pb2.Node(name="arm.tip", parent="arm.base", link=nodes_pb2.Link()),
        nodes_pb2.Node(name="hand", parent="arm.tip", tool=nodes_pb2.Tool()),
        nodes_pb2.Node(name="box", parent="hand", part=nodes_pb2.Part()),
        nodes_pb2.Node(name="table", parent="world", hidden=True, object=nodes_pb2.SceneObject()),
    ]
    assert scene_tree(nodes) == (
        "world (world)\n"
        "├─ arm (robot)\n"
        "│  └─ arm.base (link)\n"
        "│     └─ arm.tip (link)\n"
        "│        └─ hand (tool)\n"
        "│           └─ box (part)\n"
        "└─ table (object, hidden)"
    )
    assert scene_tree(nodes, links=False) == (
        "world (world)\n├─ arm (robot)\n│  └─ hand (tool)\n│     └─ box (part)\n└─ table (object, hidden)"
    )
