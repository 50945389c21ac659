"""Time-optimal law: speed and acceleration kept, the jerk without a limit (library toppra).

Source: Pham, Pham, A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis, IEEE
Transactions on Robotics 34(3), 2018. toppra is imported by the first law that needs it: it draws in scipy and
matplotlib, which take half a second.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.rates import Rate, greatest_stretch, nodes_of, stretch_needed
from virtualrobot_kernel.numeric.laws import STILL

#: Sides of the polygon that stands for the circle of the accelerations of a position or a rotation.
_SIDES = 16
#: Number of further solutions with less, where the last one exceeded the limits between its nodes.
_ROUNDS = 2
#: A solution that has to be slowed down by no more than this is not solved again.
_GOOD = 1.0005
#: Looks at each cell, and by how much slower than by them a law is.
_LOOKS, _MARGIN = 24, 1.0001
_TINY = 1e-100
#: Units of time in which toppra is asked.
_UNITS = np.array([1.0, 0.1, 0.01])


def trapezoid(length: float, max_velocity: float, max_acceleration: float) -> PiecewisePolynomial:
    """Return the fastest law from 0 to `length`, at rest at both ends: full acceleration, full speed, full braking."""
    speed = min(max_velocity, math.sqrt(length * max_acceleration))
    ramp = speed / max_acceleration
    cruise = max(length / speed - ramp, 0.0)
    breaks = [0.0, ramp, ramp + cruise, 2.0 * ramp + cruise]
    half = 0.5 * max_acceleration
    way = half * ramp * ramp
    pieces = [[0.0, 0.0, half, 0.0], [way, speed, 0.0, 0.0], [length - way, speed, -half, 0.0]]
    if cruise <= 1e-12 * ramp:
        breaks, pieces = [0.0, ramp, 2.0 * ramp], [pieces[0], pieces[2]]
    return PiecewisePolynomial(np.array(breaks), np.array(pieces)[:, :, None])


def time_optimal_law(rates: Sequence[Rate]) -> PiecewisePolynomial:
    """Return the law over the range of the first rate that keeps the velocity and acceleration limits of all.

    It is piecewise quadratic (four coefficients, the last 0). Where it would exceed a limit between the nodes of
    toppra's grid, it is solved again with less there, and in the end slowed down as a whole by what is left.
    """
    nodes = nodes_of(rates)
    speed, slope, bend = _constraints(rates, nodes)
    share = np.ones(len(nodes))
    laws = []
    for _ in range(1 + _ROUNDS):
        speeds = _solved(nodes, speed * share, slope * (share**2)[:, None], bend * (share**2)[:, None])
        law = _quadratic(nodes, speeds)
        taus = (law.breaks[:-1, None] + np.diff(law.breaks)[:, None] * np.linspace(0.0, 1.0 - 1e-9, _LOOKS)).ravel()
        needed = stretch_needed(rates, law, taus)[:2].max(axis=0).reshape(-1, _LOOKS).max(axis=1)
        laws.append(law.stretched(law.end * greatest_stretch(rates, law, taus, 2) * _MARGIN))
        if needed.max() < _GOOD:
            break
        beside = np.maximum(np.append(needed, 0.0), np.append(0.0, needed))
        share *= np.maximum(beside, 1.0)
    return min(laws, key=lambda law: law.end)


def _constraints(rates: Sequence[Rate], nodes: Array) -> tuple[Array, Array, Array]:
    """Return what keeps the limits at the nodes (m,): speed (m,) s' <= 1, |slope s'' + bend s'^2| <= 1, (m, r) each.

    The acceleration f s'' + f' s'^2 of a vector lies in the plane of f and f'. There the circle of its limit becomes a
    polygon in it, with two of its corners along f.
    """
    speed = np.zeros(len(nodes))
    slopes, bends = [], []
    angles = (np.arange(_SIDES // 2) + 0.5) * (2.0 * np.pi / _SIDES)
    normals = np.stack([np.cos(angles), np.sin(angles)]) / np.cos(np.pi / _SIDES)
    for rate in rates:
        at = np.flatnonzero((nodes >= rate.begin) & (nodes <= rate.end))
        f, f1 = rate.polynomial.states(nodes[at], 1)
        velocity, acceleration, _ = rate.limits
        length = rate.lengths(f)
        speed[at] = np.maximum(speed[at], (length / velocity).max(axis=1))
        if rate.size == 1:
            parts = [(f / acceleration, f1 / acceleration)]
        else:
            f, f1 = (values.reshape(len(at), -1, rate.size) for values in (f, f1))
            along = (f * f1).sum(axis=2) / np.maximum(length, _TINY)
            across = np.sqrt(np.maximum((f1**2).sum(axis=2) - along**2, 0.0))
            along, across, length = (values / acceleration for values in (along, across, length))
            parts = [(length[:, k, None] * normals[0], along[:, k, None] * normals[0] + across[:, k, None] * normals[1])
                     for k in range(length.shape[1])]  # fmt: skip
        for part in parts:
            for columns, values in zip((slopes, bends), part, strict=True):
                whole = np.zeros((len(nodes), values.shape[1]))
                whole[at] = values
                columns.append(whole)
    return speed, np.concatenate(slopes, axis=1), np.concatenate(bends, axis=1)


def _solved(nodes: Array, speed: Array, slope: Array, bend: Array) -> Array:
    """Return s' at the nodes (m,) by toppra: at rest at both ends."""
    # toppra has tolerances of its own, which are fit for numbers near 1: the unit of the way is that of the path, the
    # unit of time about that of the motion. Where s' spans many orders of magnitude another unit of time may help.
    way = float(nodes[-1] - nodes[0])
    nodes, speed, slope, bend = (nodes - nodes[0]) / way, speed * way, slope * way, bend * way**2
    some = np.flatnonzero((np.abs(slope).max(axis=0) > 0.0) | (np.abs(bend).max(axis=0) > 0.0))
    top = 1.0 / np.maximum(speed, STILL * speed.max())
    for unit in float(np.trapezoid(speed, nodes)) * _UNITS:
        speeds = _toppra(nodes, unit * top, slope[:, some] / unit**2, bend[:, some] / unit**2)
        if speeds is not None and np.all(np.isfinite(speeds)) and np.all(speeds[1:-1] > 0.0):
            return speeds * (way / unit)
    raise KernelError("toppra found no time-optimal law along this path; ask for the jerk-limited one")


def _toppra(nodes: Array, top: Array, slope: Array, bend: Array) -> Array | None:
    """Return s' at the nodes (m,) with s' <= top and |slope s'' + bend s'^2| <= 1, or None."""
    try:
        from toppra.algorithm import TOPPRA
        from toppra.constraint import ConstraintType, DiscretizationType, LinearConstraint
        from toppra.constraint.linear_constraint import canlinear_colloc_to_interpolate
    except ImportError as error:
        raise KernelError(
            f"a time-optimal law along a curve needs the library toppra, which the kernel does not have ({error}): "
            "pip install 'virtualrobot[time-optimal]' (Linux on x86-64); a jerk-limited law needs nothing, nor does a "
            "point-to-point move without zones"
        ) from error

    logging.getLogger("toppra").setLevel(logging.CRITICAL)  # what it fails at is solved otherwise, or told as an error

    class Limits(LinearConstraint):
        def __init__(self) -> None:
            super().__init__()
            self.set_discretization_type(DiscretizationType.Interpolation)
            self.constraint_type = ConstraintType.CanonicalLinear
            self.identical = True

        def compute_constraint_params(self, path: object, gridpoints: Array, *_: object) -> tuple:
            eye, ones = np.eye(slope.shape[1]), np.ones(2 * slope.shape[1])
            linear = (slope, bend, np.zeros_like(slope), np.concatenate([eye, -eye]), ones)
            squares = np.stack([np.zeros(len(top)), top**2], axis=1)
            return *canlinear_colloc_to_interpolate(*linear, None, None, gridpoints, identical=True)[:5], None, squares

    solver = TOPPRA([Limits()], _Line(nodes), gridpoints=nodes, solver_wrapper="seidel")
    return solver.compute_parameterization(0.0, 0.0)[1]


class _Line:
    """Path as toppra asks for it where the constraints are known already: only its range."""

    dof = 1

    def __init__(self, nodes: Array) -> None:
        self.path_interval = nodes[[0, -1]]


def _quadratic(nodes: Array, speeds: Array) -> PiecewisePolynomial:
    """Return the law that passes the nodes with these speeds, with constant s'' in between."""
    seconds = 2.0 * np.diff(nodes) / (speeds[:-1] + speeds[1:])
    pieces = np.stack([nodes[:-1], speeds[:-1], 0.5 * np.diff(speeds) / seconds, np.zeros(len(seconds))], axis=1)
    return PiecewisePolynomial(np.concatenate([[0.0], np.cumsum(seconds)]), pieces[:, :, None])
