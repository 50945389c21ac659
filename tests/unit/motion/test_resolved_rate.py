"""Joint paths by compiled steps are those of NumPy's, which arms with an objective take: pieces and refusals alike."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.cartesian_path import CartesianPath
from virtualrobot_kernel.motion.circle import Center, arc
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.line import Line, line_between
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics, farthest_joint_path, joint_path
from virtualrobot_kernel.motion.spline import spline
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.kinematics import Floats, InverseResult
from virtualrobot_sdk.poses import rotation_matrix

from .motions import arm_limits, kinematics

NAMES = ("iiwa", "panda", "xarm6", "puma560")
RESOLUTION = 1e-5
Draws = Callable[[int], int]


class Untold:
    """Kinematics that do not tell their chain."""

    def __init__(self, kinematics: ChainKinematics) -> None:
        """Ask these."""
        self.forward, self.jacobian = kinematics.forward, kinematics.jacobian

    def inverse(self, base_t_tip: Floats, options: object = None, /) -> InverseResult:
        raise AssertionError("paths are followed without it")


def found(
    tcp: TcpKinematics, tcp_path: CartesianPath, q: Floats, limits: JointLimits, whole: bool
) -> tuple[PiecewisePolynomial | None, str]:
    """Return the joint path, whole or as far as it goes, and the words of what ends it."""
    try:
        if whole:
            return joint_path(tcp, tcp_path, q, limits), ""
        path, end = farthest_joint_path(tcp, tcp_path, q, limits, RESOLUTION)
        return path, str(end)
    except KernelError as error:
        return None, str(error)


def wish(rng: np.random.Generator, kind: str, base_t_tcp: Floats) -> CartesianPath:
    """Return a random line, arc, spline or jog from a pose (4, 4)."""

    def near(distance: float) -> Floats:
        pose = base_t_tcp.copy()
        pose[:3, :3] = rotation_matrix(rng.normal(0.0, 2.0 * distance, 3)) @ pose[:3, :3]
        pose[:3, 3] += rng.normal(0.0, distance, 3)
        return pose

    if kind == "line":
        return line_between(base_t_tcp, near(0.1))
    if kind == "arc":
        offset = rng.normal(0.0, 0.05, 3)
        axis = np.cross(offset, rng.normal(size=3))  # the centre is in its plane
        return arc(base_t_tcp, Center(base_t_tcp[:3, 3] + offset, axis, rng.uniform(0.2, 4.0)), None)
    if kind == "spline":
        return spline(base_t_tcp, [near(0.05) for _ in range(4)])
    return Line(base_t_tcp, rng.normal(size=3) * rng.integers(2), rng.normal(size=3))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["line", "arc", "spline", "jog"])
def test_compiled_steps_are_those_of_numpy(name: str, kind: str, rng: np.random.Generator, draws: Draws) -> None:
    told, limits = kinematics(name), arm_limits(name)
    paths = 0
    for _ in range(draws(20)):
        tip = np.eye(4)
        tip[:3, :3], tip[:3, 3] = rotation_matrix(rng.normal(size=3)), rng.uniform(-0.1, 0.1, 3)
        lower, upper = np.maximum(told.lower, -np.pi), np.minimum(told.upper, np.pi)
        q = rng.uniform(0.9 * lower + 0.1 * upper, 0.1 * lower + 0.9 * upper)
        tcp_path = wish(rng, kind, told.forward(q)[-1] @ tip)
        whole = kind != "jog"
        compiled, words = found(TcpKinematics(told, tip), tcp_path, q, limits, whole)
        plain, expected = found(TcpKinematics(Untold(told), tip), tcp_path, q, limits, whole)
        assert words == expected
        assert (compiled is None) == (plain is None)
        if compiled is None or plain is None:
            continue
        paths += 1
        np.testing.assert_array_equal(compiled.breaks, plain.breaks)
        places = np.linspace(0.0, plain.end, 50)
        for row, (a, b) in enumerate(zip(compiled.states(places, 2), plain.states(places, 2), strict=True)):
            # Each derivative divides rounding by the length of a piece.
            np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-12 * 1e3**row * max(1.0, float(np.abs(b).max())))
    assert paths or draws(20) < 20
