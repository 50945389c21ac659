"""Accuracy over positions: an arm of three joints, whose Jacobian is written down, and draws of its joints."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray
from virtualrobot_apps.studies.accuracy import accuracy
from virtualrobot_apps.studies.parameters import generator
from virtualrobot_apps.studies.work import Cell

Floats = NDArray[np.float64]

L2, L3 = 0.5, 0.4


def point(q: Floats) -> Floats:
    """Return where the tip is: q[0] turns about z, q[1] and q[2] bend in the plane that this is (m)."""
    out = L2 * math.cos(q[1]) + L3 * math.cos(q[1] + q[2])
    up = L2 * math.sin(q[1]) + L3 * math.sin(q[1] + q[2])
    return np.array([math.cos(q[0]) * out, math.sin(q[0]) * out, up])


class Shoulder:
    """World of such an arm, at the origin; at its target the elbow is up or down, and down it touches something."""

    def __init__(self, target: Floats, down_is_free: bool = False) -> None:
        """Take the target's place (3,)."""
        self.target, self.down_is_free = target, down_is_free

    def restore(self) -> None:
        pass

    def pose(self, node: str) -> Floats:
        found = np.eye(4)
        found[:3, 3] = self.target
        return found

    def postures(self, robot: str, poses: Floats) -> SimpleNamespace:
        x, y, z = poses[0, :3, 3]
        out = math.hypot(x, y)
        bend = (out**2 + z**2 - L2**2 - L3**2) / (2.0 * L2 * L3)
        if abs(bend) > 1.0:
            return SimpleNamespace(positions=np.empty((0, 3)), free=np.zeros(0, bool), touching=())
        rows = []
        for sign in (-1.0, 1.0):
            last = sign * math.acos(bend)
            first = math.atan2(z, out) - math.atan2(L3 * math.sin(last), L2 + L3 * math.cos(last))
            rows.append([math.atan2(y, x), first, last])
        free = np.array([True, self.down_is_free])
        touching = (None, None if self.down_is_free else ("elbow", "table"))
        return SimpleNamespace(positions=np.array(rows), free=free, touching=touching)

    def kinematic_errors(self, robot: str) -> SimpleNamespace:
        def poses(errors: Floats, postures: Floats) -> Floats:
            found = np.tile(np.eye(4), (len(postures), 1, 1))
            found[:, :3, 3] = [point(q) for q in postures]
            return found

        return SimpleNamespace(count=24, poses=poses)


def told(world: Shoulder, **parameters: object) -> dict:
    asked = {"robot": "arm", "target": "seam", "joints": 1e-3} | parameters
    return accuracy(Cell(0, asked, generator(1, 0), world, None))


def test_deviations_are_those_of_the_written_jacobian_and_of_draws(rng: np.random.Generator) -> None:
    """The columns of J have the lengths of the point's distances from each axis; its z axis is the world's here."""
    target = np.array([0.5, 0.2, 0.3])
    found = told(Shoulder(target))
    (q, _) = Shoulder(target).postures("", np.array([[[1, 0, 0, 0.5], [0, 1, 0, 0.2], [0, 0, 1, 0.3]]])).positions
    np.testing.assert_allclose(point(q), target, atol=1e-12)
    out = math.hypot(0.5, 0.2)
    assert found["deviation"] == pytest.approx(1e-3 * math.sqrt(out**2 + (out**2 + 0.3**2) + L3**2), rel=1e-6)
    # Up and down it moves by the horizontal distance from the second axis, and from the third.
    rest = out - L2 * math.cos(q[1])
    assert found["along"] == pytest.approx(1e-3 * math.hypot(out, rest), rel=1e-6)
    assert found["across"] == pytest.approx(math.sqrt(found["deviation"] ** 2 - found["along"] ** 2), rel=1e-9)
    drawn = np.array([point(q + 1e-3 * rng.normal(size=3)) for _ in range(4000)]) - target
    assert math.sqrt((drawn**2).sum(axis=1).mean()) == pytest.approx(found["deviation"], rel=0.05)
    assert drawn[:, 2].std() == pytest.approx(found["along"], rel=0.05)
    # |det J| of such an arm is L2 L3 |sin q3| times the distance from the first axis; the product of singular values.
    assert 0.0 < found["dexterity"] ** 3 <= L2 * L3 * abs(math.sin(q[2])) * out
    assert told(Shoulder(target, down_is_free=True))["deviation"] <= found["deviation"] + 1e-12


def test_a_place_beside_the_target_is_another_one() -> None:
    beside = told(Shoulder(np.array([0.5, 0.2, 0.3])), dx=0.1, dz=-0.1)
    np.testing.assert_allclose(
        [value for value in beside.values() if value is not None],
        [value for value in told(Shoulder(np.array([0.6, 0.2, 0.2]))).values() if value is not None],
        rtol=1e-9,
    )
    stretched = told(Shoulder(np.array([0.9 - 1e-9, 0.0, 0.0])))
    assert stretched["dexterity"] < 1e-4 and stretched["reason"] is None


def test_why_there_is_none_is_told() -> None:
    far = told(Shoulder(np.array([2.0, 0.0, 0.0])))
    assert (far["deviation"], far["reason"]) == (None, "out of reach")
    touching = Shoulder(np.array([0.5, 0.2, 0.3]))
    touching.postures = lambda robot, poses: SimpleNamespace(  # type: ignore[method-assign]
        positions=np.zeros((1, 3)), free=np.array([False]), touching=(("elbow", "table"),)
    )
    assert told(touching)["reason"] == "elbow touches table"
    with pytest.raises(ValueError, match="joints is 0 or more, not -1"):
        told(Shoulder(np.array([0.5, 0.2, 0.3])), joints=-1.0)
