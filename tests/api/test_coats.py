"""Coats: triangles on nodes, coloured by values that change; what is wrong with one is refused by name."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, UnknownNameError
from virtualrobot.v1 import geometry_pb2, history_pb2, kernel_pb2, view_pb2

from tests.api.asking import refusal
from tests.kernels import KernelProcess, Stubs

CORNERS = np.array([[-1, -0.2, -1], [1, -0.2, -1], [1, -0.2, 1], [-1, -0.2, 1]], np.float32)
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
"""A square of 2 m across y, seen from -y; its second triangle is the upper left one."""
BEFORE = ([0.0, -4.0, 0.0], [0.0, 0.0, 0.0])
NAN, INF = float("nan"), float("inf")


def coat(name: str = "film", node: str = "plate", **fields: object) -> view_pb2.Coat:
    """Return a coat of the square."""
    arrays = {
        "vertices": (CORNERS, geometry_pb2.NUMERIC_TYPE_FLOAT32),
        "faces": (FACES, geometry_pb2.NUMERIC_TYPE_INT32),
    }
    for field, (values, kind) in arrays.items():
        given = np.asarray(fields.pop(field, values), values.dtype)
        told = geometry_pb2.NumericArray(type=kind, shape=given.shape, data=given.tobytes())
        fields[field] = told
    return view_pb2.Coat(**{"name": name, "node": node, "low": 0.0, "high": 50.0, **fields})  # pyright: ignore[reportArgumentType]


def set_coat(stubs: Stubs, given: view_pb2.Coat) -> None:
    stubs.view.SetCoat(view_pb2.SetCoatRequest(coat=given))


def paint(stubs: Stubs, *values: int, first: int = 0, name: str = "film") -> None:
    given = view_pb2.CoatValues(name=name, first=first, values=bytes(values))
    stubs.view.PaintCoat(view_pb2.PaintCoatRequest(values=given))


@pytest.fixture
def plate(stepped: Stubs, steps: Client) -> Stubs:
    """Return stubs to a world with a plate behind where the square is; no coats."""
    stepped.view.RemoveCoats(view_pb2.RemoveCoatsRequest())
    steps.scene.add_part("plate", virtualrobot.box(2.0, 0.2, 2.0))
    return stepped


WRONG: dict[str, tuple[Callable[[], view_pb2.Coat], str]] = {
    "no name": (lambda: coat(" "), "a coat has no name"),
    "an unknown node": (lambda: coat(node="plaet"), "plate"),
    "no triangles": (lambda: coat(faces=np.empty((0, 3))), "has no triangles"),
    "a face without its corner": (lambda: coat(faces=[[0, 1, 4]]), "rows are 0 to 3"),
    "a face before the first corner": (lambda: coat(faces=[[0, -1, 2]]), "rows are 0 to 3"),
    "a corner that is not finite": (lambda: coat(vertices=[[0, 0, NAN]] * 4), "not finite"),
    "a flat array": (lambda: coat(vertices=[1.0, 2.0, 3.0]), "must have the shape"),
    "too few values": (lambda: coat(values=b"\1\2\3"), "3 values and 4 vertices"),
    "low above high": (lambda: coat(low=50.0, high=50.0), "`low` must be below `high`"),
    "a low that is no number": (lambda: coat(low=NAN), "coat.low must be a finite number"),
    "a high without end": (lambda: coat(high=INF), "coat.high must be a finite number"),
    "an unknown colour map": (lambda: coat(color_map=9), "color_map is 9"),
    "too many triangles": (lambda: coat(faces=np.zeros((1_000_001, 3))), "at most 1,000,000"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_wrong_is_said(plate: Stubs, what: str) -> None:
    make, words = WRONG[what]
    assert words in refusal(lambda: set_coat(plate, make())).message
    assert not next(iter(plate.view.WatchCoats(view_pb2.WatchCoatsRequest()))).coats


def test_two_gigabytes_are_refused_before_they_are_read(plate: Stubs) -> None:
    """A message has a limit, which tells its size; this one is only just over it."""
    limit = plate.kernel.GetInfo(kernel_pb2.GetInfoRequest()).max_message_bytes
    told = refusal(lambda: set_coat(plate, coat(values=bytes(limit + 1))))
    assert told.code.name == "RESOURCE_EXHAUSTED"


def test_values_that_no_corner_has_are_refused(plate: Stubs) -> None:
    set_coat(plate, coat())
    told = refusal(lambda: paint(plate, 1, 2, first=3))
    assert "4 corners; 2 values from row 3 on are 1 too many" in told.message
    assert "film" in refusal(lambda: paint(plate, 1, name="flim")).message
    assert refusal(lambda: plate.view.RemoveCoats(view_pb2.RemoveCoatsRequest(names=["x"]))).reason == "UNKNOWN_NAME"


def test_a_watch_tells_what_has_changed(plate: Stubs) -> None:
    set_coat(plate, coat(values=bytes([0, 10, 20, 30]), unit="µm"))
    stream = iter(plate.view.WatchCoats(view_pb2.WatchCoatsRequest()))
    first = next(stream)
    assert [(one.node, one.title, one.unit, len(one.palette)) for one in first.coats] == [("plate", "film", "µm", 768)]
    assert first.coats[0].values == bytes([0, 10, 20, 30])
    paint(plate, 11, 20, first=1)
    (told,) = next(stream).values
    assert (told.name, told.first, told.values) == ("film", 1, bytes([11]))
    set_coat(plate, coat(unit="mm"))
    assert [one.unit for one in next(stream).coats] == ["mm"]
    plate.view.RemoveCoats(view_pb2.RemoveCoatsRequest())
    assert list(next(stream).removed_names) == ["film"]


def test_pictures_and_cameras_show_it_and_range_sensors_pass_through(plate: Stubs, steps: Client) -> None:
    """A triangle is drawn where all its corners have values; heat is white at the highest and black at the lowest."""
    set_coat(plate, coat(color_map=view_pb2.COLOR_MAP_HEAT))

    def seen() -> np.ndarray:
        return (
            steps.view.capture(BEFORE, size=(64, 64), format="raw", plain=True).pixels[[20, 44], [20, 44]].astype(int)
        )

    bare = seen()
    paint(plate, 255, 255, 255, 0)
    lower = seen()
    assert (lower[0] == bare[0]).all() and lower[1].min() > bare[1].min() + 10
    paint(plate, 255, first=3)
    assert seen()[0].min() > bare[0].min() + 10
    paint(plate, 1, 1, 1, 1)
    assert seen().max() < 60
    found = steps.view.pick(31.5, 31.0, BEFORE, size=(64, 64))
    assert (found.node, found.distance) == ("plate", pytest.approx(3.8, abs=1e-3))
    eye = virtualrobot.looking_at([0.0, -4.0, 0.0], [0.0, 0.0, 0.0])
    steps.scene.add_camera("eye", virtualrobot.camera(32, 32), pose=eye)
    color = steps.sensors["eye"].read().camera.color
    assert color is not None and color[16, 16].max() < 60
    rays = steps.rays.cast([0.0, -4.0, 0.0], [[0.0, 1.0, 0.0]])
    assert rays.distances[0] == pytest.approx(3.9, abs=1e-3)
    steps.scene["plate"].hide()
    assert steps.view.pick(31.5, 31.0, BEFORE, size=(64, 64)).node == ""


def test_it_is_no_part_of_the_history(plate: Stubs, steps: Client) -> None:
    """Nothing of it is a step; an undo leaves it, and one whose node is back is back with it."""
    before = [step.number for step in plate.history.ListSteps(history_pb2.ListStepsRequest()).steps]
    film = steps.view.add_coat("film", "plate", CORNERS, FACES, low=0.0, high=50.0)
    for thickness in (10.0, 20.0, 30.0):
        film.paint(np.full(4, thickness))
    assert [step.number for step in plate.history.ListSteps(history_pb2.ListStepsRequest()).steps] == before
    steps.scene["plate"].remove()
    assert steps.view.pick(31.5, 31.0, BEFORE, size=(64, 64)).node == ""
    steps.history.undo()
    assert steps.view.pick(31.5, 31.0, BEFORE, size=(64, 64)).distance == pytest.approx(3.8, abs=1e-3)


def test_quantities_become_bytes(plate: Stubs, steps: Client, stepped_kernel: KernelProcess) -> None:
    """The legend's ends are 1 and 255; what is beyond them counts as an end, and NaN is nothing."""
    film = steps.view.add_coat("film", "plate", CORNERS, FACES, low=10.0, high=20.0, unit="µm", title="Film")
    with virtualrobot.connect(stepped_kernel.address) as other:
        told = other.view.watch_coats()
        assert next(told)["film"].tolist() == [0, 0, 0, 0]
        film.paint([NAN, 5.0, 15.0, 25.0])
        assert next(told)["film"].tolist() == [0, 1, 128, 255]
        film.paint([NAN, 5.0, 15.0, 25.0])  # the same: nothing is sent
        film.paint([12.54, 10.0, 15.0, 20.0])
        assert next(told)["film"].tolist() == [66, 1, 128, 255]
        film.remove()
        assert next(told) == {}
    with pytest.raises(InvalidArgumentError, match="no colour map; there are viridis"):
        steps.view.add_coat("film", "plate", CORNERS, FACES, low=0.0, high=1.0, color_map="rainbow")
    with pytest.raises(UnknownNameError):
        film.paint([1.0, 2.0, 3.0, 4.0])
    with pytest.raises(InvalidArgumentError, match="has 4 corners"):
        film.paint([1.0, 2.0])


def test_all_coats_are_bounded(plate: Stubs) -> None:
    for number in range(100):
        set_coat(plate, coat(f"film {number}"))
    assert "101 coats; at most 100" in refusal(lambda: set_coat(plate, coat("one more"))).message
    set_coat(plate, coat("film 7", low=-1.0))
    names = {one.name for one in next(iter(plate.view.WatchCoats(view_pb2.WatchCoatsRequest()))).coats}
    assert len(names) == 100
    plate.view.RemoveCoats(view_pb2.RemoveCoatsRequest())
