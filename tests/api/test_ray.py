"""RayService.CastRays: hits against formulas, in any frame, by each component; what is refused; what goes wrong."""

from __future__ import annotations

import math
import re

import grpc
import numpy as np
import pytest
from virtualrobot._wire.messages import array_message, array_of
from virtualrobot.v1 import geometry_pb2, nodes_pb2, plugin_pb2, plugin_pb2_grpc, ray_pb2, scene_pb2

from tests.api.asking import IIWA, apply, box, create, load, refusal
from tests.api.reading import scene
from tests.api.test_scene import update
from tests.kernels import EMPTY_SCENE, KernelProcess, StartKernel, Stubs
from tests.plugins.install import environment, install

FLANGE = "arm.lbr_iiwa_link_7"
BUNDLED = ("embree", "reference", "bullet")
INVALID, LIMIT = (
    ("INVALID_ARGUMENT", grpc.StatusCode.INVALID_ARGUMENT),
    ("LIMIT_EXCEEDED", grpc.StatusCode.OUT_OF_RANGE),
)


@pytest.fixture(scope="module")
def kernel(start_kernel: StartKernel, tmp_path_factory: pytest.TempPathFactory) -> KernelProcess:
    """Return a kernel with ray casters that go wrong."""
    return start_kernel(environment=environment(install(tmp_path_factory.mktemp("site"), "wrong_casters")))


def request(origins: object, directions: object, **fields: object) -> ray_pb2.CastRaysRequest:
    return ray_pb2.CastRaysRequest(
        origins=array_message(np.atleast_2d(np.array(origins, float))),
        directions=array_message(np.array(directions, float)),
        **fields,  # pyright: ignore[reportArgumentType]
    )


class Hits:
    """An answer as arrays."""

    def __init__(self, response: ray_pb2.CastRaysResponse) -> None:
        """Take the arrays of a message."""
        self.distances, self.normals = array_of(response.distances), array_of(response.normals)
        names = [*response.element_names, ""]
        self.nodes = [names[place] for place in array_of(response.elements).tolist()]
        self.response = response


def cast(stubs: Stubs, origins: object, directions: object, **fields: object) -> Hits:
    return Hits(stubs.ray.CastRays(request(origins, directions, **fields)))


def ball(name: str, radius: float, x: float = 0.0, hidden: bool = False) -> nodes_pb2.Node:
    return nodes_pb2.Node(
        name=name,
        hidden=hidden,
        part=nodes_pb2.Part(),
        parent_t_node=geometry_pb2.Pose(position=geometry_pb2.Vector3(x=x)),
        figures=[nodes_pb2.Figure(sphere=nodes_pb2.Sphere(radius_meters=radius))],
    )


@pytest.mark.parametrize("component", BUNDLED)
def test_boxes_are_met_where_their_faces_are(stubs: Stubs, component: str, rng: np.random.Generator) -> None:
    """A cube of 10 cm from 1 m above: rays of any length, slanted, and past it."""
    apply(stubs, create(box("a")), create(box("b", z=-0.5)))
    aims = np.column_stack([rng.uniform(-0.049, 0.049, (50, 2)), np.full(50, 0.05)])
    origins = np.array([0.0, 0.0, 1.05]) + rng.uniform(-0.01, 0.01, (50, 3))
    lengths = rng.uniform(1e-6, 1e6, (50, 1))
    found = cast(stubs, origins, lengths * (aims - origins), ray_caster=component)
    np.testing.assert_allclose(found.distances, np.linalg.norm(aims - origins, axis=1), atol=1e-6)
    assert found.nodes == ["a"] * 50
    np.testing.assert_allclose(found.normals, np.tile([0.0, 0.0, 1.0], (50, 1)), atol=1e-6)
    beside = cast(stubs, [0.2, 0.0, 1.0], [[0.0, 0.0, -1.0], [-0.2, 0.0, -1.45]], ray_caster=component)
    assert beside.nodes == ["", "b"]
    assert beside.distances.tolist() == [math.inf, pytest.approx(math.hypot(0.2, 1.45), abs=1e-6)]
    assert beside.normals[0].tolist() == [0.0, 0.0, 0.0]


def test_a_range_ends_the_rays_and_hidden_nodes_are_not_met(stubs: Stubs) -> None:
    apply(stubs, create(ball("a", 0.5, 2.0)), create(ball("b", 0.4, 1.0, hidden=True)))
    ways = [[1.0, 0.0, 0.0]]
    assert cast(stubs, [0.0, 0.0, 0.0], ways).distances.tolist() == [pytest.approx(1.5, abs=1e-6)]
    assert cast(stubs, [0.0, 0.0, 0.0], ways, max_range_meters=1.4).nodes == [""]
    assert cast(stubs, [0.0, 0.0, 0.0], ways, max_range_meters=1.6).nodes == ["a"]
    apply(stubs, update("b", "hidden", hidden=False))
    assert cast(stubs, [0.0, 0.0, 0.0], ways).nodes == ["b"]


@pytest.mark.parametrize("component", BUNDLED)
def test_rays_pass_through_what_is_ignored_and_all_below_it(stubs: Stubs, component: str) -> None:
    """A foot hides nothing of the ground whose top is at 0, though a box hangs on it; nor a box whose top is at 0.5."""
    apply(stubs, create(box("ground", z=-0.05)), create(ball("foot", 0.05)), create(box("other", x=1.0, z=0.45)))
    child = box("child", z=0.5)
    child.parent = "foot"
    apply(stubs, create(child))
    down, origins = [[0.0, 0.0, -1.0]] * 2, [[0.0, 0.0, 2.0], [1.0, 0.0, 2.0]]
    assert cast(stubs, origins, down, ray_caster=component).nodes == ["child", "other"]
    found = cast(stubs, origins, down, ray_caster=component, ignored=["foot"])
    assert found.nodes == ["ground", "other"]
    np.testing.assert_allclose(found.distances, [2.0, 1.5], atol=1e-6)
    assert cast(stubs, origins, down, ray_caster=component, ignored=["world"]).nodes == ["", ""]


def test_spheres_are_met_as_they_are_meant(stubs: Stubs, rng: np.random.Generator) -> None:
    """To 1e-6 of the range, where the roots of the quadratic equation are; triangles would be off by 1e-3."""
    apply(stubs, create(ball("a", 0.5)))
    origins = rng.normal(size=(200, 3))
    origins *= 3.0 / np.linalg.norm(origins, axis=1, keepdims=True)
    aims = rng.uniform(-0.25, 0.25, (200, 3))
    ways = (aims - origins) / np.linalg.norm(aims - origins, axis=1, keepdims=True)
    along = -(origins * ways).sum(axis=1)
    true = along - np.sqrt(along**2 - 9.0 + 0.25)
    found = cast(stubs, origins, ways)
    np.testing.assert_allclose(found.distances, true, atol=3e-6)
    np.testing.assert_allclose(found.normals, (origins + true[:, None] * ways) / 0.5, atol=1e-5)


def test_rays_in_the_frame_of_a_link_go_with_it(stepped: Stubs, rng: np.random.Generator) -> None:
    load(stepped, IIWA, "arm")
    x, y = rng.uniform(-0.5, 0.5, 2).tolist()
    apply(stepped, create(box("a", x, y, 1.6)), create(ball("b", 0.3, 1.0)))
    world_t_flange = scene(stepped, FLANGE)[FLANGE]
    ways = rng.normal(size=(300, 3))
    here = cast(stepped, [0.0, 0.0, 0.1], ways, frame=FLANGE)
    start = world_t_flange @ [0.0, 0.0, 0.1, 1.0]
    there = cast(stepped, [start[:3]], ways @ world_t_flange[:3, :3].T)
    assert {*here.nodes} > {""}
    assert here.nodes == there.nodes
    np.testing.assert_allclose(here.distances, there.distances, atol=1e-6)
    np.testing.assert_allclose(here.normals @ world_t_flange[:3, :3].T, there.normals, atol=1e-5)


@pytest.mark.parametrize("component", BUNDLED)
def test_what_moved_is_met_where_it_is_now(stubs: Stubs, component: str) -> None:
    """Shapes that a worker keeps are sent once; poses, and shapes that are new, each time."""
    apply(stubs, create(box("a", 1.0)))
    ways = [[1.0, 0.0, 0.0]]
    assert cast(stubs, [0.0, 0.0, 0.0], ways, ray_caster=component).distances[0] == pytest.approx(0.95, abs=1e-6)
    apply(stubs, update("a", "parent_t_node", parent_t_node=box("a", 2.0).parent_t_node))
    assert cast(stubs, [0.0, 0.0, 0.0], ways, ray_caster=component).distances[0] == pytest.approx(1.95, abs=1e-6)
    larger = box("a", 2.0)
    larger.figures[0].box.size.x = 1.0
    applied = apply(stubs, update("a", "figures", figures=larger.figures))
    found = cast(stubs, [0.0, 0.0, 0.0], ways, ray_caster=component)
    assert found.distances[0] == pytest.approx(1.5, abs=1e-6)
    assert found.response.stamp.structure_revision == applied.stamp.structure_revision


def test_no_rays_are_answered_too(stubs: Stubs) -> None:
    found = cast(stubs, np.zeros((1, 3)), np.zeros((0, 3)))
    assert (found.distances.shape, found.normals.shape, found.nodes) == ((0,), (0, 3), [])


GOOD = [[0.0, 0.0, 1.0]] * 3
BAD = {
    "zero direction": (request([0, 0, 0], [*GOOD[:2], [0, 0, 0]]), INVALID, r"directions has .* in row 2; .* but zero"),
    "NaN": (request([0, 0, 0], [GOOD[0], [0, math.nan, 0]]), INVALID, r"directions .* not finite: nan in row 1"),
    "infinite origin": (request([[0, 0, math.inf]], GOOD), INVALID, r"origins .* not finite: inf in row 0"),
    "far origin": (request([[0, 0, 0], [0, 1e13, 0], [0, 0, 0]], GOOD), INVALID, r"origins .* row 1; .* within 1e\+12"),
    "two origins": (request([[0, 0, 0]] * 2, GOOD), INVALID, "origins are 2 and directions 3"),
    "flat": (request([0, 0, 0], [[0, 1], [1, 0]]), INVALID, r"directions must have the shape \(n, 3\), not \(2, 2\)"),
    "nothing": (ray_pb2.CastRaysRequest(), INVALID, "directions.type must say"),
    "negative range": (request([0, 0, 0], GOOD, max_range_meters=-1.0), INVALID, "max_range_meters must be 0 or above"),
    "NaN range": (request([0, 0, 0], GOOD, max_range_meters=math.nan), INVALID, "max_range_meters must be a finite"),
    "too many": (
        ray_pb2.CastRaysRequest(
            origins=array_message([[0.0, 0.0, 0.0]]),
            directions=geometry_pb2.NumericArray(type=geometry_pb2.NUMERIC_TYPE_FLOAT64, shape=[10**9, 3]),
        ),
        LIMIT,
        "1000000000 rays are too many for a call; cast at most 300000",
    ),
    "no node": (
        request([0, 0, 0], GOOD, frame="arm"),
        ("UNKNOWN_NAME", grpc.StatusCode.NOT_FOUND),
        "no node named 'arm'",
    ),
    "nobody to ignore": (
        request([0, 0, 0], GOOD, ignored=["arm"]),
        ("UNKNOWN_NAME", grpc.StatusCode.NOT_FOUND),
        "no node named 'arm'",
    ),
    "no component": (
        request([0, 0, 0], GOOD, ray_caster="embre"),
        ("UNKNOWN_NAME", grpc.StatusCode.NOT_FOUND),
        "no ray_caster component named 'embre'; did you mean 'embree'",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_makes_no_sense_is_refused(stubs: Stubs, case: str) -> None:
    bad, (reason, code), said = BAD[case]
    refused = refusal(lambda: stubs.ray.CastRays(bad))
    assert (refused.reason, refused.code) == (reason, code), refused
    assert re.search(said, refused.message), refused.message


WRONG = {
    "raises": (r"KeyError: 'triangle 7'", "RAISED"),
    "hangs": (r"cast gave no answer within 2 s", "HUNG"),
    "crashes": (r"its process ended with exit code 3 in cast", "DIED"),
    "wrong_shape": (r"distance is float64 \(3, 1\); it must be an array of float64 \(3,\)", "NONSENSE"),
}


@pytest.mark.parametrize("component", WRONG)
def test_a_component_that_goes_wrong_costs_one_call(stubs: Stubs, component: str) -> None:
    """It is told in ListPlugins, and made anew for the next call."""
    assert cast(stubs, [0.0, 0.0, 0.0], GOOD, ray_caster=component).nodes == ["", "", ""]
    apply(stubs, create(box("a", z=1.0)))
    refused = refusal(lambda: cast(stubs, [0.0, 0.0, 0.0], GOOD, ray_caster=component))
    said, kind = WRONG[component]
    assert (refused.reason, refused.metadata["fault"]) == ("PLUGIN_FAILED", kind)
    assert re.search(said, refused.message), refused.message
    listed = ray_casters(stubs)
    assert re.search(said, listed[component].uses[0].fault)
    assert cast(stubs, [0.0, 0.0, 0.0], GOOD).nodes == ["a"] * 3
    stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
    assert cast(stubs, [0.0, 0.0, 0.0], GOOD, ray_caster=component).nodes == ["", "", ""]
    assert ray_casters(stubs)[component].uses[0].fault == ""


def ray_casters(stubs: Stubs) -> dict[str, plugin_pb2.Component]:
    """Return what ListPlugins tells of the ray casters, by name."""
    plugins = plugin_pb2_grpc.PluginServiceStub(stubs.channel).ListPlugins(plugin_pb2.ListPluginsRequest()).plugins
    every = [one for plugin in plugins for one in plugin.components]
    return {one.name: one for one in every if one.kind == plugin_pb2.COMPONENT_KIND_RAY_CASTER}
