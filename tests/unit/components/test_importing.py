"""Importers at work: kept for equal settings, closed only when idle, made anew after a fault; real worker processes."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import psutil
import pytest
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.importing import KEPT_WITH_SETTINGS, Importers
from virtualrobot_kernel.errors import KernelError

ROBOT = b"""<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">
<xacro:arg name="part" default="none"/><link name="$(arg part)"/></robot>"""


@pytest.fixture
def importers() -> Iterator[Importers]:
    importers = Importers(Catalog())
    yield importers
    importers.close()
    assert not _workers()


def _workers() -> list[psutil.Process]:
    found = []
    for child in psutil.Process().children():
        with contextlib.suppress(psutil.NoSuchProcess):  # kernels of other tests end meanwhile
            if "virtualrobot_sdk.worker" in " ".join(child.cmdline()):
                found.append(child)
    return found


def _linked(importers: Importers, part: str) -> bytes:
    return importers.translate(ROBOT, "r.xacro", {}, {"arguments": {"part": part}}).data


def test_an_importer_is_kept_for_equal_settings_and_the_oldest_give_way(importers: Importers) -> None:
    for _ in range(2):
        assert b'<link name="a"' in _linked(importers, "a")
    (kept,) = importers.uses()
    assert kept.calls == 2
    for part in "bcdef":
        assert f'<link name="{part}"'.encode() in _linked(importers, part)
    assert len(importers.uses()) == len(_workers()) == KEPT_WITH_SETTINGS


def test_an_importer_that_somebody_has_is_not_closed_to_make_room(importers: Importers) -> None:
    parts = [f"p{i}" for i in range(2 * KEPT_WITH_SETTINGS)]
    with ThreadPoolExecutor(len(parts)) as pool:
        found = list(pool.map(lambda part: _linked(importers, part), parts))
    assert [f'<link name="{part}"'.encode() in text for part, text in zip(parts, found, strict=True)] == [True] * 8
    assert len(importers.uses()) == KEPT_WITH_SETTINGS


def test_a_broken_file_is_refused_in_words_and_the_next_is_read(importers: Importers) -> None:
    with pytest.raises(KernelError, match=r"r\.xacro"):
        importers.translate(b"<robot", "r.xacro", {}, {})
    assert importers.translate(ROBOT, "r.xacro", {}, {}).format == ".urdf"
    with pytest.raises(KernelError, match=r"no importer reads '\.doc'"):
        importers.translate(b"", "r.doc", {}, {})
    with pytest.raises(KernelError, match="'argument'"):
        importers.translate(ROBOT, "r.xacro", {}, {"argument": {}})
