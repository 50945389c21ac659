"""Text: what is shown and asked, and the strings &0 to &99."""

from __future__ import annotations

from typing import TYPE_CHECKING

from virtualrobot_apps.languages.rapl.faults import RaplFault
from virtualrobot_apps.languages.rapl.table import command

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapl.task import RaplTask


@command("TYPE", "said [number]")
def _type(task: RaplTask, text: str, value: float | None) -> None:
    """Shows a text or string, and after it a value."""
    task.write(text if value is None else f"{text}{value:g}")


@command("TYPEI", "variable...")
def _type_integers(task: RaplTask, names: list[str]) -> None:
    """Shows variables as whole numbers."""
    task.write(" ".join(f"{task.variable(name):.0f}" for name in names))


@command("TYPEV", "variable...")
def _type_values(task: RaplTask, names: list[str]) -> None:
    """Shows variables as numbers."""
    task.write(" ".join(f"{task.variable(name):.4f}" for name in names))


@command("PRINT", "said [number]")
def _print(task: RaplTask, text: str, value: float | None) -> None:
    """Shows what TYPE does: there is no printer beside the terminal."""
    _type(task, text, value)


@command("PRINTI", "variable...")
def _print_integers(task: RaplTask, names: list[str]) -> None:
    """Shows what TYPEI does."""
    _type_integers(task, names)


@command("PRINTV", "variable...")
def _print_values(task: RaplTask, names: list[str]) -> None:
    """Shows what TYPEV does."""
    _type_values(task, names)


@command("LISTV")
def _list(task: RaplTask) -> None:
    """Shows all variables."""
    for name, value in sorted(task.variables.items()):
        task.write(f"{name} {value:.4f}")


@command("INPUT", "new_variable")
def _input(task: RaplTask, name: str) -> None:
    """Asks for a number, and gives it to a variable."""
    answer = task.question(f"{name}?")
    try:
        task.variables[name] = float(answer)
    except ValueError:
        raise RaplFault(f"{name} takes a number, not {answer!r}") from None


@command("ENCODE", "variable string [I]")
def _encode(task: RaplTask, name: str, string: int, whole: str) -> None:
    """Writes a variable into a string, with I as a whole number."""
    value = task.variable(name)
    task.strings[string] = f"{value:.0f}" if whole else f"{value:.4f}"


@command("DECODE", "string number new_variable")
def _decode(task: RaplTask, string: int, begin: float, name: str) -> None:
    """Gives a variable the number that a string has from a character on, counted from 1."""
    words = task.strings[string][max(0, int(begin) - 1) :].split()
    try:
        task.variables[name] = float(words[0])
    except (IndexError, ValueError):
        raise RaplFault(f"&{string} has no number from character {begin:g} on: {task.strings[string]!r}") from None


@command("CUT", "string number number")
def _cut(task: RaplTask, string: int, begin: float, count: float) -> None:
    """Takes characters out of a string: from one on, counted from 1, so many."""
    text, first = task.strings[string], max(0, int(begin) - 1)
    task.strings[string] = text[:first] + text[first + max(0, int(count)) :]


@command("PASTE", "said string number")
def _paste(task: RaplTask, text: str, string: int, begin: float) -> None:
    """Puts a text or string into a string before a character, counted from 1."""
    whole, first = task.strings[string], max(0, int(begin) - 1)
    task.strings[string] = whole[:first] + text + whole[first:]


@command("STRPOS", "said string new_variable")
def _position(task: RaplTask, text: str, string: int, name: str) -> None:
    """Gives a variable the place of a text or string within a string, counted from 1; 0 where it is not there."""
    task.variables[name] = float(task.strings[string].find(text) + 1)
