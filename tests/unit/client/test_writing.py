"""Files that a kernel names are written below their folder and nowhere else."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest
import virtualrobot
from virtualrobot.v1 import nodes_pb2
from virtualrobot.writing import write_beside, write_file


class Held:
    """Gives the name of each file as its bytes."""

    def download(self, sha256: str) -> bytes:
        return sha256.encode()


def beside(folder: Path, *names: str) -> list[Path]:
    files = [nodes_pb2.AssetFile(uri=name, sha256=f"bytes of {name}") for name in names]
    return write_beside(folder, files, Held())  # pyright: ignore[reportArgumentType] all that is used of Assets


def test_files_go_below_the_folder(tmp_path: Path) -> None:
    written = beside(tmp_path, "a.stl", "meshes/link 1/b.obj")
    assert written == [tmp_path / "a.stl", tmp_path / "meshes" / "link 1" / "b.obj"]
    assert [path.read_text() for path in written] == ["bytes of a.stl", "bytes of meshes/link 1/b.obj"]


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
    path = write_file(tmp_path / "new" / "x.bin", b"1")
    assert write_file(path, b"22").read_bytes() == b"22"
    if os.name != "nt":
        mask = os.umask(0)
        os.umask(mask)
        assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~mask
