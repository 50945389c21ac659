"""`virtualrobot collision`: what touches, what may, and how far a robot is from the rest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import NODE
from virtualrobot.cli.options import FiniteRange, Target, WholeRange, target_options

if TYPE_CHECKING:
    from virtualrobot.collisions.allowed_pairs import AllowedPair, SampledPair
    from virtualrobot.collisions.collisions import Distance
    from virtualrobot.collisions.meshes import CollisionMesh
    from virtualrobot.collisions.settings import CollisionOptions, CollisionSettings, GuardCost
    from virtualrobot.collisions.values import Collision
    from virtualrobot.collisions.watch import CollisionReport
    from virtualrobot.connection import Client

MODES = ("off", "monitor", "stop", "guard", "inherit")

_EXAMPLES = """
\b
Examples:
  virtualrobot collision
  virtualrobot collision allowed arm
  virtualrobot collision distance arm --range 0.2
  virtualrobot collision allow arm.link_0 table --reason "stands on it"
  virtualrobot collision find arm
  virtualrobot collision mode stop
  virtualrobot collision pad table 0.02
  virtualrobot collision watch
  virtualrobot collision meshes arm --hull-vertices 64
"""


@click.group(invoke_without_command=True, epilog=_EXAMPLES)
@target_options
@click.pass_context
def collision(ctx: click.Context, target: Target) -> None:
    """Show what touches and may not; or what may, and how far things are apart."""
    ctx.obj = target
    if ctx.invoked_subcommand is None:
        with target.connect() as client:
            found = client.collisions.check(detail="contacts").pairs
        click.echo("\n".join(collision_lines(found)))


@collision.command()
@click.argument("nodes", nargs=-1, type=NODE)
@target_options
def allowed(target: Target, nodes: tuple[str, ...]) -> None:
    """Show the pairs that may touch, all or those with NODES and what hangs below them, and why."""
    with target.connect() as client:
        found = client.collisions.allowed.list(*nodes)
    click.echo("\n".join(allowed_lines(found)))


@collision.command()
@click.argument("robot", type=NODE)
@click.argument("nodes", nargs=-1, type=NODE)
@click.option(
    "--range",
    "range_meters",
    type=FiniteRange(min=0.0, min_open=True),
    metavar="METERS",
    help="All pairs that are so near.",
)
@click.option("--show/--hide", default=None, help="A line between the nearest points in the viewer and in pictures.")
@target_options
def distance(target: Target, robot: str, nodes: tuple[str, ...], range_meters: float | None, show: bool | None) -> None:
    """Show how far ROBOT, or any node with all below it, is from everything else or from NODES."""
    with target.connect() as client:
        if show is not None:
            name = " - ".join((robot, ", ".join(nodes))) if nodes else robot
            others = {other: ends for other, ends in client.view.clearances.items() if other != name}
            client.view.clearances = {**others, name: (robot, nodes)} if show else others
        if range_meters is None:
            found = [client.collisions.distance(robot, to=nodes)]
        else:
            found = client.collisions.distances(robot, to=nodes, max_distance=range_meters)
    click.echo("\n".join(distance_lines(found)))


@collision.command()
@click.argument("first")
@click.argument("second")
@click.option("--reason", default="", metavar="WORDS", help="Why they may.")
@target_options
def allow(target: Target, first: str, second: str, reason: str) -> None:
    """Let the nodes FIRST and SECOND touch each other."""
    with target.connect() as client:
        client.collisions.allowed.add(first, second, reason)
        _tell_empty(client, first, second)


@collision.command()
@click.argument("first")
@click.argument("second")
@target_options
def forbid(target: Target, first: str, second: str) -> None:
    """Let the nodes FIRST and SECOND, which a client or an import has allowed to touch, do so no more."""
    with target.connect() as client:
        client.collisions.allowed.remove(first, second)


@collision.command("forbid-built")
@click.argument("nodes", nargs=-1, type=NODE)
@target_options
def forbid_built(target: Target, nodes: tuple[str, ...]) -> None:
    """Let pairs that imports have found to touch as built do so no more: all, or those with NODES or what is below."""
    with target.connect() as client:
        found = client.collisions.allowed.forbid_built(*nodes)
    click.echo("\n".join(allowed_lines(found)))


@collision.command()
@click.argument("mode", required=False, type=click.Choice(MODES))
@click.option("--robot", "robots", multiple=True, metavar="NAME", help="Only this robot; repeatable.")
@click.option("--look-ahead", type=FiniteRange(0.0, 60.0), metavar="SECONDS", help="How far motions are checked ahead.")
@target_options
def mode(target: Target, mode: str | None, robots: tuple[str, ...], look_ahead: float | None) -> None:
    """Show what is done about collisions, or set it: reports, stops, or a guard that keeps them from happening."""
    if robots and mode is None:
        raise click.UsageError("--robot wants a mode: off, monitor, stop, guard, or inherit for that of the world")
    if mode == "inherit" and not robots:
        raise click.UsageError("only a robot can inherit the world's mode: name it by --robot")
    with target.connect() as client:
        if mode is not None or look_ahead is not None:
            changes: CollisionOptions = {"robots": dict.fromkeys(robots, None if mode == "inherit" else mode)}
            if look_ahead is not None:
                changes["look_ahead"] = look_ahead
            client.collisions.set(None if robots else mode, **changes)
        found, cost = client.collisions.settings, client.collisions.guard_cost
    click.echo("\n".join(settings_lines(found, cost)))


@collision.command()
@click.argument("node", type=NODE)
@click.argument("meters", type=FiniteRange(0.0, 1.0))
@target_options
def pad(target: Target, node: str, meters: float) -> None:
    """Have the figures of NODE count as thicker by METERS, so that others keep away; 0 takes that away."""
    with target.connect() as client:
        client.collisions.set(paddings={node: meters})
        _tell_empty(client, node)


@collision.command()
@click.argument("nodes", nargs=-1, type=NODE)
@click.option("--hull-vertices", type=WholeRange(0, 256), metavar="N", help="Have them collide as hulls; 0: not.")
@target_options
def meshes(target: Target, nodes: tuple[str, ...], hull_vertices: int | None) -> None:
    """Show what the meshes of NODES and of all below them collide as, or have them collide as convex hulls."""
    if hull_vertices is not None and not nodes:
        raise click.UsageError("name the nodes whose meshes shall collide as hulls")
    with target.connect() as client:
        if hull_vertices is None:
            found = client.collisions.meshes(*nodes)
        else:
            found = (
                client.collisions.use_hulls(*nodes, vertices=hull_vertices)
                if hull_vertices
                else client.collisions.use_triangles(*nodes)
            )
    click.echo("\n".join(mesh_lines(found)))


@collision.command()
@click.option("--count", type=WholeRange(min=0), metavar="N", help="End after so many events.")
@target_options
def watch(target: Target, count: int | None) -> None:
    """Show what touches now, then what begins and ends and whom it stops, until Ctrl-C."""
    told: int | None = None
    with target.connect() as client:
        settings = client.collisions.settings
        if {settings.mode, *settings.robots.values()} == {"off"}:
            click.echo("no robot is watched: every mode is off; 'virtualrobot collision mode monitor' changes that")
            told = 0
        for report in client.collisions.watch():
            for line in report_lines(report, first=told is None):
                click.echo(line)
            told = (told or 0) + len(report.events) + report.missed_events
            if count is not None and told >= count:
                break


@collision.command()
@click.argument("robot", type=NODE)
@click.option("--samples", type=WholeRange(min=1), default=1000, metavar="N", help="Configurations [1000].")
@click.option("--seed", type=WholeRange(min=0), default=0, metavar="N", help="What they are drawn from [0].")
@target_options
def find(target: Target, robot: str, samples: int, seed: int) -> None:
    """Try random configurations of ROBOT, and show which of its nodes touch, and how often."""
    with target.connect() as client:
        found = client.collisions.allowed.find(robot, samples=samples, seed=seed)
    click.echo("\n".join(sampled_lines(found)))


def collision_lines(found: Sequence[Collision]) -> Iterator[str]:
    """Yield what touches as lines."""
    from virtualrobot.collisions.values import where

    if not found:
        yield "nothing touches that may not"
    for pair in found:
        yield f"{pair.first} touches {pair.second}{where(pair)}"


def report_lines(report: CollisionReport, first: bool) -> Iterator[str]:
    """Yield what a watch tells as lines: all that touches first, then what has happened."""
    if first:
        yield from collision_lines([one.collision for one in report.touching])
        yield from [report.fault] * bool(report.fault)
    if report.missed_events:
        yield f"{report.missed_events} events were not told: there were more than 1,000"
    yield from map(str, report.events)


def _tell_empty(client: Client, *names: str) -> None:
    """Say of which nodes nothing can touch, since only what is below them has figures."""
    for name in names:
        if not client.scene.node(name).figures:
            click.echo(
                f"{name} has no figures of its own, so this changes nothing: name nodes below it, such as its links"
            )


def settings_lines(found: CollisionSettings, cost: GuardCost) -> list[str]:
    """Return what is done about collisions as lines, and what guarding has cost where a robot is guarded."""
    from virtualrobot.tables import aligned

    ahead = f"{found.look_ahead:g} s" if found.look_ahead else "none"
    rows = [["mode", found.mode], ["look-ahead", ahead], *([robot, own] for robot, own in found.robots.items())]
    rows.extend([node, f"padding {1e3 * padding:g} mm"] for node, padding in found.paddings.items())
    if cost.ticks and "guard" in {found.mode, *found.robots.values()}:
        told = f"{1e3 * cost.mean_time:.2g} ms a tick, {1e3 * cost.worst_time:.2g} ms at most"
        rows.append(["guarding took", f"{told}, in {cost.ticks} ticks"])
    return aligned(rows, left=2)


def allowed_lines(found: Sequence[AllowedPair]) -> list[str]:
    """Return pairs that may touch as the lines of a table."""
    from virtualrobot.tables import aligned

    if not found:
        return ["no pairs"]
    return aligned([[pair.first, pair.second, pair.cause, pair.reason] for pair in found], left=4)


def distance_lines(found: Sequence[Distance]) -> list[str]:
    """Return how far things are apart as the lines of a table."""
    from virtualrobot.tables import aligned

    if not found:
        return ["nothing is so near"]
    return aligned([[pair.first, pair.second, f"{pair.distance:.6f} m"] for pair in found], left=2)


def mesh_lines(found: Sequence[CollisionMesh]) -> list[str]:
    """Return what meshes collide as, as the lines of a table, and below it what is wrong with them."""
    from virtualrobot.tables import aligned

    if not found:
        return ["no meshes"]
    rows = [["node", "mesh", "triangles", "collides as", "with", "out of it", "made in"]]
    for mesh in found:
        kind = ("hull" if mesh.hull else "triangles") + (", convex" if mesh.convex and not mesh.hull else "")
        out = f"{1e3 * mesh.deviation:.3f} mm" if mesh.hull else ""
        file = mesh.uri.rpartition("/")[2]
        made = f"{1e3 * mesh.build_time:.1f} ms"
        rows.append([mesh.node, file, str(mesh.mesh_triangles), kind, str(mesh.triangles), out, made])
    return [*aligned(rows, left=2), *dict.fromkeys(mesh.warning for mesh in found if mesh.warning)]


def sampled_lines(found: Sequence[SampledPair]) -> list[str]:
    """Return how often pairs touched as the lines of a table, those that never did as one line."""
    from virtualrobot.tables import aligned

    rows = [[pair.first, pair.second, _often(pair)] for pair in found if not pair.never]
    lines = aligned(rows, left=2) if rows else []
    return [*lines, f"{sum(pair.never for pair in found)} pairs never touched"]


def _often(pair: SampledPair) -> str:
    return "always" if pair.always else f"{100.0 * pair.touched / pair.samples:.1f} %"
