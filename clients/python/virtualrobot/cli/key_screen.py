"""A terminal whose keys do something at once, with a few lines of text that are kept up to date."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from virtualrobot.errors import VirtualRobotError

if TYPE_CHECKING:
    from prompt_toolkit.input import Input
    from prompt_toolkit.key_binding import KeyPressEvent
    from prompt_toolkit.output import Output

ARROWS = ("up", "down", "left", "right")


class KeyScreen:
    """Keys until q, Escape or Ctrl-C. What a key does may be refused: the refusal stands below the text."""

    def __init__(self, pressed: Callable[[str], object], text: Callable[[], str]) -> None:
        """Have `pressed` called with each key: its letter, or `up`, `down`, `left`, `right`."""
        self._pressed, self._text = pressed, text
        self._said = ""

    def run(self, source: Input | None = None, output: Output | None = None) -> None:
        """Take keys of this terminal, or of `source`, until one ends it."""
        from prompt_toolkit.application import Application
        from prompt_toolkit.key_binding import KeyBindings
        from prompt_toolkit.keys import Keys
        from prompt_toolkit.layout import FormattedTextControl, Layout, Window

        bindings = KeyBindings()

        @bindings.add(Keys.Any)
        def _(event: KeyPressEvent) -> None:
            self._guarded(event.data)

        for name in ARROWS:
            bindings.add(name)(lambda _, name=name: self._guarded(name))

        @bindings.add("q")
        @bindings.add("c-c")
        @bindings.add("c-d")
        @bindings.add("escape", eager=True)
        def _(event: KeyPressEvent) -> None:
            event.app.exit()

        control = FormattedTextControl(lambda: f"{self._text()}\n{self._said}")
        app: Application[None] = Application(
            layout=Layout(Window(control)), key_bindings=bindings, input=source, output=output, refresh_interval=0.2
        )
        app.run()

    def _guarded(self, key: str) -> None:
        try:
            self._pressed(key)
            self._said = ""
        except VirtualRobotError as error:
            self._said = str(error)
