"""Stopper of a cell: a process of its own that stops for who has the key, and ends with who started it."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from virtualrobot_sdk.drivers.shared import CELL, NEVER, CellBlock
from virtualrobot_sdk.drivers.stopper import ANSWER, Stopper


@pytest.fixture
def cell(tmp_path: Path) -> Iterator[CellBlock]:
    cell = CellBlock.create(tmp_path / CELL)
    yield cell
    cell.close()


def test_who_has_the_key_stops_the_cell_and_nobody_else(cell: CellBlock) -> None:
    stopper = Stopper(cell.path)
    host, _, port = stopper.address.partition(":")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        asking.connect((host, int(port)))
        asking.settimeout(30.0)
        for wrong in (b"", b"stop", stopper.key[:-1].encode(), b"x" * 2000):
            asking.send(wrong)
        # Datagrams of one sender come in their order on one machine: the answer is to the last one.
        assert cell.stop_ns == NEVER
        asking.send(stopper.key.encode() + b"\n")
        assert asking.recv(64) == ANSWER
        assert cell.stop_ns != NEVER
        cell.release()
        asking.send(stopper.key.encode())
        assert asking.recv(64) == ANSWER and cell.stop_ns != NEVER
    stopper.close()
    stopper.close()
    assert not psutil.pid_exists(stopper.pid)


def test_without_a_cell_it_does_not_begin(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="ended as it began"):
        Stopper(tmp_path / "none")
