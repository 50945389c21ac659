"""Free ways of arms around what stands in between."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypedDict, Unpack

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import group_message, joint_map, pair_messages, value_or_default
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import shown
from virtualrobot._wire.transport import Waiting
from virtualrobot.errors import InvalidArgumentError, UnknownNameError
from virtualrobot.motions import moves
from virtualrobot.motions.motion import Motion, StartOptions
from virtualrobot.motions.program import Program
from virtualrobot.motions.steps import Named, name_of
from virtualrobot.motions.tool_path_parts import ToolPathPart, parts_of
from virtualrobot.motions.tool_paths import (
    ToolPath,
    ToolPathPartner,
    ToolPathProgress,
    check_at_start,
    partner_message,
    tool_path_message,
    tool_path_of,
)
from virtualrobot.robots.named_goals import is_target
from virtualrobot.v1 import motion_pb2, path_pb2

PLANNERS = {
    "RRTConnect": path_pb2.PATH_PLANNER_RRT_CONNECT,
    "RRT": path_pb2.PATH_PLANNER_RRT,
    "KPIECE1": path_pb2.PATH_PLANNER_KPIECE1,
    "BKPIECE1": path_pb2.PATH_PLANNER_BKPIECE1,
    "LBKPIECE1": path_pb2.PATH_PLANNER_LBKPIECE1,
    "RRTstar": path_pb2.PATH_PLANNER_RRT_STAR,
    "InformedRRTstar": path_pb2.PATH_PLANNER_INFORMED_RRT_STAR,
}
"""The planners by the names that OMPL gives them."""
PLANNER_NAMES = {number: name for name, number in PLANNERS.items()}


@dataclass(frozen=True, slots=True)
class PathProgress:
    """Progress of the search for a path.

    Attributes:
        elapsed: time since the search began (s).
        states: number of configurations that the search has joined so far.
        checks: number of configurations and lines that have been checked.
    """

    elapsed: float
    states: int
    checks: int


@shown
@checked
@dataclass(frozen=True, slots=True, eq=False)
class FreePath:
    """A path on which an arm touches nothing that it may not, as the world was when it was looked for.

    Attributes:
        joint_names: the joints (k,) that move the robot's flange.
        waypoints: (n, k) joint values from the start to the goal, radians or meters; the straight lines between them
            are free.
        straight: true where the straight way to the goal is free: then it is the path.
        length: of the path, in the space of the joints.
        straight_length: of the straight way, free or not.
        program: point-to-point moves with rounded corners; the motion that the kernel makes of them from the path's
            start was proven to touch nothing.
        duration: the duration of that motion (s).
        planner: the planner that was asked.
        planning_time: the time that finding it took (s).
        checks: number of configurations and lines that were checked, and `states`, of those that the search has joined.
    """

    joint_names: tuple[str, ...]
    waypoints: NDArray[np.float64]
    straight: bool
    length: float
    straight_length: float
    program: Program = field(repr=False)
    duration: float
    planner: str
    planning_time: float
    checks: int
    states: int
    _services: Services = field(repr=False)

    def start(self, **options: Unpack[StartOptions]) -> Motion:
        """Go along the path; the options are those of `Robot`.

        Raises WrongStateError when the robot is not at the path's start: nobody has looked at the way from elsewhere.
        """
        start = dict(zip(self.joint_names, self.waypoints[0].tolist(), strict=True))
        check_at_start(self._services, self.program, start)
        return self.program.start(**options)


class ToolPathOptions(TypedDict, total=False):
    """Options of `Paths.find_tool_path`."""

    tolerance: Mapping[str, float | tuple[float, float] | str] | None
    reference: str
    acceleration: float | None
    time_limit: float | None
    group: str | tuple[str, str] | None
    external: Sequence[Named]
    may_touch: Iterable[tuple[str, str]]
    slope: float | None
    partners: Sequence[ToolPathPartner]
    progress: Callable[[ToolPathProgress], None] | None


@checked
class Paths:
    """Free ways in the world of one kernel.

    Example:
        >>> path = client.paths.find("arm", {"lbr_iiwa_joint_1": 1.5})
        >>> path.start()
    """

    def __init__(self, services: Services) -> None:
        """Look for paths in the world of one kernel."""
        self._services = services

    def find(
        self,
        robot: Named,
        goal: Mapping[str, float] | str | ArrayLike,
        *,
        start: Mapping[str, float] | None = None,
        reference: str = "world",
        configuration: str | None = None,
        planner: str = "RRTConnect",
        seed: int = 0,
        time_limit: float | None = None,
        speed_factor: float | None = None,
        zone_percent: float | None = None,
        group: str | tuple[str, str] | None = None,
        clearance: float = 0.0,
        progress: Callable[[PathProgress], None] | None = None,
    ) -> FreePath:
        """Return a path on which an arm touches nothing that it may not. Nothing moves.

        All else stands as it does now; the part that the robot holds goes along.

        Args:
            robot: the robot, or its name.
            goal: joint values by name, the name of a posture or a target, or a 4x4 pose of the tool centre point.
            start: joints that are elsewhere at the start of the path; without it, it begins where the robot stands.
            reference: the node in whose frame the pose is.
            configuration: the only configuration that will do for a pose; by default all are tried.
            planner: RRTConnect (the default), RRT, KPIECE1, BKPIECE1 and LBKPIECE1 end with the first path; RRTstar and
                InformedRRTstar use all the time for a shorter one.
            seed: the seed of the search; with the first ones equal seeds find equal paths.
            time_limit: in s, 10 by default.
            speed_factor: of the moves, above 0, up to 1 (the default).
            zone_percent: the most by which corners are rounded off, 0 to 50 (the default).
            group: the group of the robot whose joints move, by name or as (base link, tip link); by default its own
                chain.
            clearance: how far the robot, with its tools and what it holds, stays away from all else that it may not
                touch, at start and goal too: in m beyond the paddings, up to 1.
            progress: is called about four times a second; what it raises ends the search. Without it the client's
                `on_progress` is told.

        Raises:
            CollisionError: when the robot touches something at the start or at every goal, or is nearer than the
                clearance.
            UnreachableError: when a pose is out of reach, or no path was found in time.
            UnknownNameError: for a robot, joint, posture, target or planner that there is not.
            LimitError: when a joint cannot be there.
            WrongStateError: when the kernel does not have the library ompl.
        """
        robot = name_of(robot)
        if planner not in PLANNERS:
            raise UnknownNameError(f"there is no planner {planner!r}; give one of {', '.join(PLANNERS)}")
        if isinstance(goal, str) and is_target(self._services, robot, goal):
            to = motion_pb2.PointToPoint(pose=moves.target_goal(goal, {"configuration": configuration}))
        else:
            to = moves.point_to_point(goal, {"reference": reference, "configuration": configuration})
        request = path_pb2.FindPathRequest(
            robot=robot,
            start=motion_pb2.JointGoal(joint_positions=joint_map(start or {})),
            goal=to,
            planner=PLANNERS[planner],
            seed=seed,
            time_limit_seconds=value_or_default(time_limit, "time_limit"),
            speed_factor=value_or_default(speed_factor, "speed_factor"),
            blend_percent=zone_percent,
            group=group_message(group),
            clearance_meters=clearance,
        )
        last = path_pb2.FindPathResponse()
        waiting = Waiting("looking for a path", self._services.channel.on_progress)
        try:
            with self._services.path.FindPath(request) as stream:
                for last in stream:
                    if progress is not None:
                        progress(PathProgress(last.elapsed_seconds, last.states, last.checks))
                    else:
                        waiting.tell(f"{last.states} configurations, {last.checks} checks")
        finally:
            waiting.end()
        return self._path(last)

    def find_tool_path(
        self,
        robot: Named,
        frames: ArrayLike,
        velocity: float,
        *,
        tolerance: Mapping[str, float | tuple[float, float] | str] | None = None,
        reference: str = "world",
        acceleration: float | None = None,
        time_limit: float | None = None,
        group: str | tuple[str, str] | None = None,
        external: Sequence[Named] = (),
        may_touch: Iterable[tuple[str, str]] = (),
        slope: float | None = None,
        partners: Sequence[ToolPathPartner] = (),
        progress: Callable[[ToolPathProgress], None] | None = None,
    ) -> ToolPath:
        """Return how an arm leads its tool along frames at an even speed and touches nothing that it may not.

        Nothing moves. All else stands as it does now; the part that the robot holds goes along. For arms of six joints
        that turn, with a spherical wrist or with axes 2, 3 and 4 parallel, and of seven of which one is a free value.

        Args:
            robot: the robot, or its name.
            frames: (n, 4, 4) of the tool centre point, on a smooth curve, such as `path_frames` makes.
            velocity: the speed of the frame along the path (m/s).
            tolerance: how far the tool may be from its frame, by axis: `x`, `y`, `z` in m along those of the frame,
                `rotation_x`, `rotation_y`, `rotation_z` in rad about them, one after the other. A number is as far
                either way, two are from where to where, and `free` is any turn. It is on the frame else.
            reference: the node in whose frame the frames are.
            acceleration: the greatest one to that speed and from it (m/s^2), 1 by default.
            time_limit: in s, 30 by default.
            group: the group of the robot whose tool is led, by name or as (base link, tip link); by default its own
                chain.
            external: robots that move along: what carries the arm, such as a rail, or the reference, such as a
                positioner; at most three joints in all. The speed is that in the frame of the reference.
            may_touch: pairs of nodes that may touch on this path, such as a cutter and the part that it cuts. The
                path's program needs `Program.allow` before it, then.
            slope: the greatest angle (rad) between the z of the frames and straight down, for which external axes are
                chosen; any by default.
            partners: arms that go along, each on a path of its own, by one law of time; at most three.
            progress: is called about four times a second; what it raises ends the search. Without it the client's
                `on_progress` is told.

        Raises:
            UnreachableError: where no posture reaches the path, or nothing was found in time.
            LimitError: where a joint can't be there, or can't be so fast; tolerances and speeds that nobody means.
            CollisionError: where all that the tolerances allow touches something.
            SingularityError: where the arm would have to pass a singularity.
            InvalidArgumentError: for frames and tolerances that make no sense.
            UnknownNameError: for a robot or node that there is not.
        """
        request = path_pb2.FindToolPathRequest(
            robot=name_of(robot),
            group=group_message(group),
            path=tool_path_message(frames, reference, velocity, acceleration, tolerance or {}, slope),
            time_limit_seconds=value_or_default(time_limit, "time_limit"),
            external_robots=map(name_of, external),
            may_touch=pair_messages(may_touch),
            partners=map(partner_message, partners),
        )
        last = path_pb2.FindToolPathResponse()
        waiting = Waiting("looking for a way along a tool path", self._services.channel.on_progress)
        try:
            with self._services.path.FindToolPath(request) as stream:
                for last in stream:
                    if progress is not None:
                        progress(ToolPathProgress(last.elapsed_seconds, last.searches, last.checks))
                    else:
                        waiting.tell(f"{last.searches} searches, {last.checks} checks")
        finally:
            waiting.end()
        return tool_path_of(self._services, last)

    def find_tool_path_parts(
        self, robot: Named, frames: ArrayLike, velocity: float, **options: Unpack[ToolPathOptions]
    ) -> tuple[ToolPathPart, ...]:
        """Return how an arm leads its tool along frames in as few parts as it can, and where it can't at all.

        Nothing moves. Between two parts the tool leaves the path, for another posture. The arguments are those of
        `find_tool_path`; a part that can't be has no path but the refusal.

        Raises:
            InvalidArgumentError: for frames and tolerances that make no sense.
            UnknownNameError: for a robot or node that there is not.
        """
        poses = np.array(frames, dtype=np.float64)
        if poses.ndim != 3 or len(poses) < 2:
            raise InvalidArgumentError(f"frames have the shape (n, 4, 4), n at least 2, not {poses.shape}")
        if options.get("partners"):
            raise InvalidArgumentError(
                "a tool path with partners can't be gone in parts: they would have to part at the same places"
            )
        return parts_of(
            len(poses), lambda first, last: self.find_tool_path(robot, poses[first : last + 1], velocity, **options)
        )

    def _path(self, last: path_pb2.FindPathResponse) -> FreePath:
        path = last.path
        return FreePath(
            tuple(path.joint_names),
            np.array([waypoint.positions for waypoint in path.waypoints]),
            path.straight,
            path.length,
            path.straight_length,
            Program(self._services, path.spec),
            path.duration_seconds,
            PLANNER_NAMES[path.planner],
            path.planning_seconds,
            last.checks,
            last.states,
            self._services,
        )

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Paths of the kernel at {self._services.address}: find(robot, goal), by {', '.join(PLANNERS)}>"
