"""SolveDrives and ReckonDrives: where drives have to be on a way, or the shortest to a goal, and where they led."""

from __future__ import annotations

import numpy as np
from virtualrobot.v1 import robot_pb2

from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.crafts.craft import CraftAtWork
from virtualrobot_kernel.crafts.reckoning import reckoned
from virtualrobot_kernel.crafts.ways import Goal, Way, way_to
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.structs import settings
from virtualrobot_kernel.messages.values import array, array_message, finite, not_negative, stamp
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.world.state import Snapshot

MOST_PARTS = 1000
"""Greatest number of parts of a way in one call of SolveDrives."""

MOST_ROWS = 10_000
"""Greatest number of rows in one call of ReckonDrives."""

FARTHEST = 1e6
"""Greatest coordinate of a goal, and greatest turning radius (m)."""


async def solved_drives(kernel: KernelServices, request: robot_pb2.SolveDrivesRequest) -> robot_pb2.SolveDrivesResponse:
    """Return where drives are on a way, found in a worker thread on the snapshot of that moment."""
    snapshot = kernel.world.snapshot
    uid = snapshot.structure.node(request.robot).uid
    goal = _goal(request)
    parts = None if goal else array(request.parts, (None, 3), "parts")
    # A way of no parts tells where it would begin.
    craft = kernel.crafts.driven(uid) if parts is not None and not len(parts) else kernel.crafts.to_drive(uid)
    if parts is not None and len(parts) > MOST_PARTS:
        raise KernelError(
            f"a way has {MOST_PARTS} parts at most, not {len(parts)}", reason=Reason.TOO_LARGE, parts=len(parts)
        )

    def solve() -> robot_pb2.SolveDrivesResponse:
        q = snapshot.state.q
        if parts is not None:
            way = Way(parts, "", 0.0)
        else:
            assert goal is not None  # there are no parts
            way = way_to(craft, q, goal)
            _check_free(kernel, snapshot, craft, goal, way)
        x, y, heading = craft.place(q).tolist()
        return robot_pb2.SolveDrivesResponse(
            stamp=stamp(snapshot),
            joint_names=craft.drives.joints,
            positions=array_message(craft.way(q, way.parts)),
            x_meters=x,
            y_meters=y,
            heading_radians=heading,
            parts=array_message(way.parts),
            length_meters=way.length,
            word=way.word,
            turning_radius_meters=way.radius,
        )

    return await kernel.in_worker(solve)


async def reckoned_drives(
    kernel: KernelServices, request: robot_pb2.ReckonDrivesRequest
) -> robot_pb2.ReckonDrivesResponse:
    """Return the way of a craft by where its drives were, reckoned in a worker thread."""
    snapshot = kernel.world.snapshot
    craft = kernel.crafts.driven(snapshot.structure.node(request.robot).uid)
    names = tuple(request.joint_names)
    if sorted(names) != sorted(craft.drives.joints):
        raise KernelError(
            f"the drives of {request.robot!r} are the joints {', '.join(craft.drives.joints)}, not {', '.join(names)}",
            field="joint_names",
        )
    positions = array(request.positions, (None, len(names)), "positions")
    if not 1 <= len(positions) <= MOST_ROWS:
        raise KernelError(f"positions have 1 to {MOST_ROWS} rows, not {len(positions)}", field="positions")
    positions = positions[:, [names.index(name) for name in craft.drives.joints]]
    begin = np.array([finite(getattr(request, what), what) for what in ("x_meters", "y_meters", "heading_radians")])
    covariance = array(request.covariance, (3, 3), "covariance") if request.HasField("covariance") else np.zeros((3, 3))
    variance = not_negative(request.variance_per_radian, "variance_per_radian")
    other = settings(request.settings, "settings")

    def reckon() -> robot_pb2.ReckonDrivesResponse:
        with kernel.crafts.believed(craft.node.uid, other) as one:
            poses, covariances = reckoned(one, begin, positions, covariance, variance)
        return robot_pb2.ReckonDrivesResponse(
            stamp=stamp(snapshot), poses=array_message(poses), covariances=array_message(covariances)
        )

    return await kernel.in_worker(reckon)


def _goal(request: robot_pb2.SolveDrivesRequest) -> Goal | None:
    """Return the goal of a request, or None where it has parts."""
    if not request.HasField("goal"):
        return None
    if request.HasField("parts"):
        raise KernelError("give the parts of a way or its goal, not both", field="goal")
    given = request.goal
    for what in ("x_meters", "y_meters"):
        if abs(finite(value := getattr(given, what), f"goal.{what}")) > FARTHEST:
            raise KernelError(
                f"goal.{what} must be within {FARTHEST:g} m, not {value:g}", field=f"goal.{what}", value=value
            )
    heading = finite(given.heading_radians, "goal.heading_radians") if given.HasField("heading_radians") else None
    radius = not_negative(given.turning_radius_meters, "goal.turning_radius_meters")
    if radius > FARTHEST:
        what = "goal.turning_radius_meters"
        raise KernelError(f"{what} must be {FARTHEST:g} m at most, not {radius:g}", field=what, value=radius)
    return Goal(given.x_meters, given.y_meters, heading, given.may_reverse, radius)


def _check_free(kernel: KernelServices, snapshot: Snapshot, craft: CraftAtWork, goal: Goal, way: Way) -> None:
    """Raise KernelError (COLLISION) where the craft would touch something at the end of its way that it doesn't now."""
    q = snapshot.state.q
    heading = goal.heading
    if heading is None:
        heading = float(craft.place(q)[2] + way.parts[:, 2].sum())
    there = standing_at(snapshot, ..., craft.standing_at(q, goal.x, goal.y, heading))
    with kernel.collisions.scene() as scene:
        scene.place(snapshot)
        already = set(scene.touching({craft.node.uid}))
        scene.place(there)
        new = sorted(set(scene.touching({craft.node.uid})) - already)
    if new:
        first, second = (snapshot.structure.nodes[uid].name for uid in new[0])
        raise KernelError(
            f"{craft.node.name!r} cannot stand at {goal.x:g}, {goal.y:g} turned by {np.degrees(heading):.1f} degrees: "
            f"{first!r} would touch {second!r}",
            reason=Reason.COLLISION,
            first=first,
            second=second,
        )
