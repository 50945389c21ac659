"""Reach and placements of studies: bare EAIK and FCL, and the annulus in which a UR5e works with its tool down."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from eaik.IK_DH import DhRobot
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError
from virtualrobot_apps.studies import placement, worlds
from virtualrobot_apps.studies.environment import RobotEnvironment, Step
from virtualrobot_apps.studies.reach import orientations
from virtualrobot_apps.studies.study_file import read_study
from virtualrobot_apps.studies.worlds import open_world
from virtualrobot_kernel.collision.scene import CollisionScene, Detail
from virtualrobot_kernel.embedded import EmbeddedWorld
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.planning.robots import arm_of, standing_at

from tests.apps.studies import done
from tests.tiers import Draws

pytestmark = pytest.mark.long

Floats = NDArray[np.float64]

# "DH Parameters for calculations of kinematics and dynamics", Universal Robots: UR5e, m.
D1, A2, A3, D4, D5, D6 = 0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996
SCENE = """
schema_version: 1
nodes:
- name: table
  object: {}
  parent_t_node: {position: {z: -0.03}}
  figures: [{box: {size: {x: 2, y: 2, z: 0.04}}}]
- name: post
  object: {}
  parent_t_node: {position: {x: 0.45, y: 0.3, z: 0.3}}
  figures: [{box: {size: {x: 0.1, y: 0.1, z: 0.6}}}]
- {name: first, object: {}, parent_t_node: {position: {x: 0.3, y: 0.1, z: 0.2}, orientation: {x: 1}}}
- {name: second, object: {}, parent_t_node: {position: {x: 0.2, y: -0.5, z: 0.1}, orientation: {x: 1}}}
models: [{uri: "model://ur5e", name: arm}]
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a UR5e by a post on a table, and two places to grasp at."""
    file = tmp_path_factory.mktemp("scene") / "cell.yaml"
    file.write_text(SCENE)
    return file


@pytest.fixture(scope="module")
def world(scene: Path) -> Iterator[EmbeddedWorld]:
    """Return the scene's world."""
    made = EmbeddedWorld(scene)
    yield made
    made.close()


OTHERS = {
    "ur3e": (0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921),
    "ur5e": (D1, A2, A3, D4, D5, D6),
    "ur10e": (0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655),
}
"""The same of its relatives, from the same table."""


def is_within(x: float, y: float, z: float, model: str = "ur5e") -> bool:
    """Return whether a robot of Universal Robots reaches (x, y, z) of its base's frame (m) with its tool down.

    The wrist's first joint is then D6 above the flange, D4 beside the plane of the arm and D5 before or behind, so that
    its centre is at u = sqrt(r^2 - D4^2) +- D5 and height z + D6 - D1; the elbow lets it be | |A2| - |A3| | to
    |A2| + |A3| from the shoulder.
    """
    d1, a2, a3, d4, d5, d6 = OTHERS[model]
    across = x * x + y * y - d4**2
    if across < 0.0:
        return False
    distances = [math.hypot(math.sqrt(across) + side * d5, z + d6 - d1) for side in (1.0, -1.0)]
    return any(abs(abs(a2) - abs(a3)) <= one <= abs(a2) + abs(a3) for one in distances)


STUDY = """
schema_version: 1
scene: {scene}
setup: virtualrobot_apps.studies.worlds:open_world
function: virtualrobot_apps.studies.{function}
block: 20
parameters: {parameters}
results: {results}
"""


def rows_of(text: str, folder: Path) -> list[dict[str, Any]]:
    """Run a study of this text in a folder, and return the rows of its cells."""
    (folder / "study.yaml").write_text(text)
    _, parts = done(read_study(folder / "study.yaml"), folder / "out")
    return parts.table().to_pylist()


TABLE = """
schema_version: 1
models:
- name: arm
  denavit_hartenberg:
    convention: DENAVIT_HARTENBERG_CONVENTION_STANDARD
    rows:
"""


def of_the_table(folder: Path) -> EmbeddedWorld:
    """Return a UR5e by its maker's table, whose joints turn by 180 degrees to both sides, and nothing else."""
    rows = zip((D1, 0.0, 0.0, D4, D5, D6), (0.0, A2, A3, 0.0, 0.0, 0.0), (1, 0, 0, 1, -1, 0), strict=True)
    limits = f"limits: {{lower: {-math.pi}, upper: {math.pi}}}"
    lines = (f"    - {{d_meters: {d}, a_meters: {a}, alpha_radians: {n * math.pi / 2}, {limits}}}" for d, a, n in rows)
    (folder / "table.yaml").write_text(TABLE + "\n".join(lines))
    return EmbeddedWorld(folder / "table.yaml")


@pytest.mark.parametrize("is_of_table", [False, True])
def test_branches_and_contacts_are_those_of_bare_libraries(
    world: EmbeddedWorld, tmp_path: Path, is_of_table: bool, rng: np.random.Generator, draws: Draws
) -> None:
    """Each angle of EAIK, made anew from the maker's table, and FCL at each posture, without a tree of balls."""
    if is_of_table:
        world = of_the_table(tmp_path)
    world.restore()
    bare = DhRobot(
        np.array([math.pi / 2, 0.0, 0.0, math.pi / 2, -math.pi / 2, 0.0]),
        np.array([0.0, A2, A3, 0.0, 0.0, 0.0]),
        np.array([D1, 0.0, 0.0, D4, D5, D6]),
    )
    count = draws(10_000)
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, 3] = rng.uniform(-0.8, 0.8, (count, 3))
    poses[:, :3, :3] = rng.permutation(orientations(count, 1))
    found = world.postures("arm", poses)
    snapshot = world._now
    arm = arm_of(snapshot, snapshot.structure.node("arm"))
    checked = CollisionScene(world._scene._shapes)
    free = 0
    for target, pose in enumerate(poses):
        answer = bare.IK(pose)
        exact = [q for q, least in zip(answer.Q, answer.is_LS, strict=True) if not least]
        expected = {tuple(np.round(np.exp(1j * q), 6) + 0.0) for q in exact}
        ours = found.positions[found.target == target]
        assert len(ours) == len(expected)
        for q, is_free in zip(ours, found.free[found.target == target], strict=True):
            apart = [np.abs(np.angle(np.exp(1j * (q - other)))).max() for other in exact]
            assert min(apart) < 1e-6
            checked.place(standing_at(snapshot, arm.q_index, q))
            assert bool(is_free) is not bool(checked.collisions(Detail.FIRST, [arm.robot.uid]))
            free += bool(is_free)
    assert 0 < free < len(found.target)
    if is_of_table:
        world.close()


def test_a_tool_that_points_down_reaches_an_annulus(world: EmbeddedWorld, rng: np.random.Generator) -> None:
    world.restore()
    places = rng.uniform([-1.0, -1.0, -0.3], [1.0, 1.0, 0.9], (300, 3))
    poses = np.tile(np.diag([1.0, -1.0, -1.0, 1.0]), (300, 1, 1))
    poses[:, :3, 3] = places
    reached = set(world.postures("arm", poses).target.tolist())
    assert reached == {number for number, place in enumerate(places) if is_within(*place)}
    assert 50 < len(reached) < 250


def test_it_says_where_joints_are_and_what_they_would_touch(world: EmbeddedWorld, rng: np.random.Generator) -> None:
    """Contacts are those of `postures`, wherever the arm itself stands meanwhile."""
    world.restore()
    poses = np.tile(np.diag([1.0, -1.0, -1.0, 1.0]), (60, 1, 1))
    poses[:, :3, 3] = rng.uniform([-0.7, -0.7, 0.0], [0.7, 0.7, 0.5], (60, 3))
    found = world.postures("arm", poses)
    names, limits = list(world.joints("arm")), world.joint_limits("arm")
    assert len(names) == 6 and len(found.positions) > 50
    for q, touching in zip(found.positions, found.touching, strict=True):
        world.set_joints("arm", dict(zip(names, rng.uniform(limits[:, 0], limits[:, 1]).tolist(), strict=True)))
        assert world.touching("arm", q) == touching
        world.set_joints("arm", dict(zip(names, q.tolist(), strict=True)))
        np.testing.assert_allclose(list(world.joints("arm").values()), q)
    with pytest.raises(KernelError, match="the 6 joints of 'arm' are finite numbers, not"):
        world.touching("arm", np.zeros(5))
    # What stands elsewhere touches elsewhere.
    q = next(q for q, touching in zip(found.positions, found.touching, strict=True) if touching is None)
    tool = found.target[[row.tolist() for row in found.positions].index(q.tolist())]
    pose = world.parent_pose("post")
    pose[:2, 3] = poses[tool, :2, 3]
    world.place("post", pose)
    assert world.touching("arm", q) is not None


def test_gymnasium_finds_nothing_wrong_with_it(scene: Path) -> None:
    """Its checker, on an arm that goes down to where it touches the table."""

    def down(step: Step) -> float:
        return -float(step.observation["tool"][2])

    env = RobotEnvironment(scene, "arm", down, nodes=["first"])
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=r".*(minimum value is -infinity|maximum value is infinity).*")
        check_env(env, skip_render_check=True)
    env.reset(seed=1)
    touched = [env.step(np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0]))[4] for _ in range(100)]
    assert {} in touched and touched[-1]["touching"]
    env.close()


def test_a_tolerance_study_follows_the_law_of_what_is_off(scene: Path, tmp_path: Path) -> None:
    """Of a part that is off alone, erf(sqrt 2) - 2 sqrt(2 / pi) e^-2 = 0.7385 within two deviations (Maxwell)."""
    text = STUDY.format(
        scene=scene,
        function="tolerance:hit\ndraws: 200",
        parameters="{robot: {list: [arm]}, target: {list: [second]}, part: {list: [0.001]}, "
        "tolerance: {list: [0.002]}}",
        results="{off: number, turned: number, hit: number, free: number}",
    )
    rows = rows_of(text, tmp_path)
    assert {row["status"] for row in rows} == {"ok"}, rows[0]["error"]
    share = np.mean([row["hit"] for row in rows])
    assert abs(share - 0.7385) < 4.0 * math.sqrt(0.7385 * 0.2615 / len(rows))
    assert all(row["free"] == 1.0 and row["turned"] < 1e-8 for row in rows)


def test_it_goes_back_and_says_what_its_base_touches(world: EmbeddedWorld) -> None:
    world.restore()
    before = world.tool_pose("arm")
    assert world.contacts("arm") == []
    lowered = np.eye(4)
    lowered[:3, 3] = 0.45, 0.3, 0.1
    world.place("arm", lowered)
    assert world.pose("arm")[:3, 3] == pytest.approx([0.45, 0.3, 0.1])
    assert {name for pair in world.contacts("arm") for name in pair} >= {"post"}
    world.restore()
    assert np.array_equal(world.tool_pose("arm"), before)
    assert world.contacts("arm") == []


def test_a_reach_map_is_told_place_by_place(world: EmbeddedWorld, scene: Path, tmp_path: Path) -> None:
    """Beyond the arm's length nothing is reached; before it, what the same orientations give one by one."""
    text = STUDY.format(
        scene=scene,
        function="reach:reach",
        parameters="{robot: {list: [arm]}, directions: {list: [6]}, turns: {list: [2]}, "
        "x: {list: [0.2, 0.4, 1.2]}, y: {list: [0.3]}, z: {list: [0.25]}}",
        results="{reached: number, free: number, branches: number}",
    )
    rows = rows_of(text, tmp_path)
    assert [row["status"] for row in rows] == ["ok"] * 3, rows
    world.restore()
    for row in rows:
        free = reached = branches = 0
        for rotation in orientations(6, 2):
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = rotation, (row["x"], row["y"], row["z"])
            found = world.postures("arm", pose[None])
            reached, free = reached + bool(len(found.target)), free + bool(found.free.any())
            branches += int(found.free.sum())
        assert (row["reached"], row["free"], row["branches"]) == (reached / 12, free / 12, branches / 12)
    assert rows[1]["reached"] > rows[1]["free"] and rows[2]["reached"] == 0.0
    assert rows[0]["free"] > 0.0


def test_placements_are_those_from_which_the_targets_are_in_the_annulus(scene: Path, tmp_path: Path) -> None:
    """Of all places of a grid, by the formula; and the reason names what is out of reach, or touches."""
    text = STUDY.format(
        scene=scene,
        function="placement:place",
        parameters='{robot: {list: [arm]}, targets: {list: ["first, second"]}, yaw: {list: [0.3]}, '
        "x: {grid: {from: -0.9, to: 0.9, count: 9}}, y: {grid: {from: -0.9, to: 0.9, count: 9}}}",
        results="{reached: number, free: number, margin: number, reason: text}",
    )
    rows = rows_of(text, tmp_path)
    places = np.array([[0.3, 0.1, 0.2], [0.2, -0.5, 0.1]])
    for row in rows:
        assert row["status"] == "ok", row["error"]
        seen = places - [row["x"], row["y"], 0.0]
        assert row["reached"] == np.mean([is_within(*place) for place in seen])
        if row["reason"] is None:
            assert row["free"] == 1.0 and 0.0 < row["margin"] <= 1.0
        elif "touches" not in row["reason"]:
            name = "first" if not is_within(*seen[0]) else "second"
            assert row["reason"] == f"{name}: out of reach"
    reasons = [row["reason"] for row in rows]
    assert None in reasons and any(one and "touches" in one for one in reasons)


def test_robots_of_the_catalogue_reach_what_their_tables_say(scene: Path, tmp_path: Path) -> None:
    """Three of one family in the place of one, each at the places of a grid; and a model that there is not."""
    text = STUDY.format(
        scene=scene,
        function="robots:choose",
        parameters="{model: {list: ['model://ur3e', 'model://ur5e', 'model://ur10e', 'model://ur55e']}, "
        "robot: {list: [arm]}, targets: {list: ['first, second']}, "
        "x: {grid: {from: -0.9, to: 0.3, count: 5}}, y: {grid: {from: -0.4, to: 0.4, count: 3}}}",
        results="{reached: number, free: number, margin: number, reason: text}",
    ).replace(":open_world", ":open_worlds")
    places, shares = np.array([[0.3, 0.1, 0.2], [0.2, -0.5, 0.1]]), dict[str, float]()
    for row in rows_of(text, tmp_path):
        model = row["model"].removeprefix("model://")
        if model == "ur55e":
            assert row["status"] == "failed" and "ur55e" in row["error"]
            continue
        assert row["status"] == "ok", row["error"]
        assert row["reached"] == np.mean(
            [is_within(*place, model=model) for place in places - [row["x"], row["y"], 0.0]]
        )
        shares[model] = shares.get(model, 0.0) + row["reached"]
    assert shares["ur3e"] < shares["ur5e"] < shares["ur10e"]
    with pytest.raises(KernelError, match="there is no model of the scene named 'arms'"):
        EmbeddedWorld(scene, {"arms": "model://ur3e"})


def test_the_worlds_that_were_asked_for_last_are_kept(monkeypatch: pytest.MonkeyPatch, scene: Path) -> None:
    class Opened:
        def __init__(self, model: str) -> None:
            self.model, self.is_closed, self.restored = model, False, 0

        def restore(self) -> None:
            self.restored += 1

        def close(self) -> None:
            self.is_closed = True

    opened: list[Opened] = []

    def opening(_: Path, models: dict[str, str]) -> Opened:
        opened.append(Opened(models["arm"]))
        return opened[-1]

    monkeypatch.setattr(worlds, "open_world", opening)
    found = worlds.Worlds(scene, most=2)
    for model in ("a", "b", "a", "c", "a", "b"):
        found.of("arm", model)
    assert [(one.model, one.is_closed, one.restored) for one in opened] == [
        *(("a", False, 3), ("b", True, 1), ("c", True, 1), ("b", False, 1)),
    ]
    with pytest.raises(InvalidArgumentError, match="this study needs a scene"):
        worlds.open_worlds(None)


def test_calibrations_become_as_good_as_the_noise_lets_them(scene: Path, tmp_path: Path) -> None:
    """With the 25 errors that points on the last axis tell; without noise to what is second order in the errors.

    That is some times 0.5 mm by 2 mrad, 1 um.
    """
    text = STUDY.format(
        scene=scene,
        function="calibration:calibrate",
        parameters="{robot: {list: [arm]}, postures: {list: [60]}, noise: {list: [0.0, 0.00005]}, "
        "lengths: {list: [0.0005]}, angles: {list: [0.002]}}",
        results="{rank: number, condition: number, before: number, after: number, worst: number, found_noise: number}",
    )
    exact, noisy = rows_of(text, tmp_path)
    assert exact["status"] == noisy["status"] == "ok", exact["error"] + noisy["error"]
    assert exact["rank"] == noisy["rank"] == 25
    assert exact["before"] > 1e-3 and exact["worst"] < 2e-5
    # SSR / (3 n - rank) within four of chi^2's deviations.
    assert abs((noisy["found_noise"] / 5e-5) ** 2 - 1.0) < 4.0 * np.sqrt(2.0 / (180 - 25))
    assert noisy["after"] < 6e-5 < noisy["before"]


def test_margins_are_those_of_the_worst_target() -> None:
    class Found:
        target = np.array([0, 0, 1])
        positions = np.array([[0.0, 0.5], [0.9, 0.0], [0.0, -1.5]])
        free = np.array([True, True, True])
        touching = (None, None, None)

    limits = np.array([[-1.0, 1.0], [-2.0, 2.0]])
    # The first target's best posture is 0.75 of half a range off, the second one's 0.25.
    assert placement.margin(Found(), limits, 2) == pytest.approx(0.25)


def test_bad_input_is_told(world: EmbeddedWorld, tmp_path: Path) -> None:
    with pytest.raises(InvalidArgumentError, match="this study needs a scene"):
        open_world(None)
    with pytest.raises(KernelError, match="cannot read the scene file"):
        EmbeddedWorld(tmp_path / "none.yaml")
    with pytest.raises(KernelError, match="did you mean 'arm'"):
        world.postures("armm", np.eye(4)[None])
    with pytest.raises(KernelError, match=r"poses are \(n, 4, 4\) and finite"):
        world.postures("arm", np.eye(4))
    with pytest.raises(KernelError, match=r"the pose of 'arm' is \(4, 4\) and finite"):
        world.place("arm", np.full((4, 4), np.nan))
    with pytest.raises(ValueError, match="directions and turns are 1 or more"):
        orientations(0, 1)
