"""ViewService: the set-up that every viewer shows; it is kept by a kernel without a viewer too."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from google.protobuf.field_mask_pb2 import FieldMask
from virtualrobot.v1 import geometry_pb2, nodes_pb2, scene_pb2, sensing_pb2, view_pb2

from tests.api.asking import IIWA, apply, box, create, load, refusal
from tests.api.test_scene import remove, update
from tests.kernels import Stubs

Vector = geometry_pb2.Vector3


def get(stubs: Stubs) -> view_pb2.View:
    return stubs.view.GetView(view_pb2.GetViewRequest()).view


def change(stubs: Stubs, *mask: str, **fields: Any) -> view_pb2.View:  # noqa: ANN401 fields of View
    request = view_pb2.UpdateViewRequest(view=view_pb2.View(**fields), update_mask=FieldMask(paths=mask))
    return stubs.view.UpdateView(request).view


def camera(x: float = 1.0, **fields: Any) -> view_pb2.Camera:  # noqa: ANN401 fields of Camera
    return view_pb2.Camera(position=Vector(x=x, y=2.0, z=3.0), target=Vector(y=2.0, z=3.0), **fields)


@pytest.fixture
def view(stepped: Stubs) -> Iterator[Stubs]:
    """Return stubs to a kernel whose view is as at the start."""
    fields = [field.name for field in view_pb2.View.DESCRIPTOR.fields]
    change(stepped, *fields)
    yield stepped


def test_only_what_the_mask_names_changes(view: Stubs) -> None:
    load(view, IIWA, "arm")
    apply(view, create(box("a")))
    before = get(view)
    assert (before.grid_hidden, before.HasField("camera"), len(before.joint_axes)) == (False, False, 0)
    red = geometry_pb2.Color(red=1.0, green=0.25, blue=0.0)
    after = change(view, "background", background=red, grid_hidden=True, joint_axes=["arm"])
    assert (after.background.green, after.grid_hidden, len(after.joint_axes)) == (0.25, False, 0)
    after = change(
        view,
        "grid_hidden",
        "joint_axes",
        "bounding_boxes",
        grid_hidden=True,
        joint_axes=["arm"],
        bounding_boxes=["a", "arm"],
    )
    assert (after.grid_hidden, list(after.joint_axes), list(after.bounding_boxes)) == (True, ["arm"], ["a", "arm"])
    assert after == get(view)
    after = change(view, "camera", camera=camera())
    assert after.camera.position == Vector(x=1.0, y=2.0, z=3.0)
    assert after.camera.field_of_view_radians == 0.9, "the default that the contract names"
    assert not change(view, "camera").HasField("camera"), "a field without a value goes back to its default"
    assert view.view.GetView(view_pb2.GetViewRequest()).viewer_count == 0


def test_nodes_keep_their_boxes_under_another_name(view: Stubs) -> None:
    apply(view, create(box("a")), create(box("b")))
    change(view, "bounding_boxes", bounding_boxes=["a", "b"])
    apply(view, update("a", "name", name="c"), remove("b"))
    assert list(get(view).bounding_boxes) == ["c"]


def test_the_watch_tells_each_change(view: Stubs) -> None:
    watch = view.view.WatchView(view_pb2.WatchViewRequest())
    assert next(watch).view == get(view)
    for hidden in (True, False, True):
        change(view, "grid_hidden", grid_hidden=hidden)
        assert next(watch).view.grid_hidden == hidden
    watch.cancel()


def test_what_cannot_be_drawn_is_refused_and_changes_nothing(view: Stubs) -> None:
    apply(view, create(box("a")))
    change(view, "camera", camera=camera())
    before = get(view)
    nan = float("nan")
    for reason, mask, fields in (
        ("UNKNOWN_NAME", ["joint_axes"], {"joint_axes": ["nobody"]}),
        ("UNKNOWN_NAME", ["joint_axes"], {"joint_axes": ["a"]}),
        ("UNKNOWN_NAME", ["bounding_boxes", "grid_hidden"], {"bounding_boxes": ["nobody"], "grid_hidden": True}),
        ("UNKNOWN_NAME", ["backgruond"], {}),
        ("UNKNOWN_NAME", ["camera.target"], {"camera": camera()}),
        ("INVALID_ARGUMENT", [], {"grid_hidden": True}),
        ("INVALID_ARGUMENT", ["camera"], {"camera": camera(0.0)}),
        ("INVALID_ARGUMENT", ["camera"], {"camera": camera(nan)}),
        ("INVALID_ARGUMENT", ["camera"], {"camera": camera(field_of_view_radians=3.5)}),
        ("INVALID_ARGUMENT", ["camera"], {"camera": camera(field_of_view_radians=-1.0)}),
        ("INVALID_ARGUMENT", ["camera"], {"camera": camera(field_of_view_radians=nan)}),
        ("INVALID_ARGUMENT", ["background"], {"background": geometry_pb2.Color(red=1.1)}),
        ("INVALID_ARGUMENT", ["background"], {"background": geometry_pb2.Color(red=nan)}),
    ):
        refused = refusal(lambda mask=mask, fields=fields: change(view, *mask, **fields))
        assert refused.reason == reason, (mask, fields)
        assert get(view) == before
    refused = refusal(lambda: change(view, "camera", camera=camera(0.0)))
    assert "camera is at its own target" in refused.message


def test_a_scene_that_replaces_the_world_sets_up_the_view_anew(stubs: Stubs) -> None:
    before = get(stubs)
    change(stubs, "grid_hidden", "background", grid_hidden=True, background=geometry_pb2.Color(red=1.0))
    stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text="schema_version: 1\n", add=True))
    assert get(stubs).grid_hidden
    stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text="schema_version: 1\n"))
    assert get(stubs) == before


def test_what_is_shown_of_sensors_goes_with_their_names(view: Stubs) -> None:
    lidar = nodes_pb2.Node(name="lidar", range_sensor=sensing_pb2.RangeSensor())
    eye = nodes_pb2.Node(name="eye", camera_sensor=sensing_pb2.CameraSensor())
    apply(view, create(lidar), create(eye))
    shown = [
        view_pb2.SensorOverlay(sensor="lidar", points=True, rays=True, color_by=view_pb2.POINT_COLOR_INTENSITY),
        view_pb2.SensorOverlay(sensor="eye", frustum=True, image=True, color_by=view_pb2.POINT_COLOR_DISTANCE),
    ]
    assert list(change(view, "sensors", sensors=shown).sensors) == shown
    apply(view, update("lidar", "name", name="scanner"))
    assert [one.sensor for one in get(view).sensors] == ["scanner", "eye"]
    apply(view, remove("eye"))
    assert [one.sensor for one in get(view).sensors] == ["scanner"]
    assert not change(view, "sensors").sensors


def test_what_is_shown_of_sensors_is_looked_at(view: Stubs) -> None:
    lidar = nodes_pb2.Node(name="lidar", range_sensor=sensing_pb2.RangeSensor())
    apply(view, create(lidar), create(box("a")))
    overlay = view_pb2.SensorOverlay
    for sensors, named in [
        ([overlay(sensor="a", points=True)], "'a'"),
        ([overlay(sensor="gone")], "lidar"),
        ([overlay(sensor="lidar"), overlay(sensor="lidar", rays=True)], "twice"),
        ([overlay(sensor="lidar", color_by=7)], "POINT_COLOR_INTENSITY"),  # pyright: ignore[reportArgumentType]
    ]:
        refused = refusal(lambda sensors=sensors: change(view, "sensors", sensors=sensors))
        assert named in refused.message
    assert not get(view).sensors
