"""Hold to run by a key: `virtualrobot move ARM ... --hold`."""

from __future__ import annotations

import asyncio
import sys
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING

import click

from virtualrobot.errors import VirtualRobotError

if TYPE_CHECKING:
    from prompt_toolkit.input import Input
    from prompt_toolkit.key_binding import KeyPressEvent
    from prompt_toolkit.output import Output

    from virtualrobot.motions.motion import Motion

FIRST_SECONDS = 0.6
"""Time (s) for which a key counts as held after its first press: a terminal repeats it only then."""

AGAIN_SECONDS = 0.2
"""Time (s) for which it counts as held after each repetition."""

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


class _Key:
    """Key of a terminal, which tells presses and no release."""

    def __init__(self) -> None:
        self._until = 0.0

    def press(self) -> None:
        """Count it as held for a while."""
        now = time.monotonic()
        self._until = now + (AGAIN_SECONDS if now < self._until else FIRST_SECONDS)

    @property
    def is_down(self) -> bool:
        """True while it counts as held."""
        return time.monotonic() < self._until


def hold_by_key(motion: Motion, source: Input | None = None, output: Output | None = None) -> None:
    """Let a motion that was started with `hold` run while the space key is held, until it ends; q cancels it.

    Raises what the kernel refuses, as when somebody else holds it.
    """
    from prompt_toolkit.application import Application
    from prompt_toolkit.key_binding import KeyBindings
    from prompt_toolkit.layout import FormattedTextControl, Layout, Window

    bindings, key = KeyBindings(), _Key()
    failed: list[VirtualRobotError] = []

    @bindings.add(" ")
    def _(event: KeyPressEvent) -> None:
        key.press()

    @bindings.add("q")
    @bindings.add("c-c")
    @bindings.add("c-d")
    @bindings.add("escape", eager=True)
    def _(event: KeyPressEvent) -> None:
        motion.cancel("let go for good at the keyboard")

    def text() -> str:
        state = "moves" if key.is_down else "stands"
        return f"{motion.id} {state}, {100.0 * motion.progress:.0f}%   hold space to move, q ends it"

    app: Application[None] = Application(
        layout=Layout(Window(FormattedTextControl(text))),
        key_bindings=bindings,
        input=source,
        output=output,
        refresh_interval=0.2,
    )

    async def follow() -> None:
        with ExitStack() as holding:
            held = False
            try:
                while not motion.phase.ended:
                    if key.is_down != held:
                        held = not held
                        holding.enter_context(motion.held()) if held else holding.close()
                    await asyncio.sleep(LOOK_SECONDS)
            except VirtualRobotError as error:
                failed.append(error)
        app.exit()

    def begin() -> None:
        app.create_background_task(follow())

    app.run(pre_run=begin)
    if failed:
        motion.cancel("it could not be held")
        raise failed[0]
