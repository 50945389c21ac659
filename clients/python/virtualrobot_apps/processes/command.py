"""`virtualrobot process`: processes that files describe, planned and run."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import Target, target_options

if TYPE_CHECKING:
    from virtualrobot import Client

    from virtualrobot_apps.processes.process import PlannedProcess

_EXAMPLES = """
\b
Examples:
  virtualrobot process new arc_weld weld.yaml
  virtualrobot process look weld.yaml
  virtualrobot process plan weld.yaml
  virtualrobot process plan weld.yaml --output weld-program.yaml
  virtualrobot process plan weld.yaml --report weld.html
  virtualrobot process run weld.yaml
"""
EXAMPLES = Path(__file__).parent / "examples"
FILE = click.argument("file", type=click.Path(path_type=Path, dir_okay=False), metavar="FILE")


@click.group(epilog=_EXAMPLES, short_help="Plan and run a process, such as arc welding, that a file describes.")
@target_options
@click.pass_context
def process(ctx: click.Context, target: Target) -> None:
    """Plan and run a process that FILE (YAML) describes: where on a part, by which tool, how fast.

    The cell has to be there: the robot with its tool, and the parts.
    """
    ctx.obj = target


@process.command()
@click.argument("name", metavar="PROCESS", type=click.Choice(sorted(one.stem for one in EXAMPLES.glob("*.yaml"))))
@FILE
def new(name: str, file: Path) -> None:
    """Write an example of a file of PROCESS to FILE, which must not be there yet."""
    try:
        with file.open("x", encoding="utf-8") as there:
            there.write((EXAMPLES / f"{name}.yaml").read_text("utf-8"))
    except FileExistsError:
        raise click.UsageError(f"{file} is there already") from None
    except OSError as error:
        raise click.UsageError(f"{file} can't be written: {error.strerror}") from None
    click.echo(f"an example of {name} is in {file}")


@process.command()
@FILE
@target_options
def look(target: Target, file: Path) -> int:
    """Tell where along its ways the tool gets to, and where something would touch, before it is planned.

    The exit code is 0 where it gets to all places, each for itself, without touching anything, else 1.
    """
    from virtualrobot_apps.processes.process import look_file

    with target.connect() as client:
        found = look_file(client, file)
    for one in found:
        for _, line in one.lines():
            click.echo(line)
    return 0 if all(one.is_free for one in found) else 1


@process.command()
@FILE
@click.option(
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="PROGRAM",
    help="Write the program there, which `virtualrobot run` takes.",
)
@click.option(
    "--report",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="REPORT",
    help="Write a page about the cell there, .html or .pdf: cycle, reach, clearances, devices, measures.",
)
@target_options
def plan(target: Target, file: Path, output: Path | None, report: Path | None) -> int:
    """Tell what a process comes to, and whether it keeps all limits and touches nothing, with exit code 0 or 1."""
    from virtualrobot.cli.plan import verdict

    for written in (output, report):
        if written is not None and not written.parent.is_dir():
            raise click.UsageError(f"there is no folder {written.parent}")
    if report is not None and report.suffix.lower() not in (".html", ".pdf"):
        raise click.UsageError(f"a report is .html or .pdf, not {report.name}")
    with target.connect() as client:
        made = planned(client, file)
        found = made.program.check()
        if output is not None:
            output.write_text(made.program.text + "\n", "utf-8")
        if report is not None:
            from virtualrobot_apps.processes.cell_report import cell_report, write_report

            write_report(cell_report(client, file.stem, made, found), report)
        if found.first_violation is not None:
            click.echo(f"step {found.first_violation.step_path}: ", nl=False)
        return verdict(str(file), found, False)


@process.command()
@FILE
@click.option("--no-show", is_flag=True, help="Don't show what it does on the parts, such as a film that grows.")
@target_options
def run(target: Target, file: Path, no_show: bool) -> None:
    """Plan a process and run it; Ctrl-C stops it on its path. Pages, pictures and cameras see what it does."""
    from virtualrobot.cli.move import follow, show_notes
    from virtualrobot.cli.options import GO_ON

    with target.connect() as client:
        made = planned(client, file)
        if client.clock.mode == "stepped":
            click.echo(f"time stands still: the process goes on with each 'virtualrobot step'; {GO_ON}", err=True)
        showing = None if no_show or made.shown is None else made.shown()
        motion = made.program.start(wait=False)
        show_notes(motion)
        with nullcontext() if showing is None else showing.during(motion):
            follow(motion)
        click.echo(f"{motion.id} is done")


def planned(client: Client, file: Path) -> PlannedProcess:
    """Return the process of a file as it is planned in the cell, and tell what it comes to.

    Raises:
        VirtualRobotError: as `plan_file` does.
    """
    from virtualrobot_apps.processes.process import plan_file

    made = plan_file(client, file)
    for line in made.measures:
        click.echo(line)
    return made
