"""Clients that applications get: of a kernel in real time, and of one whose time goes on by steps."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import virtualrobot

from tests.kernels import KernelProcess, Stubs


@pytest.fixture
def client(kernel: KernelProcess, stubs: Stubs) -> Iterator[virtualrobot.Client]:
    """Return a client of a kernel with an empty world whose time follows the wall clock."""
    with virtualrobot.connect(kernel.address) as client:
        yield client


@pytest.fixture
def steps(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[virtualrobot.Client]:
    """Return a client of a kernel whose time goes on by steps."""
    with virtualrobot.connect(stepped_kernel.address) as client:
        yield client
