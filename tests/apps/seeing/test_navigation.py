"""Navigation in a real kernel: a UGV explores a furnished floor, and goes to places on its map, lost at first."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.errors import InvalidArgumentError, WrongStateError
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.seeing.navigation import floors, journeys
from virtualrobot_apps.seeing.navigation.command import navigate
from virtualrobot_apps.seeing.navigation.grid import load
from virtualrobot_apps.seeing.navigation.navigator import Goal, Navigator, Observation
from virtualrobot_apps.seeing.navigation.planning import Costmap, Planner, length
from virtualrobot_apps.seeing.navigation.poses import Floats, between, distance, planar
from virtualrobot_apps.seeing.navigation.vehicle import SHARE, Vehicle, sensors_of

from tests.apps.seeing.flat_vehicles import known, room
from tests.apps.seeing.test_exploring import gap

pytestmark = pytest.mark.long
ROBOT = "ugv"
LIDAR = virtualrobot.pose(0.3, 0.0, 0.45)
"""Of a lidar on a Husky's deck."""


@pytest.fixture(scope="module")
def kernel() -> Iterator[KernelProcess]:
    """Return a kernel whose time goes on by steps."""
    with KernelProcess("--stepped", headless=True) as kernel:
        yield kernel


@pytest.fixture
def client(kernel: KernelProcess) -> Iterator[virtualrobot.Client]:
    with virtualrobot.connect(kernel.address) as client:
        yield client


def placed(client: virtualrobot.Client, boxes: list[floors.Box], start: Floats) -> None:
    """Build a floor with a UGV on it."""
    floors.build(client, boxes)
    pose = virtualrobot.pose(start[0], start[1], 0.0, yaw=start[2])
    client.load_robot(f"model://{ROBOT}", name=ROBOT, base="planar", pose=pose)


def true_pose(client: virtualrobot.Client) -> Floats:
    """Return where the base is, for measuring only."""
    return planar(client.scene.pose(f"{ROBOT}.base"))


def test_it_knows_where_it_is_while_it_explores(client: virtualrobot.Client, seed: int) -> None:
    """The lidar has noise of 1.75%, encoders have steps: off by less than 50 mm rms; nothing is touched."""
    placed(client, floors.floor(seed), np.array(floors.START))
    vehicle = Vehicle(client, ROBOT, *sensors_of(client, ROBOT))
    off, clear = [], []

    def watch(pose: Floats) -> None:
        off.append(between(true_pose(client), pose))
        if len(off) % 10 == 0:
            clear.append(client.collisions.distance(ROBOT, to=[floors.NODE]).distance)

    start, told = np.array(floors.START), list[str]()
    explored = journeys.explore(client, vehicle, start, say=told.append, watch=watch, longest=25.0)
    errors = np.array(off)
    assert np.sqrt((errors[:, :2] ** 2).sum(axis=1).mean()) < 0.05 and np.abs(errors[:, 2]).max() < 0.05
    assert min(clear) > 0.0 and len(explored.mapper.poses) > 8
    assert told[-1] == str(explored.unseen[-1]) and told[-1].endswith("unseen: 25 s are over")


def test_it_finds_its_place_and_goes_to_its_goals(client: virtualrobot.Client, seed: int, tmp_path: Path) -> None:
    """On the true map as a file, from a place that it isn't told; ways are at most 1.3 times the shortest."""
    boxes = floors.floor(seed)
    start, *goals = floors.places(boxes, 3, seed, 0.45)
    placed(client, boxes, np.array([*start, 0.5]))
    grid = floors.true_grid(boxes, 0.05)
    vehicle = Vehicle(client, ROBOT, *sensors_of(client, ROBOT))
    track, clear = [], []

    def watch(_: Floats) -> None:
        track.append(true_pose(client)[:2])
        if len(track) % 10 == 0:
            clear.append(client.collisions.distance(ROBOT, to=[floors.NODE]).distance)

    told: list[str] = []
    assert journeys.go(client, vehicle, grid, [Goal(*goals[0])], say=told.append, watch=watch) == [True]
    assert told[-1].startswith("has come to")
    assert distance(true_pose(client), goals[0]) < 0.2 and min(clear) > 0.0
    track.clear()
    here = true_pose(client)
    assert journeys.go(client, vehicle, grid, [Goal(*goals[1])], here, say=told.append, watch=watch) == [True]
    assert distance(true_pose(client), goals[1]) < 0.2 and min(clear) > 0.0
    shortest = Planner(Costmap.of(grid, vehicle.footprint, np.zeros((0, 2)))).way(here, goals[1])
    assert length(np.array(track)) < 1.3 * length(shortest)


def test_the_command_writes_no_map_that_cannot_be(kernel: KernelProcess, tmp_path: Path) -> None:
    """Files of another kind, robots that are not there, and maps that are missing are told in a line."""
    address = ["--address", kernel.address]
    done = CliRunner().invoke(navigate, ["explore", ROBOT, str(tmp_path / "floor.png"), *address])
    assert done.exit_code == 2 and "ends in .yaml, not 'floor.png'" in done.output
    done = CliRunner().invoke(navigate, ["go", ROBOT, str(tmp_path / "none.yaml"), "--to", "1", "0", *address])
    assert done.exit_code and "there is no map" in str(done.exception)
    done = CliRunner().invoke(navigate, ["explore", "nobody", str(tmp_path / "floor.yaml"), *address])
    assert done.exit_code and "there is no robot named 'nobody'" in str(done.exception)


def test_the_command_tells_by_its_exit_code_that_something_is_unseen(
    kernel: KernelProcess, client: virtualrobot.Client, tmp_path: Path
) -> None:
    """Behind a gap of 0.3 m there is more than it can see from before it."""
    file = ["explore", ROBOT, str(tmp_path / "floor.yaml"), "--from", "0.6", "0.6", "0", "--address", kernel.address]
    placed(client, gap(), np.array([0.6, 0.6, 0.0]))
    done = CliRunner().invoke(navigate, file)
    assert done.exit_code == 1 and "leaves an edge of" in done.output and (tmp_path / "floor.yaml").is_file()
    placed(client, room(1.9, 2.0), np.array([0.6, 0.6, 0.0]))
    done = CliRunner().invoke(navigate, file)
    assert done.exit_code == 0 and "unseen" not in done.output, done.output


def test_there_is_no_map_where_nothing_stands(client: virtualrobot.Client) -> None:
    """Scans come and have no echo: that is told, and not that none comes."""
    placed(client, [], np.array(floors.START))
    client.scene.remove(floors.NODE)
    vehicle = Vehicle(client, ROBOT, *sensors_of(client, ROBOT))
    with pytest.raises(WrongStateError, match="hardly an echo"):
        journeys.explore(client, vehicle, np.array(floors.START))


def test_the_command_goes_nowhere_by_a_blind_lidar(
    kernel: KernelProcess, client: virtualrobot.Client, tmp_path: Path
) -> None:
    """No ray has an echo: it says so by the lidar's name, and stays where it stood, known or not."""
    walls, start = room(4.0, 3.0), np.array([1.0, 1.0, 0.0])
    known(walls, 4.0, 3.0).save(tmp_path / "floor.yaml")
    placed(client, walls, start)
    client.sensors[f"{ROBOT}.lidar"].set_model("laser", {"dropout_rate": 1.0})
    before = true_pose(client)
    file = ["go", ROBOT, str(tmp_path / "floor.yaml"), "--to", "3", "2", "--address", kernel.address]
    for begin, mapped in ((["--from", "1", "1", "0"], " though the map has walls in its reach"), ([], "")):
        done = CliRunner().invoke(navigate, [*file, *begin])
        words = f"the scans of 'ugv.lidar' have hardly an echo{mapped}"
        assert done.exit_code == 1 and done.output == f"stands: {words}\ngives up: {words}, for 10 s\n"
        assert distance(true_pose(client), before) < 1e-6


def test_an_interrupt_writes_the_map_so_far(
    kernel: KernelProcess, client: virtualrobot.Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    placed(client, room(4.0, 3.0), np.array([1.0, 1.0, 0.0]))
    file, step = tmp_path / "floor.yaml", Navigator.step

    def interrupted(navigator: Navigator, seen: Observation) -> tuple[float, float]:
        if navigator.goal is not None:
            raise KeyboardInterrupt
        return step(navigator, seen)

    monkeypatch.setattr(Navigator, "step", interrupted)
    done = CliRunner().invoke(navigate, ["explore", ROBOT, str(file), "--address", kernel.address])
    assert done.exit_code == 130 and "interrupted: writes the map so far" in done.output, done.output
    assert f"{file}: " in done.output and load(file).occupied.any()


def test_an_imu_is_no_encoder(client: virtualrobot.Client) -> None:
    placed(client, room(4.0, 3.0), np.array(floors.START))
    with pytest.raises(InvalidArgumentError, match=r"'ugv.imu' tells no joints, .*; encoders are 'ugv.encoders'"):
        Vehicle(client, ROBOT, f"{ROBOT}.lidar", f"{ROBOT}.imu")


def test_a_sonar_is_no_lidar(client: virtualrobot.Client) -> None:
    placed(client, [], np.array(floors.START))
    with pytest.raises(InvalidArgumentError, match=r"'ugv.sonar_front' has 1 x 1 rays: a lidar that looks around"):
        Vehicle(client, ROBOT, "ugv.sonar_front", sensors_of(client, ROBOT)[1])


def test_twists_are_as_slow_as_the_drives_of_a_vehicle(client: virtualrobot.Client) -> None:
    """By the sizes and the slip of a Husky a wheel turns by (v + omega slip track / 2) / radius; the arc stays."""
    floors.build(client, floors.floor(1))
    husky = client.load_robot("model://husky", name="husky", base="planar", pose=virtualrobot.pose(*floors.START[:2]))
    base = "husky.base_footprint"
    client.scene.add_range_sensor("husky.lidar", virtualrobot.range_sensor("LDS-01"), parent=base, pose=LIDAR)
    client.scene.add_motion_sensor("husky.encoders", virtualrobot.encoders(), parent="husky")
    vehicle = Vehicle(client, "husky", *sensors_of(client, "husky"))
    assert vehicle.drivable(0.2, 0.0) == (0.2, 0.0)
    v, w = vehicle.drivable(0.5, -1.0)
    assert w / v == pytest.approx(-2.0)
    wheel = (v + abs(w) * 1.875 * 0.5708 / 2.0) / 0.17775
    assert wheel == pytest.approx(SHARE * husky.limits["front_left_wheel"].velocity)
