"""`virtualrobot grasp`, `release`, `tool`, `mount`, `unmount`, `speed`, `pause`, `lease`, ...: a robot at work."""

from __future__ import annotations

import click

from virtualrobot.cli.move import follow
from virtualrobot.cli.names import NODE, PART, ROBOT, SOURCE, TOOL
from virtualrobot.cli.options import FiniteRange, Numbers, Target, degrees_option, pose_of_numbers, target_options

_FACTOR = FiniteRange(0.0, 1.0, min_open=True)


@click.command()
@click.argument("robot", type=ROBOT)
@click.argument("part", required=False, type=PART)
@click.option("--within", type=FiniteRange(0.0, min_open=True), metavar="METERS", help="How far it may be [0.2].")
@target_options
def grasp(target: Target, robot: str, part: str | None, within: float | None) -> None:
    """Fix PART, or the nearest part, to ROBOT's tool, where it is."""
    with target.connect() as client:
        click.echo(f"{robot} holds {client.robot(robot).pick(part, within)}")


@click.command()
@click.argument("robot", type=ROBOT)
@click.argument("part", required=False, type=PART)
@click.option("--to", "parent", type=NODE, default="world", help="What it is fixed to from now on [world].")
@target_options
def release(target: Target, robot: str, part: str | None, parent: str) -> None:
    """Let PART, or all that ROBOT's tool holds, go; it stays where it is."""
    with target.connect() as client:
        client.robot(robot).place(part, parent)
        click.echo(f"{robot} has let {part or 'all'} go")


@click.command()
@click.argument("robot", type=ROBOT)
@click.argument("state", required=False)
@click.option("--width", type=FiniteRange(0.0), metavar="METERS", help="Instead of a state: how wide it opens.")
@click.option("--tool", "name", type=TOOL, help="Which of its tools [the chosen one].")
@click.option("--select", is_flag=True, help="Let the robot work with this tool from now on.")
@click.option("--point", metavar="NAME", help="With --select: its tool centre point [the first].")
@target_options
def tool(
    target: Target,
    robot: str,
    state: str | None,
    width: float | None,
    name: str | None,
    select: bool,
    point: str | None,
) -> None:
    """Show ROBOT's tools and their states, or move a tool into STATE, such as open."""
    if state is not None and width is not None:
        raise click.UsageError("give a state or --width, not both")
    if point and not select:
        raise click.UsageError("--point goes with --select")
    with target.connect() as client:
        handle = client.robot(robot)
        if state is None and width is None and not select:
            now = handle.state
            for tool in handle.tools:
                states = ", ".join(handle.tool(tool).states)
                chosen = "*" if tool == now.tool else " "
                wide = f"  {1e3 * now.tool_widths[tool]:.1f} mm" if tool in now.tool_widths else ""
                click.echo(f"{chosen} {tool}  {now.tool_states.get(tool) or 'no state'}  of: {states or 'none'}{wide}")
            return
        one = handle.tool(name)
        if select:
            one.select(point)
            click.echo(f"{robot} works with {one.name}")
        if state is not None:
            follow(one.set(state, wait=False))
            click.echo(f"{one.name} is {state}")
        if width is not None:
            follow(one.move_to_width(width, wait=False))
            click.echo(f"{one.name} is {1e3 * one.width:.1f} mm wide")


@click.command()
@click.argument("robot", type=ROBOT)
@click.argument("what", type=SOURCE)
@click.option("--name", help="Of what is loaded [its own].")
@click.option("--adapter", type=NODE, help="The link or adapter that it goes to [the flange].")
@click.option("--at", type=Numbers(3, 6), metavar="X,Y,Z[,R,P,Y]", help="Where its frame goes [on that of the flange].")
@click.option("--point", metavar="NAME", help="The tool centre point to work with [the first].")
@degrees_option
@target_options
def mount(
    target: Target,
    robot: str,
    what: str,
    name: str | None,
    adapter: str | None,
    at: tuple[float, ...] | None,
    point: str | None,
    degrees: bool,
) -> None:
    """Mount WHAT on ROBOT, which works with it then.

    WHAT is a model by name such as model://parallel_gripper, the path of a model file with a / in it, or the name of a
    tool, a gripper, or an adapter with one that is there.
    """
    place = None if at is None else pose_of_numbers(at, degrees)
    with target.connect() as client:
        mounted = client.robot(robot).mount(what, name=name, adapter=adapter, pose=place, tcp=point)
        click.echo(f"{robot} works with {mounted.name}")


@click.command()
@click.argument("robot", type=ROBOT)
@click.argument("what", required=False, type=NODE)
@click.option("--to", type=NODE, default="world", help="What it is fixed to from now on, such as a rack [world].")
@click.option("--at", type=Numbers(3, 6), metavar="X,Y,Z[,R,P,Y]", help="Where it goes there [where it is].")
@degrees_option
@target_options
def unmount(target: Target, robot: str, what: str | None, to: str, at: tuple[float, ...] | None, degrees: bool) -> None:
    """Take WHAT, or the chosen tool with its gripper, off ROBOT."""
    with target.connect() as client:
        client.robot(robot).unmount(what, to=to, pose=None if at is None else pose_of_numbers(at, degrees))
        click.echo(f"{robot} has let its tool go")


@click.command()
@click.argument("factor", required=False, type=_FACTOR)
@click.argument("robot", required=False, type=ROBOT)
@click.option(
    "--tool-limit",
    type=FiniteRange(min=0.0),
    metavar="M/S",
    help="With ROBOT: the greatest speed of its tool centre point, as for teaching; 0 is no limit.",
)
@target_options
def speed(target: Target, factor: float | None, robot: str | None, tool_limit: float | None) -> None:
    """Show the factor by which all motions are slowed, or set it to FACTOR, for all or for ROBOT alone."""
    if tool_limit is not None and robot is None:
        raise click.UsageError("--tool-limit goes with a FACTOR and a ROBOT")
    with target.connect() as client:
        if robot is not None and tool_limit is not None:
            client.robot(robot).tcp_speed_limit = tool_limit
        slowed = client if robot is None else client.robot(robot)
        if factor is not None:
            slowed.speed_factor = factor
        click.echo(f"{slowed.speed_factor:g}")


@click.command()
@click.argument("robots", nargs=-1, type=ROBOT)
@target_options
def pause(target: Target, robots: tuple[str, ...]) -> None:
    """Slow every motion, or those of ROBOTS, to standstill on its path; 'virtualrobot resume' lets it go on."""
    _each(target, robots, "pause")


@click.command()
@click.argument("robots", nargs=-1, type=ROBOT)
@target_options
def resume(target: Target, robots: tuple[str, ...]) -> None:
    """Let every motion, or those of ROBOTS, go on after a pause."""
    _each(target, robots, "resume")


def _each(target: Target, robots: tuple[str, ...], what: str) -> None:
    with target.connect() as client:
        for robot in robots:
            client.robot(robot)  # raises when there is none
        motions = [motion for motion in client.motions() if not robots or set(motion.robots) & set(robots)]
        for motion in motions:
            getattr(motion, what)()
            click.echo(f"{what}d {motion.id} of {', '.join(motion.robots)}")
        if not motions:
            click.echo("nothing moves")


@click.command()
@click.argument("robots", nargs=-1, type=ROBOT)
@click.option("--take", is_flag=True, help="Take them over from whoever has them; their motions stop.")
@click.option("--owner", help="The name that others are told [user, machine and program].")
@click.option("--end", is_flag=True, help="In a shell: give all leased robots back.")
@target_options
def lease(target: Target, robots: tuple[str, ...], take: bool, owner: str | None, end: bool) -> None:
    """Lease ROBOTS, so that nobody else moves them, until Ctrl-C; in a shell until it ends, or --end."""
    session = target.session
    if end == bool(robots):
        raise click.UsageError("name the robots to lease, or --end in a shell")
    if end and session is None:
        raise click.UsageError("--end is for a shell; elsewhere Ctrl-C ends a lease")
    with target.connect() as client:
        if session is not None and end:
            session.release()
            click.echo("released")
            return
        held = client.lease(*robots, take=take, owner=owner)
        click.echo(f"leased {', '.join(robots)} as {held.id}")
        if session is not None:
            session.leases.append(held)
            return
        with held:
            click.echo(f"{held.id} has ended: {held.wait_for_loss()}", err=True)
        raise click.exceptions.Exit(1)


@click.command()
@click.argument("mode", required=False, type=click.Choice(["realtime", "stepped"]))
@click.option("--speed", type=FiniteRange(0.01, 100.0), help="Simulated seconds for each second of the wall clock.")
@click.option("--at", type=FiniteRange(0.0), help="Of a replay: the moment to go to, in seconds of simulation time.")
@target_options
def clock(target: Target, mode: str | None, speed: float | None, at: float | None) -> None:
    """Show how time runs; let it follow the wall clock, times --speed, or only steps; go elsewhere in a replay."""
    if speed is not None and mode == "stepped":
        raise click.UsageError("--speed is for a clock that follows the wall clock")
    with target.connect() as client:
        if at is not None:
            client.clock.seek(at)
        if mode == "stepped":
            client.clock.set_stepped()
        elif mode or speed is not None:
            client.clock.set_realtime(1.0 if speed is None else speed)
        now = client.clock.read()
        runs = f"{now.speed_factor:g} times the wall clock" if now.mode == "realtime" else "time goes on by steps"
        of = "" if now.recorded is None else f" of {now.recorded[0]:.3f} to {now.recorded[1]:.3f} s"
        click.echo(f"{now.mode}: {runs}; {now.stamp.simulation_time:.3f} s{of}, tick {now.stamp.tick}")
