"""The view settings: changed as a whole or not at all, and told to who listens."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from virtualrobot_kernel.drawing.framing import framed, outgrown
from virtualrobot_kernel.drawing.view import Camera, ViewSettings, ViewStore
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.structure import WORLD_UID, Kind, NodeSpec

from tests.unit.planning.dynamics_cases import snapshot_of
from tests.unit.world.builders import random_pose


def test_an_update_changes_the_named_fields_only() -> None:
    store = ViewStore()
    told: list[ViewSettings] = []
    end = store.subscribe(told.append)
    settings = store.update(grid_hidden=True, joint_axes=(3,))
    assert settings == ViewSettings(grid_hidden=True, joint_axes=(3,))
    assert (store.get(), store.revision, told) == (settings, 1, [settings])
    end()
    store.update(grid_hidden=False)
    assert len(told) == 1


@pytest.mark.parametrize(
    ("fields", "named"),
    [
        ({"background": (0.1, 1.2, 0.3)}, "1.2"),
        ({"background": (float("nan"), 0.0, 0.0)}, "nan"),
        ({"camera": Camera((1.0, 2.0, 3.0), (1.0, 2.0, 3.0))}, "its own target"),
        ({"camera": Camera((1.0, float("inf"), 3.0), (0.0, 0.0, 0.0))}, "inf"),
        ({"camera": Camera((1.0, 2.0, 3.0), (0.0, 0.0, 0.0), 4.0)}, "4.0"),
    ],
)
def test_what_cannot_be_drawn_is_refused_and_changes_nothing(fields: dict, named: str) -> None:
    store = ViewStore()
    before = store.get()
    with pytest.raises(KernelError, match=named):
        store.update(grid_hidden=True, **fields)
    assert store.get() is before
    assert store.revision == 0


def test_waiting_ends_with_the_change() -> None:
    store = ViewStore()
    thread = threading.Timer(0.05, lambda: store.update(grid_hidden=True))
    thread.start()
    revision, settings = store.wait(0, timeout=30.0)
    thread.join()
    assert (revision, settings.grid_hidden) == (1, True)
    assert store.wait(0, timeout=0.0)[0] == 1


def test_changes_by_many_threads_are_all_kept() -> None:
    store = ViewStore()
    threads = [threading.Thread(target=lambda: [store.update(grid_hidden=True) for _ in range(100)]) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert store.revision == 800


def test_a_framed_box_is_wholly_in_the_picture_and_fills_it(rng: np.random.Generator) -> None:
    """By the projection of a pinhole camera: every corner is in a 1.4:1 window, and one is near its edge."""
    for _ in range(50):
        low = rng.uniform(-5.0, 5.0, 3)
        bounds = np.array([low, low + rng.uniform(0.6, 6.0, 3)])
        camera = framed(bounds)
        eye, target = np.array(camera.position), np.array(camera.target)
        forward = (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        up = np.cross(right, forward)
        corners = np.array(np.meshgrid(*bounds.T)).reshape(3, -1).T - eye
        tangent = np.tan(0.5 * camera.field_of_view)
        across = np.abs(corners @ right) / (corners @ forward) / (1.4 * tangent)
        height = np.abs(corners @ up) / (corners @ forward) / tangent
        assert (corners @ forward).min() > 0.0
        assert 0.8 < max(across.max(), height.max()) < 1.0


def test_a_scene_outgrows_its_frame_by_a_tenth() -> None:
    framed_bounds = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert outgrown(None, framed_bounds)
    assert not outgrown(framed_bounds, np.array([[0.0, 0.0, 0.0], [1.09, 0.0, 0.0]]))
    assert not outgrown(framed_bounds, np.array([[0.4, 0.0, 0.0], [0.6, 0.0, 0.0]]))
    assert outgrown(framed_bounds, np.array([[0.0, 0.0, -0.11], [1.0, 0.0, 0.0]]))


@pytest.mark.parametrize("keeps", [False, True])
def test_a_camera_goes_along_with_its_node(keeps: bool, rng: np.random.Generator) -> None:
    """Turned with the node, a point is R p + t; one that keeps its direction is p + t."""
    world_t_node = random_pose(rng)
    snapshot = snapshot_of([NodeSpec("cart", Kind.OBJECT, parent_t_node=world_t_node)])
    camera = Camera((1.0, 0.2, 0.5), (0.0, 0.0, 2.0), 0.6, snapshot.structure.uid_by_name["cart"], keeps)
    placed = camera.placed(snapshot)
    assert placed is not None and placed.node == WORLD_UID and placed.field_of_view == 0.6
    turn, origin = np.eye(3) if keeps else world_t_node[:3, :3], world_t_node[:3, 3]
    np.testing.assert_allclose(placed.position, turn @ camera.position + origin, atol=1e-12)
    np.testing.assert_allclose(placed.target, turn @ camera.target + origin, atol=1e-12)
    gone = Camera((1.0, 0.0, 0.0), node=999)
    assert gone.placed(snapshot) is None
    here = Camera((1.0, 0.0, 0.0))
    assert here.placed(snapshot) is here
