"""`virtualrobot plan` and `check`: what a move would do, and whether it can; nothing moves."""

from __future__ import annotations

import csv
import sys
from typing import TYPE_CHECKING, TextIO

import click

from virtualrobot.cli.options import Target, target_options
from virtualrobot.cli.orders import Order, order_options

if TYPE_CHECKING:
    from virtualrobot.plans import MotionCheck, MotionPlan, RobotTrajectory
    from virtualrobot.robot_values import JointLimits

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


@click.command(epilog=_PLAN_EXAMPLES)
@order_options
@click.option("--every", type=float, default=0.0, metavar="SECONDS", help="The time between samples [a tick].")
@click.option("--csv", "file", type=click.File("w"), metavar="FILE", help="Write the samples to a file; - is here.")
@click.option("--table", is_flag=True, help="Show the samples instead of the greatest values.")
@target_options
def plan(target: Target, robot: str, order: Order, every: float, file: TextIO | None, table: bool) -> None:
    """Show what a move would do: how long it takes, how fast each joint is and what it needs. Nothing moves."""
    from virtualrobot.tables import aligned

    with target.connect() as client:
        handle = client.robot(robot)
        planned = handle.plan(order.move(handle), sample_seconds=every)
        limits = handle.limits
    told = planned.robots[robot]
    if file is not None:
        csv.writer(file, lineterminator="\n").writerows(samples(planned, told))
        if file is sys.stdout:
            return
    rows = samples(planned, told, "{:.4f}") if table else peaks(told, limits)
    click.echo("\n".join(aligned(rows)))
    fastest = told.tcp_speeds.max()
    click.echo(f"{planned.duration_seconds:.3f} s; the tool centre point moves at up to {fastest:.4f} m/s")
    for note in planned.notes:
        click.echo(note.message)


@click.command(epilog=_CHECK_EXAMPLES)
@order_options
@click.option(
    "--min-singular-value",
    type=float,
    default=0.0,
    metavar="VALUE",
    help="The smallest singular value of the Jacobian that is accepted [that of lines and arcs alone].",
)
@target_options
def check(target: Target, robot: str, order: Order, min_singular_value: float) -> int:
    """Tell whether a move keeps all limits: exit code 0, or 1 with the first one that it violates. Nothing moves."""
    with target.connect() as client:
        handle = client.robot(robot)
        found = handle.check(order.move(handle), min_singular_value=min_singular_value)
    return verdict(robot, found)


def verdict(what: str, found: MotionCheck) -> int:
    """Print in a line what a check has found; return the exit code."""
    if found.first_violation is not None:
        click.echo(found.first_violation.message)
        return 1
    margin = found.min_singular_value
    near = "" if margin is None else f", and its smallest singular value is {margin:.3g}"
    click.echo(f"{what} keeps all limits: the motion takes {found.duration_seconds:.3f} s{near}")
    return 0


def peaks(told: RobotTrajectory, limits: dict[str, JointLimits]) -> list[list[str]]:
    """Return for each joint where it starts and ends, and its greatest speed, acceleration and effort, with shares."""
    rows = [["joint", "from", "to", "velocity", "acceleration", "effort"]]
    for column, name in enumerate(told.joint_names):
        limit = limits[name]
        greatest = (
            (abs(told.velocities[:, column]).max(), limit.velocity),
            (abs(told.accelerations[:, column]).max(), limit.acceleration),
            (abs(told.efforts[:, column]).max(), limit.effort),
        )
        ends = (f"{told.positions[row, column]:.4f}" for row in (0, -1))
        rows.append([name, *ends, *(f"{value:.3f}{_share(value, most)}" for value, most in greatest)])
    return rows


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
