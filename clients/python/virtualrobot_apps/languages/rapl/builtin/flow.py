"""Flow: lines and programs that are gone to, conditions, variables, times, and the end."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING

from virtualrobot_apps.languages.rapl.table import command

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapl.lexer import Word
    from virtualrobot_apps.languages.rapl.task import RaplTask

_RELATIONS = {
    "EQ": operator.eq,
    "NE": operator.ne,
    "LT": operator.lt,
    "GT": operator.gt,
    "LE": operator.le,
    "GE": operator.ge,
}


@command(";", "message")
def _comment(task: RaplTask, message: str) -> None:
    """Is a comment."""


@command("!", "assignment")
def _assign(task: RaplTask, assigned: tuple[str | int, float | str]) -> None:
    """Gives a variable the value of an expression, or a string (&1) that of a text or string."""
    target, value = assigned
    if isinstance(target, int):
        task.strings[target] = str(value)
    else:
        task.variables[target] = float(value)


@command("++", "new_variable")
def _increase(task: RaplTask, name: str) -> None:
    """Adds 1 to a variable."""
    task.variables[name] = task.variables.get(name, 0.0) + 1.0


@command("--", "new_variable")
def _decrease(task: RaplTask, name: str) -> None:
    """Takes 1 from a variable."""
    task.variables[name] = task.variables.get(name, 0.0) - 1.0


@command("GOTO", "line")
def _go_to(task: RaplTask, line: int) -> None:
    """Goes on at a line."""
    task.go_to(line)


@command("IF", "number relation number THEN line")
def _if(task: RaplTask, left: float, relation: str, right: float, line: int) -> None:
    """Goes on at a line where two values compare so: == (EQ), <> (NE), < (LT), > (GT), <= (LE), >= (GE)."""
    if _RELATIONS[relation](left, right):
        task.go_to(line)


@command("IFSTRING", "string ==|EQ said THEN line")
def _if_string(task: RaplTask, string: int, relation: str, text: str, line: int) -> None:
    """Goes on at a line where a string is a text."""
    if task.strings[string] == text:
        task.go_to(line)


@command("GOSUB", "program [parameter...]")
def _go_sub(task: RaplTask, program: str, parameters: list[Word]) -> None:
    """Goes to another program, which knows what it is given as %0 to %7, up to its RETURN or last line."""
    task.call(program, parameters)


@command("RETURN", "[number]")
def _return(task: RaplTask, skipped: float | None) -> None:
    """Goes back to the calling program, and leaves out as many lines there; of the first program it is the end."""
    task.leave(int(skipped or 0))


@command("STOP", "message")
def _stop(task: RaplTask, message: str) -> None:
    """Ends the program, and shows a message; the arm goes on to where it was sent."""
    if message:
        task.write(message)
    task.end()


@command("ABORT")
def _abort(task: RaplTask) -> None:
    """Ends the program; the arm goes on to where it was sent."""
    task.end()


@command("PAUSE", "message")
def _pause(task: RaplTask, message: str) -> None:
    """Shows a message, and waits for Enter."""
    task.question(f"{message or 'PAUSE'}: Enter goes on")


@command("DELAY", "number")
def _delay(task: RaplTask, seconds: float) -> None:
    """Waits for some seconds of the simulation, while the arm moves on."""
    task.delay(seconds)


@command("TIME", "new_variable")
def _time(task: RaplTask, name: str) -> None:
    """Gives a variable the time of the simulation (s)."""
    task.variables[name] = task.time()


@command("TRACE")
def _trace(task: RaplTask) -> None:
    """Shows program and number of each line from now on."""
    task.traces = True


@command("DVAR", "variable...")
def _forget(task: RaplTask, names: list[str]) -> None:
    """Forgets variables."""
    for name in names:
        task.variables.pop(name, None)
