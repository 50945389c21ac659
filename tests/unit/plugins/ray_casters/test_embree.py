"""The component `embree`: what takes its place where Embree can't be driven, and its refusals."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from virtualrobot_plugins.ray_casters import embree
from virtualrobot_plugins.ray_casters.embree import EmbreeCaster
from virtualrobot_plugins.ray_casters.embreex_scene import EmbreexScene
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.rays import RayScene, make_shape
from virtualrobot_sdk.testing.ray_truth import plane, random_rays, random_scene

REASON = "there is no such library today"
DOWN = np.array([[0.0, 0.0, -1.0]])


@pytest.fixture
def without_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(embree, "unavailable", lambda: REASON)


@pytest.mark.usefixtures("without_library")
def test_embreex_takes_its_place_and_the_log_says_so(
    rng: np.random.Generator, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    with caplog.at_level(logging.WARNING, "virtualrobot_plugins.rays"):
        other = EmbreeCaster()
    assert REASON in caplog.text
    assert "embreex" in caplog.text
    monkeypatch.undo()
    scene = random_scene(rng, 12)
    rays = random_rays(rng, 1000, scene)
    expected, found = EmbreeCaster().cast(scene, *rays, np.inf), other.cast(scene, *rays, np.inf)
    same = expected.element == found.element
    assert same.mean() > 0.99  # an edge may be decided either way
    is_hit = same & np.isfinite(expected.distance)
    slant = np.abs((expected.normal * rays[1]).sum(axis=1))
    off = np.abs(np.where(is_hit, expected.distance, 0.0) - np.where(is_hit, found.distance, 0.0))
    assert (off * np.maximum(slant, 1e-3)).max() < 1e-5


@pytest.mark.usefixtures("without_library")
def test_without_either_the_reasons_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> EmbreexScene:
        raise ImportError("no module named embreex")

    monkeypatch.setattr(embree, "EmbreexScene", missing)
    with pytest.raises(ArgumentError, match=f"{REASON}.*no module named embreex"):
        EmbreeCaster()


@pytest.mark.parametrize("place", [False, True], ids=["embreex", "library"])
def test_shapes_that_are_none_are_refused(place: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not place:
        monkeypatch.setattr(embree, "unavailable", lambda: REASON)
    caster = EmbreeCaster()
    good = plane(2.0)
    for bad in (
        make_shape([[0, 0, 0], [1, 0, 0], [0, 1, np.nan]], [[0, 1, 2]]),
        make_shape([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]]),
    ):
        scene = RayScene((good, bad), np.repeat(np.eye(4)[None], 2, axis=0))
        with pytest.raises(ArgumentError, match="a shape"):
            caster.cast(scene, np.array([[0.1, 0.2, 1.0]]), DOWN, 5.0)
    assert caster.cast(RayScene((good,), np.eye(4)[None]), np.array([[0.1, 0.2, 1.0]]), DOWN, 5.0).element[0] == 0


def test_any_layout_of_arrays_is_taken() -> None:
    scene = RayScene((plane(2.0),), np.eye(4)[None])
    origins, directions = np.repeat([[0.1, 0.2, 1.0]], 20, axis=0), np.repeat(DOWN, 20, axis=0)
    expected = EmbreeCaster().cast(scene, origins, directions, 5.0)
    for order in (np.asfortranarray, lambda a: np.repeat(a, 2, axis=0)[::2], lambda a: a.astype(np.float32)):
        found = EmbreeCaster().cast(scene, order(origins), order(directions), 5.0)
        np.testing.assert_allclose(found.distance, expected.distance, rtol=1e-6)


@pytest.mark.parametrize("shape", [(), (3,), (2, 2), (2, 3, 1)])
def test_other_shapes_of_arrays_are_refused(shape: tuple[int, ...]) -> None:
    scene = RayScene((plane(2.0),), np.eye(4)[None])
    with pytest.raises(ArgumentError, match="must"):
        EmbreeCaster().cast(scene, np.ones(shape), np.ones(shape), 5.0)
