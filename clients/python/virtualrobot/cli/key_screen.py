"""Keys of a terminal that do something at once, with a few lines of text that are kept up to date."""

from __future__ import annotations

import time
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING

from virtualrobot.errors import VirtualRobotError

if TYPE_CHECKING:
    from prompt_toolkit.input import Input
    from prompt_toolkit.key_binding import KeyPressEvent
    from prompt_toolkit.output import Output

FIRST_SECONDS = 0.6
"""Time (s) for which a key counts as held after its first press: a terminal repeats it only then."""

AGAIN_SECONDS = 0.2
"""Time (s) for which it counts as held after each repetition."""

_DRAWN_SECONDS = 0.2


class HeldKey:
    """Key of a terminal that is held down: a terminal repeats a key, and tells nothing when it is let go."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Hold none; `clock` tells the time in s."""
        self._clock = clock
        self._key, self._until = "", 0.0

    def press(self, key: str) -> None:
        """Count a key as held for a while, and no other one."""
        again = key == self.key
        self._key, self._until = key, self._clock() + (AGAIN_SECONDS if again else FIRST_SECONDS)

    def release(self) -> None:
        """Hold none."""
        self._key = ""

    @property
    def key(self) -> str:
        """Name of the key that counts as held; empty: none."""
        return self._key if self._clock() < self._until else ""


class KeyScreen:
    """Keys until q, Escape or Ctrl-C. What the kernel refuses stands below the text."""

    def __init__(
        self,
        press: Callable[[str], object],
        text: Callable[[], str],
        end: Callable[[], object] | None = None,
        follow: Callable[[], Awaitable[object]] | None = None,
    ) -> None:
        """Prepare a screen.

        Args:
            press: called with each key, its letter or its name, such as `up`.
            text: what is shown.
            end: called for q, Escape and Ctrl-C instead of closing the screen.
            follow: runs meanwhile; the screen is closed when it returns.
        """
        self._press, self._text, self._end, self._follow = press, text, end, follow
        self._said = ""

    def run(self, source: Input | None = None, output: Output | None = None) -> None:
        """Take keys of this terminal, or of `source`, until one ends it; raises what `follow` raises."""
        from prompt_toolkit.application import Application
        from prompt_toolkit.key_binding import KeyBindings
        from prompt_toolkit.keys import Keys
        from prompt_toolkit.layout import FormattedTextControl, Layout, Window

        bindings = KeyBindings()
        failed: list[VirtualRobotError] = []

        @bindings.add(Keys.Any)
        def _(event: KeyPressEvent) -> None:
            key = event.key_sequence[0].key
            self._guarded(lambda: self._press(key.value if isinstance(key, Keys) else key))

        @bindings.add("q")
        @bindings.add("c-c")
        @bindings.add("c-d")
        @bindings.add("escape", eager=True)
        def _(event: KeyPressEvent) -> None:
            self._guarded(self._end or close)

        def close() -> None:
            if app.is_running and not app.is_done:
                app.exit()

        async def follow() -> None:
            assert self._follow is not None
            try:
                await self._follow()
            except VirtualRobotError as error:
                failed.append(error)
            close()

        def begin() -> None:
            if self._follow is not None:
                app.create_background_task(follow())

        app: Application[None] = Application(
            layout=Layout(Window(FormattedTextControl(self._shown))),
            key_bindings=bindings,
            input=source,
            output=output,
            refresh_interval=_DRAWN_SECONDS,
        )
        app.run(pre_run=begin)
        if failed:
            raise failed[0]

    def _guarded(self, act: Callable[[], object]) -> None:
        try:
            act()
            self._said = ""
        except VirtualRobotError as error:
            self._said = str(error)

    def _shown(self) -> str:
        try:
            return f"{self._text()}\n{self._said}"
        except VirtualRobotError as error:  # such as a kernel that has gone
            return str(error)
