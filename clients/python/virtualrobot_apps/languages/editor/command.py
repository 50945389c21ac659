"""`virtualrobot editor`: a language server and a debug adapter for editors."""

from __future__ import annotations

import click
from virtualrobot.cli.options import Target, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot editor lsp
  virtualrobot editor dap --port 4711
"""

_port = click.option(
    "--port",
    metavar="PORT",
    type=click.IntRange(0, 65535),
    help="Listen here, at 127.0.0.1, instead of speaking on the standard streams; 0: a port that is free.",
)


@click.group(epilog=_EXAMPLES, short_help="Serve editors: diagnostics, hover, completion, and a debugger.")
@target_options
@click.pass_context
def editor(ctx: click.Context, target: Target) -> None:
    """Servers that editors start, for programs in RAPID and URScript."""
    ctx.obj = target


@editor.command()
@_port
def lsp(port: int | None) -> int:
    """Serve an editor by the Language Server Protocol: RAPID and URScript.

    It tells faults as they are written, and what words mean and where they are declared, completes words, and lays
    texts out.
    """
    from virtualrobot_apps.languages.editor.channel import serve
    from virtualrobot_apps.languages.editor.lsp import LanguageServer

    return serve(lambda channel: LanguageServer(channel).run(), port)


@editor.command()
@_port
@target_options
def dap(target: Target, port: int | None) -> int:
    """Serve an editor by the Debug Adapter Protocol: programs in RAPID, with or without a robot, and in URScript.

    Breakpoints, steps, the call stack with program and motion pointer, and variables that can be edited.
    """
    from virtualrobot_apps.languages.editor.channel import serve
    from virtualrobot_apps.languages.editor.dap import DebugAdapter

    return serve(lambda channel: DebugAdapter(channel, target).run(), port)
