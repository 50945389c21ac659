"""Rays through the client and the command line."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client

from tests.api.client.conftest import Run


@pytest.fixture
def cell(client: Client) -> Client:
    """Return a client of a world with a table that stands 0.7 m high, and a ball beside it."""
    client.scene.add_part("table", virtualrobot.box(1.0, 1.0, 0.1), pose=virtualrobot.pose(z=0.65))
    client.scene.add_part("ball", virtualrobot.sphere(0.2), pose=virtualrobot.pose(2.0, z=1.0))
    return client


def test_rays_are_arrays_with_the_names_of_what_they_hit(cell: Client) -> None:
    hits = cell.rays.cast([0.0, 0.0, 1.0], [[0, 0, -1], [3, 0, 0], [0, 0, 1]], ray_caster="reference")
    np.testing.assert_allclose(hits.distances[[0, 2]], [0.3, math.inf], atol=1e-9)
    assert hits.nodes == ["table", "ball", ""]
    assert sorted(hits.element_names) == ["ball", "table"]
    np.testing.assert_allclose(hits.normals[[0, 2]], [[0, 0, 1], [0, 0, 0]], atol=1e-6)
    assert hits.cast_time > 0.0
    assert hits.stamp.structure_revision > 0
    exact = cell.rays.cast([[0.0, 0.0, 1.0], [2.0, 0.0, 0.0]], [[1, 0, 0], [0, 0, 1]])
    np.testing.assert_allclose(exact.distances, [1.8, 0.8], atol=2e-6)


def test_a_frame_and_a_range_are_heeded(cell: Client) -> None:
    cell.scene.add_part("hand", virtualrobot.box(0.01, 0.01, 0.01), pose=virtualrobot.pose(2.0, z=2.0, roll=math.pi))
    hits = cell.rays.cast([0.0, 0.0, 0.01], [[0, 0, 1]], frame="hand")
    assert (hits.nodes, hits.distances.round(5).tolist()) == (["ball"], [0.79])
    assert cell.rays.cast([0.0, 0.0, 0.01], [[0, 0, 1]], frame="hand", max_range=0.5).nodes == [""]
    assert cell.rays.cast([0.0, 0.0, 0.01], [[0, 0, 1]], frame="hand", ignored="ball").nodes == [""]


@pytest.mark.parametrize(
    ("origins", "directions", "error", "said"),
    [
        (
            [0, 0, 0],
            np.broadcast_to([0.0, 0.0, 1.0], (10**9, 3)),
            virtualrobot.LimitError,
            "10+ rays are too many",
        ),
        ([0, 0, 0], [0, 0, 1], virtualrobot.InvalidArgumentError, r"the shape \(n, 3\), not \(3,\)"),
        (
            [[0, 0, 0]] * 2,
            [[0, 0, 1]] * 3,
            virtualrobot.InvalidArgumentError,
            r"\(3, 3\) or \(3,\), not \(2, 3\)",
        ),
        ([0, 0, 0], [[0, 0, 1], [0, 0, 0]], virtualrobot.InvalidArgumentError, "in row 1; a direction has any length"),
    ],
)
def test_what_makes_no_sense_is_refused(
    client: Client, origins: object, directions: object, error: type[Exception], said: str
) -> None:
    with pytest.raises(error, match=said):
        client.rays.cast(origins, directions)  # type: ignore[arg-type]


def test_ray_casters_are_compared(cell: Client) -> None:
    parts: list[float] = []
    found = cell.rays.compare(["reference", "embree"], count=500, seed=3, progress=parts.append)
    assert [one.ray_caster for one in found] == ["reference", "embree"]
    assert (found[0].agreement, found[0].largest_difference, found[0].fault) == (1.0, 0.0, "")
    assert found[1].cast_time > 0.0
    assert parts == sorted(parts)
    assert parts[-1] == 1.0


def test_what_progress_raises_ends_a_comparison(cell: Client) -> None:
    def stop(part: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cell.rays.compare(count=1000, progress=stop)
    assert cell.rays.cast([0.0, 0.0, 1.0], [[0, 0, -1]]).nodes == ["table"]


def test_the_command_shows_a_table(cell: Client, run: Run) -> None:
    head, *rows = run("rays", "reference", "embree", "--count", "300", "--seed", "5").splitlines()
    assert re.fullmatch(r"ray caster +same to 1 mm +other element +median +largest +first cast +a ray", head)
    assert [row.split()[0] for row in rows] == ["reference", "embree"]
    assert re.search(r" 100.000 % +0.000 % +0 m +0 m +\d+\.\d{3} s +\S+ us$", rows[0])


def test_the_command_casts_a_ray(cell: Client, run: Run) -> None:
    assert (
        run("rays", "--from", "0,0,1", "--along", "0,0,-5") == "table after 0.300000 m, normal 0.0000, 0.0000, 1.0000\n"
    )
    assert run("rays", "reference", "--from", "0,0,0", "--along", "0,0,1", "--frame", "ball").startswith(
        "ball after 0."
    )
    assert run("rays", "--from", "0,0,1", "--along", "0,0,1") == "nothing\n"
    assert run("rays", "--from", "0,0,1", "--along", "0,0,-1", "--ignored", "table") == "nothing\n"
    assert "there is no ray_caster component named 'embre'" in run(
        "rays", "embre", "--from", "0,0,1", "--along", "0,0,1", code=1
    )
