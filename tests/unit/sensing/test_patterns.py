"""Where beams go, against the words of the contract."""

from __future__ import annotations

import math

import numpy as np
import pytest
from virtualrobot_kernel.sensing.patterns import beams_of, rays_of
from virtualrobot_kernel.world.sensing import Fan, FreeBeams, Pattern, Raster, Ring, SingleBeam, Spinning

AHEAD, LEFT = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]


def test_a_single_beam_goes_along_x() -> None:
    beams = beams_of(SingleBeam())
    assert beams.shape == (1, 1)
    np.testing.assert_array_equal(beams.directions, [AHEAD])


def test_a_fan_goes_from_x_towards_y_and_casts_both_ends() -> None:
    beams = beams_of(Fan(3, 0.0, math.pi / 2))
    diagonal = [math.sqrt(0.5), math.sqrt(0.5), 0.0]
    np.testing.assert_allclose(beams.directions, [AHEAD, diagonal, LEFT], atol=1e-15)
    np.testing.assert_allclose(beams.before_end, [0.25, 0.125, 0.0])  # a quarter of a turn


def test_a_head_turns_from_behind_over_the_right_to_the_left() -> None:
    beams = beams_of(Spinning(4, (0.0, 0.5)))
    assert beams.shape == (2, 4)
    around = np.array([[-1.0, 0.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    np.testing.assert_allclose(beams.directions[:4, :2], around, atol=1e-15)
    np.testing.assert_allclose(beams.directions[4:, :2], around * math.cos(0.5), atol=1e-15)
    np.testing.assert_allclose(beams.directions[4:, 2], math.sin(0.5))
    np.testing.assert_allclose(beams.before_end, [0.75, 0.5, 0.25, 0.0])


def test_a_raster_begins_at_the_upper_left_and_its_middle_is_ahead() -> None:
    beams = beams_of(Raster(3, 3, 1.0, 0.6))
    directions = beams.directions.reshape(3, 3, 3)
    np.testing.assert_allclose(directions[1, 1], AHEAD, atol=1e-15)
    x, y, z = directions[0, 0]
    assert (math.atan2(y, x), math.asin(z)) == pytest.approx((0.5, 0.3))
    assert beams_of(Raster(1, 1, 1.0, 0.6)).directions.tolist() == [AHEAD]


def test_transducers_of_a_ring_stand_on_a_circle_and_look_outwards() -> None:
    beams = beams_of(Ring(2, 0.2, 0.0, math.pi / 2))
    np.testing.assert_allclose(beams.origins, [[0.2, 0.0, 0.0], [0.0, 0.2, 0.0]], atol=1e-15)
    np.testing.assert_allclose(beams.directions, [AHEAD, LEFT], atol=1e-15)


def test_free_beams_get_unit_length() -> None:
    beams = beams_of(FreeBeams(np.array([[2.0, 0.0, 0.0], [0.0, 0.5, 0.0]]), np.array([[0.0, 0.0, 1.0]] * 2)))
    np.testing.assert_array_equal(beams.directions, [AHEAD, LEFT])
    np.testing.assert_array_equal(beams.origins[:, 2], 1.0)


def test_free_beams_may_be_of_any_length() -> None:
    beams = beams_of(FreeBeams(np.array([[1e200, 0.0, 0.0], [1e300, -1e300, 0.0], [1e-200, 0.0, 0.0]])))
    np.testing.assert_allclose(beams.directions, [[1.0, 0.0, 0.0], [0.5**0.5, -(0.5**0.5), 0.0], [1.0, 0.0, 0.0]])


@pytest.mark.parametrize("pattern", [Fan(7, -1.0, 2.0), Spinning(5, (-0.3, 0.0, 1.2)), Raster(4, 3, 1.0, 1.0)])
def test_the_rays_of_a_beam_keep_their_angles_to_it_and_to_each_other(
    pattern: Pattern, rng: np.random.Generator
) -> None:
    """Gram matrices are the same: each beam's frame is a rotation; its y is level and its z not downwards."""
    beam = rng.normal(size=(4, 3))
    beam[0] = AHEAD
    beam /= np.linalg.norm(beam, axis=1, keepdims=True)
    directions = beams_of(pattern).directions
    rays = rays_of(directions, beam)
    np.testing.assert_allclose(rays[:, 0], directions, atol=1e-15)
    np.testing.assert_allclose(
        rays @ np.swapaxes(rays, 1, 2), np.broadcast_to(beam @ beam.T, (len(rays), 4, 4)), atol=1e-12
    )
    axes = rays_of(directions, np.eye(3))
    np.testing.assert_allclose(np.linalg.det(axes), 1.0)
    np.testing.assert_allclose(axes[:, 1, 2], 0.0, atol=1e-15)
    assert (axes[:, 2, 2] > 0.0).all()


def test_a_beam_straight_up_has_a_frame_too() -> None:
    axes = rays_of(np.array([[0.0, 0.0, 1.0]]), np.eye(3))[0]
    np.testing.assert_array_equal(axes[1], LEFT)
    assert np.linalg.det(axes) == pytest.approx(1.0)
