"""Files that a kernel names are written below their folder and nowhere else."""

from __future__ import annotations

import hashlib
import os
import stat
from pathlib import Path
from typing import Any

import pytest
import virtualrobot
from virtualrobot.files.writing import write_beside, write_file
from virtualrobot.v1 import nodes_pb2


class Held:
    """Stands for the kernel's store; gives the hash of each file as its bytes."""

    def download(self, sha256: str) -> bytes:
        return sha256.encode()


def beside(folder: Path, *names: str) -> list[Path]:
    held: Any = Held()
    return write_beside(folder, [nodes_pb2.AssetFile(uri=name, sha256=f"bytes of {name}") for name in names], held)


def test_files_go_below_the_folder(tmp_path: Path) -> None:
    written = beside(tmp_path, "a.stl", "meshes/link 1/b.obj")
    assert written == [tmp_path / "a.stl", tmp_path / "meshes" / "link 1" / "b.obj"]
    assert [path.read_text() for path in written] == ["bytes of a.stl", "bytes of meshes/link 1/b.obj"]


def test_what_is_there_is_replaced_only_when_that_is_wanted(tmp_path: Path) -> None:
    data = b"the bytes"
    same = nodes_pb2.AssetFile(uri="same.stl", sha256=hashlib.sha256(data).hexdigest())
    other = nodes_pb2.AssetFile(uri="meshes/other.stl", sha256="0" * 64)
    held: Any = Held()
    (tmp_path / "meshes").mkdir()
    (tmp_path / "same.stl").write_bytes(data)
    (tmp_path / "meshes" / "other.stl").write_bytes(data)
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"other\.stl is there already"):
        write_beside(tmp_path, [same, other], held, replace=False)
    assert (tmp_path / "meshes" / "other.stl").read_bytes() == data
    write_beside(tmp_path, [same], held, replace=False)
    write_beside(tmp_path, [same, other], held)
    assert (tmp_path / "meshes" / "other.stl").read_text() == "0" * 64


@pytest.mark.parametrize(
    "name",
    [
        *("/etc/x", "../x", "a/../../x", "a/..", "", ".", "a//b", "file:///x", "package://p/x"),
        *("C:/x", "C:x", "\\\\host\\x", "..\\x", "a\\b", "a:b"),
    ],
)
def test_a_name_that_leads_elsewhere_is_refused_before_anything_is_written(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "folder"
    with pytest.raises(virtualrobot.VirtualRobotError, match="outside the folder"):
        beside(folder, "good.stl", name)
    assert list(tmp_path.rglob("*")) == []


def test_a_file_is_written_as_a_whole_or_not_at_all(tmp_path: Path) -> None:
    (tmp_path / "taken").mkdir()
    with pytest.raises(virtualrobot.InvalidArgumentError, match="cannot be written"):
        write_file(tmp_path / "taken", b"x")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]
    path = write_file(tmp_path / "x.bin", b"1")
    assert write_file(path, b"22").read_bytes() == b"22"
    if os.name != "nt":
        mask = os.umask(0)
        os.umask(mask)
        assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~mask


def test_a_folder_that_is_not_there_is_not_made(tmp_path: Path) -> None:
    for write in (lambda: write_file(tmp_path / "nope" / "x.yaml", b"x"), lambda: beside(tmp_path / "nope", "x.stl")):
        with pytest.raises(virtualrobot.InvalidArgumentError, match="nope' is not there; make it first"):
            write()
    assert list(tmp_path.iterdir()) == []
