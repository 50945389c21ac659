"""Kernel in the tests' own process, reached over TCP like any other: its journal can be read, its code be watched."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any
from unittest import mock

from virtualrobot_kernel.api.server import Address
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.history.journal import Journal, Keeper
from virtualrobot_kernel.kernel import Kernel, Settings
from virtualrobot_kernel.serve import compile_all_code
from virtualrobot_kernel.world.clock import Mode


@contextmanager
def kernel_inside(*keepers: Keeper) -> Iterator[tuple[Kernel, str]]:
    """Give a stepped kernel and its address; all that it journals goes to `keepers` too."""

    def journal(own: Sequence[Keeper], *args: Any, **named: Any) -> Journal:  # noqa: ANN401 as they come
        return Journal((*own, *keepers), *args, **named)

    compile_all_code()
    with mock.patch("virtualrobot_kernel.history.history.Journal", journal):
        kernel = Kernel(Settings(Address("127.0.0.1", 0, ""), Mode.STEPPED), Catalog(), lambda: None)
    try:
        yield kernel, f"127.0.0.1:{kernel.start()}"
    finally:
        kernel.close()
