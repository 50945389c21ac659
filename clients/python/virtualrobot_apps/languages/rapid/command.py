"""`virtualrobot rapid`: checks programs in RAPID."""

from __future__ import annotations

from pathlib import Path

import click
from virtualrobot.cli.options import Target, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot rapid check palletize.mod
  virtualrobot rapid check main.mod tools.sys --signal doGripper --signal diPart
"""

_files = click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(path_type=Path))
_signals = click.option("--signal", "signals", metavar="NAME", multiple=True, help="The world has this signal.")


@click.group(epilog=_EXAMPLES, short_help="Check programs in RAPID, the language of ABB's controllers.")
@target_options
@click.pass_context
def rapid(ctx: click.Context, target: Target) -> None:
    """Programs in RAPID, the language of ABB's controllers: modules in files, which together are one program."""
    ctx.obj = target


@rapid.command()
@_files
@_signals
@target_options
def check(target: Target, files: tuple[Path, ...], signals: tuple[str, ...]) -> int:
    """Tell what is wrong in the program that FILEs make together, with exit code 0 or 1; needs no kernel.

    Looked at are words, names, types and arguments, and whether all that is used works here.
    """
    from virtualrobot_apps.languages.core.diagnostics import ProgramError
    from virtualrobot_apps.languages.rapid.task import load_files

    try:
        program = load_files(files, signals)
    except ProgramError as error:
        for one in error.diagnostics:
            click.echo(str(one))
        click.echo(f"{len(error.diagnostics)} fault{'s' * (len(error.diagnostics) != 1)}")
        return 1
    counted = sum(len(scope.routines) for scope in program.checked.modules)
    named = ", ".join(sorted(use.name for use in program.signals.values()))
    click.echo(
        f"no fault in {counted} routine{'s' * (counted != 1)}" + (f"; signals of the world: {named}" if named else "")
    )
    return 0
