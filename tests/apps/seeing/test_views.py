"""Next best views of bodies of boxes: what is covered is judged by rays of the judge's own."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot.errors import InvalidArgumentError
from virtualrobot_apps.seeing.views.planning import NoViewError, ViewPlanner, views_around
from virtualrobot_apps.seeing.views.voxels import FREE, OCCUPIED, UNKNOWN, Floats, Voxels

from tests.apps.seeing.bodies import BODIES, EDGE, FAN, HIGH, LOW, MIDDLE, RAYS, REACH, covered, look
from tests.apps.seeing.box_scanner import Box


@pytest.mark.long
def test_eight_views_cover_what_can_be_covered(rng: np.random.Generator) -> None:
    """At least 0.90 of what all 60 views see together, and in the mean 0.1 above views that are drawn."""
    found = {name: covered(boxes, rng) for name, boxes in BODIES.items()}
    assert all(one.chosen >= 0.90 for one in found.values()), found
    assert np.mean([one.chosen - one.drawn for one in found.values()]) > 0.1, found


def test_a_ray_frees_what_it_passes_and_fills_where_it_ends() -> None:
    voxels = Voxels((0.0, 0.0, 0.0), (1.0, 0.3, 0.3), 0.1)
    echoes = voxels.take(
        np.array([-0.5, 0.15, 0.15]), np.array([(0.65, 0.15, 0.15), (0.35, 0.25, 0.15)]), np.array([1, 0], bool)
    )
    assert echoes == 1
    row = voxels.states[:, 1, 1]
    assert (row[:5] == FREE).all() and row[6] == OCCUPIED and (row[7:] == UNKNOWN).all()
    assert voxels.states[3, 2, 1] == FREE and voxels.states[4, 2, 1] == UNKNOWN
    (first,) = voxels.first_met(np.array([-0.5, 0.15, 0.15]), np.array([[1.0, 0.0, 0.0]]), 2.0)
    assert np.unravel_index(first, voxels.states.shape) in ((5, 1, 1), (6, 1, 1))
    (nothing,) = voxels.first_met(np.array([-0.5, 0.15, 0.15]), np.array([[-1.0, 0.0, 0.0]]), 2.0)
    assert nothing == -1


@pytest.mark.parametrize("along", [np.array([[0.0, 0.0, 1.0]]), FAN], ids=["one ray", "a fan"])
def test_range_finders_of_one_and_two_dimensions_are_led_to_what_is_unknown(along: Floats) -> None:
    """Each of eight views tells surface that none before has told; a fan of 200 rays far more than 8 rays."""
    planner = ViewPlanner(Voxels(LOW, HIGH, EDGE), views_around(MIDDLE, np.array([0.7]), 30), along, REACH)
    known = [0]
    for _ in range(8):
        view = planner.next()
        assert view is not None
        look(planner, view, BODIES["crate"], along)
        known.append(int((planner.voxels.states == OCCUPIED).sum()))
    assert (np.diff(known) >= 1).all() and (len(along) == 1 or known[-1] > 100), known


def test_the_model_lies_on_the_body_and_its_holes_are_named() -> None:
    """A cube seen from one side alone: the vertices are on that side, and the hole is around what is behind it."""
    cube: list[Box] = [((-0.1, -0.1, 0.1), (0.1, 0.1, 0.3))]
    view = np.eye(4)
    view[:3, :3] = np.array([(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
    view[:3, 3] = -0.9, 0.0, 0.2
    planner = ViewPlanner(Voxels(LOW, HIGH, EDGE), view[None], RAYS, REACH)
    assert look(planner, view, cube) > 100
    vertices, triangles = planner.voxels.surface()
    corners = vertices[triangles]
    middles, across = corners.mean(axis=1), np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    front = np.abs(middles[:, 0] + 0.1) < 0.005
    front &= (np.abs(middles[:, 1]) < 0.08) & (np.abs(middles[:, 2] - 0.2) < 0.08)
    assert front.sum() > 50 and (across[front, 0] <= 1e-12).all()
    assert planner.holes()[0].voxels > 20 and max(abs(planner.holes()[0].place[:2])) < 0.3
    empty = Voxels(LOW, HIGH, EDGE).surface()
    assert empty[0].shape == (0, 3) and empty[1].shape == (0, 3)


def test_what_cannot_be_seen_is_said() -> None:
    views = views_around(MIDDLE, np.array([0.7]), 10)
    with pytest.raises(NoViewError, match="none of 10 views is in reach"):
        ViewPlanner(Voxels(LOW, HIGH, EDGE), views, RAYS, REACH, lambda all_of_them: np.zeros(len(all_of_them), bool))
    far = views_around(MIDDLE, np.array([5.0]), 10)
    planner = ViewPlanner(Voxels(LOW, HIGH, EDGE), far, RAYS, REACH)
    with pytest.raises(NoViewError, match=r"no echo in the box, whose middle is 4\.91 m away: .* the 1\.6 m"):
        look(planner, far[0], BODIES["crate"])
    with pytest.raises(InvalidArgumentError, match="has no room for voxels"):
        Voxels(HIGH, LOW, EDGE)
    with pytest.raises(InvalidArgumentError, match="voxels are more than"):
        Voxels(LOW, HIGH, 0.001)


def test_what_no_sensor_has_is_refused() -> None:
    """Rays, ranges and views that no sensor has, and scans with numbers that are not finite."""
    views, voxels = views_around(MIDDLE, np.array([0.7]), 10), Voxels(LOW, HIGH, EDGE)
    for rays, words in (
        (np.zeros((0, 3)), "rays are one or more directions of length 1, not 0"),
        (RAYS * np.nan, "rays are not finite, the first is number 0"),
        (2.0 * RAYS, "directions of length 1"),
        (RAYS[:, :2], r"rays have the shape \(n, 3\)"),
    ):
        with pytest.raises(InvalidArgumentError, match=words):
            ViewPlanner(voxels, views, rays, REACH)
    for reach in (0.0, np.nan, np.inf, -1.0):
        with pytest.raises(InvalidArgumentError, match="a sensor sees farther than 0 m"):
            ViewPlanner(voxels, views, RAYS, reach)
    with pytest.raises(InvalidArgumentError, match=r"views are finite poses \(n, 4, 4\)"):
        ViewPlanner(voxels, views[0], RAYS, REACH)
    with pytest.raises(InvalidArgumentError, match=r"possible\(views\) is a mask of 10 booleans, not bool \(3,\)"):
        ViewPlanner(voxels, views, RAYS, REACH, lambda all_of_them: np.ones(3, bool))
    planner = ViewPlanner(voxels, views, RAYS, REACH)
    with pytest.raises(InvalidArgumentError, match="1 of 2 ends of rays are not finite, the first is number 1"):
        planner.take(np.zeros(3), np.array([(0.1, 0.0, 0.0), (np.nan, 0.0, 0.0)]), np.ones(2, bool))
    with pytest.raises(InvalidArgumentError, match=r"met is a mask of 2 booleans, not bool \(3,\)"):
        planner.take(np.zeros(3), np.full((2, 3), 0.1), np.ones(3, bool))
    assert not voxels.states.any()


def test_views_look_at_the_middle_from_their_distance() -> None:
    views = views_around(MIDDLE, np.array([0.7, 0.9]), 20)
    off = views[:, :3, 3] - MIDDLE
    np.testing.assert_allclose(np.linalg.norm(off, axis=1), np.repeat([0.7, 0.9], 20))
    np.testing.assert_allclose(views[:, :3, 2], -off / np.linalg.norm(off, axis=1)[:, None], atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(views[:, :3, :3]), 1.0)
