"""Debug adapters, and editors that are connected to them."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.apps.languages.debugging import Editor, adapters, editors


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    """Return the port of a debug adapter."""
    with adapters() as port:
        yield port


@pytest.fixture
def editor(port: int) -> Iterator[Editor]:
    """Return an editor that is connected."""
    with editors(port) as editor:
        yield editor
