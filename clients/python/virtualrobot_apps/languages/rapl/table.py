"""Table of RAPL-II's commands: a row for each that works, and the names of those that don't, with the reason.

A row is the function that does it, with the form of its arguments. Check, documentation and tests read it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from virtualrobot_apps.languages.rapl.forms import Element, elements_of

Run = TypeVar("Run", bound=Callable[..., Any])


@dataclass(frozen=True, slots=True)
class Command:
    """A command that works.

    Attributes:
        name: as it is typed.
        form: its arguments (see `forms`).
        elements: the same, read.
        text: the sentence that tells people what it does.
        room: the module that has it.
        run: the function that does it, called with the task and each argument.
        signals: `input` or `output` where its numbers are those of signals.
    """

    name: str
    form: str
    elements: list[Element]
    text: str
    room: str
    run: Callable[..., Any]
    signals: str


COMMANDS: dict[str, Command] = {}
"""All that works, by name."""


def command(name: str, form: str = "", *, signals: str = "") -> Callable[[Run], Run]:
    """Enter a function as a command; the first line of its docstring tells what it does."""

    def enter(run: Run) -> Run:
        text = (run.__doc__ or "").partition("\n")[0]
        room = run.__module__.rpartition(".")[2]
        COMMANDS[name] = Command(name, form, elements_of(form), text, room, run, signals)
        return run

    return enter


REFUSED: dict[str, tuple[str, ...]] = {
    "it works on the controller's own memory, programs or ports": tuple(
        "ALLOC CONFIG DELETE DEVICE DIR DISABLE EDIT ENABLE EXECUTE FREE HELP HIMEM IORD IOWR LISTP MEMRD MEMWR NOHELP "
        "PASSWORD PROCEED REMOTE RENAME RETRY RTCLOCK RUN SERIAL STATUS".split()
    ),
    "it works on motors, brakes, homing or extra axes, which a program here has not": tuple(
        "ARM AXSTATUS GAIN HOME LIMP LOCK MAGGRIP NOLIMP UNLOCK WE1 WE3 WE5 XCAL XHOME XREADY XZERO".split()
    ),
    "it works on the teach pendant or the front panel": tuple("FLASH IFAUX IFPOWER IFSTART MANUAL TEACH".split()),
    "it shows something again and again; W0 and W2 show the position once": tuple("W1 W3 W4 W5".split()),
    "it is typed, and stands in the file of locations here": ("POINT",),
    "its form is not known to us": tuple("CIRCLE HLIM IGNORE INVERT ONSIG TRIGGER".split()),
}
"""Commands of the manual that are refused by name, by the reason."""


def refusal(name: str) -> str:
    """Return why a command is refused; empty for one that is not."""
    return next((reason for reason, names in REFUSED.items() if name in names), "")
