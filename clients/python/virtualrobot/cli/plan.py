"""`virtualrobot plan` and `check`: what a move would do, and whether it can; nothing moves."""

from __future__ import annotations

import csv
import math
import sys
from dataclasses import replace
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.options import FiniteRange, Target, target_options
from virtualrobot.cli.orders import Order, angles, order_options

if TYPE_CHECKING:
    from virtualrobot.motions.plans import MotionCheck, MotionPlan, RobotTrajectory
    from virtualrobot.robots.robot import Robot
    from virtualrobot.robots.values import JointLimits

_PLAN_EXAMPLES = """
\b
Examples:
  virtualrobot plan arm --pose 0.5,0,0.3 --linear
  virtualrobot plan arm --to home --every 0.1 --table
  virtualrobot plan arm --to home --csv home.csv
"""

_CHECK_EXAMPLES = """
\b
Examples:
  virtualrobot check arm --pose 0.5,0,0.3 --linear
  virtualrobot check arm --to home --min-singular-value 0.05 && virtualrobot move arm --to home
"""


limits_only = click.option("--limits-only", is_flag=True, help="Don't look for collisions.")


@click.command(epilog=_PLAN_EXAMPLES)
@order_options
@click.option(
    "--every",
    type=FiniteRange(min=0.0),
    metavar="SECONDS",
    help="With --table or --csv: between samples [a tick].",
)
@click.option("--csv", "file", metavar="FILE", help="Write the samples to a file; - shows them and nothing else.")
@click.option("--table", is_flag=True, help="Show the samples instead of the greatest values.")
@target_options
def plan(target: Target, robot: str, order: Order, every: float | None, file: str | None, table: bool) -> None:
    """Show what a move would do: how long it takes, how fast each joint is and what it needs. Nothing moves."""
    from virtualrobot.tables import aligned

    if every and not table and file is None:
        raise click.UsageError("--every goes with --table or --csv")
    with target.connect() as client:
        handle = client.robot(robot)
        planned = handle.plan(order.move(handle), sample_time=every or None)
        known = handle.limits
        limits = {name: known[joint] for name, joint in handle.coordinates.items()}
        told = in_degrees(handle, planned.robots[robot]) if order.degrees else planned.robots[robot]
    # A move of one group tells of its tool centre point.
    for moved in told.groups.values():
        told = replace(told, world_t_tcp=moved.world_t_tcp, tcp_speeds=moved.tcp_speeds)
    if file is not None:
        write_samples(file, samples(planned, told))
        if file == "-":
            return
    if table:
        click.echo("\n".join(aligned(samples(planned, told, "{:z.4f}"))))
    elif not every:
        click.echo("\n".join(aligned(peaks(told, limits, planned.robots[robot]))))
    # What is greatest lies between samples that are far apart.
    fastest = "" if every else f"; the tool centre point moves at up to {told.tcp_speeds.max():.4f} m/s"
    click.echo(f"{planned.duration:.3f} s{fastest}")
    for note in planned.notes:
        click.echo(note.message)
    tell_start(planned)


@click.command(epilog=_CHECK_EXAMPLES)
@order_options
@click.option(
    "--min-singular-value",
    type=FiniteRange(min=0.0),
    default=0.0,
    metavar="VALUE",
    help="The smallest singular value of the Jacobian that is accepted [that of lines and arcs alone].",
)
@limits_only
@target_options
def check(target: Target, robot: str, order: Order, min_singular_value: float, limits_only: bool) -> int:
    """Tell whether a move keeps all limits and touches nothing. Nothing moves.

    The exit code is 0, or 1 with what it violates first.
    """
    with target.connect() as client:
        handle = client.robot(robot)
        found = handle.check(
            order.move(handle), min_singular_value=min_singular_value or None, collisions=not limits_only
        )
    return verdict(robot, found, limits_only)


def verdict(what: str, found: MotionCheck, limits_only: bool) -> int:
    """Print in a line what a check has found; return the exit code."""
    if found.first_violation is not None:
        click.echo(found.first_violation.message)
        return 1
    margin = found.min_singular_value
    near = "" if margin is None else f", and its smallest singular value is {margin:.3g}"
    keeps = "keeps all limits" if limits_only else "keeps all limits and touches nothing"
    click.echo(f"{what} {keeps}: the motion takes {found.duration:.3f} s{near}")
    tell_start(found)
    return 0


def tell_start(shown: MotionPlan | MotionCheck) -> None:
    """Tell by which command a plan is started as it is."""
    if shown.reference is not None:
        click.echo(f"as it is here: virtualrobot start {shown.reference.id}")


def peaks(told: RobotTrajectory, limits: dict[str, JointLimits], exact: RobotTrajectory) -> list[list[str]]:
    """Return for each joint where it starts and ends, and its greatest speed, acceleration and effort, with shares.

    `told` is what people are told, perhaps in degrees, and `exact` the same in SI, as the limits are.
    """
    rows = [["joint", "from", "to", "velocity", "acceleration", "effort"]]
    for column, name in enumerate(told.joint_names):
        limit = limits[name]
        greatest = (
            (told.velocities, exact.velocities, limit.velocity),
            (told.accelerations, exact.accelerations, limit.acceleration),
            (told.efforts, exact.efforts, limit.effort),
        )
        shown = (
            f"{abs(ours[:, column]).max():.3f}{_share(abs(theirs[:, column]).max(), most)}"
            for ours, theirs, most in greatest
        )
        rows.append([name, *(f"{told.positions[row, column]:z.4f}" for row in (0, -1)), *shown])
    return rows


def in_degrees(robot: Robot, told: RobotTrajectory) -> RobotTrajectory:
    """Return the same with the angles of turning joints in degrees."""
    turning = angles(robot)
    unit = [math.degrees(1.0) if name in turning else 1.0 for name in told.joint_names]
    # The velocities of a quaternion are angular ones.
    rate = [math.degrees(1.0) if name in turning or "/q" in name[-3:] else 1.0 for name in told.joint_names]
    return replace(
        told,
        positions=told.positions * unit,
        velocities=told.velocities * rate,
        accelerations=told.accelerations * rate,
    )


def write_samples(file: str, rows: list[list[str]]) -> None:
    """Write rows as CSV to a file, or show them for `-`."""
    if file == "-":
        csv.writer(sys.stdout, lineterminator="\n").writerows(rows)
        return
    try:
        with open(file, "w", encoding="utf-8", newline="") as opened:
            csv.writer(opened, lineterminator="\n").writerows(rows)
    except OSError as error:
        raise click.ClickException(f"{file} cannot be written: {error.strerror}") from None


def _share(value: float, most: float) -> str:
    """Return how much of a limit a value is; nothing for a limit that is not known."""
    return f" ({100.0 * value / most:.0f}%)" if most > 0.0 else ""


def samples(planned: MotionPlan, told: RobotTrajectory, form: str = "{!r}") -> list[list[str]]:
    """Return a row for each sample after one of headings: seconds, positions, and the tool centre point's."""
    rows = [["time", *told.joint_names, "x", "y", "z", "tcp_speed"]]
    for row, time in enumerate(planned.times.tolist()):
        place = told.world_t_tcp[row, :3, 3].tolist()
        values = (time, *told.positions[row].tolist(), *place, float(told.tcp_speeds[row]))
        rows.append([form.format(value) for value in values])
    return rows
