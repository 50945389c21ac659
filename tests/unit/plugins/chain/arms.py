"""The four serial arms of the tests as kinematics components."""

from __future__ import annotations

import numpy as np
from virtualrobot_kernel.planning.extract import extract_chain
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.kinematics import SerialChain

from ...numeric.urdf_arrays import ARMS, URDFS, Forest, read


def extract(forest: Forest, base: str, tip: str) -> tuple[SerialChain, np.ndarray]:
    """Return the chain between two links and the coordinates of the forest that it uses."""
    return extract_chain(
        forest.links.index(base),
        forest.links.index(tip),
        parent=forest.parent,
        joint_type=forest.joint_type,
        axis=forest.axis,
        q_index=forest.q_index,
        multiplier=forest.multiplier,
        offset=forest.offset,
        parent_t_node=forest.parent_t_node,
        lower=forest.lower,
        upper=forest.upper,
        joint_names=forest.joints,
    )


def arm_chain(name: str) -> SerialChain:
    """Return the chain of an arm from its base link to its tip link."""
    return extract(read(URDFS[name]), *ARMS[name])[0]


def arm(name: str) -> ChainKinematics:
    """Return an arm as a component."""
    return ChainKinematics(arm_chain(name))
