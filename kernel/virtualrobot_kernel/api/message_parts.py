"""Parts of many messages that travel together: so few that none is large, so many that they cost little."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TypeVar

from google.protobuf.message import Message

M = TypeVar("M", bound=Message)

TOGETHER_BYTES = 1024 * 1024
"""Greatest size (bytes) of messages that travel together in one; a larger one goes alone."""


def parts(messages: Iterable[M], most_bytes: int = TOGETHER_BYTES) -> Iterator[list[M]]:
    """Yield messages in their order, as many together as `most_bytes` hold."""
    part: list[M] = []
    size = 0
    for message in messages:
        added = message.ByteSize()
        if part and size + added > most_bytes:
            yield part
            part, size = [], 0
        part.append(message)
        size += added
    if part:
        yield part
