"""YAML texts changed in single places, as panels do: what a person has written beside stays."""

from __future__ import annotations

from collections.abc import Sequence

import yaml

from virtualrobot_apps.cell_io.yaml_file import parse


def with_value(text: str, path: Sequence[str], value: str, file: str = "text.yaml") -> str:
    """Return a text in which a field has a value, such as ("tolerance", "rotation") the value `free`.

    The field comes in where it isn't there yet. Raises MalformedFileError for a text that `parse` refuses.
    """
    text = _ended(text)
    here = parse(text, file).node
    for place, name in enumerate(path):
        assert isinstance(here, yaml.MappingNode)
        found = _field(here, name)
        if found is None or (place + 1 < len(path) and not isinstance(found, yaml.MappingNode)):
            inner = value
            for one in reversed(path[place + 1 :]):
                inner = f"{{{one}: {inner}}}"
            return _replaced(text, found, inner) if found is not None else _inserted(text, here, f"{name}: {inner}")
        here = found
    return _replaced(text, here, value)


def with_item(text: str, path: Sequence[str], words: str, *, add: bool, file: str = "text.yaml") -> str:
    """Return a text in which words are the only item of a list that is there, or, with `add`, its last one.

    Raises MalformedFileError for a text that `parse` refuses, and where there is no such list.
    """
    text = _ended(text)
    item = parse(text, file)
    for name in path:
        item = item.mapping()[name]
    item.items()
    node = item.node
    if node.flow_style:  # pyright: ignore[reportAttributeAccessIssue] a list has a style
        inner = text[node.start_mark.index + 1 : node.end_mark.index - 1].strip() if add else ""
        return _replaced(text, node, f"[{inner}, {words}]" if inner else f"[{words}]")
    indent, line = " " * node.start_mark.column, f"- {words}\n"
    begin, end = node.start_mark.index, node.end_mark.index
    # A block ends where the next field begins.
    return text[:end] + indent + line + text[end:] if add else text[:begin] + line + text[end:]


def _field(node: yaml.MappingNode, name: str) -> yaml.Node | None:
    return next((value for key, value in node.value if key.value == name), None)


def _inserted(text: str, node: yaml.MappingNode, words: str) -> str:
    """Return a text with one more field of a mapping: before its brace closes, or behind its first fields."""
    if node.flow_style:
        end = node.end_mark.index - 1
        comma = ", " if node.value else ""
        return text[:end] + comma + words + text[end:]
    if not node.start_mark.column:
        return text + words + "\n"
    first = node.value[0][0].start_mark
    return text[: first.index] + words + "\n" + " " * first.column + text[first.index :]


def _replaced(text: str, node: yaml.Node, words: str) -> str:
    """Return a text with other words for a node; a block ends where the next field begins, so its line is ended."""
    end = node.end_mark.index
    ending = "\n" if text[node.start_mark.index : end].endswith("\n") else ""
    return text[: node.start_mark.index] + words + ending + text[end:]


def _ended(text: str) -> str:
    return text if text.endswith("\n") or not text else text + "\n"
