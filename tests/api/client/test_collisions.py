"""Collisions through the client and the command line."""

from __future__ import annotations

import re

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot

from tests.api.client.conftest import Run

LEANING = {"iiwa": {"lbr_iiwa_joint_2": 0.5}}


@pytest.fixture
def cell(client: Client, iiwa: Robot) -> Client:
    """Return a client of a world with an arm, upright, and a box where its sixth link gets when it leans forward."""
    client.scene.add_part("box", virtualrobot.box(0.2, 0.2, 0.2), pose=virtualrobot.pose(x=0.5, z=0.9))
    return client


def test_a_check_is_true_where_something_touches(cell: Client) -> None:
    assert not cell.collisions.check()
    found = cell.collisions.check(LEANING, detail="contacts", robots=["iiwa"])
    assert found and found.seconds > 0.0 and found.stamp.structure_revision > 0
    (pair,) = found.pairs
    assert (pair.first, pair.second, pair.depth) == ("iiwa.lbr_iiwa_link_6", "box", None)
    assert pair.points.shape == pair.normals.shape == (len(pair.points), 3)
    assert np.all(np.abs(pair.points - [0.5, 0.0, 0.9]) <= 0.1 + 1e-6)
    np.testing.assert_allclose(np.linalg.norm(pair.normals, axis=1), 1.0)
    (bare,) = cell.collisions.check(LEANING, detail="first").pairs
    assert bare.points.shape == (0, 3)


def test_distances_have_points(cell: Client) -> None:
    nearest = cell.collisions.distance("iiwa")
    assert nearest.second == "box"
    assert np.linalg.norm(nearest.points[1] - nearest.points[0]) == pytest.approx(nearest.distance, abs=1e-9)
    every = cell.collisions.distances("iiwa", to=["box"], range_meters=5.0)
    assert len(every) == 8 and every[0].distance == nearest.distance
    assert cell.collisions.distance("iiwa", configurations=LEANING).distance == 0.0


def test_pairs_are_allowed_and_forbidden(cell: Client) -> None:
    allowed = cell.collisions.allowed
    before = list(allowed)
    assert {pair.cause for pair in before} == {"adjacent"} and len(before) == 7
    allowed.add("box", "iiwa.lbr_iiwa_link_6", "it pushes")
    (pair,) = allowed.list("box")
    assert (pair.first, pair.second, pair.cause, pair.reason) == ("iiwa.lbr_iiwa_link_6", "box", "client", "it pushes")
    assert not cell.collisions.check(LEANING)
    allowed.remove("iiwa.lbr_iiwa_link_6", "box")
    assert [(pair.first, pair.second) for pair in allowed] == [(pair.first, pair.second) for pair in before]
    with pytest.raises(virtualrobot.UnknownNameError, match="no client has allowed"):
        allowed.remove("iiwa.lbr_iiwa_link_6", "box")


def test_a_search_tells_its_progress_and_may_be_ended(cell: Client) -> None:
    parts: list[float] = []
    found = cell.collisions.allowed.find("iiwa", samples=40, progress=parts.append)
    assert parts[-1] == 1.0 and parts == sorted(parts)
    assert len(found) == 21 and {pair.samples for pair in found} == {40}
    assert all(pair.never == (pair.touched == 0) and pair.always == (pair.touched == 40) for pair in found)

    def stop(part: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cell.collisions.allowed.find("iiwa", samples=50_000, progress=stop)


def test_nonsense_is_refused_before_or_by_the_kernel(cell: Client) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match="one of first, pairs, contacts, not 'all'"):
        cell.collisions.check(detail="all")
    with pytest.raises(virtualrobot.InvalidArgumentError, match="above 0"):
        cell.collisions.distances("iiwa", range_meters=0.0)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="keep a distance"):
        cell.collisions.distance("box", to=["box"])
    with pytest.raises(virtualrobot.UnknownNameError, match="did you mean 'iiwa'"):
        cell.collisions.check(robots=["iwa"])
    with pytest.raises(virtualrobot.LimitError):
        cell.collisions.check({"iiwa": {"lbr_iiwa_joint_2": 4.0}})


def test_the_command_line_shows_it(cell: Client, iiwa: Robot, run: Run) -> None:
    assert run("collision") == "nothing touches that may not\n"
    assert re.match(r"iiwa\.\w+ +box +0\.\d{6} m\n$", run("collision", "distance", "iiwa"))
    assert len(run("collision", "distance", "iiwa", "box", "--range", "9").splitlines()) == 8
    assert run("collision", "distance", "iiwa", "box", "--range", "0.01") == "nothing is so near\n"
    cell.scene.add_part("ball", virtualrobot.sphere(0.05), pose=virtualrobot.pose(x=0.12, z=0.02))
    assert re.match(r"iiwa\.lbr_iiwa_link_0 touches ball at [-\d., ]+\n$", run("collision"))
    run("collision", "allow", "ball", "iiwa.lbr_iiwa_link_0", "--reason", "lies there")
    assert run("collision", "allowed", "ball").split() == ["iiwa.lbr_iiwa_link_0", "ball", "client", "lies", "there"]
    assert run("collision") == "nothing touches that may not\n"
    run("collision", "forbid", "ball", "iiwa.lbr_iiwa_link_0")
    assert run("collision", "allowed", "ball") == "no pairs\n"
    assert "pairs never touched" in run("collision", "find", "iiwa", "--samples", "20", "--seed", "1")
    assert "is one node" in run("collision", "allow", "ball", "ball", code=1)
