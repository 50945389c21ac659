"""ViewService.MeasurePointDistance and the view's measurements: distances between points that move with nodes."""

from __future__ import annotations

import numpy as np
import pytest
from google.protobuf.field_mask_pb2 import FieldMask
from virtualrobot.v1 import geometry_pb2, view_pb2

from tests.api.asking import IIWA, apply, box, create, joints, load, refusal, start
from tests.api.reading import matrix, scene, step
from tests.api.test_scene import remove, update
from tests.kernels import Stubs

TIP = "arm.lbr_iiwa_link_7"


def at(node: str, *point: float) -> view_pb2.NodePoint:
    x, y, z = point
    return view_pb2.NodePoint(node=node, point=geometry_pb2.Vector3(x=x, y=y, z=z))


def measure(stubs: Stubs, first: view_pb2.NodePoint, second: view_pb2.NodePoint) -> view_pb2.PointDistance:
    return stubs.view.MeasurePointDistance(view_pb2.MeasurePointDistanceRequest(first=first, second=second)).distance


def as_array(vector: geometry_pb2.Vector3) -> np.ndarray:
    return np.array([vector.x, vector.y, vector.z])


def show(stubs: Stubs, *measurements: view_pb2.Measurement) -> view_pb2.View:
    view = view_pb2.View(measurements=measurements)
    return stubs.view.UpdateView(
        view_pb2.UpdateViewRequest(view=view, update_mask=FieldMask(paths=["measurements"]))
    ).view


def test_points_are_in_the_frames_of_their_nodes(stepped: Stubs) -> None:
    apply(stepped, create(box("a", 1.0, 2.0, 3.0)))
    found = measure(stepped, at("a", 0.0, 0.0, 1.0), at("", 1.0, 2.0, 0.0))
    assert (found.distance_meters, as_array(found.first).tolist()) == (4.0, [1.0, 2.0, 4.0])
    assert measure(stepped, at("a", 1.0, 0.0, 0.0), at("a", -1.0, 0.0, 0.0)).distance_meters == 2.0


def test_a_watched_distance_follows_a_moving_arm(stepped: Stubs, rng: np.random.Generator) -> None:
    """Against the poses that GetScene tells at the same tick."""
    load(stepped, IIWA, "arm")
    apply(stepped, create(box("a", *rng.uniform(-1.0, 1.0, 3))))
    first, second = at(TIP, *rng.uniform(-0.2, 0.2, 3)), at("a", *rng.uniform(-0.1, 0.1, 3))
    request = view_pb2.WatchPointDistanceRequest(first=first, second=second, max_rate_hertz=1000.0)
    watch = stepped.view.WatchPointDistance(request)
    assert next(watch).distance == measure(stepped, first, second)
    start(stepped, joints("arm", lbr_iiwa_joint_1=1.0, lbr_iiwa_joint_4=-1.0))
    seen = []
    for _ in range(5):
        tick = step(stepped, 20).stamp.tick
        told = next(one.distance for one in watch if one.stamp.tick == tick)
        poses = scene(stepped, TIP, "a")
        ends = [poses[TIP] @ [*as_array(first.point), 1.0], poses["a"] @ [*as_array(second.point), 1.0]]
        np.testing.assert_allclose([as_array(told.first), as_array(told.second)], np.array(ends)[:, :3], atol=1e-12)
        assert told.distance_meters == pytest.approx(np.linalg.norm(ends[0] - ends[1]), abs=1e-12)
        seen.append(told.distance_meters)
    assert len(set(seen)) == 5, "the arm moves"
    watch.cancel()


def test_a_watch_ends_when_its_node_goes(stepped: Stubs) -> None:
    apply(stepped, create(box("a")))
    request = view_pb2.WatchPointDistanceRequest(first=at("a", 0.0, 0.0, 0.0), second=at("", 0.0, 0.0, 0.0))
    watch = stepped.view.WatchPointDistance(request)
    next(watch)
    apply(stepped, update("a", "name", name="b"))
    assert next(watch).distance.distance_meters == 0.0, "it is known by its uid"
    apply(stepped, remove("b"))
    refused = refusal(lambda: next(watch))
    assert (refused.reason, "has been removed" in refused.message) == ("UNKNOWN_NAME", True)


def test_what_cannot_be_measured_is_refused(stepped: Stubs) -> None:
    nan, here = float("nan"), at("", 0.0, 0.0, 0.0)
    assert refusal(lambda: measure(stepped, at("nobody", 0.0, 0.0, 0.0), here)).reason == "UNKNOWN_NAME"
    refused = refusal(lambda: measure(stepped, here, at("", 0.0, nan, 0.0)))
    assert (refused.reason, refused.metadata["field"]) == ("INVALID_ARGUMENT", "second.point")
    bad_rate = view_pb2.WatchPointDistanceRequest(first=here, second=here, max_rate_hertz=-1.0)
    assert refusal(lambda: next(stepped.view.WatchPointDistance(bad_rate))).reason == "INVALID_ARGUMENT"


def test_the_view_keeps_measurements_by_uid(stepped: Stubs) -> None:
    apply(stepped, create(box("a")), create(box("b")))
    both = [
        view_pb2.Measurement(name="gap", first=at("a", 0.1, 0.0, 0.0), second=at("world", 0.0, 0.0, 0.0)),
        view_pb2.Measurement(name="other", first=at("a", 0.0, 0.0, 0.0), second=at("b", 0.0, 0.0, 0.0)),
    ]
    assert list(show(stepped, *both).measurements) == both
    apply(stepped, update("a", "name", name="c"), remove("b"))
    (left,) = stepped.view.GetView(view_pb2.GetViewRequest()).view.measurements
    assert (left.name, left.first.node) == ("gap", "c")
    for reason, bad in (
        ("NAME_TAKEN", [left, left]),
        ("INVALID_ARGUMENT", [view_pb2.Measurement(first=left.first, second=left.second)]),
        ("UNKNOWN_NAME", [both[0]]),
        (
            "INVALID_ARGUMENT",
            [view_pb2.Measurement(name="far", first=at("c", float("inf"), 0.0, 0.0), second=left.first)],
        ),
    ):
        assert refusal(lambda bad=bad: show(stepped, *bad)).reason == reason
        assert list(stepped.view.GetView(view_pb2.GetViewRequest()).view.measurements) == [left]
    show(stepped)


def test_a_pose_of_a_node_may_be_any(stepped: Stubs) -> None:
    """A turned node's point, by the pose that was asked for."""
    node = box("a", 0.3, -0.2, 0.5)
    node.parent_t_node.orientation.CopyFrom(geometry_pb2.Quaternion(z=np.sin(0.35), w=np.cos(0.35)))
    apply(stepped, create(node))
    point = matrix(node.parent_t_node) @ [0.4, 0.1, 0.0, 1.0]
    found = measure(stepped, at("a", 0.4, 0.1, 0.0), at("", 0.0, 0.0, 0.0))
    np.testing.assert_allclose(as_array(found.first), point[:3], atol=1e-12)
