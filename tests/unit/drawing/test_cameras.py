"""Cameras of open viewers: put where settings ask, along with what these go along with."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import viser
from virtualrobot_kernel.drawing.cameras import Cameras
from virtualrobot_kernel.drawing.view import Camera
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.unit.planning.dynamics_cases import snapshot_of
from tests.unit.world.builders import shifted

BOX = np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]])


def cart_at(x: float) -> Snapshot:
    return snapshot_of([NodeSpec("cart", Kind.OBJECT, parent_t_node=shifted(x=x))])


def viewer() -> tuple[viser.ViserServer, Any]:
    """Return a server with one viewer, as much of it as is used, and the viewer's camera."""
    camera = SimpleNamespace(position=(0.0, 0.0, 0.0), look_at=(0.0, 0.0, 0.0))
    client = SimpleNamespace(camera=camera, atomic=nullcontext)
    first = SimpleNamespace()
    return cast(viser.ViserServer, SimpleNamespace(get_clients=lambda: {0: client}, initial_camera=first)), camera


def test_viewers_go_along_with_a_node_until_it_is_gone() -> None:
    server, seen = viewer()
    cameras, here = Cameras(server), cart_at(1.0)
    asked = Camera((0.0, -2.0, 0.5), (0.0, 0.0, 0.5), node=here.structure.uid_by_name["cart"])
    cameras.follow(asked, here, BOX)
    np.testing.assert_allclose([seen.position, seen.look_at], [[1.0, -2.0, 0.5], [1.0, 0.0, 0.5]])
    cameras.follow(asked, cart_at(3.0), BOX)
    np.testing.assert_allclose([seen.position, seen.look_at], [[3.0, -2.0, 0.5], [3.0, 0.0, 0.5]])

    # While it stands, a person may look from elsewhere.
    seen.position = np.array([9.0, 9.0, 9.0])
    cameras.follow(asked, cart_at(3.0), BOX)
    np.testing.assert_allclose(seen.position, [9.0, 9.0, 9.0])

    # Without it the scene is framed, as without a camera.
    cameras.follow(asked, snapshot_of([]), BOX)
    np.testing.assert_allclose(seen.look_at, BOX.mean(axis=0))
