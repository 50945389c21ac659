"""Collisions through the client and the command line."""

from __future__ import annotations

import re
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot
from virtualrobot.collisions.watch import CollisionEvent

from tests.api.client.conftest import Run

SLIDER = """<robot name="slider"><link name="base"/><link name="cube"><collision><geometry><box size="0.2 0.2 0.2"/>
</geometry></collision></link><joint name="slide" type="prismatic"><parent link="base"/><child link="cube"/>
<axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""

LEANING = {"iiwa": {"lbr_iiwa_joint_2": 0.5}}


@pytest.fixture
def cell(client: Client, iiwa: Robot) -> Client:
    """Return a client of a world with an arm, upright, and a box where its sixth link gets when it leans forward."""
    client.scene.add_part("box", virtualrobot.box(0.2, 0.2, 0.2), pose=virtualrobot.pose(x=0.5, z=0.9))
    return client


def test_a_check_is_true_where_something_touches(cell: Client) -> None:
    assert not cell.collisions.check()
    found = cell.collisions.check(LEANING, detail="contacts", robots=["iiwa"])
    assert found and found.check_time > 0.0 and found.stamp.structure_revision > 0
    (pair,) = found.pairs
    assert (pair.first, pair.second) == ("iiwa.lbr_iiwa_link_6", "box")
    assert pair.depth is not None and 0.0 < pair.depth < 0.2 and pair.depth_approximate
    assert pair.points.shape == pair.normals.shape == (len(pair.points), 3)
    assert np.all(np.abs(pair.points - [0.5, 0.0, 0.9]) <= 0.1 + 1e-6)
    np.testing.assert_allclose(np.linalg.norm(pair.normals, axis=1), 1.0)
    (bare,) = cell.collisions.check(LEANING, detail="first").pairs
    assert bare.points.shape == (0, 3) and bare.depth is None and not bare.depth_approximate


def test_distances_have_points(cell: Client) -> None:
    nearest = cell.collisions.distance("iiwa")
    assert nearest.second == "box"
    assert np.linalg.norm(nearest.points[1] - nearest.points[0]) == pytest.approx(nearest.distance, abs=1e-9)
    every = cell.collisions.distances("iiwa", to=["box"], max_distance=5.0)
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
    with pytest.raises(virtualrobot.UnknownNameError, match="neither a client nor an import has allowed"):
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


def test_a_watch_tells_what_touches_stops_and_ends(cell: Client, iiwa: Robot, run: Run) -> None:
    cell.clock.set_stepped()
    cell.collisions.set("stop", look_ahead=0.0)
    with closing(cell.collisions.watch()) as watch:  # pyright: ignore[reportArgumentType] a generator
        report = first = next(watch)
        assert (first.touching, first.events, first.missed_events, first.fault) == ((), (), 0, "")
        motion = iiwa.move_joints({"lbr_iiwa_joint_2": 1.9}, speed_factor=0.2, wait=False)
        cell.clock.step(1000)
        events: list[CollisionEvent] = []
        while not any(event.kind == "stopped" for event in events):
            report = next(watch)
            events.extend(report.events)
    begun, stopped = events[0], next(event for event in events if event.kind == "stopped")
    assert (begun.kind, begun.nodes[1], begun.begun and begun.begun.tolerated) == ("begun", "box", False)
    assert begun.begun is not None
    assert begun.begun.collision.points.shape[1] == 3
    assert begun.simulation_time == begun.begun.simulation_time > 0.0
    assert (stopped.robots, stopped.tick, stopped.motion_ids) == (("iiwa",), begun.tick, (motion.id,))
    assert stopped.reason == f"'{begun.nodes[0]}' touches 'box'"
    assert str(stopped) == f"{stopped.simulation_time:.3f} s  iiwa stopped: {stopped.reason}"
    assert re.match(rf"\d+\.\d{{3}} s  {begun.nodes[0]} and box touch at [-\d., ]+, about [\d.]+ mm deep$", str(begun))
    assert report.checks > 1 and report.check_time > 0.0 and report.stamp.tick >= stopped.tick
    assert re.match(
        r"(iiwa\.\w+ touches box at [-\d., ]+, about [\d.]+ mm deep\n)+$", run("collision", "watch", "--count", "0")
    )
    cell.collisions.set("off")
    assert run("collision", "watch", "--count", "0").startswith("no robot is watched: every mode is off;")
    cell.collisions.set(robots={"iiwa": "monitor"})
    assert "iiwa.lbr_iiwa_link" in run("collision", "watch", "--count", "0")


def test_a_robots_own_mode_is_set_and_taken_back(cell: Client, run: Run) -> None:
    assert run("collision", "mode", "stop", "--robot", "iiwa").split() == "mode off look-ahead 1 s iiwa stop".split()
    assert run("collision", "mode", "--look-ahead", "0.5").split() == "mode off look-ahead 0.5 s iiwa stop".split()
    assert "--robot wants a mode" in run("collision", "mode", "--robot", "iiwa", "--look-ahead", "1", code=2)
    assert "only a robot can inherit" in run("collision", "mode", "inherit", code=2)
    assert run("collision", "mode", "inherit", "--robot", "iiwa").split() == "mode off look-ahead 0.5 s".split()


def test_allowing_what_has_no_figures_is_told(cell: Client, run: Run) -> None:
    assert run("collision", "allow", "iiwa", "box").startswith(
        "iiwa has no figures of its own, so this changes nothing"
    )
    assert run("collision", "allow", "iiwa.lbr_iiwa_link_7", "box") == ""


def test_paddings_and_what_guarding_costs_are_shown(cell: Client, iiwa: Robot, run: Run) -> None:
    apart = cell.collisions.distance("iiwa", to=["box"]).distance
    assert run("collision", "pad", "box", "0.01") == ""
    assert cell.collisions.distance("iiwa", to=["box"]).distance == pytest.approx(apart - 0.01, abs=1e-9)
    assert run("collision", "pad", "iiwa", "0.01").startswith("iiwa has no figures of its own")
    assert "nan" in run("collision", "pad", "box", "nan", code=2)
    before = cell.collisions.guard_cost.ticks
    cell.collisions.set("guard", paddings={"iiwa": 0.0})
    iiwa.move_joints({"lbr_iiwa_joint_1": 0.1})
    shown = run("collision", "mode").split()
    assert shown[:8] == "mode guard look-ahead none box padding 10 mm".split()
    assert re.match(r"guarding took [\d.e+]+ ms a tick, [\d.e+]+ ms at most, in \d+ ticks$", " ".join(shown[8:]))
    assert before < int(shown[-2]) == cell.collisions.guard_cost.ticks
    run("collision", "pad", "box", "0")
    assert not cell.collisions.settings.paddings


def test_nonsense_is_refused_before_or_by_the_kernel(cell: Client) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match="one of first, pairs, contacts, not 'all'"):
        cell.collisions.check(detail="all")
    with pytest.raises(virtualrobot.InvalidArgumentError, match="above 0"):
        cell.collisions.distances("iiwa", max_distance=0.0)
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
    assert re.match(r"iiwa\.lbr_iiwa_link_0 touches ball at [-\d., ]+, about [\d.]+ mm deep\n$", run("collision"))
    run("collision", "allow", "ball", "iiwa.lbr_iiwa_link_0", "--reason", "lies there")
    assert run("collision", "allowed", "ball").split() == ["iiwa.lbr_iiwa_link_0", "ball", "client", "lies", "there"]
    assert run("collision") == "nothing touches that may not\n"
    run("collision", "forbid", "ball", "iiwa.lbr_iiwa_link_0")
    assert run("collision", "allowed", "ball") == "no pairs\n"
    assert "pairs never touched" in run("collision", "find", "iiwa", "--samples", "20", "--seed", "1")
    assert "is one node" in run("collision", "allow", "ball", "ball", code=1)


@pytest.mark.long
def test_many_configurations_are_checked_as_each_one_would_be(cell: Client, rng: np.random.Generator) -> None:
    """In what is told as touching the two nodes touch; progress grows from 0 to 1."""
    samples = rng.uniform(-1.5, 1.5, (600, 7))
    told: list[float] = []
    found = cell.collisions.check_configurations("iiwa", samples, progress=told.append)
    assert told == sorted(set(told)) and (told[0], told[-1]) == (0.0, 1.0) and len(told) == 4
    assert 0 < found.free.sum() < len(samples)
    names = cell.robot("iiwa").joint_names
    for row in rng.choice(len(samples), 60, replace=False).tolist():
        one = cell.collisions.check({"iiwa": dict(zip(names, samples[row].tolist(), strict=True))})
        assert bool(one) == (not found.free[row])
        if one:
            assert found.pair(row) in {(pair.first, pair.second) for pair in one.pairs}
        else:
            assert found.pair(row) is None and found.touching[row] == -1
    reordered = cell.collisions.check_configurations("iiwa", samples[:, ::-1], joint_names=names[::-1])
    np.testing.assert_array_equal(reordered.free, found.free)
    by_name = cell.collisions.check_configurations("iiwa", dict(zip(names, samples.T, strict=True)))
    np.testing.assert_array_equal(by_name.touching >= 0, ~found.free)
    nothing = cell.collisions.check_configurations("iiwa", np.zeros((0, 7)), progress=told.append)
    assert (len(nothing.free), nothing.pairs, told[-1]) == (0, (), 1.0)


def test_several_robots_stand_elsewhere(client: Client, tmp_path: Path) -> None:
    """Cubes of 0.2 m that slide on one line from 1 m apart touch where they are at most 0.2 m apart."""
    (tmp_path / "slider.urdf").write_text(SLIDER)
    for name, side in (("left", -0.5), ("right", 0.5)):
        client.load_robot(tmp_path / "slider.urdf", name=name, pose=virtualrobot.pose(x=side))
    left, right = (column.ravel() for column in np.meshgrid(np.linspace(0.0, 0.9, 10), np.linspace(-0.9, 0.0, 10)))
    found = client.collisions.check_configurations("left", left[:, None], others={"right": {"slide": right}})
    apart = np.abs(1.0 - left + right)
    clear = np.abs(apart - 0.2) > 1e-6
    np.testing.assert_array_equal(found.free[clear], (apart > 0.2)[clear])
    assert found.pairs == (("left.cube", "right.cube"),)
    client.scene.add_part("block", virtualrobot.box(0.1, 0.1, 0.1), pose=virtualrobot.pose(x=-0.5))
    for robots, free in (((), [False, True]), (("right",), [True, True]), (("left",), [False, True])):
        one = client.collisions.check_configurations("left", [[0.0], [0.5]], robots=robots)
        assert one.free.tolist() == free


def test_configurations_of_wrong_shape_are_refused(cell: Client) -> None:
    check = cell.collisions.check_configurations
    with pytest.raises(virtualrobot.InvalidArgumentError, match="by joint name, or in order"):
        check("iiwa", {"lbr_iiwa_joint_1": [0.0]}, joint_names=["lbr_iiwa_joint_1"])
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"shape \(n, k\)"):
        check("iiwa", np.zeros((2, 3, 7)))
    with pytest.raises(virtualrobot.InvalidArgumentError, match="'iiwa' is among the others too"):
        check("iiwa", np.zeros((2, 7)), others={"iiwa": np.ones((2, 7))})
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"shape \(n, 7\), not \(1, 6\)"):
        check("iiwa", np.zeros(6))
    with pytest.raises(virtualrobot.VirtualRobotError, match="a message may have"):
        check("iiwa", np.zeros((310_000, 7)))


def test_what_progress_raises_ends_the_check(cell: Client) -> None:
    def stop(part: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cell.collisions.check_configurations("iiwa", np.zeros((200_000, 7)), progress=stop)
    assert len(cell.collisions.check_configurations("iiwa", np.zeros((1, 7))).free) == 1
