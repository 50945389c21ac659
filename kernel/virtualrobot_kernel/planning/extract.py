"""Cut a serial chain out of the forest: joints between a base row and a tip row, fixed and locked ones folded in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from virtualrobot_sdk.kinematics import Codes, Floats, Integers, SerialChain
from virtualrobot_sdk.reference import joint_motion

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.numeric.forest import FIXED, PRISMATIC, REVOLUTE


def extract_chain(
    base_row: int,
    tip_row: int,
    *,
    parent: Integers,
    joint_type: Codes,
    axis: Floats,
    q_index: Integers,
    multiplier: Floats,
    offset: Floats,
    parent_t_node: Floats,
    lower: Floats,
    upper: Floats,
    joint_names: Mapping[int, str] | Sequence[str],
) -> tuple[SerialChain, Integers]:
    """Return the chain from one row of the forest to another, and the index in q of each of its k coordinates.

    The base frame is that of `base_row`, after its own joint. Coordinates are ordered as met from base to tip; a mimic
    joint shares its source's. Forest arrays are those of `numeric.forest.forward_forest`; `lower` and `upper` (nq,)
    are the limits of each entry of q, `joint_names` their names.

    Raises KernelError when the tip doesn't hang on the base, when no joint between them moves, or when one of them is
    floating or planar (a chain has only joints of one coordinate).
    """
    rows: list[int] = []
    row = tip_row
    while row != base_row:
        if row < 0 or len(rows) > len(parent):
            raise KernelError(f"row {tip_row} does not hang on row {base_row}", tip_row=tip_row, base_row=base_row)
        rows.append(row)
        row = int(parent[row])
    since_joint = np.eye(4)
    moving: list[int] = []
    pre: list[Floats] = []
    for row in reversed(rows):
        since_joint = since_joint @ parent_t_node[row]
        kind = joint_type[row]
        if kind == FIXED:
            continue
        if kind not in (REVOLUTE, PRISMATIC):
            raise KernelError(
                f"row {row} has a floating or planar joint; a chain takes only revolute and prismatic ones",
                reason=Reason.INVALID_ARGUMENT,
                row=row,
            )
        moving.append(row)
        pre.append(since_joint)
        since_joint = np.eye(4)
    if not moving:
        raise KernelError(
            f"no joint moves between row {base_row} and row {tip_row}", base_row=base_row, tip_row=tip_row
        )
    coordinates = list(dict.fromkeys(int(q_index[row]) for row in moving))
    chain = SerialChain(
        pre=np.array(pre),
        axis=np.ascontiguousarray(axis[moving], np.float64),
        joint_type=np.ascontiguousarray(joint_type[moving], np.int8),
        q_index=np.array([coordinates.index(int(q_index[row])) for row in moving], np.int32),
        multiplier=np.ascontiguousarray(multiplier[moving], np.float64),
        offset=np.ascontiguousarray(offset[moving], np.float64),
        post=since_joint,
        lower=np.array(lower[coordinates], np.float64),
        upper=np.array(upper[coordinates], np.float64),
        joint_names=tuple(joint_names[i] for i in coordinates),
    )
    return chain, np.array(coordinates, np.int32)


def lock_coordinates(chain: SerialChain, values: Mapping[int, float]) -> tuple[SerialChain, Integers]:
    """Return the chain whose coordinates (from 0) in `values` stand still at these radians or metres.

    Also the coordinates that are left, (k - locked,), in order. At least one must be left.
    """
    free = np.array([i for i in range(len(chain.joint_names)) if i not in values], np.int32)
    moving: list[int] = []
    pre: list[Floats] = []
    pose = np.eye(4)
    for i, coordinate in enumerate(chain.q_index):
        pose = pose @ chain.pre[i]
        if coordinate not in values:
            moving.append(i)
            pre.append(pose)
            pose = np.eye(4)
            continue
        value = np.array(chain.multiplier[i] * values[int(coordinate)] + chain.offset[i])
        pose = pose @ joint_motion(int(chain.joint_type[i]), chain.axis[i], value)
    reduced = SerialChain(
        pre=np.array(pre),
        axis=np.ascontiguousarray(chain.axis[moving]),
        joint_type=np.ascontiguousarray(chain.joint_type[moving]),
        q_index=np.searchsorted(free, chain.q_index[moving]).astype(np.int32),
        multiplier=np.ascontiguousarray(chain.multiplier[moving]),
        offset=np.ascontiguousarray(chain.offset[moving]),
        post=pose @ chain.post,
        lower=np.array(chain.lower[free]),
        upper=np.array(chain.upper[free]),
        joint_names=tuple(chain.joint_names[i] for i in free),
    )
    return reduced, free
