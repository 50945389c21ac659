"""`virtualrobot fmu`: a cell as a Functional Mock-up Unit, for Simulink and other tools that speak FMI."""

from __future__ import annotations

from pathlib import Path

import click
from virtualrobot.cli.options import Target, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot fmu --output cell.fmu
  virtualrobot fmu ugv --sensor ugv.sonar_front --output ugv.fmu
"""


@click.command(epilog=_EXAMPLES, short_help="Write the cell as an FMU (FMI 3.0, co-simulation).")
@click.argument("robots", nargs=-1, metavar="[ROBOT]...")
@click.option("--output", type=click.Path(path_type=Path, dir_okay=False), required=True, metavar="FILE.fmu")
@click.option(
    "--command",
    "kind",
    type=click.Choice(["positions", "velocities"]),
    default="positions",
    show_default=True,
    help="By what joints are commanded; crafts are by twists.",
)
@click.option("--sensor", "sensors", multiple=True, metavar="NAME", help="Tell this range sensor; may be given again.")
@target_options
def fmu(target: Target, robots: tuple[str, ...], output: Path, kind: str, sensors: tuple[str, ...]) -> None:
    """Write the cell, or these ROBOTs of it, as an FMU for co-simulation: a tool that loads it steps this kernel."""
    try:
        from virtualrobot_apps.fmi.export import export_cell
    except ModuleNotFoundError as error:
        raise click.UsageError(f"{error}; install it: pip install 'virtualrobot[fmi]'") from error
    from virtualrobot_apps.fmi.cell import INPUT, plan_cell

    with target.connect("fmu") as client:
        plan = plan_cell(client, robots, model=output.stem, command=kind, sensors=sensors, address=target.address or "")
    export_cell(plan, output)
    inputs = sum(one.causality == INPUT for one in plan.variables)
    click.echo(f"{output}: {inputs} inputs, {len(plan.variables) - inputs} outputs")
