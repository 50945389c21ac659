"""CollisionService: checks, distances, allowed pairs, their search, and what is refused."""

from __future__ import annotations

import math
import threading

import grpc
import numpy as np
import pytest
from virtualrobot.v1 import collision_pb2, geometry_pb2, lease_pb2, nodes_pb2, scene_pb2

from tests.api.asking import IIWA, PANDA, apply, box, create, load, refusal
from tests.kernels import Stubs

Check = collision_pb2.CheckCollisionRequest
Measure = collision_pb2.MeasureDistancesRequest
FIRST, PAIRS, CONTACTS = (
    collision_pb2.COLLISION_DETAIL_FIRST,
    collision_pb2.COLLISION_DETAIL_PAIRS,
    collision_pb2.COLLISION_DETAIL_CONTACTS,
)


def names(response: collision_pb2.CheckCollisionResponse) -> set[tuple[str, str]]:
    return {(pair.first, pair.second) for pair in response.pairs}


def standing(robot: str = "arm", **positions: float) -> collision_pb2.RobotConfiguration:
    return collision_pb2.RobotConfiguration(robot=robot, joint_positions=positions)


def allow(stubs: Stubs, first: str, second: str, reason: str = "") -> scene_pb2.ApplyResponse:
    pair = nodes_pb2.NodePair(first=first, second=second, reason=reason)
    return apply(stubs, scene_pb2.Command(set_allowed_pairs=collision_pb2.SetAllowedPairs(allow=[pair])))


def forbid(stubs: Stubs, first: str, second: str) -> scene_pb2.ApplyResponse:
    pair = nodes_pb2.NodePair(first=first, second=second)
    return apply(stubs, scene_pb2.Command(set_allowed_pairs=collision_pb2.SetAllowedPairs(forbid=[pair])))


def allowed(stubs: Stubs, *nodes: str) -> dict[tuple[str, str], tuple[int, str]]:
    response = stubs.collision.ListAllowedPairs(collision_pb2.ListAllowedPairsRequest(nodes=nodes))
    return {(pair.first, pair.second): (pair.cause, pair.reason) for pair in response.pairs}


def test_a_check_tells_what_touches_now_and_elsewhere(stubs: Stubs) -> None:
    """A box where link 6 comes to be when joint 2 leans forward; checking moves nothing."""
    load(stubs, IIWA, "arm")
    apply(stubs, create(box("box", x=0.5, z=0.9)))
    now = stubs.collision.CheckCollision(Check())
    assert names(now) == set()
    assert now.stamp.structure_revision > 0 and now.check_seconds > 0.0
    leaning = stubs.collision.CheckCollision(Check(configurations=[standing(lbr_iiwa_joint_2=0.75)]))
    assert names(leaning) and all(pair[1] == "box" for pair in names(leaning))
    first = stubs.collision.CheckCollision(Check(configurations=[standing(lbr_iiwa_joint_2=0.75)], detail=FIRST))
    assert len(first.pairs) == 1 and names(first) <= names(leaning)
    assert names(stubs.collision.CheckCollision(Check())) == set()


def test_contacts_have_points_normals_and_a_depth(stubs: Stubs) -> None:
    """Two cubes of 10 cm, the upper 1 cm in the lower: the face in between is 1 cm thick, at 4 to 5 cm."""
    robot = box("robot", x=0.05)
    robot.robot.SetInParent()
    apply(stubs, create(robot), create(box("part", x=0.05, z=0.09)))
    (pair,) = stubs.collision.CheckCollision(Check(detail=CONTACTS)).pairs
    assert (pair.first, pair.second) == ("robot", "part")
    assert pair.depth_meters == pytest.approx(0.01, abs=1e-9) and not pair.depth_approximate
    for contact in pair.contacts:
        assert 0.04 - 1e-9 <= contact.point.z <= 0.05 + 1e-9
        assert (contact.normal.x, contact.normal.y, contact.normal.z) == pytest.approx((0, 0, 1), abs=1e-9)
    (without,) = stubs.collision.CheckCollision(Check(detail=PAIRS)).pairs
    assert not without.contacts and not without.HasField("depth_meters")
    load(stubs, IIWA, "arm")
    (mesh,) = (
        pair
        for pair in stubs.collision.CheckCollision(Check(robots=["arm"], detail=CONTACTS)).pairs
        if pair.first == "part" or pair.second == "part"
    )
    assert mesh.depth_approximate and 0.0 < mesh.depth_meters < 0.15 and 0 < len(mesh.contacts) <= 64


def test_only_pairs_with_named_robots_are_told(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    load(stubs, IIWA, "other")
    apply(stubs, create(box("box", z=0.3)))
    every = names(stubs.collision.CheckCollision(Check()))
    of_arm = names(stubs.collision.CheckCollision(Check(robots=["arm"])))
    assert of_arm == {pair for pair in every if any(name.startswith("arm.") for name in pair)}
    assert of_arm < every


def test_a_picked_part_belongs_to_the_robot(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    tool = nodes_pb2.Node(name="gripper", parent="arm.lbr_iiwa_link_7", tool=nodes_pb2.Tool(), figures=box("x").figures)
    apply(stubs, create(tool))
    place = stubs.scene.GetScene(scene_pb2.GetSceneRequest(names=["gripper"])).world_t_node
    x, y, z = np.frombuffer(place.data, "<f8")[:3]
    apply(stubs, create(box("part", x, y, z + 0.04)), create(box("beside", x, y, z + 0.1)))
    before = names(stubs.collision.CheckCollision(Check()))
    assert ("gripper", "part") in before and ("part", "beside") not in before
    pick = scene_pb2.PickPart(robot="arm", part="part", max_distance_meters=1.0)
    apply(stubs, scene_pb2.Command(pick_part=pick))
    held = names(stubs.collision.CheckCollision(Check()))
    assert ("gripper", "part") not in held and ("part", "beside") in held


def test_distances_are_told_with_points_and_names(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    apply(stubs, create(box("near", x=0.6, z=0.5)), create(box("far", x=3.0)))
    (pair,) = stubs.collision.MeasureDistances(Measure(first=["arm"])).pairs
    assert pair.first.startswith("arm.") and pair.second == "near"
    points = [np.array([p.x, p.y, p.z]) for p in (pair.first_point, pair.second_point)]
    assert np.linalg.norm(points[1] - points[0]) == pytest.approx(pair.distance_meters, abs=1e-9)
    assert points[1][0] == pytest.approx(0.55, abs=1e-9)
    response = stubs.collision.MeasureDistances(Measure(first=["arm"], second=["far"], range_meters=9.0))
    distances = [pair.distance_meters for pair in response.pairs]
    assert len(distances) == 8 and distances == sorted(distances)
    moved = Measure(first=["arm"], second=["near"], configurations=[standing(lbr_iiwa_joint_2=0.3)])
    assert stubs.collision.MeasureDistances(moved).pairs[0].distance_meters < pair.distance_meters
    (between,) = stubs.collision.MeasureDistances(Measure(first=["near"], second=["far"])).pairs
    assert between.distance_meters == pytest.approx(math.hypot(2.3, 0.4), abs=1e-9)
    assert not stubs.collision.MeasureDistances(Measure(first=["near"], second=["near"])).pairs


def test_allowed_pairs_have_their_causes(stubs: Stubs) -> None:
    load(stubs, PANDA, "panda")
    apply(stubs, create(box("box", x=0.5)))
    found = allowed(stubs)
    assert found["panda.panda_link1", "panda.panda_link2"] == (collision_pb2.ALLOWED_CAUSE_ADJACENT, "")
    assert found["panda.panda_link7", "panda.panda_hand"] == (collision_pb2.ALLOWED_CAUSE_RIGID, "")
    assert not any("box" in pair for pair in found)
    allow(stubs, "box", "panda.panda_link1", "it leans on it")
    assert allowed(stubs, "box") == {
        ("panda.panda_link1", "box"): (collision_pb2.ALLOWED_CAUSE_CLIENT, "it leans on it")
    }
    forbid(stubs, "panda.panda_link1", "box")
    assert allowed(stubs, "box") == {}


def test_what_is_allowed_is_no_collision_and_follows_its_nodes(stubs: Stubs) -> None:
    """A pair is of nodes: renamed it stays, removed it goes, and a new node of the name has none."""
    load(stubs, IIWA, "arm")
    apply(stubs, create(box("box", z=0.1)))
    touching = names(stubs.collision.CheckCollision(Check()))
    assert touching
    for first, second in touching:
        allow(stubs, first, second)
    assert names(stubs.collision.CheckCollision(Check())) == set()
    rename = scene_pb2.UpdateNode(name="box", node=nodes_pb2.Node(name="crate"), update_mask={"paths": ["name"]})
    apply(stubs, scene_pb2.Command(update_node=rename))
    assert {pair[1] for pair in allowed(stubs, "crate")} == {"crate"}
    apply(stubs, scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="crate")), create(box("crate", z=0.1)))
    assert allowed(stubs, "crate") == {}
    assert {pair[1] for pair in names(stubs.collision.CheckCollision(Check()))} == {"crate"}


def test_a_scene_file_keeps_allowed_pairs(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    apply(stubs, create(box("box", z=0.1)))
    allow(stubs, "arm.lbr_iiwa_link_0", "box", "stands: in it")
    saved = stubs.scene.SaveScene(scene_pb2.SaveSceneRequest())
    before = allowed(stubs)
    stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text=saved.text))
    assert allowed(stubs) == before
    assert stubs.scene.SaveScene(scene_pb2.SaveSceneRequest()).text == saved.text
    assert "allowed_pairs:" in saved.text


def test_a_lease_keeps_others_from_allowing_pairs_of_its_robot(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    apply(stubs, create(box("one")), create(box("two")))
    lease = stubs.lease.AcquireLease(lease_pb2.AcquireLeaseRequest(robots=["arm"], owner="me"))
    assert refusal(lambda: allow(stubs, "arm.lbr_iiwa_link_0", "one")).reason == "LEASED"
    allow(stubs, "one", "two")
    stubs.lease.ReleaseLease(lease_pb2.ReleaseLeaseRequest(token=lease.token))


def test_the_search_counts_what_touches(stubs: Stubs, seed: int) -> None:
    """The same seed gives the same counts; what is allowed is not tried; the last message alone has pairs."""
    load(stubs, PANDA, "panda")
    request = collision_pb2.FindAllowedPairsRequest(robot="panda", samples=300, seed=seed)
    *progress, last = stubs.collision.FindAllowedPairs(request)
    assert last.progress == 1.0 and last.samples == 300
    assert all(0.0 <= one.progress < 1.0 and not one.pairs for one in progress)
    counts = {(pair.first, pair.second): pair.touched for pair in last.pairs}
    assert not counts.keys() & allowed(stubs).keys()
    assert list(counts.values()) == sorted(counts.values(), reverse=True)
    assert 0 < max(counts.values()) < 300 and min(counts.values()) == 0
    *_, again = stubs.collision.FindAllowedPairs(request)
    assert {(pair.first, pair.second): pair.touched for pair in again.pairs} == counts
    pair = max(counts, key=lambda one: counts[one])
    allow(stubs, *pair)
    *_, fewer = stubs.collision.FindAllowedPairs(request)
    assert {(one.first, one.second): one.touched for one in fewer.pairs} == {
        key: count for key, count in counts.items() if key != pair
    }


def test_a_search_that_nobody_waits_for_ends(stubs: Stubs) -> None:
    """Four searches take all threads; as they are cancelled a check gets its turn."""
    load(stubs, PANDA, "panda")
    request = collision_pb2.FindAllowedPairsRequest(robot="panda", samples=100_000)
    streams = [stubs.collision.FindAllowedPairs(request) for _ in range(4)]
    for stream in streams:
        assert next(stream).progress < 1.0
        stream.cancel()
    assert stubs.collision.CheckCollision(Check(), timeout=20.0).check_seconds < 20.0


def test_many_ask_at_once(stubs: Stubs, rng: np.random.Generator) -> None:
    """Each thread has a scene of its own: the answers are those of one after the other."""
    load(stubs, IIWA, "arm")
    places = rng.uniform(-0.35, 0.35, (10, 3)).tolist()
    apply(stubs, *(create(box(f"b{i}", x, y, 0.7 + z)) for i, (x, y, z) in enumerate(places)))
    requests = []
    for _ in range(40):
        positions = {f"lbr_iiwa_joint_{joint}": float(rng.uniform(-2, 2)) for joint in range(1, 8)}
        arm = collision_pb2.RobotConfiguration(robot="arm", joint_positions=positions)
        requests.append(Check(configurations=[arm]))
    expected = [names(stubs.collision.CheckCollision(request)) for request in requests]
    found: dict[int, set[tuple[str, str]]] = {}

    def ask(start: int) -> None:
        for place in range(start, len(requests), 6):
            found[place] = names(stubs.collision.CheckCollision(requests[place]))

    threads = [threading.Thread(target=ask, args=(start,)) for start in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [found[place] for place in range(len(requests))] == expected
    assert len({frozenset(one) for one in expected}) > 5


def test_what_makes_no_sense_is_refused_by_name(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    apply(stubs, create(box("box")))
    collision = stubs.collision
    nan = refusal(lambda: collision.CheckCollision(Check(configurations=[standing(lbr_iiwa_joint_2=math.nan)])))
    assert (nan.code, nan.reason) == (grpc.StatusCode.INVALID_ARGUMENT, "INVALID_ARGUMENT")
    assert "configurations[0].joint_positions['lbr_iiwa_joint_2'] must be a finite number" in nan.message
    far = refusal(lambda: collision.CheckCollision(Check(configurations=[standing(lbr_iiwa_joint_2=9.0)])))
    assert far.reason == "LIMIT_EXCEEDED"
    joint = refusal(lambda: collision.CheckCollision(Check(configurations=[standing(elbow=1.0)])))
    assert (joint.reason, "elbow" in joint.message) == ("UNKNOWN_NAME", True)
    twice = refusal(lambda: collision.CheckCollision(Check(configurations=[standing(), standing()])))
    assert "configurations[1] names the robot 'arm' again" in twice.message
    assert refusal(lambda: collision.CheckCollision(Check(robots=["box"]))).reason == "UNKNOWN_NAME"
    assert "detail" in refusal(lambda: collision.CheckCollision(Check(detail=77))).message  # pyright: ignore
    assert "first names no node" in refusal(lambda: collision.MeasureDistances(Measure())).message
    inf = refusal(lambda: collision.MeasureDistances(Measure(first=["arm"], range_meters=math.inf)))
    assert "range_meters" in inf.message
    apply(stubs, scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="box")))
    assert refusal(lambda: collision.MeasureDistances(Measure(first=["box"]))).reason == "UNKNOWN_NAME"
    assert refusal(lambda: allow(stubs, "box", "arm")).reason == "UNKNOWN_NAME"
    assert "is one node" in refusal(lambda: allow(stubs, "arm", "arm")).message
    assert "allow[0].second names no node" in refusal(lambda: allow(stubs, "arm", "")).message
    unknown = refusal(lambda: forbid(stubs, "arm", "arm.lbr_iiwa_link_0"))
    assert (unknown.reason, "neither a client nor an import has allowed" in unknown.message) == ("UNKNOWN_NAME", True)
    empty = refusal(lambda: apply(stubs, scene_pb2.Command(set_allowed_pairs=collision_pb2.SetAllowedPairs())))
    assert "no pair" in empty.message
    many = collision_pb2.FindAllowedPairsRequest(robot="arm", samples=100_001)
    assert refusal(lambda: list(collision.FindAllowedPairs(many))).reason == "LIMIT_EXCEEDED"
    assert refusal(lambda: list(collision.FindAllowedPairs(collision_pb2.FindAllowedPairsRequest(robot="no")))).reason


def test_a_wall_as_thin_as_paper_is_met(stubs: Stubs) -> None:
    """A tenth of a millimeter thick, through the middle of a link."""
    load(stubs, IIWA, "arm")
    wall = box("wall", z=0.9)
    wall.figures[0].box.size.CopyFrom(geometry_pb2.Vector3(x=1.0, y=1.0, z=1e-4))
    apply(stubs, create(wall))
    assert any(pair[1] == "wall" for pair in names(stubs.collision.CheckCollision(Check(detail=FIRST))))
