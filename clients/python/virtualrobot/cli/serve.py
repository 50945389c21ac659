"""`virtualrobot serve` and `grade`: programs of the kernel's side, found by their entry points.

The client library does not know them otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import EntryPoint, entry_points
from typing import Any

import click

_INSTALL = "in a clone of VirtualRobot, install it with: pip install '.[kernel]'"
_PASS_ALL = {"ignore_unknown_options": True, "allow_extra_args": True, "allow_interspersed_args": False}


@click.command(add_help_option=False, context_settings=_PASS_ALL)
@click.pass_context
def serve(ctx: click.Context) -> int:
    """Start a kernel and keep it running; `virtualrobot serve --help` shows the kernel's own options."""
    arguments = list(ctx.args)
    if ctx.parent is not None and ctx.parent.params.get("debug") and "--debug" not in arguments:
        arguments.append("--debug")
    with _told_how_to_install(raised="--debug" in arguments):
        return int(kernel_entry_point("serve").load()(arguments) or 0)


@click.command(add_help_option=False, context_settings=_PASS_ALL)
@click.pass_context
def replay(ctx: click.Context) -> int:
    """Show, or verify, what a project folder has recorded; `virtualrobot replay --help` shows its options."""
    with _told_how_to_install(raised="--debug" in ctx.args):
        return int(kernel_entry_point("replay").load()(list(ctx.args)) or 0)


@click.command(add_help_option=False, context_settings=_PASS_ALL)
@click.pass_context
def grade(ctx: click.Context) -> int:
    """Test components of plugins; `virtualrobot grade --help` shows the test kit's own options."""
    with _told_how_to_install(raised="--debug" in ctx.args):
        main = kernel_entry_point("grade").load()
    # A module that is missing from here on is one of the component's.
    return int(main(list(ctx.args)) or 0)


@contextmanager
def _told_how_to_install(raised: bool) -> Iterator[None]:
    """Turn a missing module into a readable error, unless it shall be `raised` as it is."""
    try:
        yield
    except ModuleNotFoundError as error:
        if raised:
            raise
        raise click.ClickException(f"the kernel is not installed here ({error.name} is missing); {_INSTALL}") from error


def kernel_program(name: str) -> Callable[..., Any]:
    """Return a function of the kernel, whose refusals are readable errors; raise one when it is not installed."""
    function = kernel_entry_point(name).load()

    def told(*arguments: object) -> object:
        try:
            return function(*arguments)
        except Exception as error:
            if not hasattr(error, "reason"):
                raise
            raise click.ClickException(str(error)) from error

    return told


def kernel_entry_point(name: str) -> EntryPoint:
    """Return where a program of the kernel is; raise a readable error when the kernel is not installed."""
    found = entry_points(group="virtualrobot.kernel", name=name)
    if not found:
        raise click.ClickException(f"the kernel is not installed here; {_INSTALL}")
    return next(iter(found))
