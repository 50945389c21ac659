"""Summary of an error in one line: its type, its text and the line of the author's code that it came from."""

from __future__ import annotations

import re
import traceback
from pathlib import Path
from types import TracebackType

_LONGEST = 400
_OURS = ("virtualrobot_sdk", "pluggy", "importlib", "runpy")


def package_of(path: str) -> str:
    """Return the top-level package of `package.module:attribute`."""
    return re.split(r"[.:\[]", path, maxsplit=1)[0].strip()


def describe_error(error: BaseException, package: str) -> str:
    """Return `ValueError: the text (file.py:12 in function)`; the line is the innermost one of the top-level `package`.

    Where none of its lines is on the way, it is the innermost that is not this SDK's.
    """
    text = " ".join(_text(error).split())
    text = text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."
    said = f"{type(error).__name__}: {text}" if text else type(error).__name__
    where = _where(error, package)
    return f"{said} ({where})" if where else said


def traceback_of(error: BaseException) -> str:
    """Return the traceback as text, without the frames of this SDK that it begins with."""
    trace = error.__traceback__
    while trace is not None and _module(trace).partition(".")[0] in _OURS:
        trace = trace.tb_next
    return "".join(traceback.format_exception(type(error), error, trace))


def _text(error: BaseException) -> str:
    if isinstance(error, SyntaxError):
        return error.msg
    try:
        return str(error)
    except Exception as second:  # An author's __str__ may be as broken as the rest.
        return f"(its __str__ raises {type(second).__name__})"


def _where(error: BaseException, package: str) -> str:
    if isinstance(error, SyntaxError) and error.filename:
        return f"{Path(error.filename).name}:{error.lineno}"
    frames = [(trace, line) for trace, line in _frames(error.__traceback__)]
    own = [f for f in frames if _module(f[0]).partition(".")[0] == package]
    foreign = [f for f in frames if _module(f[0]).partition(".")[0] not in _OURS and not _frozen(f[0])]
    if not (chosen := own or foreign):
        return ""
    trace, line = chosen[-1]
    code = trace.tb_frame.f_code
    place = "" if code.co_name == "<module>" else f" in {code.co_name}"
    return f"{Path(code.co_filename).name}:{line}{place}"


def _frames(trace: TracebackType | None) -> list[tuple[TracebackType, int]]:
    found = []
    while trace is not None:
        found.append((trace, trace.tb_lineno))
        trace = trace.tb_next
    return found


def _module(trace: TracebackType) -> str:
    return str(trace.tb_frame.f_globals.get("__name__", ""))


def _frozen(trace: TracebackType) -> bool:
    return trace.tb_frame.f_code.co_filename.startswith("<frozen")
