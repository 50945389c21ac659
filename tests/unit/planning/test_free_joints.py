"""What free joints are used for: at a pose and along a path they go where the objective leads, and the tool stays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import ArrayLike
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.motion.cartesian_plan import plan_lin
from virtualrobot_kernel.motion.nullspace import (
    free_motion,
    joint_limit_clearance,
    manipulability,
    obstacle_clearance,
    posture_distance,
)
from virtualrobot_kernel.planning.free_joints import cartesian_tcp, objective_of, solve_inverse
from virtualrobot_kernel.planning.planned_move import joint_limits
from virtualrobot_kernel.planning.redundancy import FREE, Preference, Redundancy
from virtualrobot_kernel.planning.robots import arm_of, tcp_frame, tip_of
from virtualrobot_kernel.planning.solvers import Solvers
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.kinematics import InverseOptions, InverseResult

from .robots import standing

DEFAULTS = InverseOptions()
MODELS = ("panda", "iiwa", "nine_axis")
LIMITS = Redundancy(preference=Preference.JOINT_LIMITS)
MANIPULABILITY = Redundancy(preference=Preference.MANIPULABILITY)


@pytest.fixture(scope="module")
def solvers() -> Iterator[Solvers]:
    solvers = Solvers(Catalog())
    yield solvers
    solvers.close()


def somewhere(model: str, rng: np.random.Generator) -> tuple[str, dict[str, float]]:
    """Return the robot's name and a random posture well within limits."""
    snapshot, node = standing(model)
    chain = arm_of(snapshot, node).serial()
    q = (chain.lower + chain.upper) / 2.0 + 0.4 * rng.uniform(-1.0, 1.0, len(chain.lower)) * (chain.upper - chain.lower)
    return node.name, dict(zip(chain.joint_names, q.tolist(), strict=True))


@pytest.mark.parametrize("k", [3, 7])
def test_gradients_are_those_of_the_costs(k: int, rng: np.random.Generator) -> None:
    """By central differences; a joint without limits or without a wanted position does not count."""
    lower, upper = rng.uniform(-3.0, -1.0, k), rng.uniform(1.0, 3.0, k)
    lower[0] = -np.inf
    posture = rng.uniform(-1.0, 1.0, k)
    posture[1] = np.nan
    shape = rng.normal(size=(6, k, k))
    objectives = [
        joint_limit_clearance(lower, upper),
        posture_distance(posture),
        manipulability(lambda q: np.eye(6, k) + 0.1 * np.sin(shape @ q)),  # far from any
    ]
    for i, objective in enumerate(objectives):
        q = rng.uniform(-0.9, 0.9, k)
        steps = 1e-6 * np.eye(k)
        expected = [(objective(q + step)[0] - objective(q - step)[0]) / 2e-6 for step in steps]
        np.testing.assert_allclose(objective(q)[1], expected, rtol=1e-4, atol=1e-5)
        if i < 2:
            assert objective(q)[1][i] == 0.0


@pytest.mark.long
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("redundancy", [LIMITS, MANIPULABILITY], ids=["limits", "manipulability"])
def test_a_pose_is_solved_where_the_wish_is_best_nearby(
    solvers: Solvers, model: str, redundancy: Redundancy, rng: np.random.Generator
) -> None:
    for _ in range(4):
        _, seed = somewhere(model, rng)
        snapshot, node = standing(model, seed)
        arm = arm_of(snapshot, node)
        target = tcp_frame(snapshot, node)
        _, plain = solve_inverse(snapshot, node, target, {}, solvers.of)
        _, better = solve_inverse(snapshot, node, target, {}, solvers.of, redundancy=redundancy)
        tcp = cartesian_tcp(snapshot, arm, solvers.of, FREE)
        objective = objective_of(
            snapshot, arm, redundancy, solvers.of(snapshot, arm).jacobian, np.array(list(seed.values()))
        )
        assert objective is not None
        costs = [objective(q)[0] for q in better.solutions]
        assert costs == sorted(costs)
        assert costs[0] <= min(objective(q)[0] for q in plain.solutions[:8]) + 1e-12
        assert costs[0] < objective(np.array(list(seed.values())))[0], "a random posture is not the best one"
        for q in better.solutions:
            np.testing.assert_allclose(
                tip_of(snapshot, arm)(q), tip_of(snapshot, arm)(np.array(list(seed.values()))), atol=1e-9
            )
            assert ((q >= arm.serial().lower) & (q <= arm.serial().upper)).all()
        assert len(better.configurations) == len(better.solutions)
        assert len(better.arm_angles) in (0, len(better.solutions))
        assert tcp.objective is None


def test_a_pose_is_solved_near_a_wanted_posture(solvers: Solvers, rng: np.random.Generator) -> None:
    """The arm's own posture is wanted: nothing is nearer to it.

    That is promised near what the component gives; and far from singularities nothing else is the best nearby.
    """
    for model in ("panda", "iiwa"):
        least, off = 0.0, np.inf
        while least < 0.1 or off > 0.2:
            _, wanted = somewhere(model, rng)
            q = np.array(list(wanted.values()))
            away = {name: value + float(rng.uniform(-0.05, 0.05)) for name, value in wanted.items()}
            snapshot, node = standing(model, wanted)
            least = np.linalg.svd(solvers.of(snapshot, arm_of(snapshot, node)).jacobian(q), compute_uv=False)[-1]
            _, given = solve_inverse(snapshot, node, tcp_frame(snapshot, node), away, solvers.of)
            off = min((np.abs(one - q).max() for one in given.solutions[:1]), default=np.inf)
        objective = Redundancy(preference=Preference.POSTURE, posture=wanted)
        _, found = solve_inverse(snapshot, node, tcp_frame(snapshot, node), away, solvers.of, redundancy=objective)
        np.testing.assert_allclose(found.solutions[0], q, atol=2e-3)


@pytest.mark.long
@pytest.mark.parametrize("model", MODELS)
def test_a_line_follows_the_wish_and_stays_a_line(solvers: Solvers, model: str, rng: np.random.Generator) -> None:
    """To 0.01 mm, within the joints' limits, and to postures that cost less in the sum than without the objective.

    Going downhill is no promise for one line, so a sum that says otherwise is asked of more of them.
    """
    gains: list[float] = []
    while len(gains) < 3 or (sum(gains) <= 0.0 and len(gains) < 10):
        _, posture = somewhere(model, rng)
        snapshot, node = standing(model, posture)
        arm = arm_of(snapshot, node)
        limits, start = joint_limits(snapshot, node, arm.joint_names)
        tcp = cartesian_tcp(snapshot, arm, solvers.of, LIMITS)
        assert tcp.objective is not None
        goal = tcp.pose(start)
        goal[:3, 3] += 0.15 * rng.uniform(-1.0, 1.0, 3)
        try:
            plain = plan_lin(tcp.kinematics, start, goal, limits, tip_t_tcp=tcp.tip_t_tcp)
            wished = plan_lin(tcp.kinematics, start, goal, limits, tip_t_tcp=tcp.tip_t_tcp, objective=tcp.objective)
        except KernelError:
            continue  # a limit or a singularity on the way
        gains.append(tcp.objective(plain.goal)[0] - tcp.objective(wished.goal)[0])
        np.testing.assert_allclose(tcp.pose(wished.goal), goal, atol=1e-6)
        track = wished.tracks[0]
        line = goal[:3, 3] - tcp.pose(start)[:3, 3]
        q_all, velocities, accelerations, *_ = track.derivatives(np.linspace(0.0, wished.duration, 200))
        for q, velocity, acceleration in zip(q_all, velocities, accelerations, strict=True):
            off = tcp.pose(q)[:3, 3] - tcp.pose(start)[:3, 3]
            along = off @ line / (line @ line)
            assert np.linalg.norm(off - along * line) < 1e-5
            assert (np.abs(velocity) <= limits.velocity * 1.001).all()
            assert (np.abs(acceleration) <= limits.acceleration * 1.01).all()
    assert sum(gains) > 0.0


def test_free_motion_goes_downhill_and_the_tool_stays(rng: np.random.Generator) -> None:
    for _ in range(100):
        k = int(rng.integers(7, 11))
        jacobian, rate, q = rng.normal(size=(6, k)), rng.normal(size=k), rng.uniform(-2.0, 2.0, k)
        objective = joint_limit_clearance(np.full(k, -2.1), np.full(k, 2.1))
        free = free_motion(jacobian, rate, objective, q)
        np.testing.assert_allclose(jacobian @ free, 0.0, atol=1e-10)
        assert objective(q)[1] @ free < 0.0
        assert 0.0 < np.linalg.norm(free) <= np.linalg.norm(rate)


@pytest.mark.long
def test_a_line_that_would_meet_a_limit_is_led_away_from_it(solvers: Solvers) -> None:
    """The iiwa's elbow, near its limit, swings aside while the tool goes its way."""
    gone = {"plain": 0, "wished": 0}
    rng = np.random.default_rng(20081)
    for _ in range(40):
        _, posture = somewhere("iiwa", rng)
        snapshot, node = standing("iiwa", posture)
        arm = arm_of(snapshot, node)
        limits, start = joint_limits(snapshot, node, arm.joint_names)
        tcp = cartesian_tcp(snapshot, arm, solvers.of, LIMITS)
        goal = tcp.pose(start)
        goal[:3, 3] += 0.3 * rng.uniform(-1.0, 1.0, 3)
        for name, objective in (("plain", None), ("wished", tcp.objective)):
            try:
                plan_lin(tcp.kinematics, start, goal, limits, tip_t_tcp=tcp.tip_t_tcp, objective=objective)
                gone[name] += 1
            except KernelError:
                pass
    assert gone["wished"] > gone["plain"], gone


def test_a_wish_of_an_arm_without_a_joint_to_spare_changes_nothing(solvers: Solvers) -> None:
    snapshot, node = standing("panda", {"panda_joint4": -1.5, "panda_joint6": 1.5})
    locked = replace(LIMITS, locked_joints={"panda_joint7": 0.4})
    target = tcp_frame(snapshot, node)
    alone = replace(locked, preference=FREE.preference)
    _, plain = solve_inverse(snapshot, node, target, {}, solvers.of, redundancy=alone)
    _, wished = solve_inverse(snapshot, node, target, {}, solvers.of, redundancy=locked)
    np.testing.assert_array_equal(wished.solutions, plain.solutions)


class FewPostures(ChainKinematics):
    """A component without names that knows few postures of a pose, each by its arm angle, wherever it is asked from."""

    def inverse(self, base_t_tip: ArrayLike, _: InverseOptions = DEFAULTS, /) -> InverseResult:
        ways = [super(FewPostures, self).inverse(base_t_tip, InverseOptions(seed=seed)) for seed in self._seeds()]
        solutions = np.concatenate([way.solutions[:1] for way in ways])
        return ways[0]._replace(
            solutions=solutions, configurations=("",) * len(solutions), arm_angles=tuple(solutions[:, 0].tolist())
        )

    def _seeds(self) -> np.ndarray:
        return self.middle + np.outer((0.2, -0.2), np.ones(len(self.joint_names)))


def test_a_posture_whose_arm_angle_nobody_tells_is_left_as_it_was() -> None:
    snapshot, node = standing("iiwa", {"lbr_iiwa_joint_2": 0.4, "lbr_iiwa_joint_4": -1.2, "lbr_iiwa_joint_6": 0.8})
    _, found = solve_inverse(
        snapshot, node, tcp_frame(snapshot, node), {}, lambda _, arm: FewPostures(arm.serial()), redundancy=LIMITS
    )
    assert len(found.solutions) == 2
    np.testing.assert_array_equal(found.arm_angles, found.solutions[:, 0])


def test_a_posture_of_unknown_joints_is_refused(solvers: Solvers) -> None:
    snapshot, node = standing("panda", {"panda_joint4": -1.5, "panda_joint6": 1.5})
    objective = Redundancy(preference=Preference.POSTURE, posture={"panda_joint9": 0.0})
    with pytest.raises(UnknownNameError, match="panda_joint9"):
        solve_inverse(snapshot, node, tcp_frame(snapshot, node), {}, solvers.of, redundancy=objective)


def test_the_wish_to_stay_away_is_the_gradient_of_its_cost(rng: np.random.Generator) -> None:
    """Distances that are linear in the joints, by central differences; those beyond the range do not count.

    The joints change them by less than 0.05 m, so none comes as near as things count at most.
    """
    slopes, base = rng.uniform(-0.012, 0.012, (3, 4)), np.array([0.1, 0.2, 0.4])
    objective = obstacle_clearance(lambda q: (base + slopes @ q, slopes), np.full(4, -2.0), np.full(4, 2.0))
    q = rng.uniform(-1.0, 1.0, 4)
    expected = [(objective(q + step)[0] - objective(q - step)[0]) / 2e-6 for step in 1e-6 * np.eye(4)]
    np.testing.assert_allclose(objective(q)[1], expected, rtol=1e-5, atol=1e-8)
    near = objective(np.zeros(4))[0]
    assert near == pytest.approx(0.0025 * ((10.0 - 1.0 / 0.3) ** 2 + (5.0 - 1.0 / 0.3) ** 2))
    nothing = obstacle_clearance(lambda q: (np.zeros(0), np.zeros((0, 4))), np.full(4, -2.0), np.full(4, 2.0))
    assert nothing(np.zeros(4))[0] == 0.0 and not nothing(np.zeros(4))[1].any()
