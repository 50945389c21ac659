"""Hold to run by a key: `virtualrobot move ARM ... --hold`."""

from __future__ import annotations

import asyncio
import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING

import click

from virtualrobot.errors import VirtualRobotError

if TYPE_CHECKING:
    from prompt_toolkit.input import Input
    from prompt_toolkit.output import Output

    from virtualrobot.motions.motion import Motion

LOOK_SECONDS = 0.02

hold_option = click.option(
    "--hold", is_flag=True, help="Move only while the space key of this terminal is held down; q ends it."
)


def check_terminal(hold: bool, no_wait: bool = False) -> None:
    """Raise UsageError where nobody could hold a key down."""
    if hold and no_wait:
        raise click.UsageError("--hold is for somebody who stays; leave out --no-wait")
    if hold and (sys.stdin is None or not sys.stdin.isatty()):
        raise click.UsageError("--hold needs a terminal, whose space key is held down")


def hold_by_key(motion: Motion, source: Input | None = None, output: Output | None = None) -> None:
    """Let a motion that was started with `hold` run while the space key is held, until it ends; q cancels it.

    Raises what the kernel refuses, as when somebody else holds it.
    """
    from virtualrobot.cli.key_screen import HeldKey, KeyScreen

    held = HeldKey()

    def press(key: str) -> None:
        if key == " ":
            held.press(key)

    def text() -> str:
        state = "moves" if held.key else "stands"
        return f"{motion.id} {state}, {100.0 * motion.progress:.0f}%   hold space to move, q ends it"

    async def follow() -> None:
        with ExitStack() as holding:
            beat = None
            while not motion.phase.ended:
                if not held.key:
                    beat = holding.close()
                elif beat is None:
                    beat = holding.enter_context(motion.beats())
                else:
                    beat()
                await asyncio.sleep(LOOK_SECONDS)

    def end() -> None:
        motion.cancel("let go for good at the keyboard")

    try:
        KeyScreen(press, text, end, follow).run(source, output)
    except VirtualRobotError:
        motion.cancel("it could not be held")
        raise
