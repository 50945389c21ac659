"""Joints as URDF can say them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from virtualrobot_kernel.formats.export.names import legal, unique
from virtualrobot_kernel.world.structure import Joint, JointType, LinkData, Node

UNBOUNDED = 1e9
"""Substitute for an infinite position limit where URDF demands a number; rad or m."""


def joint_names(links: list[Node]) -> tuple[dict[int, str], dict[str, str]]:
    """Return names for the joints of a robot's links, no two alike: by the link's uid, and of moving ones by their own.

    Joints that move come first, since others follow them by their names; a fixed joint may share a name with another.
    """
    by_uid: dict[int, str] = {}
    moving: dict[str, str] = {}
    joints = {link.uid: link.data.joint for link in links if isinstance(link.data, LinkData)}
    for uid, joint in sorted(joints.items(), key=lambda item: item[1].type is JointType.FIXED):
        by_uid[uid] = unique(legal(joint.name or "joint"), by_uid.values())
        if joint.type is not JointType.FIXED:
            moving[joint.name] = by_uid[uid]
    return by_uid, moving


def urdf_joint(joint: Joint, name: str, moving: Mapping[str, str]) -> tuple[Joint, list[str]]:
    """Return the joint under another name, and what had to be changed besides.

    A joint that turns is revolute when it has limits and continuous when it has none. A prismatic or revolute joint
    must have two limits: UNBOUNDED stands for one that is missing.

    Args:
        joint: as the world has it.
        name: in the file.
        moving: names in the file of the joints that move, by their own.
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
