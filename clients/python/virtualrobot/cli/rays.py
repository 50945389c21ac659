"""`virtualrobot rays`: how ray casters agree and what they cost, or what one ray hits."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import NODE
from virtualrobot.cli.options import Numbers, Target, WholeRange, target_options

if TYPE_CHECKING:
    from virtualrobot.sensors.rays import RayCasterComparison, RayHits

_BAR_WIDTH = 40

_EXAMPLES = """
\b
Examples; 'virtualrobot plugins' shows the ray casters that are installed:
  virtualrobot rays
  virtualrobot rays embree reference --count 2000
  virtualrobot rays --from 0,0,2 --along 0,0,-1
  virtualrobot rays --from 0,0,2 --along 0,0,-1 --ignored arm
"""


@click.command(epilog=_EXAMPLES)
@click.argument("ray_casters", nargs=-1)
@click.option("--count", type=WholeRange(min=1), metavar="N", help="How many rays are compared [10000].")
@click.option("--seed", type=WholeRange(min=0), metavar="N", help="What they are drawn from [0].")
@click.option("--from", "origin", type=Numbers(3), metavar="X,Y,Z", help="Cast one ray instead: from here, in meters,")
@click.option("--along", type=Numbers(3), metavar="X,Y,Z", help="and in this direction.")
@click.option("--frame", type=NODE, metavar="NODE", help="The node whose frame they are in [the world's].")
@click.option(
    "--ignored", type=NODE, metavar="NODE", multiple=True, help="A node that the ray passes through, with all below it."
)
@target_options
def rays(
    target: Target,
    ray_casters: tuple[str, ...],
    count: int | None,
    seed: int | None,
    origin: tuple[float, ...] | None,
    along: tuple[float, ...] | None,
    frame: str | None,
    ignored: tuple[str, ...],
) -> None:
    """Compare RAY_CASTERS (or all of them) by random rays through the scene; or cast one ray by one of them."""
    if (origin is None) != (along is None):
        raise click.UsageError("--from and --along go together")
    if origin is None and (frame is not None or ignored):
        raise click.UsageError("--frame and --ignored go with --from and --along")
    if origin is not None and (count is not None or seed is not None or len(ray_casters) > 1):
        raise click.UsageError("one ray is cast by one ray caster, without --count and --seed")
    with target.connect() as client:
        if origin is not None:
            name = ray_casters[0] if ray_casters else "embree"
            hits = client.rays.cast(origin, [along or ()], frame=frame or "world", ray_caster=name, ignored=ignored)
            click.echo(hit_words(hits))
            return
        found = client.rays.compare(ray_casters, count=count, seed=seed or 0, progress=_draw_bar)
    click.echo("\n".join(comparison_lines(found, count or 10_000)))


def _draw_bar(part: float) -> None:
    """Draw which part is done where somebody looks."""
    if sys.stdout.isatty():
        bar = "#" * round(_BAR_WIDTH * part)
        click.echo(f"\r[{bar:-<{_BAR_WIDTH}}] {100 * part:3.0f}%", nl=part >= 1.0)


def hit_words(hits: RayHits) -> str:
    """Return what the first ray hits in words."""
    if not hits.nodes[0]:
        return "nothing"
    normal = ", ".join(f"{value:z.4f}" for value in hits.normals[0])
    return f"{hits.nodes[0]} after {hits.distances[0]:.6f} m, normal {normal}"


def comparison_lines(found: Sequence[RayCasterComparison], count: int) -> Iterator[str]:
    """Yield how ray casters agree on `count` rays and what they cost as lines, faults below the table."""
    from virtualrobot.tables import aligned

    rows = [["ray caster", "same to 1 mm", "other element", "median", "largest", "first cast", "a ray"]]
    for one in found:
        if one.fault:
            rows.append([one.ray_caster, "failed", "", "", "", "", ""])
            continue
        rows.append(
            [
                one.ray_caster,
                f"{100.0 * one.agreement:.3f} %",
                f"{100.0 * one.other_element:.3f} %",
                f"{one.median_difference:.2g} m",
                f"{one.largest_difference:.2g} m",
                f"{one.first_cast_time:.3f} s",
                f"{1e6 * one.cast_time / count:.3g} us",
            ]
        )
    yield from aligned(rows)
    yield from (f"{one.ray_caster}: {one.fault}" for one in found if one.fault)
