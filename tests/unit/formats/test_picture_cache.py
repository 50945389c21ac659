"""Pictures of models are kept by what they depend on, and costs of a broken folder are those of taking them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from virtualrobot_kernel.formats.picture_cache import PictureCache
from virtualrobot_sdk.models import Model

ARM = Model("arm", "An arm", uri="package://numpy/arm.urdf", package="numpy")


def test_a_picture_is_that_of_one_model(tmp_path: Path) -> None:
    cache = PictureCache(tmp_path / "models")
    assert cache.get(ARM) is None
    cache.put(ARM, b"picture")
    assert PictureCache(tmp_path / "models").get(ARM) == b"picture"
    for other in (replace(ARM, name="other"), replace(ARM, uri="package://numpy/b.urdf"), replace(ARM, package="none")):
        assert cache.get(other) is None


def test_a_folder_that_is_none_costs_nothing_but_time(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    cache = PictureCache(tmp_path / "file")
    cache.put(ARM, b"picture")
    assert cache.get(ARM) is None
