"""Persistents that a program has changed, written back into its files, as a controller keeps them in its modules."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from virtualrobot.errors import WrongStateError

from virtualrobot_apps.languages.core.source import Source, decoded, encoded_like
from virtualrobot_apps.languages.rapid.lexer import pieces_of
from virtualrobot_apps.languages.rapid.support import copied
from virtualrobot_apps.languages.rapid.symbols import Datum
from virtualrobot_apps.languages.rapid.task import RapidTask
from virtualrobot_apps.languages.rapid.values import number_text


class Persistents:
    """Persistents with a first value of tasks, as they are now."""

    def __init__(self, tasks: Iterable[RapidTask]) -> None:
        """Keep the values, before the tasks run."""
        self._before = [
            (datum, holder, copied(holder[0]))
            for task in tasks
            for datum, holder in task.persistents()
            if datum.node is not None and datum.node.value is not None and datum.source is not None
        ]

    def save(self) -> list[tuple[Path, int]]:
        """Write those that have other values now into their files; return these, and how many each has.

        Other text stays as it is. Raises WrongStateError for a file that somebody has changed meanwhile, and then no
        file is written.
        """
        changed: dict[str, list[Datum]] = {}
        values: dict[int, Any] = {}
        for datum, holder, before in self._before:
            if holder[0] != before and datum.source is not None:
                changed.setdefault(datum.source.file, []).append(datum)
                values[id(datum)] = holder[0]
        written = [(Path(file), _with_values(file, data, values), len(data)) for file, data in changed.items()]
        for file, content, _ in written:
            file.write_bytes(content)
        return [(file, count) for file, _, count in written]


def exact_text(value: Any) -> str:  # noqa: ANN401 any value of RAPID
    """Return a value as a declaration has it, numbers with all their digits."""
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if isinstance(value, str):
        return '"{}"'.format("".join(_LETTERS.get(one, one) for one in value))
    if isinstance(value, list):
        return f"[{','.join(map(exact_text, value))}]"
    tried = (number_text(value), f"{value:.15g}", f"{value:.17g}")
    return next((text for text in tried if float(text) == value), tried[-1])


_LETTERS = {'"': '""', "\\": "\\\\", **{chr(code): f"\\{code:02X}" for code in range(32)}}
"""Characters that a text in quotes has by two or more."""


def _with_values(file: str, data: list[Datum], values: dict[int, Any]) -> bytes:
    """Return the bytes of a file with the values of data that it declares."""
    content = Path(file).read_bytes()
    source = data[0].source
    if source is None or Source(decoded(content), file).text != source.text:
        raise WrongStateError(f"{file} was changed while the program ran, and persistents are not saved")
    text = source.text
    places = [(_value_of(source, datum), exact_text(values[id(datum)])) for datum in data]
    for (begin, end), value in sorted(places, reverse=True):
        text = text[:begin] + value + text[end:]
    return encoded_like(text, content)


def _value_of(source: Source, datum: Datum) -> tuple[int, int]:
    """Return where the first value of a datum begins and ends in its source."""
    assert datum.node is not None
    begin = 0
    for kind, _, at in pieces_of(source, datum.node.at):
        if kind == ":=" and not begin:
            begin = at + 2
            begin += len(source.text[begin:]) - len(source.text[begin:].lstrip())
        elif kind == ";":
            return begin, at
    raise AssertionError("a declaration ends with a semicolon")
