"""Range sensors by the bundled components, against solids and motions whose distances are formulas."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.sensing.range_reader import RangeReader
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.commands import UpdateNode
from virtualrobot_kernel.world.figures import Box, Cylinder, Figure, Material, Sphere
from virtualrobot_kernel.world.sensing import Fan, FreeBeams, RangeSensor, Raster, Ring, Spinning
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

from tests.drawing.cell import Cell, at

TURN = np.array([[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""A quarter of a turn to the left."""


@pytest.fixture(scope="module")
def catalog() -> Catalog:
    return Catalog()


Make = Callable[..., RangeReader]


@pytest.fixture
def cell() -> Cell:
    return Cell()


@pytest.fixture
def make(cell: Cell, catalog: Catalog) -> Iterator[Make]:
    """Return what adds a sensor to the cell and gives its reader."""
    made: list[RangeReader] = []

    def reader(
        name: str = "sensor", parent: str = "world", pose: np.ndarray | None = None, **fields: object
    ) -> RangeReader:
        cell.add(name, parent=parent, pose=pose, kind=Kind.RANGE_SENSOR, data=RangeSensor(**fields))  # pyright: ignore[reportArgumentType]
        node = cell.snapshot.structure.node(name)
        made.append(RangeReader(node, catalog, ShapeLibrary(cell.meshes), {}))
        return made[-1]

    yield reader
    for one in made:
        one.close()


def moment(snapshot: Snapshot, *history: Snapshot, number: int = 1) -> Moment:
    return Moment(snapshot, history, number, np.random.default_rng((0, number)))


@pytest.mark.parametrize("caster", ["embree", "reference"])
def test_a_ring_inside_a_cylinder(cell: Cell, make: Make, caster: str) -> None:
    """From a circle of 0.2 m inside a pipe of 1 m all see 0.8 m at right angles; facets are nearer by 0.5%."""
    cell.add("pipe", Figure(Cylinder(1.0, 4.0), material=Material(reflectance=0.7)))
    reader = make(pattern=Ring(8, 0.2, 0.1, 5.0), ray_caster=caster, pose=at(0.0, 0.0, 0.3))
    said = reader.read(moment(cell.snapshot))
    assert said.distances.shape == (1, 8)
    np.testing.assert_allclose(said.distances, 0.8, rtol=1e-6 if caster == "embree" else 5e-3)
    np.testing.assert_allclose(said.intensities, 0.7, rtol=3e-3)
    assert said.ages is None


def test_a_raster_sees_a_wall_by_the_cosine(cell: Cell, make: Make) -> None:
    """A wall 3 m ahead: 3 / (cos azimuth cos elevation); points lie in it; intensity is that cosine (Lambert)."""
    cell.add("wall", Figure(Box((0.2, 20.0, 20.0))), pose=at(3.1, 0.0, 0.0))
    said = make(pattern=Raster(9, 7, 1.0, 0.8)).read(moment(cell.snapshot))
    azimuth, elevation = np.linspace(0.5, -0.5, 9), np.linspace(0.4, -0.4, 7)[:, None]
    cosine = np.cos(azimuth) * np.cos(elevation)
    np.testing.assert_allclose(said.distances, 3.0 / cosine, rtol=1e-6)
    np.testing.assert_allclose(said.intensities, 0.5 * cosine, rtol=1e-5)
    np.testing.assert_allclose(said.points(np.eye(4))[..., 0], 3.0, rtol=1e-6)
    np.testing.assert_allclose(said.points(TURN)[..., 1], 3.0, rtol=1e-6)
    assert said.element_names == ("wall",)
    assert not said.elements.any()


def test_it_does_not_see_itself_but_what_it_carries(cell: Cell, make: Make) -> None:
    cell.add("mount", Figure(Box((0.1, 0.1, 0.1))))
    reader = make(parent="mount", pose=at(0.2, 0.0, 0.0))
    cell.do()
    node = cell.snapshot.structure.node("sensor")
    cell.add("hood", Figure(Sphere(0.1)), parent="sensor", pose=at(1.0, 0.0, 0.0))
    said = reader.read(moment(cell.snapshot))
    assert node.kind is Kind.RANGE_SENSOR
    assert said.distances[0, 0] == pytest.approx(0.9)
    assert said.element_names[said.elements[0, 0]] == "hood"


def test_what_is_out_of_range_is_not_valid(cell: Cell, make: Make) -> None:
    cell.add("ball", Figure(Sphere(0.5)), pose=at(3.0, 0.0, 0.0))
    said = make("far", max_range_meters=2.4).read(moment(cell.snapshot))
    assert (said.distances[0, 0], said.valid[0, 0], said.elements[0, 0]) == (np.inf, 0, -1)
    assert np.isnan(said.points(np.eye(4))).all()
    said = make("near", min_range_meters=2.6).read(moment(cell.snapshot))
    assert said.valid[0, 0] == 0


def test_a_turning_head_bends_a_wall_as_it_moves(cell: Cell, make: Make) -> None:
    """Driving at 1 m/s towards a wall that is x0 away at the end: a column t before saw x0 + t, in whole ticks."""
    cell.add("wall", Figure(Box((0.2, 50.0, 50.0))), pose=at(5.1, 0.0, 0.0))
    columns, rate, tick = 100, 10.0, 0.004
    reader = make(
        pattern=Spinning(columns, (0.0, 0.1)), rate_hertz=rate, motion_distortion=True, max_range_meters=1000.0
    )
    assert reader.history_seconds == pytest.approx(0.1)
    worlds = []
    for i in range(26):
        cell.do(UpdateNode("sensor", parent_t_node=at(0.004 * i, 0.0, 0.0)))  # 4 mm a tick: 1 m/s
        worlds.append(replace(cell.snapshot, state=replace(cell.snapshot.state, tick=100 + i)))
    said = reader.read(moment(worlds[-1], *worlds[:-1]))
    assert said.ages is not None
    turn = (columns - 1 - np.arange(columns)) / columns / rate
    np.testing.assert_allclose(said.ages, np.ceil(turn / tick - 1e-9) * tick, atol=1e-6)
    azimuth = 2.0 * np.pi / columns * np.arange(columns) - np.pi
    ahead = np.abs(azimuth) < 1.3
    for row, elevation in enumerate((0.0, 0.1)):
        cosine = np.cos(azimuth[ahead]) * np.cos(elevation)
        np.testing.assert_allclose(said.distances[row, ahead], (4.9 + said.ages[ahead]) / cosine, rtol=1e-5)
    assert (said.elements[:, ahead] == 0).all()
    at_once = reader.read(moment(worlds[-1]))  # without a past all is as it is
    np.testing.assert_array_equal(at_once.ages, 0.0)
    assert at_once.distances[0, 50] == pytest.approx(4.9)


def test_what_came_within_a_turn_is_seen_by_the_later_columns_only(cell: Cell, make: Make) -> None:
    cell.add("wall", Figure(Cylinder(4.0, 2.0)))
    reader = make(pattern=Spinning(100, (0.0,)), rate_hertz=10.0, motion_distortion=True)
    before = [replace(cell.snapshot, state=replace(cell.snapshot.state, tick=i)) for i in range(13)]
    cell.add("pipe", Figure(Cylinder(1.0, 2.0)))
    after = [replace(cell.snapshot, state=replace(cell.snapshot.state, tick=i)) for i in range(13, 26)]
    said = reader.read(moment(after[-1], *before, *after[:-1]))
    names = np.array(said.element_names)[said.elements[0]]
    assert said.ages is not None
    early = said.ages > 12.5 * 0.004
    assert set(names[early]) == {"wall"} and set(names[~early]) == {"pipe"}
    np.testing.assert_allclose(said.distances[0], np.where(early, 4.0, 1.0), rtol=1e-6)


def test_free_beams_begin_where_they_are_said_to(cell: Cell, make: Make) -> None:
    cell.add("wall", Figure(Box((0.2, 20.0, 20.0))), pose=TURN @ at(3.1, 0.0, 0.0))
    origins = np.array([[0.5, 0.0, 0.0], [-0.5, 1.0, 0.0]])
    beams = FreeBeams(np.array([[3.0, 0.0, 0.0], [0.1, 0.0, 0.0]]), origins)
    said = make(pattern=beams, pose=TURN).read(moment(cell.snapshot))
    np.testing.assert_allclose(said.distances, [[2.5, 3.5]], rtol=1e-6)
    points = said.points(TURN)
    np.testing.assert_allclose(points[0], [[0.0, 3.0, 0.0], [-1.0, 3.0, 0.0]], atol=1e-6)


def test_a_beam_of_several_rays_counts_in_the_limit(cell: Cell, make: Make) -> None:
    settings = {"rays": 256, "divergence_radians": [0.01, 0.01]}
    fan = Fan(100_000, 0.0, 1.0)
    with pytest.raises(LimitError, match="25,600,000 rays a reading; at most 8,000,000"):
        make(pattern=fan, sensor_model="laser", sensor_model_settings=settings)


def test_noise_is_that_of_the_model_and_the_same_again(cell: Cell, make: Make) -> None:
    """The mean of n readings is off by less than 5 sigma / sqrt(n), their deviation within 5 sigma / sqrt(2 n)."""
    cell.add("wall", Figure(Sphere(3.0)))
    settings = {"deviation_meters": 0.02, "noise_limit": "none", "resolution_meters": 0.0}
    reader = make(pattern=Spinning(1000, (-0.1, 0.0, 0.1)), sensor_model="laser", sensor_model_settings=settings)
    first, again, other = (reader.read(moment(cell.snapshot, number=k)) for k in (1, 1, 2))
    np.testing.assert_array_equal(first.distances, again.distances)
    assert (first.distances != other.distances).mean() > 0.9
    n = first.distances.size
    error = first.distances.astype(float) - 3.0
    assert abs(error.mean()) < 5 * 0.02 / np.sqrt(n)
    assert abs(error.std() - 0.02) < 5 * 0.02 / np.sqrt(2 * n)


def test_components_that_are_not_there(make: Make) -> None:
    with pytest.raises(KernelError, match="did you mean 'embree'"):
        make(ray_caster="embre")
    with pytest.raises(KernelError, match="sensor_model component 'laser'"):
        make("other", sensor_model="laser", sensor_model_settings={"rays": 0})
