"""YAML nodes into a protobuf message, led by the message's own schema, so that every error has line and path."""

from __future__ import annotations

import base64
import binascii
import re
from dataclasses import dataclass
from difflib import get_close_matches

from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.json_format import ParseDict
from google.protobuf.message import Message

from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.formats.xml import malformed
from virtualrobot_kernel.formats.yaml_text import Check, MappingNode, Node, ScalarNode, SequenceNode
from virtualrobot_kernel.messages.fields import STRUCT, Field, is_map, is_repeated, map_value

_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?")
_INTEGER = re.compile(r"[-+]?\d+")
_NULLS = ("", "~", "null", "Null", "NULL")
# What YAML readers take plain text for by themselves; the schema decides, whatever they think.
_TAGS = ("map", "seq", "str", "int", "float", "bool", "null", "timestamp", "merge", "value")
_INTEGER_RANGES = {
    FieldDescriptor.CPPTYPE_INT32: (-(2**31), 2**31 - 1),
    FieldDescriptor.CPPTYPE_UINT32: (0, 2**32 - 1),
    FieldDescriptor.CPPTYPE_INT64: (-(2**63), 2**63 - 1),
    FieldDescriptor.CPPTYPE_UINT64: (0, 2**64 - 1),
}


@dataclass(slots=True)
class SceneReader:
    """Reader of one file; `uri` names it in errors, and `kind` says what it is."""

    uri: str
    kind: str = "scene"
    check: Check = lambda: None
    """Callback for each message; what it raises ends the reading."""

    def fill(self, message: Message, node: Node, path: str) -> None:
        """Set the fields of `message` from a YAML mapping; `path` says where in the file the mapping is."""
        self.check()
        if message.DESCRIPTOR.full_name == STRUCT:
            ParseDict(self._plain_items(node, path), message)
            return
        fields = message.DESCRIPTOR.fields_by_name
        taken_by: dict[str, str] = {}
        for key, value in self._items(node, path, f"the fields of {message.DESCRIPTOR.name}"):
            descriptor = fields.get(key)
            here = f"{path}.{key}" if path else key
            if descriptor is None:
                near = get_close_matches(key, fields, n=1)
                meant = f"did you mean {near[0]!r}? " if near else ""
                raise self._error(
                    self._key_line(node, key),
                    path or f"the {self.kind}",
                    f"there is no field {key!r}; {meant}known: {', '.join(fields)}",
                )
            if self._is_null(value):
                continue
            union = descriptor.containing_oneof
            if union is not None and len(union.fields) > 1:
                if union.name in taken_by:
                    raise self._error(
                        value, here, f"only one {union.name} may be given; there is {taken_by[union.name]!r} too"
                    )
                taken_by[union.name] = key
            self._set(message, descriptor, value, here)

    def _set(self, message: Message, descriptor: Field, node: Node, path: str) -> None:
        name = descriptor.name
        entry = descriptor.message_type
        if is_map(descriptor):
            value_field = map_value(descriptor)
            target = getattr(message, name)
            for key, value in self._items(node, path, "names and values"):
                here = f"{path}[{key!r}]"
                if value_field.message_type is not None:
                    self.fill(target[key], value, here)
                else:
                    target[key] = self._scalar(value_field, value, here)
        elif is_repeated(descriptor):
            target = getattr(message, name)
            for index, item in enumerate(self._list(node, path)):
                here = f"{path}[{index}]"
                if entry is not None:
                    self.fill(target.add(), item, here)
                else:
                    target.append(self._scalar(descriptor, item, here))
        elif entry is not None:
            child = getattr(message, name)
            child.SetInParent()
            self.fill(child, node, path)
        else:
            setattr(message, name, self._scalar(descriptor, node, path))

    def _items(self, node: Node, path: str, expected: str) -> list[tuple[str, Node]]:
        """Return keys and values of a mapping; a key that comes twice is refused."""
        self._visit(node, path)
        if not isinstance(node, MappingNode):
            raise self._error(node, path or f"the {self.kind}", f"expected {expected}, got {_described(node)}")
        lines: dict[str, int] = {}
        items: list[tuple[str, Node]] = []
        for key, value in node.value:
            if not isinstance(key, ScalarNode):
                raise self._error(key, path or f"the {self.kind}", f"a key is a word, not {_described(key)}")
            if key.value in lines:
                first = f"the key {key.value!r} is there twice; first on line {lines[key.value]}"
                raise self._error(key, path or f"the {self.kind}", first)
            lines[key.value] = key.line
            items.append((key.value, value))
        return items

    def _list(self, node: Node, path: str) -> list[Node]:
        self._visit(node, path)
        if not isinstance(node, SequenceNode):
            raise self._error(node, path, f"expected a list, got {_described(node)}")
        return node.value

    def _plain_items(self, node: Node, path: str) -> dict[str, object]:
        """Return names and values as they are written: no schema says what they must be."""
        items = self._items(node, path, "names and values")
        return {key: self._plain(value, f"{path}.{key}") for key, value in items}

    def _plain(self, node: Node, path: str) -> object:
        if isinstance(node, MappingNode):
            return self._plain_items(node, path)
        if isinstance(node, SequenceNode):
            return [self._plain(item, f"{path}[{index}]") for index, item in enumerate(self._list(node, path))]
        self._visit(node, path)
        text = node.value
        if not isinstance(node, ScalarNode) or not node.plain:
            return text
        if self._is_null(node):
            return None
        if _NUMBER.fullmatch(text):
            return self._finite(node, path)
        return text == "true" if text in ("true", "false") else text

    def _finite(self, node: ScalarNode, path: str) -> float:
        value = float(node.value)
        if value in (float("inf"), float("-inf")):
            raise self._error(node, path, f"{node.value} is too large for a number")
        return value

    def _scalar(self, descriptor: Field, node: Node, path: str) -> object:
        self._visit(node, path)
        kind = descriptor.cpp_type
        expected = "text" if kind == FieldDescriptor.CPPTYPE_STRING else _EXPECTED.get(kind, "a number")
        if not isinstance(node, ScalarNode):
            raise self._error(node, path, f"expected {expected}, got {_described(node)}")
        text, plain = node.value, node.plain
        if descriptor.type == FieldDescriptor.TYPE_BYTES:
            try:
                return base64.b64decode(text, validate=True)
            except (binascii.Error, ValueError) as error:
                raise self._error(node, path, f"not base64: {error}") from error
        if kind == FieldDescriptor.CPPTYPE_STRING:
            return text
        if kind == FieldDescriptor.CPPTYPE_BOOL and plain and text in ("true", "false"):
            return text == "true"
        if kind == FieldDescriptor.CPPTYPE_ENUM:
            return self._enum(descriptor.enum_type, node, path)
        if kind == FieldDescriptor.CPPTYPE_DOUBLE and plain and _NUMBER.fullmatch(text):
            return self._finite(node, path)
        if kind in _INTEGER_RANGES and _INTEGER.fullmatch(text):
            least, most = _INTEGER_RANGES[kind]
            if not least <= int(text) <= most:
                raise self._error(node, path, f"{text} is out of range: {least} to {most}")
            return int(text)
        raise self._error(node, path, f"expected {expected}, got {_described(node)}")

    def _enum(self, enum: Field, node: ScalarNode, path: str) -> int:
        value = enum.values_by_name.get(node.value)
        if value is None:
            valid = [name for name in enum.values_by_name if not name.endswith("_UNSPECIFIED")]
            word = node.value.upper()
            # Most forget what the names begin with, and that says nothing about how near two are.
            near = [name for name in valid if word and name.endswith(f"_{word}")] or get_close_matches(word, valid, n=1)
            meant = f"did you mean {near[0]}? " if near else ""
            known = ", ".join(valid)
            raise self._error(node, path, f"{node.value!r} is no {enum.name}; {meant}known: {known}")
        return value.number

    def _visit(self, node: Node, path: str) -> None:
        """Refuse what YAML can but scenes don't need: tags."""
        tag = node.tag or ""
        if tag and tag.removeprefix("tag:yaml.org,2002:") not in _TAGS:
            raise self._error(node, path or f"the {self.kind}", f"tags ({tag}) are not read in {self.kind} files")

    @staticmethod
    def _is_null(node: Node) -> bool:
        return isinstance(node, ScalarNode) and node.plain and node.value in _NULLS

    @staticmethod
    def _key_line(node: Node, name: str) -> int:
        assert isinstance(node, MappingNode)
        return next(key.line for key, _ in node.value if key.value == name)

    def _error(self, place: Node | int, path: str, message: str) -> MalformedFileError:
        line = place if isinstance(place, int) else place.line
        return malformed(self.uri, line, message, path)


_EXPECTED = {
    FieldDescriptor.CPPTYPE_BOOL: "true or false",
    FieldDescriptor.CPPTYPE_ENUM: "a name",
    FieldDescriptor.CPPTYPE_INT32: "a whole number",
    FieldDescriptor.CPPTYPE_UINT32: "a whole number",
    FieldDescriptor.CPPTYPE_INT64: "a whole number",
    FieldDescriptor.CPPTYPE_UINT64: "a whole number",
}


def _described(node: Node) -> str:
    if isinstance(node, MappingNode):
        return "keys and values"
    if isinstance(node, SequenceNode):
        return "a list"
    text = node.value if len(node.value) <= 40 else node.value[:37] + "..."
    return f"{text!r}"
