"""Joints as URDF can say them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

from virtualrobot_kernel.formats.export.names import legal, unique
from virtualrobot_kernel.world.structure import Joint, JointType, LinkData, Node

UNBOUNDED = 1e9
"""Substitute for an infinite position limit where URDF demands a number; rad or m."""


def joint_names(
    links: list[Node], owner_of: Callable[[int], Node | None]
) -> tuple[dict[int, str], dict[Node | None, dict[str, str]]]:
    """Return names for the joints of links, no two alike: by the link's uid, and of moving ones by robot and own name.

    Joints that move come first, since others follow them by their names; a fixed joint may share a name with another.
    `owner_of` gives the robot of a link (a uid).
    """
    by_uid: dict[int, str] = {}
    moving: dict[Node | None, dict[str, str]] = {}
    joints = {link.uid: link.data.joint for link in links if isinstance(link.data, LinkData)}
    for uid, joint in sorted(joints.items(), key=lambda item: item[1].type is JointType.FIXED):
        by_uid[uid] = unique(legal(joint.name or "joint"), by_uid.values())
        if joint.type is not JointType.FIXED:
            moving.setdefault(owner_of(uid), {})[joint.name] = by_uid[uid]
    return by_uid, moving


def urdf_joint(joint: Joint, name: str, moving: Mapping[str, str]) -> tuple[Joint, list[str]]:
    """Return the joint under another name, and what had to be changed besides.

    A joint that turns is revolute when it has limits and continuous when it has none. A prismatic or revolute joint
    must have two limits: UNBOUNDED stands for one that is missing.

    Args:
        joint: as the world has it.
        name: in the file.
        moving: names in the file of the joints of its robot that move, by their own.
    """
    mimic = replace(joint.mimic, joint=moving[joint.mimic.joint]) if joint.mimic else None
    kind, limits, oddities = joint.type, joint.limits, []
    if kind in (JointType.REVOLUTE, JointType.CONTINUOUS):
        limited = math.isfinite(limits.lower) or math.isfinite(limits.upper)
        kind = JointType.REVOLUTE if limited else JointType.CONTINUOUS
        if kind is not joint.type:
            oddities.append(
                f"the joint {name!r} has {'' if limited else 'no '}position limits: URDF calls it {kind.value[0]}"
            )
    if kind in (JointType.REVOLUTE, JointType.PRISMATIC):
        bounded = replace(limits, lower=max(limits.lower, -UNBOUNDED), upper=min(limits.upper, UNBOUNDED))
        if bounded != limits:
            oddities.append(f"the joint {name!r} lacks a position limit: {UNBOUNDED:g} stands for it")
        limits = bounded
    return Joint(name, kind, joint.axis, limits, mimic), oddities
