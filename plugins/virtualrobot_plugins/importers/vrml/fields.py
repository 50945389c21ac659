"""The fields of a node as what their users need, with prototypes worked out and every error with a line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.errors import ArgumentError

from virtualrobot_plugins.importers.refusal import refusal
from virtualrobot_plugins.importers.vrml.syntax import Is, Node, Value

Scope = Mapping[str, "tuple[Value, Scope]"]
"""Values of the fields of the prototype around a node, by name, each with the scope that it counts in."""

MAX_PROTOTYPE_DEPTH = 50


@dataclass(frozen=True, slots=True)
class Bound:
    """A node in its scope; `uri` names its file in errors."""

    node: Node
    scope: Scope
    uri: str

    @property
    def kind(self) -> str:
        """Return the type of the node."""
        return self.node.kind

    def error(self, message: str, **metadata: object) -> ArgumentError:
        """Return an error about the node."""
        return refusal(self.uri, f"{self.kind}: {message}", self.node.line, **metadata)

    def numbers(self, name: str, default: tuple[float, ...], width: int) -> NDArray[np.float64]:
        """Return a field as an array (width,) of finite numbers."""
        rows = self.rows(name, width)
        if rows is None:
            return np.array(default, np.float64)
        if len(rows) != 1:
            raise self.error(f"{name}: expected {width} numbers, got {rows.size}")
        return rows[0]

    def number(self, name: str, default: float) -> float:
        """Return a field that is one finite number."""
        return float(self.numbers(name, (default,), 1)[0])

    def rows(self, name: str, width: int) -> NDArray[np.float64] | None:
        """Return a field as an array (n, width) of finite numbers; None when it is not there."""
        value, _ = self._get(name)
        if value is None:
            return None
        if isinstance(value, list) and not value:
            return np.zeros((0, width))
        if not isinstance(value, np.ndarray):
            raise self.error(f"{name}: expected numbers")
        if value.size % width:
            raise self.error(f"{name}: expected {width} numbers for each entry, got {value.size} numbers")
        if not np.isfinite(value).all():
            raise self.error(f"{name}: a number is not finite")
        return value.reshape(-1, width)

    def indices(self, name: str) -> NDArray[np.intp] | None:
        """Return a field of whole numbers (n,); None when it is not there or empty."""
        rows = self.rows(name, 1)
        if rows is None or len(rows) == 0:
            return None
        values = rows[:, 0]
        if (np.abs(values) > 2**31).any() or (values != np.floor(values)).any():
            raise self.error(f"{name}: expected whole numbers")
        return values.astype(np.intp)

    def truth(self, name: str, default: bool) -> bool:
        """Return a field that is TRUE or FALSE."""
        value, _ = self._get(name)
        if value is None:
            return default
        if not isinstance(value, bool):
            raise self.error(f"{name}: expected TRUE or FALSE")
        return value

    def texts(self, name: str) -> list[str]:
        """Return a field of strings."""
        value, _ = self._get(name)
        values = value if isinstance(value, list) else [value]
        return [text for text in values if isinstance(text, str)]

    def nodes(self, name: str) -> list[Bound]:
        """Return the nodes of a field, those of prototypes worked out."""
        value, scope = self._get(name)
        values = value if isinstance(value, list) else [value]
        return [expanded(Bound(node, scope, self.uri)) for node in values if isinstance(node, Node)]

    def child(self, name: str, *kinds: str) -> Bound | None:
        """Return the node of a field when it is of one of these kinds; None when there is none."""
        found = self.nodes(name)
        if not found:
            return None
        if found[0].kind not in kinds:
            raise found[0].error(f"{self.kind}.{name} takes {' or '.join(kinds)}")
        return found[0]

    def _get(self, name: str) -> tuple[Value, Scope]:
        value = self.node.fields.get(name)
        return self.scope.get(value.name, (None, {})) if isinstance(value, Is) else (value, self.scope)


def expanded(bound: Bound) -> Bound:
    """Return what a prototype's instance stands for: the first node of its body; other nodes are what they are."""
    for _ in range(MAX_PROTOTYPE_DEPTH):
        prototype = bound.node.prototype
        if prototype is None or prototype.external:
            return bound
        if not prototype.body:
            raise bound.error("its prototype has no node")
        scope: dict[str, tuple[Value, Scope]] = {name: (value, {}) for name, value in prototype.defaults.items()}
        for name, value in bound.node.fields.items():
            given = bound.scope.get(value.name) if isinstance(value, Is) else (value, bound.scope)
            if given is not None:
                scope[name] = given
        bound = Bound(prototype.body[0], scope, bound.uri)
    raise bound.error(f"prototypes stand for prototypes more than {MAX_PROTOTYPE_DEPTH} deep")
