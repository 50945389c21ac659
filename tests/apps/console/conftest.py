"""A console of the kernel whose time goes on by steps, which files share as they share the kernel."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest

from tests.apps.console.consoles import Console, consoles
from tests.kernels import KernelProcess


@pytest.fixture(scope="session")
def console_of() -> Iterator[Callable[[str], Console]]:
    """Return a function that gives the console of the kernel at an address, which ends with the session."""
    running: dict[str, Console] = {}
    with ExitStack() as stack:

        def lend(address: str) -> Console:
            if address not in running:
                running[address] = stack.enter_context(consoles(address))
            return running[address]

        yield lend


@pytest.fixture
def console(stepped_kernel: KernelProcess, console_of: Callable[[str], Console]) -> Console:
    """Return a console that anybody may call, since its kernel wants no token."""
    return console_of(stepped_kernel.address)
