"""`virtualrobot path`: a free way of an arm round what stands in between."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from virtualrobot.cli.move import follow
from virtualrobot.cli.names import NODE, PLANNER, ROBOT, TARGET
from virtualrobot.cli.options import (
    FiniteRange,
    Numbers,
    Target,
    WholeRange,
    degrees_option,
    pose_of_numbers,
    target_options,
)
from virtualrobot.cli.orders import Part, group_options, joint_goal, part_of

if TYPE_CHECKING:
    from virtualrobot.motions.paths import FreePath

_EXAMPLES = """
\b
Examples:
  virtualrobot path arm --to home
  virtualrobot path arm --pose 0.5,-0.3,0.4 --go
"""


@click.command(epilog=_EXAMPLES)
@click.argument("robot", type=ROBOT)
@click.argument("more", nargs=-1, metavar="[JOINT=VALUE]...")
@click.option("--joints", metavar="VALUES", help="JOINT=VALUE,... or all values in order.")
@click.option("--pose", type=Numbers(3, 6), metavar="X,Y,Z[,R,P,Y]", help="Where the tool centre point goes.")
@click.option("--to", "place", type=TARGET, metavar="NAME", help="A posture, such as home, or a target.")
@click.option("--reference", type=NODE, help="The node in whose frame the pose is given [world].")
@click.option("--planner", type=PLANNER, metavar="NAME", help="The algorithm of OMPL [RRTConnect].")
@click.option("--seed", type=WholeRange(min=0), default=0, metavar="N", help="What the search draws from [0].")
@click.option(
    "--time-limit", type=FiniteRange(min=0.0), default=10.0, metavar="SECONDS", help="How long it may take [10]."
)
@click.option(
    "--clearance",
    type=FiniteRange(min=0.0),
    default=0.0,
    metavar="METERS",
    help="How far it stays away from all else [0].",
)
@click.option("--show/--hide", default=None, help="Its waypoints as ghosts in the viewer and in pictures.")
@click.option("--go", is_flag=True, help="Go along the path.")
@group_options
@degrees_option
@target_options
def path(
    target: Target,
    robot: str,
    more: tuple[str, ...],
    joints: str | None,
    pose: tuple[float, ...] | None,
    place: str | None,
    reference: str | None,
    planner: str | None,
    seed: int,
    time_limit: float,
    clearance: float,
    show: bool | None,
    go: bool,
    degrees: bool,
    group: Part,
) -> None:
    """Find a way on which a robot touches nothing that it may not; with --go it goes along. Ctrl-C stops either."""
    words = tuple(word for word in (joints, *more) if word)
    if bool(words) + (pose is not None) + bool(place) != 1:
        raise click.UsageError("say where to, in one way: --joints, --pose or --to")
    with target.connect() as client:
        handle = part_of(client.robot(robot), group)
        if pose is not None:
            goal = pose_of_numbers(pose, degrees, handle.tcp if not reference else None)
        else:
            given = place or joint_goal(handle, words, degrees)
            goal = dict(zip(handle.chain_joint_names, given, strict=True)) if isinstance(given, list) else given
        found = client.paths.find(
            robot,
            goal,
            reference=reference or "world",
            planner=planner or "RRTConnect",
            seed=seed,
            time_limit=time_limit,
            clearance=clearance,
            group=group[0] or (group[1:] if any(group) else None),
        )
        click.echo(path_line(found))
        if show is not None:
            others = {name: ghost for name, ghost in client.view.ghosts.items() if name != f"path of {robot}"}
            client.view.ghosts = {**others, f"path of {robot}": (robot, found)} if show else others
        if go:
            motion = found.start(wait=False, on_disconnect="stop")
            follow(motion)
            click.echo(f"{motion.id} reached its goal")


def path_line(path: FreePath) -> str:
    """Return what was found as a line."""
    motion = f"{path.duration:.2f} s of motion, found in {path.planning_time:.2f} s"
    if path.straight:
        return f"the straight way is free: {path.length:.3f} rad, {motion}"
    waypoints = f"{len(path.waypoints)} waypoints"
    return f"{waypoints}, {path.length:.3f} rad instead of {path.straight_length:.3f} straight: {motion}"
