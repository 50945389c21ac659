"""`virtualrobot urscript`: checks scripts, and lays them out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import Target, target_options

from virtualrobot_apps.emulators.ur.command import MODELS
from virtualrobot_apps.languages.core.command import faulty, lay_out, longest_option, only_robot, times_option, told

if TYPE_CHECKING:
    from virtualrobot_apps.languages.core.diagnostics import Diagnostic
    from virtualrobot_apps.languages.urscript.task import Loaded

_EXAMPLES = """
\b
Examples:
  virtualrobot urscript check square.script
  virtualrobot urscript check square.script --run --robot arm --order 'input 3 on' --times
  virtualrobot urscript format square.script grip.script
"""

_files = click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(path_type=Path))


@click.group(epilog=_EXAMPLES, short_help="Check and format scripts of controllers of Universal Robots.")
@target_options
@click.pass_context
def urscript(ctx: click.Context, target: Target) -> None:
    """Scripts in URScript, the language of Universal Robots' controllers, each in a file of its own."""
    ctx.obj = target


@urscript.command()
@_files
@click.option("--run", "runs", is_flag=True, help="Play each from where a kernel's arm stands; nothing moves there.")
@click.option("--robot", metavar="NAME", help="With --run: the arm [the only robot].")
@click.option("--model", type=click.Choice(MODELS), help="With --run: the arm's lengths [those that it has].")
@click.option("--order", "orders", metavar="TEXT", multiple=True, help="With --run: told before, as 'input 3 on'.")
@longest_option
@times_option
@target_options
def check(
    target: Target,
    files: tuple[Path, ...],
    runs: bool,
    robot: str | None,
    model: str | None,
    orders: tuple[str, ...],
    longest: float,
    times: bool,
) -> int:
    """Tell what is wrong in the scripts of FILEs, with exit code 0 or 1; needs no kernel.

    Looked at are words, names, calls and their arguments, and whether all that is used works here: a script without a
    fault starts on `virtualrobot emulate ur`. With --run each is played, too, by an arm of its own: what it would touch
    in a kernel's world, places out of reach, limits and faults at work are told.
    """
    from virtualrobot_apps.languages.core.diagnostics import ProgramError
    from virtualrobot_apps.languages.core.source import read_source
    from virtualrobot_apps.languages.urscript.task import load

    faults: list[Diagnostic] = []
    scripts: list[Loaded] = []
    for file in files:
        try:
            scripts.append(load(read_source(file).text, str(file)))
        except ProgramError as error:
            faults += error.diagnostics
    if faults:
        return faulty(ProgramError(faults))
    names = ", ".join(one.name for one in scripts)
    click.echo(f"no fault in {len(scripts)} script{'s' * (len(scripts) != 1)}: {names}")
    if not runs:
        return 0
    from virtualrobot_apps.emulators.ur.lengths import USUAL, model_of
    from virtualrobot_apps.languages.urscript.trial import play

    with target.connect() as client:
        arm = client.robot(only_robot(client, robot))
        lengths = model or model_of(arm) or USUAL
        try:
            played = [play(client, arm, one, lengths, longest, orders) for one in scripts]
        except ValueError as error:
            raise click.ClickException(str(error)) from error
    return max(told(one, times) for one in played)


@urscript.command("format")
@_files
@click.option("--check", "only_check", is_flag=True, help="Change no file, and tell which would be changed.")
def format_files(files: tuple[Path, ...], only_check: bool) -> int:
    """Lay FILEs out: two spaces for each level.

    Lines stay lines, and words what they are. A file that can't be parsed is left as it is, and its faults are told,
    with exit code 1.
    """
    from virtualrobot_apps.languages.urscript.layout import formatted

    return lay_out(files, formatted, only_check)
