"""Errors of importers for files that they cannot read: the place first, then the reason."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from virtualrobot_sdk.errors import ArgumentError


def refusal(uri: str, message: str, line: int | None = None, **metadata: object) -> ArgumentError:
    """Return the error `file:line: message`; the metadata has the whole URI and the line.

    `missing`, where given, is the name of the file that was asked for and is nowhere.
    """
    where = short_name(uri) if line is None else f"{short_name(uri)}:{line}"
    return ArgumentError(f"{where}: {message}", file=uri, line="" if line is None else line, **metadata)


def short_name(uri: str) -> str:
    """Return the name of a file without its folders."""
    return uri.replace("\\", "/").rpartition("/")[2] or uri or "the file"


def described(error: Exception) -> str:
    """Return the kind and the words of an error that a library raised, on one line of sensible length."""
    text = " ".join(str(error).split())
    return type(error).__name__ + (f": {text[:200]}" if text else "")


def library(name: str, ending: str, extra: str) -> ModuleType:
    """Return an imported library; an ArgumentError says how to install it when it is not there."""
    try:
        return import_module(name)
    except ImportError as error:
        raise missing_library(name.partition(".")[0], ending, extra, str(error)) from error


def missing_library(package: str, ending: str, extra: str, reason: str = "") -> ArgumentError:
    """Return the error that says how to install a library that is not there."""
    why = f" ({reason})" if reason else ""
    return ArgumentError(
        f"reading {ending} needs the package {package}: pip install 'virtualrobot[{extra}]'{why}",
        package=package,
        extra=extra,
    )


def listed(names: list[str], most: int = 5) -> str:
    """Return names with commas between them; of many only the first, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def counted(counts: dict[str, int]) -> str:
    """Return `Text, LINE (3 times)` for counts by name, in the order of the names."""
    return listed([name if count == 1 else f"{name} ({count} times)" for name, count in sorted(counts.items())], 12)
