"""The environment of Gymnasium by its own checker, with an arm in the plane whose kinematics are two lines."""

from __future__ import annotations

import importlib
import math
import sys
import warnings
from collections.abc import Mapping

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import SyncVectorEnv
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import quaternion_of
from virtualrobot_apps.studies.environment import RobotEnvironment, Step

Floats = NDArray[np.float64]


class Plane:
    """World of an arm of two links of 0.5 m in the plane, of a wall at x = 0.9 m, and of a goal."""

    def __init__(self) -> None:
        """Stretch it along y."""
        self.restore()
        self.is_closed = False

    def restore(self) -> None:
        self.at = {"first": math.pi / 2.0, "second": 0.0}
        self.goal = np.eye(4)
        self.goal[:2, 3] = -0.4, 0.4

    def place(self, node: str, pose: Floats) -> None:
        assert node == "goal"
        self.goal = pose

    def pose(self, node: str) -> Floats:
        assert node == "goal"
        return self.goal.copy()

    def joints(self, robot: str) -> dict[str, float]:
        return dict(self.at)

    def joint_limits(self, robot: str) -> Floats:
        return np.array([[-3.0, 3.0], [-2.5, 2.5]])

    def set_joints(self, robot: str, positions: Mapping[str, float]) -> None:
        self.at |= positions

    def tip(self, joints: Floats) -> Floats:
        first, second = joints[0], joints[0] + joints[1]
        return 0.5 * np.array([math.cos(first) + math.cos(second), math.sin(first) + math.sin(second)])

    def tool_pose(self, robot: str) -> Floats:
        pose, turn = np.eye(4), sum(self.at.values())
        pose[:2, :2] = [[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]]
        pose[:2, 3] = self.tip(np.array(list(self.at.values())))
        return pose

    def touching(self, robot: str, joints: Floats) -> tuple[str, str] | None:
        return ("arm", "wall") if self.tip(joints)[0] > 0.9 else None

    def close(self) -> None:
        self.is_closed = True


def distance(step: Step) -> tuple[float, bool]:
    """Return what is missing, and whether it is there."""
    off = float(np.linalg.norm(step.observation["tool"][:3] - step.observation["goal"][:3]))
    return -off, off < 0.02


def elsewhere(world: Plane, rng: np.random.Generator) -> None:
    pose = np.eye(4)
    pose[:2, 3] = rng.uniform(-0.5, 0.5, 2)
    world.place("goal", pose)


def made(**settings: object) -> RobotEnvironment:
    settings = {"nodes": ["goal"], "begin": elsewhere, "speed": [1.0, 2.0]} | settings
    return RobotEnvironment(Plane(), "arm", distance, **settings)  # pyright: ignore[reportArgumentType]  as far as it is used


def test_gymnasium_finds_nothing_wrong() -> None:
    """But for poses and joints without bounds, of which its checker warns; a warning else is an error here."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=r".*(minimum value is -infinity|maximum value is infinity).*")
        check_env(made(), skip_render_check=True)


def test_a_step_is_speed_times_period_within_limits() -> None:
    env = made(begin=None, period=0.1, steps=40)
    begun, _ = env.reset(seed=1)
    np.testing.assert_allclose(begun["joints"], [math.pi / 2.0, 0.0])
    np.testing.assert_allclose(begun["tool"], [0.0, 1.0, 0.0, 0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)], atol=1e-12)
    np.testing.assert_array_equal(begun["goal"], [-0.4, 0.4, 0.0, 0.0, 0.0, 0.0, 1.0])
    after, reward, is_over, is_cut, info = env.step(np.array([0.5, -7.0]))
    np.testing.assert_allclose(after["joints"], [math.pi / 2.0 + 0.05, -0.2])
    assert reward == pytest.approx(-math.dist(after["tool"][:2], (-0.4, 0.4)))
    assert (is_over, is_cut, info) == (False, False, {})
    cuts = [env.step(np.array([1.0, 0.0]))[3] for _ in range(39)]
    assert cuts == [False] * 38 + [True]
    assert env.step(np.zeros(2))[0]["joints"][0] == 3.0


def test_an_arm_that_would_touch_stays_and_says_what() -> None:
    """Turned to x, its tip is beyond 0.9 m from 0.451 rad on."""
    env = made(begin=None, period=0.1)
    env.reset(seed=1)
    last = {}
    for _ in range(30):
        observation, _, _, _, last = env.step(np.array([-1.0, 0.0]))
    assert last == {"touching": ("arm", "wall")}
    assert math.acos(0.9) < observation["joints"][0] < math.acos(0.9) + 0.1


def test_the_same_seed_gives_the_same_episodes() -> None:
    """And another one does not; a goal that was placed is gone with the next episode."""
    rng = np.random.default_rng(1)
    actions = rng.uniform(-1.0, 1.0, (20, 2))

    def played(seed: int) -> list[float]:
        env = made()
        found = []
        for one in (seed, None):
            begun, _ = env.reset(seed=one)
            found += [*begun["goal"][:2], *(env.step(action)[1] for action in actions)]
        return found

    first = played(5)
    assert first == played(5) and first != played(6)
    assert first[:2] != first[22:24]


def test_who_follows_the_slope_gets_there() -> None:
    """The transpose of the Jacobian leads to each goal within reach; the episode ends there."""
    env = made(begin=None, steps=400)
    observation, _ = env.reset(seed=3)
    env.step(np.array([0.0, 1.0]))  # off the singular posture
    is_over = is_cut = False
    while not (is_over or is_cut):
        first, second = observation["joints"][0], observation["joints"].sum()
        jacobian = 0.5 * np.array(
            [
                [-math.sin(first) - math.sin(second), -math.sin(second)],
                [math.cos(first) + math.cos(second), math.cos(second)],
            ]
        )
        wish = jacobian.T @ (observation["goal"][:2] - observation["tool"][:2])
        observation, reward, is_over, is_cut, _ = env.step(wish / max(0.2, float(np.abs(wish).max())))
    assert is_over and float(reward) > -0.02


def test_many_run_side_by_side() -> None:
    envs = SyncVectorEnv([made] * 3)
    observations, _ = envs.reset(seed=[1, 2, 3])
    alone = [made().reset(seed=seed)[0] for seed in (1, 2, 3)]
    np.testing.assert_array_equal(observations["goal"], [one["goal"] for one in alone])
    after, rewards, *_ = envs.step(np.tile([0.5, -0.5], (3, 1)))
    assert rewards.shape == (3,) and after["tool"].shape == (3, 7)
    envs.close()


def test_bad_input_is_told() -> None:
    for settings, said in (
        ({"speed": 0.0}, "speed is above 0, one for all or each of 2 joints"),
        ({"speed": [1.0, 1.0, 1.0]}, "speed is above 0, one for all or each of 2 joints"),
        ({"period": math.nan}, "period is above 0 and steps 1 or more"),
        ({"steps": 0}, "period is above 0 and steps 1 or more"),
        ({"nodes": ["tool"]}, "'tool' is observed of every robot"),
    ):
        with pytest.raises(InvalidArgumentError, match=said):
            made(**settings)
    env = made()
    env.reset(seed=1)
    for action in (np.zeros(3), np.array([math.nan, 0.0])):
        with pytest.raises(InvalidArgumentError, match=r"an action is \(2,\) and finite"):
            env.step(action)
    world = Plane()
    RobotEnvironment(world, "arm", distance, nodes=["goal"]).close()  # pyright: ignore[reportArgumentType]
    assert world.is_closed
    np.testing.assert_allclose(quaternion_of(np.eye(4)), [0.0, 0.0, 0.0, 1.0])


def test_without_gymnasium_the_line_is_told_that_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    monkeypatch.delitem(sys.modules, RobotEnvironment.__module__)
    with pytest.raises(ImportError, match=r"pip install 'virtualrobot\[learning\]'"):
        importlib.import_module(RobotEnvironment.__module__)
