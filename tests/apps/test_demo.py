"""The demo does what it shows: boxes where the pattern puts them, nothing inside anything, limits kept."""

from __future__ import annotations

import inspect
import re
from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_apps.demos.palletizing import palletize

from tests.apps.boxes import penetration
from tests.apps.demo_run import Record, watched_run

pytestmark = pytest.mark.long

LAYERS = 3
COUNT = 6 * LAYERS
SIZES = {"iiwa": (0.155, 0.10, 0.11), "panda": (0.105, 0.06, 0.07)}
GAPS = {"iiwa": 0.01, "panda": 0.03}
PALLETS = {
    "iiwa": (1.25, 0.62, 0.36),
    "panda": (-1.25, 0.62, 0.36),
}  # of the scene file; both are turned by 180 degrees

# Degrees a second. Sources: KUKA, LBR iiwa 7 R800 data sheet; Franka Emika, FCI documentation (2.175 and 2.61 rad/s).
SPEEDS = {"iiwa": [98, 98, 100, 130, 140, 180, 180], "panda": [124.62] * 4 + [149.55] * 3}


@pytest.fixture(scope="module")
def record() -> Record:
    """Return what was seen of one run."""
    return watched_run(LAYERS)


def place_of(robot: str, number: int) -> tuple[np.ndarray, float]:
    """Return middle (3,) and angle of the box `number` (from 0) in the world, by the formula of the pattern."""
    length, width, height = SIZES[robot]
    layer, in_layer = divmod(number, 6)
    column, row = divmod(in_layer, 3)
    x, y = (column - 0.5) * (length + GAPS[robot]), (row - 1.0) * (width + GAPS[robot])
    if layer % 2:
        x, y = -y, x  # turned by 90 degrees
    middle = np.add(PALLETS[robot], (-x, -y, (layer + 0.5) * height))
    return middle, np.pi + layer % 2 * np.pi / 2


@pytest.mark.parametrize("robot", SIZES)
def test_every_box_is_where_the_pattern_says(record: Record, robot: str) -> None:
    for number in range(COUNT):
        name = f"{robot}-box-{number + 1}"
        middle, angle = place_of(robot, number)
        pose = record.poses[name]
        assert np.linalg.norm(pose[:3, 3] - middle) < 1e-3, name
        turned = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        cosine = (np.trace(turned.T @ pose[:3, :3]) - 1) / 2
        assert np.arccos(np.clip(cosine, -1, 1)) < np.radians(0.2), name
        assert record.nodes[name].parent == f"pallet-{robot}"


def test_each_arm_did_its_share_and_no_box_is_left(record: Record) -> None:
    parents = [node.parent for node in record.nodes.values() if node.WhichOneof("kind") == "part"]
    assert sorted(parents) == ["pallet-iiwa"] * COUNT + ["pallet-panda"] * COUNT


def test_no_two_boxes_are_inside_each_other(record: Record) -> None:
    names = [name for name in record.poses if "-box-" in name]
    poses = np.array([record.poses[name] for name in names])
    sizes = np.array([SIZES[name.split("-")[0]] for name in names])
    assert len(names) == 2 * COUNT
    for i, name in enumerate(names[:-1]):
        depth = penetration(poses[i], sizes[i], poses[i + 1 :], sizes[i + 1 :])
        assert depth.max() < 1e-4, (name, names[i + 1 + int(depth.argmax())], depth.max())


def test_no_box_passes_through_another_or_the_cell_on_its_way(record: Record) -> None:
    cell = [
        (record.poses[node.name] @ pose_of(figure), (figure.box.size.x, figure.box.size.y, figure.box.size.z))
        for node in record.nodes.values()
        if node.WhichOneof("kind") == "object"
        for figure in node.figures
        if figure.HasField("box")
    ]
    here: dict[str, np.ndarray] = {}
    checked = 0
    for moved in record.moved:
        boxes = {name: pose for name, pose in moved.items() if "-box-" in name}
        here |= boxes
        for name, pose in boxes.items():
            size = SIZES[name.split("-")[0]]
            others = [(where, SIZES[other.split("-")[0]]) for other, where in here.items() if other != name]
            poses, sizes = zip(*(cell + others), strict=True)
            depth = penetration(pose, np.array(size), np.array(poses), np.array(sizes))
            assert depth.max() < 5e-4, (name, pose, depth.max(), poses[int(depth.argmax())])
            checked += 1
    assert checked > 20 * COUNT


def pose_of(figure) -> np.ndarray:  # noqa: ANN001 a message
    """Return `node_t_figure` of a box that is not turned."""
    pose = np.eye(4)
    position = figure.node_t_figure.position
    pose[:3, 3] = position.x, position.y, position.z
    assert not figure.node_t_figure.HasField("orientation")
    return pose


@pytest.mark.parametrize("robot", SPEEDS)
def test_the_arms_keep_their_limits(record: Record, robot: str) -> None:
    limits = list(record.limits[robot].values())
    speeds = np.array([limit.velocity for limit in limits])
    np.testing.assert_allclose(speeds[:7], np.radians(SPEEDS[robot]), rtol=1e-4)
    lower, upper = np.array([limit.lower for limit in limits]), np.array([limit.upper for limit in limits])
    states = record.states[robot]
    assert len(states) > 300
    fastest = np.max([np.abs(state.velocities) for state in states], axis=0)
    assert (fastest <= speeds * (1 + 1e-6)).all(), fastest / speeds
    assert (fastest / speeds).max() > 0.6, "the arm is moved so slowly that limits do not matter"
    for state in states:
        assert (state.positions >= lower - 1e-9).all() and (state.positions <= upper + 1e-9).all()
    # The velocities are told honestly: no joint goes farther than its limit allows from one state to the next.
    for before, after in pairwise(states):
        seconds = after.stamp.simulation_time - before.stamp.simulation_time
        assert (np.abs(after.positions - before.positions) <= speeds * seconds + 1e-9).all()


def test_the_arms_work_at_the_same_time(record: Record) -> None:
    """In turns they would never; how often they do at this speed depends on how soon calls are answered."""
    moving = {
        robot: {state.stamp.tick for state in record.states[robot] if np.abs(state.velocities).max() > 0.01}
        for robot in SPEEDS
    }
    both = moving["iiwa"] & moving["panda"]
    assert len(both) > 5


def test_signals_tell_of_the_hand_over(record: Record) -> None:
    values: dict[str, bool] = {}
    rises: dict[str, int] = {}
    for tick, changed in record.signals:
        for name, value in changed.items():
            rises[name] = rises.get(name, 0) + (value and not values.get(name, False))
        values |= changed
        if values.get("conveyor_running"):
            assert not (values["box_at_iiwa"] or values["box_at_panda"]), f"tick {tick}: the belt moves a waiting box"
        for robot in SIZES:
            if values.get(f"pallet_full_{robot}"):
                assert rises[f"box_at_{robot}"] == COUNT, f"tick {tick}: {robot} says full too early"
    moves = COUNT + 3  # the last large box reaches the iiwa after four moves
    assert rises == {
        "conveyor_running": moves,
        "box_at_iiwa": COUNT,
        "box_at_panda": COUNT,
        "pallet_full_iiwa": 1,
        "pallet_full_panda": 1,
    }
    assert values == {name: name.startswith("pallet_full") for name in values}


def test_it_prints_each_box_and_a_table(record: Record) -> None:
    boxes = re.findall(rf"^box +(\d+) of {2 * COUNT}: (iiwa|panda) +([\d.]+) s$", record.text, re.MULTILINE)
    assert [int(number) for number, _, _ in boxes] == list(range(1, 2 * COUNT + 1))
    for robot in SIZES:
        times = [float(seconds) for _, name, seconds in boxes if name == robot]
        row = re.search(rf"^{robot} +(\d+) +([\d.]+) +([\d.]+) +([\d.]+)$", record.text, re.MULTILINE)
        assert row is not None and int(row[1]) == COUNT == len(times)
        told, right = [float(row[i]) for i in (2, 3, 4)], [sum(times) / COUNT, min(times), max(times)]
        assert np.abs(np.subtract(told, right)).max() < 0.011, "the table and the lines differ by more than rounding"
    assert re.search(rf"^total +{2 * COUNT} in [\d.]+ s of simulation time$", record.text, re.MULTILINE)


def test_the_program_is_short() -> None:
    assert len(inspect.getsource(palletize).splitlines()) < 150
