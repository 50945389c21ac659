"""The Cartesian line: the tool centre point moves straight while its orientation turns about one fixed axis (slerp)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.polynomial import Array

#: Below these a line has no length (m) or no turn (rad): moving is pointless and the axis undefined.
SHORTEST_LENGTH, SMALLEST_ANGLE = 1e-9, 1e-9


@dataclass(frozen=True, eq=False)
class CartesianLine:
    """Poses base_t_tcp(u), u in [0, 1], from `base_t_start` to the goal, (4, 4) each.

    position = start + u * translation; rotation = Rot(u * rotation) R_start with the rotation vector in the base
    frame. So the twist (translation, rotation) per unit of u is constant: (6,) in m and rad, base frame, at the TCP.
    """

    base_t_start: Array
    twist: Array

    @property
    def length(self) -> float:
        """The length of the position line in m."""
        return float(np.linalg.norm(self.twist[:3]))

    @property
    def angle(self) -> float:
        """The angle that the orientation turns, in rad."""
        return float(np.linalg.norm(self.twist[3:]))

    def pose(self, u: float) -> Array:
        """Return base_t_tcp (4, 4) at the fraction `u`."""
        pose = self.base_t_start.copy()
        pose[:3, 3] += u * self.twist[:3]
        pose[:3, :3] = rotation_matrix(u * self.twist[3:]) @ pose[:3, :3]
        return pose

    def deviation(self, u: float, base_t_tcp: Array) -> Array:
        """Return the twist (6,) that takes `base_t_tcp` to the line's pose at `u`: m and rad in the base frame."""
        wanted = self.pose(u)
        turn = rotation_vector(wanted[:3, :3] @ base_t_tcp[:3, :3].T)
        return np.concatenate([wanted[:3, 3] - base_t_tcp[:3, 3], turn])

    def place(self, u: float) -> tuple[str, dict[str, object]]:
        """Return where `u` is, as words and as metadata: fraction, millimetres, degrees, position in the base frame."""
        x, y, z = self.pose(u)[:3, 3]
        travelled, whole = u * self.length * 1e3, self.length * 1e3
        turned, turn = np.degrees(u * self.angle), np.degrees(self.angle)
        words = (
            f"at {100.0 * u:.1f}% of the line ({travelled:.1f} of {whole:.1f} mm, {turned:.1f} of {turn:.1f} degrees, "
            f"TCP at x {x:.4f}, y {y:.4f}, z {z:.4f} m in the base frame)"
        )
        position = f"{x:.6f}, {y:.6f}, {z:.6f}"
        return words, {
            "fraction": f"{u:.6f}",
            "millimeters": f"{travelled:.3f}",
            "degrees": f"{turned:.3f}",
            "position": position,
        }


def cartesian_line(base_t_start: Array, base_t_goal: Array) -> CartesianLine:
    """Return the line between two poses (4, 4); the turn takes the shorter way.

    Raises KernelError when `base_t_goal` is not a pose.
    """
    check_pose(base_t_goal, "the goal of a LIN motion")
    translation = base_t_goal[:3, 3] - base_t_start[:3, 3]
    rotation = rotation_vector(base_t_goal[:3, :3] @ base_t_start[:3, :3].T)
    if np.linalg.norm(translation) < SHORTEST_LENGTH:
        translation = np.zeros(3)
    if np.linalg.norm(rotation) < SMALLEST_ANGLE:
        rotation = np.zeros(3)
    return CartesianLine(np.array(base_t_start, dtype=np.float64), np.concatenate([translation, rotation]))


def check_pose(pose: Array, what: str) -> None:
    """Raise KernelError unless `pose` is a finite rigid transform (4, 4), to 1e-6."""
    if pose.shape != (4, 4) or not np.all(np.isfinite(pose)):
        raise KernelError(f"{what} must be a finite pose (4, 4), not {pose.tolist()}")
    rotation = pose[:3, :3]
    skewness = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if skewness > 1e-6 or np.linalg.det(rotation) < 0.0 or np.abs(pose[3] - (0.0, 0.0, 0.0, 1.0)).max() > 1e-9:
        raise KernelError(f"{what} must be a rigid transform; its rotation is off by {skewness:.3g}")


def rotation_matrix(vector: Array) -> Array:
    """Return the rotation (3, 3) about `vector` (3,) by its length (Rodrigues' formula)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3) + _skew(vector)
    axis = _skew(vector / angle)
    return np.eye(3) + np.sin(angle) * axis + (1.0 - np.cos(angle)) * (axis @ axis)


def rotation_vector(rotation: Array) -> Array:
    """Return axis times angle (3,), angle in [0, pi], of a rotation (3, 3).

    By way of the quaternion with its largest element taken from the diagonal (Shepperd, Quaternion from Rotation
    Matrix, Journal of Guidance and Control 1978), so that it is exact to rounding at small angles and at pi.
    """
    m = rotation
    diagonal = (float(np.trace(m)), float(m[0, 0]), float(m[1, 1]), float(m[2, 2]))
    largest = int(np.argmax(diagonal))
    quaternion = np.empty(4)  # w, x, y, z, unnormalised
    if largest == 0:
        quaternion[:] = 1.0 + diagonal[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    else:
        i = largest - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        quaternion[0] = m[k, j] - m[j, k]
        quaternion[1 + i] = 1.0 + m[i, i] - m[j, j] - m[k, k]
        quaternion[1 + j] = m[j, i] + m[i, j]
        quaternion[1 + k] = m[k, i] + m[i, k]
    if quaternion[0] < 0.0:
        quaternion = -quaternion
    length = float(np.linalg.norm(quaternion[1:]))
    if length == 0.0:
        return np.zeros(3)
    return quaternion[1:] * (2.0 * np.arctan2(length, quaternion[0]) / length)


def _skew(v: Array) -> Array:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
