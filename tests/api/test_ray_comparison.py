"""RayService.CompareRayCasters: how components agree on a scene, what becomes of those that fail, and its end."""

from __future__ import annotations

import grpc
import psutil
import pytest
from virtualrobot.v1 import kernel_pb2, ray_pb2

from tests.api.asking import IIWA, apply, box, create, load, refusal
from tests.api.test_ray import ball
from tests.kernels import KernelProcess, StartKernel, Stubs
from tests.plugins.install import environment, install
from tests.waiting import until

pytestmark = pytest.mark.long

BUNDLED = ["embree", "bullet", "reference"]


@pytest.fixture(scope="module")
def kernel(start_kernel: StartKernel, tmp_path_factory: pytest.TempPathFactory) -> KernelProcess:
    """Return a kernel with ray casters that go wrong."""
    return start_kernel(environment=environment(install(tmp_path_factory.mktemp("site"), "wrong_casters")))


def compare(stubs: Stubs, *names: str, rays: int = 1000, seed: int = 0) -> list[ray_pb2.CompareRayCastersResponse]:
    request = ray_pb2.CompareRayCastersRequest(ray_casters=names, rays=rays, seed=seed)
    return list(stubs.ray.CompareRayCasters(request))


def found(stubs: Stubs, *names: str, rays: int = 1000, seed: int = 0) -> dict[str, ray_pb2.RayCasterComparison]:
    return {one.ray_caster: one for one in compare(stubs, *names, rays=rays, seed=seed)[-1].comparisons}


def test_the_bundled_ones_agree_on_an_arm(stubs: Stubs, seed: int) -> None:
    """Meshes alone: all three meet triangles. Where two links touch, rounding says which is hit."""
    load(stubs, IIWA, "arm")
    rows = found(stubs, *BUNDLED, rays=3000, seed=seed)
    assert list(rows) == BUNDLED
    for row in rows.values():
        assert row.fault == ""
        assert row.agreement > 0.998
        assert row.other_element < 0.01
        assert row.median_difference_meters < 1e-6
        assert row.first_cast_seconds > 0.0
        assert row.cast_seconds > 0.0
    assert (rows["embree"].agreement, rows["embree"].largest_difference_meters) == (1.0, 0.0)


def test_differences_are_measured(stubs: Stubs, seed: int) -> None:
    """A sphere of 1 m is cut off by its triangles by a known part: those who meet them are off, by millimeters."""
    apply(stubs, create(ball("a", 1.0)))
    rows = found(stubs, *BUNDLED, rays=4000, seed=seed)
    facets, exact = rows["reference"], rows["embree"]
    assert exact.agreement == 1.0
    assert 0.05 < facets.agreement < 0.95
    assert 1e-4 < facets.median_difference_meters < 1e-2
    assert facets.largest_difference_meters > facets.median_difference_meters
    assert rows["bullet"].agreement == pytest.approx(facets.agreement, abs=2e-3)


@pytest.mark.long
def test_equal_seeds_cast_equal_rays(stubs: Stubs, seed: int) -> None:
    apply(stubs, create(ball("a", 1.0)), create(box("b", 2.0)))
    one, same, other = (found(stubs, "embree", "reference", seed=s)["reference"] for s in (seed, seed, seed + 1))
    assert one.largest_difference_meters == same.largest_difference_meters
    assert one.largest_difference_meters != other.largest_difference_meters


@pytest.mark.long
def test_those_that_fail_are_rows_with_their_reason(stubs: Stubs) -> None:
    """The first that answers is what the others are compared with."""
    apply(stubs, create(box("a")))
    rows = found(stubs, "raises", "reference", "crashes", "wrong_shape", "hangs", "blind", "embree")
    assert {name for name, row in rows.items() if row.fault} == {"raises", "crashes", "wrong_shape", "hangs"}
    assert "KeyError: 'triangle 7'" in rows["raises"].fault
    assert "exit code 3" in rows["crashes"].fault
    assert "distance is float64 (1000, 1)" in rows["wrong_shape"].fault
    assert "no answer within 2 s" in rows["hangs"].fault
    assert rows["reference"].agreement == rows["embree"].agreement == 1.0
    # Who hits nothing agrees on the misses alone, and says another element, none, of each hit.
    assert 0.0 < rows["blind"].agreement < 0.9
    assert rows["blind"].other_element == pytest.approx(1.0 - rows["blind"].agreement)


def test_all_that_are_installed_are_compared_embree_first(stubs: Stubs) -> None:
    """Also in a scene without elements, where all rays miss."""
    rows = found(stubs, rays=100)
    assert next(iter(rows)) == "embree"
    assert {*BUNDLED, "blind", "slow"} < {*rows}
    assert {(row.agreement, row.other_element, row.fault) for row in rows.values()} == {(1.0, 0.0, "")}


def test_progress_grows_to_one_and_others_are_answered_meanwhile(stubs: Stubs) -> None:
    apply(stubs, create(box("a")))
    request = ray_pb2.CompareRayCastersRequest(ray_casters=["slow", "embree"], rays=100_000)
    seen, counts = [], []
    for response in stubs.ray.CompareRayCasters(request):
        seen.append(response.progress)
        counts.append(len(response.comparisons))
        stubs.kernel.GetInfo(kernel_pb2.GetInfoRequest())
    # 10 parts of 0.1 s, twice: told four times a second.
    assert len(seen) >= 6
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    assert any(0.0 < part < 0.5 for part in seen)
    assert (counts[0], counts[-1]) == (0, 2)


def test_a_cancelled_comparison_ends_its_component(stubs: Stubs, kernel: KernelProcess) -> None:
    apply(stubs, create(box("a")))
    process = psutil.Process(kernel.process.pid)
    before = {child.pid for child in process.children()}
    stream = stubs.ray.CompareRayCasters(ray_pb2.CompareRayCastersRequest(ray_casters=["slow"], rays=1_000_000))
    next(stream)
    until(lambda: bool({child.pid for child in process.children()} - before))
    stream.cancel()
    until(lambda: not {child.pid for child in process.children()} - before)


def test_what_makes_no_sense_is_refused(stubs: Stubs) -> None:
    refused = refusal(lambda: compare(stubs, rays=2_000_000))
    assert (refused.code, refused.metadata["limit"]) == (grpc.StatusCode.OUT_OF_RANGE, "1000000")
    assert "2000000 rays are too many; compare at most 1000000" in refused.message
    refused = refusal(lambda: compare(stubs, "embree", "refrence"))
    assert refused.reason == "UNKNOWN_NAME"
    assert "did you mean 'reference'" in refused.message
