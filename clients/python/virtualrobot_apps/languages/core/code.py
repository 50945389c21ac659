"""Code that was made of a program: Python's, with the lines of the program, so that tracebacks show these."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from types import CodeType

from virtualrobot_apps.languages.core.diagnostics import Diagnostic, ProgramError
from virtualrobot_apps.languages.core.source import Source


def compiled(lines: Sequence[str], places: Sequence[int], source: Source) -> CodeType:
    """Return the code of lines of Python; `places` has the line of the source that each of them comes from.

    Raises ProgramError where more is nested than Python takes.
    """
    numbers = [*places, 1]
    try:
        parsed = ast.parse("\n".join(lines) or "pass")
    except SyntaxError as error:
        raise _too_deep(source, numbers[(error.lineno or 1) - 1]) from error
    except (RecursionError, MemoryError) as error:
        raise _too_long(source) from error
    # As ast.walk does, in a third of the time.
    waiting: list[ast.AST] = [parsed]
    while waiting:
        node = waiting.pop()
        fields = node.__dict__
        for value in fields.values():
            if isinstance(value, ast.AST):
                waiting.append(value)
            elif type(value) is list:
                waiting += [one for one in value if isinstance(one, ast.AST)]
        if "lineno" in fields:
            fields["lineno"] = fields["end_lineno"] = numbers[fields["lineno"] - 1]
            fields["col_offset"] = fields["end_col_offset"] = 0
    try:
        return compile(parsed, source.file, "exec")
    except SyntaxError as error:
        raise _too_deep(source, error.lineno or 1) from error
    except RecursionError as error:
        raise _too_long(source) from error


def _too_deep(source: Source, line: int) -> ProgramError:
    said = "too many loops and conditions are nested within each other here"
    return ProgramError([Diagnostic(source.file, line, 1, said)])


def _too_long(source: Source) -> ProgramError:
    said = "a choice in this program has too many arms, or too much is within them"
    return ProgramError([Diagnostic(source.file, 1, 1, said)])
