"""Solids of figures: mass and moments of inertia against formulas, and what has no volume."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.physics.solids import evenly, shape_of, solids
from virtualrobot_kernel.shapes.submesh import Submesh, frozen
from virtualrobot_kernel.world.figures import Box, Capsule, Cone, Cylinder, Figure, Geometry, Mesh, Sphere
from virtualrobot_sdk.poses import from_roll_pitch_yaw

CORNERS = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.2, 0.2) for z in (-0.3, 0.3)])


def triangles(mesh: Mesh) -> tuple[Submesh, ...]:
    """Return a box, one of 20 micrometers, or a triangle, by the name of the file."""
    boxes = {"box.stl": CORNERS, "tiny.stl": np.sign(CORNERS) * 1e-5}
    corners = boxes.get(mesh.uri, CORNERS[:3])
    faces = [[a, b, c] for a in range(len(corners)) for b in range(a) for c in range(b)]
    return (Submesh(frozen(corners, np.float32), frozen(np.array(faces), np.int32)),)


def spread(geometry: Geometry, pose: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return center of mass and moments of inertia of a figure of 2 kg."""
    figure = Figure(geometry, np.eye(4) if pose is None else pose)
    shape = shape_of(figure, solids(triangles), "thing")
    assert shape is not None
    found = evenly(2.0, [shape], "thing")
    assert found.mass == 2.0
    return found.center, found.inertia


@pytest.mark.parametrize(
    ("geometry", "moments", "precision"),
    [
        (Box((0.2, 0.4, 0.6)), (2.0 / 12.0 * 0.52, 2.0 / 12.0 * 0.4, 2.0 / 12.0 * 0.2), 1e-12),
        (Mesh("box.stl", ""), (2.0 / 12.0 * 0.52, 2.0 / 12.0 * 0.4, 2.0 / 12.0 * 0.2), 1e-6),
        (Sphere(0.3), (0.8 * 0.09,) * 3, 1e-12),
        (Cylinder(0.1, 0.4), (2.0 / 12.0 * 0.19, 2.0 / 12.0 * 0.19, 0.01), 1e-12),
        # A capsule without length is a sphere.
        (Capsule(0.3, 1e-9), (0.8 * 0.09,) * 3, 1e-6),
    ],
)
def test_moments_are_those_of_the_formulas(geometry: Geometry, moments: tuple[float, ...], precision: float) -> None:
    center, inertia = spread(geometry)
    np.testing.assert_allclose(inertia, np.diag(moments), atol=precision)
    np.testing.assert_allclose(center, 0.0, atol=1e-7)


def test_a_cone_has_its_center_a_quarter_above_its_base() -> None:
    center, inertia = spread(Cone(0.1, 0.4))
    np.testing.assert_allclose(center, [0.0, 0.0, -0.1], atol=1e-9)
    # Of 32 corners, so a little less than 3/10 and 3/20 m r^2, with 3/80 m h^2.
    along, across = 0.3 * 2.0 * 0.01, 2.0 * (3.0 / 20.0 * 0.01 + 3.0 / 80.0 * 0.16)
    np.testing.assert_allclose(np.diag(inertia), [across, across, along], rtol=0.02)


def test_figures_are_taken_where_they_are() -> None:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = from_roll_pitch_yaw(0.0, 0.0, np.pi / 2.0)[:3, :3], (1.0, 2.0, 3.0)
    center, inertia = spread(Box((0.2, 0.4, 0.6)), pose)
    np.testing.assert_allclose(center, [1.0, 2.0, 3.0], atol=1e-12)
    np.testing.assert_allclose(np.diag(inertia), np.array([0.4, 0.52, 0.2]) / 6.0, atol=1e-12)


def test_what_has_no_volume_is_named() -> None:
    """MuJoCo takes no mesh below 1e-15 m^3, and then none of the others either."""
    for name in ("sheet", "tiny"):
        with pytest.raises(KernelError, match=rf"the mesh '{name}\.stl' of 'thing' has no volume"):
            spread(Mesh(f"{name}.stl", ""))
    with pytest.raises(KernelError, match=r"'thing' has no figure with a volume"):
        evenly(1.0, [], "thing")
