"""Tool paths with freedom: frames, how far the tool may be from them, and what was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Unpack

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import array_message, array_of, group_message, value_or_default
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError, WrongStateError
from virtualrobot.geometry import rows_from_poses
from virtualrobot.motions.motion import Motion, StartOptions
from virtualrobot.motions.program import Program
from virtualrobot.motions.steps import Named, name_of
from virtualrobot.robots.description import joints_now
from virtualrobot.v1 import path_pb2

Floats = NDArray[np.float64]

AXES = ("x", "y", "z", "rotation_x", "rotation_y", "rotation_z")
"""Axes of a frame along and about which the tool may be off it."""

FREE = "free"

AT_START = 1e-4
"""Largest distance of each joint from a path's start, in rad or m."""

ALONG = 1e-3
"""Sine of the angle between an axis and the way below which it is along it."""


@dataclass(frozen=True, slots=True)
class ToolPathProgress:
    """Progress of the search for a way along a tool path.

    Attributes:
        elapsed: time since the search began (s).
        searches: number of searches so far; each begins anew where what the one before had found can't be.
        checks: number of configurations and ways that have been checked for collisions.
    """

    elapsed: float
    searches: int
    checks: int


@dataclass(frozen=True, slots=True, eq=False)
class ExternalMotion:
    """Motion of a robot that moves along with an arm: a rail, a positioner.

    Attributes:
        joint_names: its joints (m,) that move.
        positions: (n, m) where they are as each frame is passed, radians or meters.
    """

    joint_names: tuple[str, ...]
    positions: Floats

    @property
    def start_joints(self) -> dict[str, float]:
        """Joints at the start of the path, by name."""
        return dict(zip(self.joint_names, self.positions[0].tolist(), strict=True))


@checked
@dataclass(frozen=True, slots=True, eq=False)
class ToolPathPartner:
    """Arm that leads its tool along a path of its own while another one does, by one law of time.

    Attributes:
        robot: the robot, or its name.
        frames: (n, 4, 4) of its tool centre point.
        velocity: its speed (m/s) along them; by default what makes both end together, from which another one may be 2%
            off.
        tolerance: how far its tool may be from its frame, by axis; it, `reference`, `acceleration`, `group` and `slope`
            are as of `Paths.find_tool_path`.
    """

    robot: Named
    frames: ArrayLike
    velocity: float | None = None
    tolerance: Mapping[str, float | tuple[float, float] | str] | None = None
    reference: str = "world"
    acceleration: float | None = None
    group: str | tuple[str, str] | None = None
    slope: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class PartnerMotion:
    """Motion of an arm that goes along with another one; times, joints and freedoms as of `ToolPath`.

    Attributes:
        joint_names: its joints (k,).
        times: (n,) when each of its frames is passed, in s from the start.
        positions: (n, k) where the joints are then.
        freedoms: (n, 6) where its tool is then, seen from its frame.
        length: of its path (m).
        velocity: the speed that it keeps along it (m/s).
    """

    joint_names: tuple[str, ...]
    times: Floats
    positions: Floats
    freedoms: Floats
    length: float
    velocity: float

    @property
    def start_joints(self) -> dict[str, float]:
        """Joints at the start of the path, by name."""
        return dict(zip(self.joint_names, self.positions[0].tolist(), strict=True))


@shown
@checked
@dataclass(frozen=True, slots=True, eq=False)
class ToolPath:
    """A way of an arm that leads its tool along n frames and touches nothing that it may not.

    Attributes:
        joint_names: the joints (k,) that move.
        times: (n,) when each frame is passed, in s from the start.
        positions: (n, k) where the joints are then, in radians.
        freedoms: (n, 6) where the tool is then, seen from its frame: x, y, z in m, and the turns about x, y, z in rad,
            one after the other.
        length: of the path (m).
        held: from when until when the tool keeps its speed, in s from the start.
        duration: the duration of the motion (s).
        program: the motion along the path from its start.
        planning_time: the time that finding it took (s).
        checks: number of configurations and ways that were checked for collisions, and `searches`, of searches.
        external: what the robots do that move along, by their names.
        partners: what the arms do that go along, by their names.
    """

    joint_names: tuple[str, ...]
    times: Floats
    positions: Floats
    freedoms: Floats
    length: float
    held: tuple[float, float]
    duration: float
    program: Program = field(repr=False)
    planning_time: float
    checks: int
    searches: int
    external: dict[str, ExternalMotion]
    partners: dict[str, PartnerMotion]
    _services: Services = field(repr=False)

    @property
    def start_joints(self) -> dict[str, float]:
        """Joints at the start of the path, by name."""
        return dict(zip(self.joint_names, self.positions[0].tolist(), strict=True))

    def start(self, **options: Unpack[StartOptions]) -> Motion:
        """Go along the path; the options are those of `Robot`.

        Raises WrongStateError when a robot is not at the path's start: move it to its `start_joints`.
        """
        check_at_start(self._services, self.program, self.start_joints)
        for robot, motion in (*self.external.items(), *self.partners.items()):
            check_joints(self._services, robot, motion.start_joints)
        return self.program.start(**options)


def check_at_start(services: Services, program: Program, joints: Mapping[str, float]) -> None:
    """Raise WrongStateError when the robot of a program's first move is not where a path starts."""
    check_joints(services, program._spec.steps[0].move.moves[0].robot, joints)


def check_joints(services: Services, robot: str, joints: Mapping[str, float]) -> None:
    """Raise WrongStateError when a robot is not where a path starts."""
    here = joints_now(services, robot)
    for name, value in joints.items():
        if abs(here[name] - value) > AT_START:
            raise WrongStateError(
                f"{robot!r} is not where the path starts: {name!r} is at {here[name]:.6g} and not at {value:.6g}; "
                "move it there, or look for a path from here"
            )


@checked
def path_frames(points: ArrayLike, axis: ArrayLike) -> Floats:
    """Return frames (n, 4, 4) at points (n, 3) in m: z along an axis, x along the way as far as that is across z.

    Args:
        points: the way, each point apart from the one before it.
        axis: (3,) the direction in which the tool points, of any length above 0, or (n, 3), one for each point.

    Raises:
        InvalidArgumentError: for fewer than two points, for those that are the same in a row or not finite, and for an
            axis along the way, which leaves open how a frame is turned about it.
    """
    places = np.array(points, dtype=np.float64)
    if places.ndim != 2 or places.shape[1:] != (3,) or len(places) < 2:
        raise InvalidArgumentError(f"points of a path have the shape (n, 3), n at least 2, not {places.shape}")
    z = np.array(axis, dtype=np.float64)
    if z.shape not in ((3,), places.shape):
        raise InvalidArgumentError(
            f"the axis of a path has the shape (3,), or {places.shape} as its points, not {z.shape}"
        )
    z = np.broadcast_to(z, places.shape)
    for what, values in (("points", places), ("axis", z)):
        if not np.isfinite(values).all():
            row = int(np.flatnonzero(~np.isfinite(values).all(axis=1))[0])
            raise InvalidArgumentError(f"{what}[{row}] is {values[row].tolist()}; it must be finite")
    lengths, steps = np.linalg.norm(z, axis=1), np.linalg.norm(np.diff(places, axis=0), axis=1)
    if not lengths.all():
        raise InvalidArgumentError(f"the axis at points[{int(lengths.argmin())}] has no length")
    if not steps.all():
        row = int(steps.argmin())
        raise InvalidArgumentError(f"points[{row + 1}] is the same as points[{row}]; leave it out")
    z = z / lengths[:, None]
    way = _tangents(np.diff(places, axis=0) / steps[:, None], steps[:, None])
    across = way - np.einsum("ij,ij->i", way, z)[:, None] * z
    sizes = np.linalg.norm(across, axis=1)
    if sizes.min() < ALONG * np.linalg.norm(way[sizes.argmin()]) or not sizes.min():
        raise InvalidArgumentError(
            f"the axis at points[{int(sizes.argmin())}] is along the way there, which leaves open how a frame is "
            "turned about it; give another axis, or frames of your own"
        )
    x = across / sizes[:, None]
    frames = np.tile(np.eye(4), (len(places), 1, 1))
    frames[:, :3, :3] = np.stack([x, np.cross(z, x), z], axis=2)
    frames[:, :3, 3] = places
    return frames


def _tangents(slopes: Floats, steps: Floats) -> Floats:
    """Return directions (n + 1, 3) at points of a way with slopes (n, 3) and steps (n, 1) between: of parabolas."""
    if len(slopes) == 1:
        return slopes.repeat(2, axis=0)
    inner = (slopes[:-1] * steps[1:] + slopes[1:] * steps[:-1]) / (steps[:-1] + steps[1:])
    first = slopes[0] + (slopes[0] - slopes[1]) * steps[0] / (steps[0] + steps[1])
    last = slopes[-1] + (slopes[-1] - slopes[-2]) * steps[-1] / (steps[-1] + steps[-2])
    return np.concatenate([first[None], inner, last[None]])


def tool_path_message(
    frames: ArrayLike,
    reference: str,
    velocity: float,
    acceleration: float | None,
    tolerance: Mapping[str, float | tuple[float, float] | str],
    slope: float | None = None,
) -> path_pb2.ToolPath:
    """Return a tool path as a message."""
    poses = np.array(frames, dtype=np.float64)
    if poses.ndim != 3 or poses.shape[1:] != (4, 4):
        raise InvalidArgumentError(f"frames of a tool path have the shape (n, 4, 4), not {poses.shape}")
    if not np.isfinite(poses).all():
        row = int(np.flatnonzero(~np.isfinite(poses).all(axis=(1, 2)))[0])
        raise InvalidArgumentError(f"frames[{row}] of the tool path is not finite")
    message = path_pb2.ToolPath(
        frames=array_message(rows_from_poses(poses)),
        reference=reference,
        velocity_meters_per_second=velocity,
        acceleration_meters_per_second_squared=value_or_default(acceleration, "acceleration"),
        max_slope_radians=value_or_default(slope, "slope"),
    )
    for axis, given in tolerance.items():
        if axis not in AXES:
            raise InvalidArgumentError(f"there is no axis {axis!r} of a tolerance; there are {', '.join(AXES)}")
        getattr(message, axis).CopyFrom(_tolerance(axis, given))
    return message


def _tolerance(axis: str, given: float | tuple[float, float] | str) -> path_pb2.AxisTolerance:
    if isinstance(given, str):
        if given != FREE:
            raise InvalidArgumentError(
                f"the tolerance {axis} is {given!r}; it must be a number, for as far either way, two of them, from "
                f"where to where, or {FREE!r}"
            )
        return path_pb2.AxisTolerance(free=True)
    lower, upper = given if isinstance(given, tuple | list) else (-given, given)
    return path_pb2.AxisTolerance(lower=lower, upper=upper)


def tool_path_of(services: Services, last: path_pb2.FindToolPathResponse) -> ToolPath:
    """Return what the last message of a search tells."""
    path = last.path
    return ToolPath(
        tuple(path.joint_names),
        array_of(path.times),
        array_of(path.positions),
        array_of(path.freedoms),
        path.length_meters,
        (path.held_from_seconds, path.held_until_seconds),
        path.duration_seconds,
        Program(services, path.spec),
        path.planning_seconds,
        last.checks,
        last.searches,
        {one.robot: ExternalMotion(tuple(one.joint_names), array_of(one.positions)) for one in path.external},
        {
            one.robot: PartnerMotion(
                tuple(one.joint_names),
                array_of(one.times),
                array_of(one.positions),
                array_of(one.freedoms),
                one.length_meters,
                one.velocity_meters_per_second,
            )
            for one in path.partners
        },
        services,
    )


def partner_message(partner: ToolPathPartner) -> path_pb2.ToolPathPartner:
    """Return an arm that goes along as a message."""
    path = tool_path_message(
        partner.frames,
        partner.reference,
        value_or_default(partner.velocity, "velocity"),
        partner.acceleration,
        partner.tolerance or {},
        partner.slope,
    )
    return path_pb2.ToolPathPartner(robot=name_of(partner.robot), group=group_message(partner.group), path=path)
