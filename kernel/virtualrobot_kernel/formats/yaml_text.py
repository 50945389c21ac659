"""YAML text as a tree of nodes: plain text stays text, and what would take all of the kernel's time is refused.

libyaml finds the events; the tree is made of them here, so that it ends at a limit or when nobody waits any more, which
a library that makes whole trees cannot be asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import yaml

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats.xml import malformed

MOST_CHARACTERS = 8_000_000
"""Greatest number of characters: comments are read as a whole, 100 MB/s; a scene of 10,000 boxes has 2 million."""

MOST_EVENTS = 400_000
"""Greatest number of events: one per key and value, two per list and mapping; a scene of 10,000 boxes has 360,000."""

DEEPEST = 32
"""Greatest depth: scenes are ten deep; settings of components are messages, three for each level, and end at 100."""

CHECKED_EVERY = 1000
"""Number of events of YAML between two checks: some milliseconds."""

Check = Callable[[], None]
"""Check that raises when nobody waits any more for what is done."""

_LOADER = getattr(yaml, "CBaseLoader", yaml.BaseLoader)


@dataclass(slots=True, eq=False)
class ScalarNode:
    """Text, and whether it is `plain`: without quotes. `line` counts from 1; `tag` is what is written as one."""

    value: str
    plain: bool
    line: int
    tag: str | None


@dataclass(slots=True, eq=False)
class SequenceNode:
    """List of nodes."""

    value: list[Node]
    line: int
    tag: str | None


@dataclass(slots=True, eq=False)
class MappingNode:
    """Pairs of keys and values in their order."""

    value: list[tuple[Node, Node]]
    line: int
    tag: str | None


# Light ones: those of libraries keep two marks each, and collecting millions of objects holds up everybody.
Node = ScalarNode | SequenceNode | MappingNode


def compose(text: str, uri: str, check: Check = lambda: None) -> Node | None:
    """Return the tree of a text; None when it is empty.

    Raises:
        MalformedFileError: `scene.yaml:12: ...` for what is not YAML, nested too deeply, or not written out (aliases).
        KernelError: TOO_LARGE.
    """
    if len(text) > MOST_CHARACTERS:
        raise _too_large(uri, f"{len(text):,} characters", MOST_CHARACTERS)
    tree = _Tree(uri)
    try:
        for number, event in enumerate(yaml.parse(text, _LOADER)):
            if number % CHECKED_EVERY == 0:
                check()
            if number > MOST_EVENTS:
                raise _too_large(uri, "more keys and values", MOST_EVENTS)
            tree.take(event)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark is not None else None
        raise malformed(uri, line, f"not YAML: {error.problem or error.context}") from error
    except (yaml.YAMLError, ValueError) as error:
        raise malformed(uri, None, f"not YAML: {error}") from error
    return tree.root


class _Tree:
    """Tree that grows by events."""

    def __init__(self, uri: str) -> None:
        self.root: Node | None = None
        self._uri = uri
        self._open: list[MappingNode | SequenceNode] = []
        self._keys: list[Node | None] = []

    def take(self, event: yaml.Event) -> None:
        """Go on by one event."""
        if isinstance(event, yaml.ScalarEvent):
            self._add(ScalarNode(event.value, not event.style, event.start_mark.line + 1, event.tag))
        elif isinstance(event, yaml.CollectionEndEvent):
            self._open.pop()
            self._keys.pop()
        elif isinstance(event, yaml.CollectionStartEvent):
            kind = MappingNode if isinstance(event, yaml.MappingStartEvent) else SequenceNode
            node = kind([], event.start_mark.line + 1, event.tag)
            self._add(node)
            if len(self._open) == DEEPEST:
                raise self._error(event, f"nested too deeply: more than {DEEPEST} lists and mappings in each other")
            self._open.append(node)
            self._keys.append(None)
        elif isinstance(event, yaml.AliasEvent):
            # By which few lines may become gigabytes.
            raise self._error(event, "aliases (*name) are not read: write it out")
        elif isinstance(event, yaml.DocumentStartEvent) and self.root is not None:
            raise self._error(event, "a file has one document, and here another one begins")

    def _add(self, node: Node) -> None:
        if not self._open:
            self.root = node
            return
        parent, key = self._open[-1], self._keys[-1]
        if isinstance(parent, SequenceNode):
            parent.value.append(node)
        elif key is None:
            self._keys[-1] = node
        else:
            parent.value.append((key, node))
            self._keys[-1] = None

    def _error(self, event: yaml.Event, message: str) -> KernelError:
        return malformed(self._uri, event.start_mark.line + 1, message)


def _too_large(uri: str, said: str, most: int) -> KernelError:
    return KernelError(
        f"{uri} has {said}; a file may have {most:,}: split it, or give large things as assets",
        reason=Reason.TOO_LARGE,
        file=uri,
        limit=most,
    )
