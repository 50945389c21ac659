"""Fit of components to crafts of all kinds: where their base and drives are on a robot, and their answers, checked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.arrays import is_finite
from virtualrobot_sdk.errors import ComponentFault, FaultKind

from virtualrobot_kernel.components.running import ComponentHandle
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.craft_data import Craft
from virtualrobot_kernel.world.structure import Coordinate, Node, Structure

Floats = NDArray[np.float64]

FARTHEST = 1e9
"""Greatest number (m, rad, or per s) that a component may answer."""

RIGID = 1e-6
"""Largest error of a pose that a component returns from a rigid one."""


class Moved(NamedTuple):
    """Coordinates and velocities of a craft at the end of a tick, by their places."""

    q: dict[int, float]
    v: dict[int, float]


class Fitted(NamedTuple):
    """Joint of a drive or a passive wheel: its name, its coordinate, and joint = ratio * drive."""

    joint: str
    coordinate: Coordinate
    ratio: float


def standing(q: Floats, places: Sequence[int], rates: Sequence[int]) -> Moved:
    """Return some coordinates as they are, and velocities of 0."""
    return Moved({at: float(q[at]) for at in places}, dict.fromkeys(rates, 0.0))


def center_of(craft: Craft) -> Floats:
    """Return where a component has its base, in the frame of the link that the base joint moves (4, 4)."""
    pose = np.eye(4)
    cosine, sine = math.cos(craft.heading), math.sin(craft.heading)
    pose[:2, :2] = [[cosine, -sine], [sine, cosine]]
    pose[:2, 3] = craft.center_x, craft.center_y
    return pose


def fitted(
    structure: Structure, node: Node, craft: Craft, drives: Sequence[str], passive: Sequence[str] = ()
) -> dict[str, Fitted]:
    """Return the joint of each drive of a component, and of passive wheels those that the robot has.

    Raises KernelError where the craft names a drive that the component lacks, for a drive that no joint is, for two
    of one name, and for two that move one joint.
    """
    own = {one.drive: (one.joint, one.ratio) for one in craft.drives}
    names = (*drives, *passive)
    if twice := next((name for place, name in enumerate(names) if name in names[:place]), None):
        raise KernelError(
            f"the component {craft.kinematics!r} has the drive {twice!r} twice; each needs a name of its own",
            reason=Reason.PLUGIN_FAILED,
            robot=node.name,
            drive=twice,
        )
    if unknown := [name for name in own if name not in names]:
        raise KernelError(
            f"the component {craft.kinematics!r} has no drive {unknown[0]!r}; its drives are {', '.join(drives)}"
            + (f", and {', '.join(passive)} turn with it" if passive else ""),
            robot=node.name,
            drive=unknown[0],
        )
    coordinates = structure.robots[node.uid].coordinates
    found = {name: own.get(name, (name, 1.0)) for name in names}
    if missing := [name for name in drives if found[name][0] not in coordinates]:
        raise KernelError(
            f"the component {craft.kinematics!r} has the drive {missing[0]!r}, and {node.name!r} no such joint; "
            f"say in `drives` which joint it is; joints are {', '.join(coordinates)}",
            robot=node.name,
            drive=missing[0],
        )
    movers: dict[str, str] = {}
    for name, (joint, _) in found.items():
        if (other := movers.setdefault(joint, name)) != name:
            raise KernelError(
                f"the joint {joint!r} of {node.name!r} would be moved by the drives {other!r} and {name!r}; say in "
                "`drives` which joint each is",
                robot=node.name,
                drive=name,
            )
    return {
        name: Fitted(joint, coordinates[joint], ratio) for name, (joint, ratio) in found.items() if joint in coordinates
    }


def checked(component: ComponentHandle, method: str, value: object, shape: tuple[int, ...]) -> Floats:
    """Return what a method answered; raise KernelError unless it is finite, and of this shape."""
    if not isinstance(value, np.ndarray) or value.dtype != np.float64 or value.shape != shape:
        what = f"an array {value.shape} of {value.dtype}" if isinstance(value, np.ndarray) else type(value).__name__
        raise nonsense(component, f"{method} returned {what}; it must be a float64 array {shape}")
    if not is_finite(value):
        raise nonsense(component, f"{method} returned {value.tolist()}; all must be finite")
    if value.size and np.abs(value).max() > FARTHEST:
        raise nonsense(component, f"{method} returned {value.tolist()}; all must be within {FARTHEST:g}")
    return value


def checked_step(component: ComponentHandle, answer: object, what: str, *shapes: tuple[int, ...]) -> tuple[Floats, ...]:
    """Return the parts of a step, the first of which is a pose; raise KernelError for others than `what` says."""
    if not isinstance(answer, tuple) or len(answer) != len(shapes):
        raise nonsense(component, f"step returned {type(answer).__name__}; it must be {what}")
    found = tuple(checked(component, "step", value, shape) for value, shape in zip(answer, shapes, strict=True))
    rotation = found[0][:3, :3]
    if np.abs(rotation.T @ rotation - np.eye(3)).max() > RIGID:
        raise nonsense(component, f"step returned a pose that is not rigid: {found[0].tolist()}")
    return found


def nonsense(component: ComponentHandle, said: str) -> KernelError:
    """Return the error of a component whose answer is none."""
    return component.failed(ComponentFault(FaultKind.NONSENSE, said))
