"""Kinematic errors of a chain: six small ones behind its base and each joint, and what measured points tell of them.

Six for each are more than can be told apart: of poses 4 R + 2 P + 6 can, for R turning and P sliding joints
(L. J. Everett, T. W. Hsu, "The theory of kinematic parameter identification for industrial robots", 1988).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.kinematics import REVOLUTE, SerialChain
from virtualrobot_sdk.poses import left_jacobian, rotation_matrix

from virtualrobot_kernel.planning.fitting import LeastFit, least_fit, told

Floats = NDArray[np.float64]


class KinematicErrors:
    """Chain whose links are a little other than modelled.

    Its errors e (6 (n + 1),) are for the base, then behind each of the n joints, x, y, z (m) and a rotation vector
    (rad), in the frame there.
    """

    def __init__(self, chain: SerialChain, tip_t_target: Floats) -> None:
        """Take a chain, and where what is measured is in the frame of its tip, (4, 4)."""
        self._chain = chain
        self._post = chain.post @ tip_t_target
        self.count = 6 * (len(chain.axis) + 1)
        """Number of errors."""

    def poses(self, errors: Floats, postures: Floats) -> Floats:
        """Return base_t_target (m, 4, 4) at postures (m, k), rad or m, with errors."""
        return self._frames(errors, postures)[-1]

    def slopes(self, errors: Floats, postures: Floats) -> Floats:
        """Return how far the target moves and turns, (m, 6, count), linear rows first, for small changes of errors."""
        frames = self._frames(errors, postures)
        target = frames[-1][:, :3, 3]
        found = np.zeros((len(postures), 6, self.count))
        for place, frame in enumerate(frames[:-1]):
            at, vector = 6 * place, errors[6 * place + 3 : 6 * place + 6]
            # The error is one of the frame before it turned.
            turn = frame[:, :3, :3] @ rotation_matrix(vector).T
            axes = turn @ left_jacobian(vector)
            found[:, :3, at : at + 3] = turn
            found[:, 3:, at + 3 : at + 6] = axes
            found[:, :3, at + 3 : at + 6] = np.cross(axes, (target - frame[:, :3, 3])[:, :, None], axis=1)
        return found

    def fit(self, postures: Floats, points: Floats) -> LeastFit:
        """Return the errors with which the target was at points (m, 3) of the base's frame in m postures."""

        def residuals(errors: Floats) -> tuple[Floats, Floats]:
            off = self.poses(errors, postures)[:, :3, 3] - points
            return off, self.slopes(errors, postures)[:, :3]

        return least_fit(residuals, self.count)

    def ranks(self, postures: Floats) -> tuple[int, int]:
        """Return how many errors can be told apart by poses, and by points, that are measured in m postures (m, k)."""
        slopes = self.slopes(np.zeros(self.count), postures)
        return told(slopes.reshape(-1, self.count)), told(slopes[:, :3].reshape(-1, self.count))

    def _frames(self, errors: Floats, postures: Floats) -> list[Floats]:
        """Return base_t_frame (m, 4, 4) behind each error, and of the target."""
        chain = self._chain
        at = np.tile(_error(errors[:6]), (len(postures), 1, 1))
        found = [at]
        for place, axis in enumerate(chain.axis):
            value = chain.multiplier[place] * postures[:, chain.q_index[place]] + chain.offset[place]
            joint = np.tile(np.eye(4), (len(postures), 1, 1))
            if chain.joint_type[place] == REVOLUTE:
                joint[:, :3, :3] = [rotation_matrix(one * axis) for one in value]
            else:
                joint[:, :3, 3] = value[:, None] * axis
            at = at @ chain.pre[place] @ joint @ _error(errors[6 * place + 6 : 6 * place + 12])
            found.append(at)
        return [*found, at @ self._post]


def _error(error: Floats) -> Floats:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation_matrix(error[3:]), error[:3]
    return pose
