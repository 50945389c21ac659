"""Project folders: one kernel each, and a clear word for what is no folder of this kernel."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from virtualrobot_kernel.errors import KernelError, MalformedFileError
from virtualrobot_kernel.history.folder import LOCK, PROJECT, Folder
from virtualrobot_kernel.history.past import PastFolder

HOLDER = """
import sys
from pathlib import Path
from virtualrobot_kernel.history.folder import Folder
folder = Folder(Path(sys.argv[1]))
print("held", flush=True)
sys.stdin.read()
"""


def test_a_new_folder_is_made_and_opened_again_as_it_was(tmp_path: Path) -> None:
    first = Folder(tmp_path / "cell", 2_000_000)
    assert first.is_new and first.project.tick_nanoseconds == 2_000_000 and not first.changed_versions()
    first.name_scene("cell.yaml")
    first.close()
    again = Folder(tmp_path / "cell")
    assert not again.is_new
    assert again.project == first.project and again.project.scene == "cell.yaml"
    again.close()


def test_ids_differ(tmp_path: Path) -> None:
    """Checksums begin with them, so that rows of one folder are none of another."""
    made = [Folder(tmp_path / name) for name in "ab"]
    assert made[0].project.seed != made[1].project.seed
    for folder in made:
        folder.close()


def test_two_kernels_on_one_folder_and_a_killed_one_leaves_no_lock(tmp_path: Path) -> None:
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert holder.stdout and holder.stdin and holder.stdout.readline() == "held\n"
    with pytest.raises(KernelError, match=f"another kernel uses the folder .*, the process {holder.pid};"):
        Folder(tmp_path)
    holder.kill()
    holder.wait(60.0)
    holder.stdin.close()
    holder.stdout.close()
    Folder(tmp_path).close()


def test_versions_that_decide_bits_are_compared(tmp_path: Path) -> None:
    Folder(tmp_path).close()
    said = json.loads((tmp_path / PROJECT).read_text())
    said["versions"]["numba"] = "0.1"
    (tmp_path / PROJECT).write_text(json.dumps(said))
    folder = Folder(tmp_path)
    assert folder.changed_versions().startswith("numba 0.1, now ")
    folder.close()


def _newer(path: Path) -> None:
    said = json.loads((path / PROJECT).read_text())
    (path / PROJECT).write_text(json.dumps({**said, "format": 2}))


def _content(path: Path) -> dict[str, object]:
    return {one.name: one.is_file() and one.read_bytes() for one in path.iterdir() if one.name != LOCK}


@pytest.mark.parametrize(
    ("spoil", "word"),
    [
        (lambda path: (path / PROJECT).write_text("{"), "damaged, it ends or breaks off at line 1, column 2; put"),
        (lambda path: (path / PROJECT).write_text("[]"), "damaged, it says what no kernel writes"),
        (
            lambda path: (path / PROJECT).write_text('{"format": 1, "id": 7}'),
            "damaged, it has no 'tick_nano",
        ),
        (_newer, "written by a newer version, in form 2; this one knows 1"),
        (lambda path: (path / PROJECT).unlink(), "not empty, it has 'other'"),
        (lambda path: (path / PROJECT).rename(path / "journal.db"), "no project.json"),
        (lambda path: ((path / LOCK).unlink(), (path / LOCK).mkdir()), "cannot write in the folder .*: Is a directory"),
    ],
)
def test_what_is_wrong_is_said_and_nothing_is_changed(
    tmp_path: Path, spoil: Callable[[Path], object], word: str
) -> None:
    Folder(tmp_path).close()
    (tmp_path / "other").write_text("mine")
    spoil(tmp_path)
    before = {path.name: path.is_file() and path.read_bytes() for path in tmp_path.iterdir() if path.name != LOCK}
    with pytest.raises(KernelError, match=word):
        Folder(tmp_path)
    assert {
        path.name: path.is_file() and path.read_bytes() for path in tmp_path.iterdir() if path.name != LOCK
    } == before


def test_a_folder_without_its_journal_is_no_empty_world(tmp_path: Path) -> None:
    Folder(tmp_path).close()
    Folder(tmp_path).close()  # a kernel was killed before it made its journal: nothing is lost
    (tmp_path / "last_tick").write_bytes(b"")
    before = (tmp_path / PROJECT).read_bytes()
    for opened in (Folder, PastFolder):
        with pytest.raises(KernelError, match=r"journal\.db of this project is missing"):
            opened(tmp_path)
    assert (tmp_path / PROJECT).read_bytes() == before


def test_another_length_of_ticks_is_refused(tmp_path: Path) -> None:
    Folder(tmp_path, 4_000_000).close()
    with pytest.raises(KernelError, match="ticks of 4 ms, not of 2 ms"):
        Folder(tmp_path, 2_000_000)
    Folder(tmp_path, 4_000_000).close()


def test_places_where_no_folder_can_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(KernelError, match="is a file; a project needs a folder"):
        Folder(tmp_path / "file")
    with pytest.raises(KernelError, match=r"there is no .*nope"):
        Folder(tmp_path / "nope" / "cell")
    assert not (tmp_path / "nope").exists()


def test_a_damaged_description_is_an_error_of_the_file(tmp_path: Path) -> None:
    (tmp_path / PROJECT).write_bytes(b"\xff\xfe")
    with pytest.raises(MalformedFileError, match="put back a copy"):
        Folder(tmp_path)
