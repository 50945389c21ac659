"""Where the library is looked for, and what is said where it can't be had."""

from __future__ import annotations

import ctypes.util
import importlib.util
import sys
from collections.abc import Iterator
from importlib.machinery import ModuleSpec
from pathlib import Path

import pytest
from virtualrobot_sdk.embree import EmbreeError, library
from virtualrobot_sdk.embree.availability import unavailable
from virtualrobot_sdk.embree.top import TopScene


@pytest.fixture
def anew() -> Iterator[None]:
    """Have the library looked for again, before the test and after it."""
    library.library.cache_clear()
    unavailable.cache_clear()
    yield
    library.library.cache_clear()
    unavailable.cache_clear()


@pytest.mark.parametrize(
    ("platform", "file"),
    [
        ("linux", "embreex.libs/libembree4-4aef3270.so.4"),
        ("darwin", "embreex/.dylibs/libembree4.4.dylib"),
        ("win32", "embreex.libs/embree4.dll"),
    ],
)
def test_it_is_found_where_the_wheels_have_it(
    platform: str, file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The places are those of embreex 4.4.0.post1's wheels."""
    for name in ("embreex/__init__.py", "embreex.libs/libtbb-dcf63f8c.so.12", file):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    spec = ModuleSpec("embreex", None, origin=str(tmp_path / "embreex" / "__init__.py"))
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: spec)
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: "libembree4.so.4" if name == "embree4" else None)
    monkeypatch.setattr(sys, "platform", platform)
    assert list(library.candidates()) == [str(tmp_path / file), "libembree4.so.4"]


@pytest.mark.usefixtures("anew")
def test_without_a_library_the_reason_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "candidates", lambda: iter(()))
    assert "pip install embreex" in unavailable()
    with pytest.raises(EmbreeError, match="neither embreex nor a library of the system"):
        TopScene()


@pytest.mark.usefixtures("anew")
def test_what_is_not_embree_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "libembree4.so").write_text("no library")
    true = list(library.candidates())
    wrong = [str(tmp_path / "libembree4.so"), ctypes.util.find_library("c") or "libc.so.6"]
    monkeypatch.setattr(library, "candidates", lambda: iter(wrong))
    said = unavailable()
    assert all(name in said for name in wrong)
    library.library.cache_clear()
    unavailable.cache_clear()
    monkeypatch.setattr(library, "candidates", lambda: iter([*wrong, *true]))
    assert unavailable() == ""


def test_errors_of_the_library_are_told_in_words() -> None:
    embree = library.library()
    scene = embree.functions.rtcNewScene(embree.device)
    embree.functions.rtcDetachGeometry(scene, 77)
    with pytest.raises(EmbreeError, match=r"failed at a trial: .* invalid"):
        embree.check("a trial")
    embree.check("what comes after")
    embree.functions.rtcReleaseScene(scene)
