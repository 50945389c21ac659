"""The arms of the tests of closed forms: as the kernel reads their model files, or by their published tables."""

from __future__ import annotations

from functools import cache

import numpy as np
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.planning.robots import arm_of, world_poses
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_plugins.closed_form.component import ClosedFormKinematics
from virtualrobot_sdk.kinematics import SerialChain
from virtualrobot_sdk.testing.chains import ur5

from tests.unit.formats.models import XacroOnly, disk, imported
from tests.unit.world.builders import after, empty

NAMED = ("puma560", "ur5", "irb2400", "kr16")
"""An arm with a lateral shoulder, one with three parallel axes, and two with a shoulder before axis 1."""

FILES = {"irb2400": "package://rtbdata/xacro/abb_irb140_description/urdf/irb140.xacro"}
"""Arms that no model is: the lengths in this file are those of an IRB 2400."""


@cache
def arm_chain(name: str) -> SerialChain:
    """Return the chain of a robot of the kernel's model table; `ur5` is by its maker's table."""
    if name == "ur5":
        return ur5()
    files = disk()
    model = imported(FILES.get(name, f"model://{name}"), files, MeshLibrary(files.store, XacroOnly()))
    world = after(empty(), CreateNodes(model.nodes))
    robot = next(node for node in world.structure.nodes.values() if node.kind is Kind.ROBOT)
    poses = world_poses(world.structure, world.state)
    return arm_of(Snapshot(world.structure, world.state, poses, 0, 0.0, 0.004), robot).serial()


@cache
def closed_form(name: str) -> ClosedFormKinematics:
    """Return an arm as the component."""
    return ClosedFormKinematics(arm_chain(name))


@cache
def numeric(name: str) -> ChainKinematics:
    """Return an arm as the component `chain`, which knows nothing of closed forms."""
    return ChainKinematics(arm_chain(name))


def distances(solutions: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return for each solution (m, k) the largest difference to q (k,), but for full turns (rad)."""
    return np.abs((solutions - q + np.pi) % (2.0 * np.pi) - np.pi).max(axis=1)


def closure(name: str, solutions: np.ndarray, target: np.ndarray) -> float:
    """Return the largest difference of an entry of the tips' poses from the target, by `chain`'s forward pass."""
    return max(float(np.abs(numeric(name).forward(q)[-1] - target).max()) for q in solutions)


def factors(name: str, q: np.ndarray) -> np.ndarray:
    """Return what is zero where an arm is singular: shoulder (m), elbow (m^2) and wrist, (3,), by vector algebra."""
    chain, frames = arm_chain(name), numeric(name).forward(q)
    h = np.einsum("nij,nj->ni", frames[:-1, :3, :3], chain.axis)
    p = frames[:-1, :3, 3]
    # The wrist's centre is where axes 5 and 6 meet: p_6 + t h_6 with (p_6 + t h_6 - p_5) x h_5 = 0.
    across = np.cross(h[5], h[4])
    centre = p[5] + h[5] * (np.cross(p[4] - p[5], h[4]) @ across / (across @ across))
    carried = p[3] if name == "ur5" else centre
    return np.array(
        [
            np.cross(h[0], centre - p[0]) @ h[1],
            np.cross(p[2] - p[1], carried - p[2]) @ h[1],
            np.cross(h[3], h[4]) @ h[5],
        ]
    )
