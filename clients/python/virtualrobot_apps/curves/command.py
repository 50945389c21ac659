"""`virtualrobot program curves`: curves of a CAD file as a program for a controller."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import FiniteRange, Numbers, Target, target_options

from virtualrobot_apps.languages.writers.options import LANGUAGES, language_options, wanted, write

if TYPE_CHECKING:
    from virtualrobot_apps.curves.curve import Curve

_above_zero = FiniteRange(min=0.0, min_open=True)


@click.command()
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@language_options(required=False)
@click.option("--curve", "names", metavar="NAME", multiple=True, help="A curve to follow; again for each [all].")
@click.option("--reference", metavar="NODE", default="world", show_default=True, help="Where the file's origin is.")
@click.option(
    "--tool-axis",
    type=Numbers(3),
    metavar="X,Y,Z",
    default="0,0,-1",
    show_default=True,
    help="Where the tool's z points, along the file's axes; an MDI of VDA-FS has normals of its own.",
)
@click.option("--no-turn", is_flag=True, help="Don't turn the tool's x along the curve.")
@click.option("--speed", metavar="M/S", type=_above_zero, default=0.1, show_default=True, help="The tool's speed.")
@click.option(
    "--tolerance",
    metavar="METERS",
    type=_above_zero,
    default=1e-4,
    show_default=True,
    help="How far the tool is off the curve at most.",
)
@click.option(
    "--approach",
    metavar="METERS",
    type=_above_zero,
    default=0.05,
    show_default=True,
    help="How far before the curve, against the tool's z, it comes from and goes to.",
)
@target_options
def curves(
    target: Target,
    file: Path,
    language: str | None,
    robot: str | None,
    output: Path | None,
    signs: str | None,
    coupling: float,
    names: tuple[str, ...],
    reference: str,
    tool_axis: tuple[float, ...],
    no_turn: bool,
    speed: float,
    tolerance: float,
    approach: float,
) -> int:
    """Write a program that leads an arm's tool along curves of a CAD file: VDA-FS, IGES or STEP.

    Without --as the curves are listed. It begins where the robot stands now; nothing moves. Lengths are in meters.
    """
    from virtualrobot.errors import VirtualRobotError

    from virtualrobot_apps.curves.fitting import ways
    from virtualrobot_apps.curves.program import following
    from virtualrobot_apps.curves.reading import read_curves
    from virtualrobot_apps.languages.core.command import only_robot
    from virtualrobot_apps.languages.writers.resolve import robot_program

    facts = wanted({}, signs, coupling)
    found = read_curves(file, names)
    if language is None:
        for curve in found:
            click.echo(_line(curve))
        return 0
    with target.connect() as client:
        arm = client.robot(only_robot(client, robot))
        # One half for the lines and arcs, the other for the corners between them.
        led = following(
            client,
            arm,
            ways(found, 0.5 * tolerance),
            tool_axis,
            speed=speed,
            approach=approach,
            tolerance=0.5 * tolerance,
            reference=reference,
            turn=not no_turn,
        )
        try:
            resolved = robot_program(client, led.program, arm, file.stem)
        except VirtualRobotError as error:
            raise led.error(error) from None
    write(resolved, language, facts, output or file.with_suffix(LANGUAGES[language]))
    return 0


def _line(curve: Curve) -> str:
    """Return a line about a curve, in mm."""
    import numpy as np

    shown = np.round(1000.0 * curve.ends, 6) + 0.0
    begin, end = (", ".join(f"{one:.6g}" for one in point) for point in shown.tolist())
    return f"{curve.name}: {1000.0 * curve.length:.6g} mm from ({begin}) to ({end})"
