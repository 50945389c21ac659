"""The kinematics component `dh`: an arm as its Denavit-Hartenberg table says, whatever the robot's tree says."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot_sdk.denavit_hartenberg import Row, Table, serial_arrays
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import PRISMATIC, Floats, InverseOptions, InverseResult, SerialChain

from virtualrobot_plugins.chain.component import ChainKinematics

_DEFAULTS = InverseOptions()


class DhKinematics:
    """Kinematics by a Denavit-Hartenberg table, standard or modified; solved numerically.

    Of the robot it takes the names, limits and couplings of its joints, nothing of its geometry. So its answers differ
    from the robot's tree by as much as the table does, which the self-check tells.
    """

    def __init__(self, chain: SerialChain, table: Table) -> None:
        """Take the joints of `chain` and the geometry of `table`.

        Raises ArgumentError when the table has another number of rows than the robot has joints, or when a row is of
        another type than its joint.
        """
        names = [chain.joint_names[i] for i in chain.q_index]
        if len(table.rows) != len(names):
            raise ArgumentError(
                f"the table has {len(table.rows)} rows, but the robot has {len(names)} joints from its base to its "
                f"flange: {', '.join(names)}; give a row for each",
                rows=len(table.rows),
                joints=len(names),
            )
        for i, (row, kind, name) in enumerate(zip(table.rows, chain.joint_type, names, strict=True)):
            _check_type(i, row, "prismatic" if kind == PRISMATIC else "revolute", name)
        pre, axis, joint_type, post, self._joint_t_row = serial_arrays(table)
        self._solver = ChainKinematics(chain._replace(pre=pre, axis=axis, joint_type=joint_type, post=post))

    def forward(self, q: ArrayLike, /) -> Floats:
        """Return the poses (n + 1, 4, 4) of the table's frames T_0^1 to T_0^n and of the flange in the base, at q (k,).

        `base_t_first` and `last_t_flange` of the table are included.
        """
        poses = self._solver.forward(q)
        return np.concatenate([poses[:-1] @ self._joint_t_row, poses[-1:]])

    def jacobian(self, q: ArrayLike, /) -> Floats:
        """Return the geometric Jacobian (6, k) of the flange at q (k,): linear rows first, in the base frame."""
        return self._solver.jacobian(q)

    def inverse(self, base_t_tip: ArrayLike, options: InverseOptions = _DEFAULTS, /) -> InverseResult:
        """Return a posture that puts the table's flange at `base_t_tip` (4, 4), as `chain` finds it.

        Raises ArgumentError when the target is no finite rigid transform, or when an option makes no sense.
        """
        return self._solver.inverse(base_t_tip, options)


def _check_type(place: int, row: Row, kind: str, joint: str) -> None:
    if row.type != kind:
        raise ArgumentError(
            f"rows[{place}] is {row.type}, but the robot's joint {joint!r} is {kind}",
            row=place,
            type=row.type,
            joint=joint,
        )
