"""Registration by touched points without a kernel: closed cases, predicted errors against drawn ones, bad input.

The table of errors is that of a study which drew 4,000 times three touches each: p50 and p95 at a tool, in mm, by the
standard deviation of a coordinate (mm) and the legs of a right angle of points (m).
"""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError
from virtualrobot_apps.registration.touched import UP, register

Floats = NDArray[np.float64]

TABLE = {
    (2.0, 0.3): (4.6, 12.6),
    (2.0, 0.6): (2.7, 6.0),
    (2.0, 1.2): (1.9, 3.6),
    (5.0, 0.3): (11.6, 31.5),
    (5.0, 0.6): (6.6, 15.0),
    (5.0, 1.2): (4.8, 9.0),
}


def corner(leg: float) -> Floats:
    """Return the points (3, 3) of a level right angle at the origin."""
    return np.array([[0.0, 0.0, 0.0], [leg, 0.0, 0.0], [0.0, leg, 0.0]])


def seen(points: Floats, model_t_device: Floats) -> Floats:
    """Return points (n, 3) of the model as a device has them."""
    inverse = np.linalg.inv(model_t_device)
    return points @ inverse[:3, :3].T + inverse[:3, 3]


@pytest.mark.parametrize("yaw", [-3.1, -1.5, 0.0, 0.7, np.pi])
@pytest.mark.parametrize("up", sorted(UP))
def test_exact_touches_give_the_exact_pose(yaw: float, up: str) -> None:
    points = np.array([[0.4, 0.1, 0.0], [1.3, -0.2, 0.5], [0.2, 0.9, 0.3], [-0.5, 0.1, 1.2]])
    device = virtualrobot.pose(1.2, -0.7, 0.4, yaw=yaw) @ UP[up]
    found = register(points, seen(points, device), up=up)
    assert np.abs(found.model_t_device - device).max() < 1e-9
    assert found.residuals.max() < 1e-9


def test_a_turn_is_the_best_one() -> None:
    """No turn and shift beside the one that was found leaves less over."""
    rng = np.random.default_rng(3)
    points = corner(0.8)
    touched = seen(points, virtualrobot.pose(0.3, 0.1, 0.2, yaw=0.4)) + rng.normal(0.0, 0.002, (3, 3))
    found = register(points, touched)
    least = np.sum(found.residuals**2)
    for step in (-1e-4, 1e-4):
        for axis in ("x", "y", "z", "yaw"):
            other = virtualrobot.pose(**{axis: step}) @ found.model_t_device
            assert np.sum((touched @ other[:3, :3].T + other[:3, 3] - points) ** 2) > least


@pytest.mark.parametrize(("noise", "leg"), sorted(TABLE))
def test_predicted_errors_are_those_of_the_table(noise: float, leg: float) -> None:
    points, tool = corner(leg), np.array([1.0, 0.7, 0.9])
    found = register(points, points, noise=1e-3 * noise, least_apart=0.0)
    told = [1e3 * found.error(tool, share) for share in (0.5, 0.95)]
    assert told == pytest.approx(TABLE[noise, leg], rel=0.06)


def test_predicted_errors_are_those_of_drawn_touches() -> None:
    rng = np.random.default_rng(5)
    points = np.array([[0.0, 0.0, 0.0], [0.8, 0.1, 0.2], [0.1, 0.7, 0.0], [0.5, 0.5, 0.6]])
    device, tool, noise = virtualrobot.pose(0.4, 0.2, 0.1, yaw=1.1), np.array([1.6, -0.4, 0.9]), 0.002
    touched = seen(points, device)
    at = np.append(seen(tool[None], device)[0], 1.0)
    off = []
    for _ in range(2000):
        drawn = register(points, touched + rng.normal(0.0, noise, points.shape), noise=noise)
        off.append((drawn.model_t_device @ at)[:3] - tool)
    exact = register(points, touched, noise=noise)
    lengths = np.linalg.norm(off, axis=1)
    for share in (0.5, 0.95):
        assert exact.error(tool, share) == pytest.approx(np.quantile(lengths, share), rel=0.05)
    covariance = np.cov(np.array(off).T)
    assert np.abs(exact.covariance(tool) - covariance).max() < 0.08 * covariance.max()


@pytest.mark.long
def test_a_device_that_leans_is_predicted_too() -> None:
    """The direction taken for up is off about both level axes, as a headset's is: drawn, beside what is told."""
    rng = np.random.default_rng(6)
    points = np.array([[0.0, 0.0, 0.0], [0.9, 0.1, 0.5], [0.1, 0.7, 0.1], [0.5, 0.5, 1.0]])
    tool, noise, tilt = np.array([1.6, -0.4, 0.9]), 0.001, 0.004
    off = []
    for _ in range(1500):
        leaning = virtualrobot.pose(0.0, 0.0, 0.0, *rng.normal(0.0, tilt, 2))
        touched = seen(points, leaning) + rng.normal(0.0, noise, points.shape)
        drawn = register(points, touched, noise=noise, tilt=tilt)
        off.append((drawn.model_t_device @ np.append(seen(tool[None], leaning)[0], 1.0))[:3] - tool)
    exact = register(points, points, noise=noise, tilt=tilt)
    lengths = np.linalg.norm(off, axis=1)
    for share in (0.5, 0.95):
        assert exact.error(tool, share) == pytest.approx(np.quantile(lengths, share), rel=0.08)
    covariance = np.cov(np.array(off).T)
    assert np.abs(exact.covariance(tool) - covariance).max() < 0.1 * covariance.max()
    assert exact.error(tool) > 2.0 * register(points, points, noise=noise).error(tool)


def test_what_is_left_over_counts_where_it_is_more_than_expected() -> None:
    points = corner(1.0)
    off = np.array([[0.0, 0.0, 0.004], [0.0, 0.0, -0.004], [0.0, 0.0, 0.0]])
    found = register(points, points + off, noise=0.001)
    assert found.noise == pytest.approx(np.sqrt(2.0 * 0.004**2 / 5.0))
    assert found.error([0.0, 0.0, 0.0]) > register(points, points, noise=0.001).error([0.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], "2 points were touched; touch 3 at least"),
        ([[0.0, 0.0, 0.0], [1.0, 0.5, 0.2], [2.0, 1.0, 0.4]], "lie on a line"),
        ([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 2.0]], "lie on a line"),
        ([[0.0, 0.0, 0.0]] * 3, "lie on a line"),
        ([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.3, 2.0]], "0.42 m apart at most, seen from above; touch more"),
        ([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], "rows of three finite numbers"),
        ([[0.0, 0.0, np.nan], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "not finite"),
        ([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1e300, 0.0]], r"1e\+300 m; they are in m, 1e\+06 at most"),
    ],
)
def test_poor_points_are_refused(points: list[list[float]], said: str) -> None:
    with pytest.raises(InvalidArgumentError, match=said):
        register(points, points)


def test_touches_that_do_not_fit_are_refused() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.7, 0.3]])
    with pytest.raises(InvalidArgumentError, match="the touches don't fit the points"):
        register(points, points[[1, 0, 2]])
    with pytest.raises(InvalidArgumentError, match="whether z is up for the device"):
        register(points, seen(points, UP["y"]))
    moved = points + np.diag([0.0, 0.0, 0.08])
    with pytest.raises(InvalidArgumentError, match="point 3 most") as refused:
        register(points, moved)
    assert refused.value.metadata["point"] == "3"
    with pytest.raises(InvalidArgumentError, match="2 points were touched of 3"):
        register(points, points[:2])
    with pytest.raises(InvalidArgumentError, match="z or y, not 'x'"):
        register(points, points, up="x")
    with pytest.raises(InvalidArgumentError, match="the noise of a touch is 0 m"):
        register(points, points, noise=0.0)
    with pytest.raises(InvalidArgumentError, match=r"the tilt of a device is 1 rad; it lies between 0 and 0\.1"):
        register(points, points, tilt=1.0)
    with pytest.raises(InvalidArgumentError, match="between 0 and 1"):
        register(points, points).error([0.0, 0.0, 0.0], 1.0)
