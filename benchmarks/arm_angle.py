"""The component `arm_angle` against TRAC-IK on the same arm and poses: all branches against one posture.

The arm is the iiwa 14 of PyBullet; both start from the middle of the joints' ranges, within limits. Locked joints too:
what it costs to make an arm of the Panda with joint 7 locked, against one call of TRAC-IK on the whole Panda.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
from trac_ik import TracIK
from virtualrobot_kernel.planning.extract import lock_coordinates
from virtualrobot_plugins.arm_angle.component import ArmAngleKinematics
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_plugins.closed_form.component import ClosedFormKinematics
from virtualrobot_sdk.kinematics import Floats, InverseOptions

from benchmarks.closed_form import microseconds
from benchmarks.kinematics import ARMS, Arm, chain_of
from benchmarks.rows import Row, row

POSES = 300


def trac_ik(arm: Arm, seed: Floats) -> Callable[[Floats], object]:
    """Return one call of TRAC-IK: the first posture that it finds from a seed."""
    base = {"iiwa 14": "lbr_iiwa_link_0", "Panda": "panda_link0"}[arm.name]
    solver = TracIK(base, arm.tip, str(arm.urdf), timeout=0.02, epsilon=1e-5, solver_type="Speed")
    return lambda target: solver.ik(target[:3, 3], target[:3, :3], seed)


def run() -> list[Row]:
    """Measure and return the rows."""
    rng = np.random.default_rng()
    iiwa, panda = (chain_of(arm) for arm in ARMS[:2])
    kinematics = ArmAngleKinematics(iiwa)
    targets = [kinematics.forward(q)[-1] for q in rng.uniform(iiwa.lower, iiwa.upper, (POSES, 7))]
    peer = microseconds(trac_ik(ARMS[0], (iiwa.lower + iiwa.upper) / 2.0), targets)
    options = InverseOptions(arm_angle=float(rng.uniform(-1.0, 1.0)), respect_limits=False)
    at_one = microseconds(lambda target: kinematics.inverse(target, options), targets)
    any_angle = InverseOptions(seed=(iiwa.lower + iiwa.upper) / 2.0)
    every = microseconds(lambda target: kinematics.inverse(target, any_angle), targets)
    locked = itertools.cycle(rng.uniform(panda.lower[6], panda.upper[6], POSES))
    whole = ChainKinematics(panda)
    reached = [whole.forward(q)[-1] for q in rng.uniform(panda.lower, panda.upper, (POSES // 3, 7))]
    made = microseconds(lambda _: ClosedFormKinematics(lock_coordinates(panda, {6: next(locked)})[0]), reached[:20])
    other = microseconds(trac_ik(ARMS[1], (panda.lower + panda.upper) / 2.0), reached)
    name = "TRAC-IK, one posture"
    return [
        row("all 8 branches at an arm angle, iiwa", at_one, peer, name, "µs", 0.3),
        row("all branches, each at its nearest arm angle within limits, iiwa", every, peer, name, "µs", None),
        row("an arm made of the Panda with joint 7 locked", made, other, name, "µs", None),
    ]
