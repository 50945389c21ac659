"""Figures of a robot made of a Denavit-Hartenberg table: joints are cylinders, lengths boxes, offsets rods.

A table says where axes are and nothing of the bodies between them. So the sizes are a choice: all follow from the
lengths of the arm together, the wrist half as thick as the shoulder.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from virtualrobot_sdk.denavit_hartenberg import SerialArrays, Table, pose
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_kernel.world.figures import Box, Cylinder, Figure, Geometry, Material
from virtualrobot_kernel.world.structure import Joint, JointType

BODY, JOINT, FOOT = (0.86, 0.86, 0.83, 1.0), (0.93, 0.45, 0.13, 1.0), (0.25, 0.27, 0.3, 1.0)
"""Colours of links, of joints, and of base and flange."""

THICKNESS = 0.05
"""Radius of the first joint relative to all lengths together."""

DEFAULT_REACH = 0.5
"""Size in meters of an arm without lengths, such as a wrist of three axes that meet."""

DEFAULT_STROKE = 0.3
"""Drawn stroke of a slider without limits, relative to all lengths together."""


class Skeleton:
    """Lengths (m) that figures are drawn from; links count from 0, the base, to n + 1, the flange."""

    def __init__(self, table: Table, arrays: SerialArrays, joints: Sequence[Joint]) -> None:
        """Measure the table."""
        self.table, self.arrays, self.joints = table, arrays, joints
        self.count = len(joints)
        lengths = sum(abs(row.a_meters) + abs(row.d_meters) for row in table.rows)
        lengths += sum(sum(_stroke(joint, 0.0)) for joint in joints)
        ends = math.hypot(*arrays.pre[0][:3, 3]), math.hypot(*pose(table.last_t_flange)[:3, 3])
        self.reach = lengths or sum(ends) or DEFAULT_REACH
        self.strokes = [_stroke(joint, DEFAULT_STROKE * self.reach) for joint in joints]

    def radius(self, link: int) -> float:
        """Return the radius (m) of the joint before a link; the base has the first joint's, the flange the last's."""
        along = min(max(link, 1), self.count) - 1
        return THICKNESS * self.reach * (1.0 - 0.5 * along / self.count)

    def length_between(self, first: int, second: int) -> float:
        """Return the lengths (m) between the end of link `first` and the beginning of link `second`."""
        return sum(self._length(link) for link in range(first + 1, second))

    def _length(self, link: int) -> float:
        """Return the distance between the joints before and after a link, or from the last joint to the flange."""
        beyond = self.arrays.post if link == self.count else self.arrays.pre[link]
        return math.hypot(*beyond[:3, 3])


def _stroke(joint: Joint, unknown: float) -> tuple[float, float]:
    """Return how far a sliding joint goes back and comes out (m), `unknown` without an upper limit; 0 for others."""
    if joint.type is not JointType.PRISMATIC:
        return 0.0, 0.0
    back = max(0.0, -joint.limits.lower) if math.isfinite(joint.limits.lower) else 0.0
    return back, max(0.0, joint.limits.upper) if math.isfinite(joint.limits.upper) else unknown


def draw(skeleton: Skeleton) -> list[tuple[Figure, ...]]:
    """Return the figures of each link, base and flange included, in the frames of the links."""
    drawn = [tuple(_base(skeleton))]
    drawn += [tuple(_link(skeleton, link)) for link in range(1, skeleton.count + 1)]
    return [*drawn, tuple(_flange(skeleton))]


def _base(skeleton: Skeleton) -> Iterator[Figure]:
    radius = skeleton.radius(0)
    yield _figure(Cylinder(1.8 * radius, 0.4 * radius), np.array([0.0, 0.0, 0.2 * radius]), FOOT)
    first = pose(skeleton.table.base_t_first)
    yield from _rod(np.zeros(3), first[:3, 3], radius)
    yield from _sleeve(skeleton, 0)
    if skeleton.table.convention == "modified":
        yield from _beam(first, skeleton.table.rows[0].a_meters, radius)


def _link(skeleton: Skeleton, link: int) -> Iterator[Figure]:
    """Yield joint, offset d and length a of one link, then the way to the flange or the sleeve of the next slider."""
    row, joint, radius = skeleton.table.rows[link - 1], skeleton.joints[link - 1], skeleton.radius(link)
    standard = skeleton.table.convention == "standard"
    # A standard joint turns about z where the link begins, a modified one beyond d, where its row's frame is.
    start = 0.0 if standard else -row.d_meters
    if joint.type is not JointType.PRISMATIC:
        lift = _lift(skeleton) if link == 1 else 0.0
        yield _figure(Cylinder(radius, 2.2 * radius), np.array([0.0, 0.0, start + lift]), JOINT)
    # A slider's rod reaches from its sleeve, wherever that is along the stroke, to where the link goes on.
    back, out = skeleton.strokes[link - 1]
    low, high = start + min(-out, row.d_meters), start + max(back, row.d_meters)
    yield from _rod(np.array([0.0, 0.0, low]), np.array([0.0, 0.0, high]), 0.7 * radius)
    if standard:
        half = row.theta_radians / 2.0
        at_offset = pose((0.0, 0.0, row.d_meters, 0.0, 0.0, math.sin(half), math.cos(half)))
        yield from _beam(at_offset, row.a_meters, radius)
    elif link < skeleton.count:
        yield from _beam(np.eye(4), skeleton.table.rows[link].a_meters, radius)
    if link < skeleton.count:
        yield from _sleeve(skeleton, link)
    else:
        end = skeleton.arrays.joint_t_row[-1]
        yield from _rod(end[:3, 3], skeleton.arrays.post[:3, 3], 0.7 * radius)


def _lift(skeleton: Skeleton) -> float:
    """Return the height (m) by which the first joint's cylinder is raised: one that stands upright is on the floor."""
    first = skeleton.arrays.pre[0]
    d = skeleton.table.rows[0].d_meters if skeleton.table.convention == "modified" else 0.0
    upright, height = first[2, 2] > 0.99, first[2, 3] - d * first[2, 2]
    return max(0.0, 1.1 * skeleton.radius(1) - height) if upright and height >= 0.0 else 0.0


def _sleeve(skeleton: Skeleton, link: int) -> Iterator[Figure]:
    """Yield the box at the end of a link in which the next joint slides, if that one does."""
    joint, row = skeleton.joints[link], skeleton.table.rows[link]
    if joint.type is JointType.PRISMATIC:
        place = skeleton.arrays.pre[link].copy()
        if skeleton.table.convention == "modified":
            place[:3, 3] -= place[:3, 2] * row.d_meters
        radius = skeleton.radius(link + 1)
        yield _figure(Box((2.0 * radius, 2.0 * radius, 2.4 * radius)), place, JOINT)


def _flange(skeleton: Skeleton) -> Iterator[Figure]:
    radius = skeleton.radius(skeleton.count + 1)
    yield _figure(Cylinder(1.1 * radius, 0.4 * radius), np.array([0.0, 0.0, -0.2 * radius]), FOOT)


def _beam(place: Floats, length: float, radius: float) -> Iterator[Figure]:
    """Yield the box along x of `place` (4, 4) for a length a of either sign."""
    if length != 0.0:
        middle = place.copy()
        middle[:3, 3] += place[:3, 0] * length / 2.0
        yield _figure(Box((abs(length), 1.2 * radius, 1.2 * radius)), middle, BODY)


def _rod(start: Floats, end: Floats, radius: float) -> Iterator[Figure]:
    """Yield the cylinder from one point (3,) to another."""
    along = end - start
    length = float(np.linalg.norm(along))
    if length > 0.0:
        z = along / length
        # Any two directions across the rod will do: the first is across the axis that the rod is least along.
        x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
        x /= np.linalg.norm(x)
        place = np.eye(4)
        place[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
        place[:3, 3] = (start + end) / 2.0
        yield _figure(Cylinder(radius, length), place, BODY)


def _figure(geometry: Geometry, place: Floats, color: tuple[float, float, float, float]) -> Figure:
    """Return a figure that is seen and collides, at a pose (4, 4) or a point (3,)."""
    pose = np.eye(4)
    if place.ndim == 1:
        pose[:3, 3] = place
    else:
        pose = place.copy()
    pose.setflags(write=False)
    return Figure(geometry, pose, Material(color))
