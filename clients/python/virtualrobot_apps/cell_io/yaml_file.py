"""YAML files as items that know where they stand: whatever is wrong is told with file, line and what would be right."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml
from virtualrobot._wire.names import did_you_mean
from virtualrobot.errors import MalformedFileError, MissingFileError

SCHEMA_VERSION = 1

Scalar = bool | int | float | str


def nearest(word: str, known: Collection[str]) -> str:
    """Return "; did you mean ...?" for a word that is none of those known, or ";" where none is near."""
    return did_you_mean(word, known) or ";"


@dataclass(frozen=True, eq=False)
class Item:
    """Part of a file: a list, a mapping or a value.

    Attributes:
        file: name of the file.
        path: place within it, such as `signals[2].scale`.
        node: what stands there.
    """

    file: str
    path: str
    node: yaml.Node

    @property
    def line(self) -> int:
        """Line of the file, from 1."""
        return self.node.start_mark.line + 1

    def error(self, text: str) -> MalformedFileError:
        """Return the error that says what is wrong here."""
        where = f"{self.path}: " if self.path else ""
        metadata = {"file": self.file, "line": str(self.line), "path": self.path}
        return MalformedFileError(f"{self.file}:{self.line}: {where}{text}", metadata=metadata)

    @property
    def is_mapping(self) -> bool:
        """True for a mapping of keys to values."""
        return isinstance(self.node, yaml.MappingNode)

    @property
    def is_list(self) -> bool:
        """True for a list."""
        return isinstance(self.node, yaml.SequenceNode)

    def mapping(self, what: str = "keys") -> dict[str, Item]:
        """Return the values of a mapping by their keys, in their order; refuse keys that stand twice."""
        if not isinstance(self.node, yaml.MappingNode):
            raise self.error(f"a mapping (key: value) belongs here, not {self._kind()}")
        found: dict[str, Item] = {}
        for key, value in self.node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise Item(self.file, self.path, key).error(f"{what} are words")
            path = f"{self.path}.{key.value}" if self.path else key.value
            if key.value in found:
                first = found[key.value].line
                raise Item(self.file, path, key).error(f"{key.value!r} stands here twice, first in line {first}")
            found[key.value] = Item(self.file, path, value)
        return found

    def fields(self, known: Collection[str], needed: Sequence[str] = ()) -> dict[str, Item]:
        """Return the values of a mapping whose keys are fields; refuse others, and missing ones that are needed."""
        found = self.mapping("fields")
        for name, item in found.items():
            if name not in known:
                raise item.error(f"there is no field {name!r}{nearest(name, known)} known: {', '.join(known)}")
        for name in needed:
            if name not in found:
                raise self.error(f"the field {name!r} is missing")
        return found

    def beside(self, other: Item, without: str) -> Item:
        """Return a mapping with what it has, and what it lacks of another one's, but for one key."""
        own, rest = self.node, other.node
        assert isinstance(own, yaml.MappingNode) and isinstance(rest, yaml.MappingNode), "mapping() tells others"
        known = {key.value for key, _ in own.value} | {without}
        added = [(key, value) for key, value in rest.value if key.value not in known]
        return Item(self.file, self.path, yaml.MappingNode(own.tag, [*added, *own.value], own.start_mark, own.end_mark))

    def items(self) -> list[Item]:
        """Return the items of a list."""
        if not isinstance(self.node, yaml.SequenceNode):
            raise self.error(f"a list belongs here, not {self._kind()}")
        return [Item(self.file, f"{self.path}[{number}]", node) for number, node in enumerate(self.node.value)]

    def scalar(self) -> Scalar:
        """Return a value: what stands in quotes is text, plain `true`, `false` and numbers are themselves."""
        if not isinstance(self.node, yaml.ScalarNode):
            raise self.error(f"a value belongs here, not {self._kind()}")
        text: str = self.node.value
        if self.node.style:
            return text
        if text in ("true", "false"):
            return text == "true"
        for kind in (int, float):
            try:
                return kind(text)
            except ValueError:
                continue
        return text

    def text(self) -> str:
        """Return words, which are not empty."""
        self.scalar()
        text: str = self.node.value
        if not text:
            raise self.error("a text belongs here, not nothing")
        return text

    def boolean(self) -> bool:
        """Return true or false."""
        value = self.scalar()
        if not isinstance(value, bool):
            raise self.error(f"true or false belongs here, not {value!r}")
        return value

    def number(self, least: float = -math.inf, most: float = math.inf) -> float:
        """Return a finite number within a range."""
        value = self.scalar()
        if isinstance(value, bool | str) or not math.isfinite(value):
            raise self.error(f"a finite number belongs here, not {value!r}")
        if not least <= value <= most:
            raise self.error(f"a number {_range(least, most)} belongs here, not {value:g}")
        return float(value)

    def whole(self, least: int, most: int) -> int:
        """Return a whole number within a range."""
        value = self.scalar()
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise self.error(f"a whole number {_range(least, most)} belongs here, not {value!r}")
        return value

    def one_of(self, known: Collection[str]) -> str:
        """Return one of some words."""
        text = self.text()
        if text not in known:
            raise self.error(f"{text!r} is not known{nearest(text, known)} it is one of {', '.join(known)}")
        return text

    def _kind(self) -> str:
        if isinstance(self.node, yaml.ScalarNode):
            return repr(self.node.value) if self.node.value else "nothing"
        return "a list" if self.is_list else "a mapping"


def _range(least: float, most: float) -> str:
    if most == math.inf:
        return f"of at least {least:g}"
    return f"of at most {most:g}" if least == -math.inf else f"from {least:g} to {most:g}"


def read_file(path: str | Path) -> Item:
    """Return what stands in a file.

    Raises:
        MissingFileError: when it can't be read.
        MalformedFileError: when it is not YAML, or not of schema version 1.
    """
    return parse(read_text(path), str(path))


def read_text(path: str | Path) -> str:
    """Return the text of a file; raise MissingFileError when it can't be read, MalformedFileError when it is none."""
    try:
        return Path(path).read_text("utf-8")
    except UnicodeDecodeError as error:
        raise MalformedFileError(f"{path} is no text in UTF-8", metadata={"file": str(path)}) from error
    except OSError as error:
        raise MissingFileError(f"{path} cannot be read: {error.strerror or error}") from error


def parse(text: str, file: str) -> Item:
    """Return what stands in a text; `file` is what errors call it."""
    try:
        for event in yaml.parse(text, yaml.BaseLoader):
            if isinstance(event, yaml.AliasEvent):
                line = event.start_mark.line + 1
                raise MalformedFileError(f"{file}:{line}: aliases (*name) are not read: write it out")
        node = yaml.compose(text, yaml.BaseLoader)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        where = f"{file}:{mark.line + 1}" if mark is not None else file
        said = getattr(error, "problem", None) or str(error)
        raise MalformedFileError(f"{where}: not YAML: {said}", metadata={"file": file}) from error
    if node is None:
        raise MalformedFileError(f"{file} is empty", metadata={"file": file})
    root = Item(file, "", node)
    fields = root.mapping("fields")
    if "schema_version" not in fields:
        raise root.error(f"the field 'schema_version' is missing; it is {SCHEMA_VERSION}")
    if fields["schema_version"].scalar() != SCHEMA_VERSION:
        raise fields["schema_version"].error(f"this reads version {SCHEMA_VERSION}")
    return root
