"""`virtualrobot serve`: finds the kernel by its entry point; the client library does not know it otherwise."""

from __future__ import annotations

from importlib.metadata import EntryPoint, entry_points

import click

_INSTALL = "in a clone of VirtualRobot, install it with: pip install '.[kernel]'"


@click.command(
    add_help_option=False,
    context_settings={"ignore_unknown_options": True, "allow_extra_args": True, "allow_interspersed_args": False},
)
@click.pass_context
def serve(ctx: click.Context) -> int:
    """Start a kernel and keep it running; `virtualrobot serve --help` shows the kernel's own options."""
    arguments = list(ctx.args)
    if ctx.parent is not None and ctx.parent.params.get("debug") and "--debug" not in arguments:
        arguments.append("--debug")
    try:
        return int(kernel_entry_point().load()(arguments) or 0)
    except ModuleNotFoundError as error:
        if "--debug" in arguments:
            raise
        raise click.ClickException(f"the kernel is not installed here ({error.name} is missing); {_INSTALL}") from error


def kernel_entry_point() -> EntryPoint:
    """Return where the kernel's `serve` is; raise a readable error when the kernel is not installed."""
    found = entry_points(group="virtualrobot.kernel", name="serve")
    if not found:
        raise click.ClickException(f"the kernel is not installed here; {_INSTALL}")
    return next(iter(found))
