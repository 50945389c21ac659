"""`virtualrobot urscript`: checks scripts, and lays them out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import Target, target_options

from virtualrobot_apps.languages.core.command import faulty, lay_out

if TYPE_CHECKING:
    from virtualrobot_apps.languages.core.diagnostics import Diagnostic

_EXAMPLES = """
\b
Examples:
  virtualrobot urscript check square.script
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
def check(files: tuple[Path, ...]) -> int:
    """Tell what is wrong in the scripts of FILEs, with exit code 0 or 1; needs no kernel.

    Looked at are words, names, calls and their arguments, and whether all that is used works here: a script without a
    fault starts on `virtualrobot emulate ur`.
    """
    from virtualrobot_apps.languages.core.diagnostics import ProgramError
    from virtualrobot_apps.languages.core.source import read_source
    from virtualrobot_apps.languages.urscript.task import load

    faults: list[Diagnostic] = []
    names: list[str] = []
    for file in files:
        try:
            names.append(load(read_source(file).text, str(file)).name)
        except ProgramError as error:
            faults += error.diagnostics
    if faults:
        return faulty(ProgramError(faults))
    click.echo(f"no fault in {len(names)} script{'s' * (len(names) != 1)}: {', '.join(names)}")
    return 0


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
