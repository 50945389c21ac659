"""Ray casters that calls ask: rays in parts, each component one thread at a time, made anew after a fault."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import EntryPoint
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.components.catalog import Offer
from virtualrobot_kernel.components.running import start
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.sensing.casting import RAYS_AT_ONCE, Casters, cast_rays
from virtualrobot_kernel.sensing.compare import EQUAL_METERS, compared, differences, random_rays
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.rays import NO_ELEMENT, Hits, RayScene, make_shape
from virtualrobot_sdk.registration import ComponentKind, Isolation, Registration
from virtualrobot_sdk.testing.ray_truth import box, random_scene
from virtualrobot_sdk.worker.description import describe

NOTHING = RayScene((), np.zeros((0, 4, 4)))
BOX = RayScene((box(np.ones(3)),), np.eye(4)[None])


class Counting:
    """Hits a wall at the distance that the ray's number is: its origin's x."""

    made = 0

    def __init__(self) -> None:
        """Count who was made."""
        Counting.made += 1
        self.sizes: list[int] = []

    def cast(self, scene: RayScene, origins: np.ndarray, directions: np.ndarray, max_range: float, /) -> Hits:
        """Return hits, and spoil what was given."""
        n = len(origins)
        self.sizes.append(n)
        distance = origins[:, 0] + 1.0
        normal = -directions
        answer = Hits(distance, np.zeros(n, np.int32), normal)
        origins[:], directions[:] = np.nan, np.nan
        return answer


def offer_of(factory: Callable[[], object], name: str = "tried") -> Offer:
    """Return what a plugin of this process would offer."""
    one = Registration(ComponentKind.RAY_CASTER, name, factory, isolation=Isolation.IN_PROCESS)
    (about,) = describe("1.0", [one]).components
    return Offer(EntryPoint(name, "tests.unit.sensing.test_casting", ""), about, lambda: one)


def along_x(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return rays whose origins' x is their number."""
    return np.column_stack([np.arange(count), np.zeros((count, 2))]).astype(float), np.tile([1.0, 0.0, 0.0], (count, 1))


def casters_of(*offers: Offer) -> tuple[Casters, dict[str, Offer]]:
    """Return casters, and the catalog that they find components in."""
    known = {offer.about.name: offer for offer in offers}
    room: Any = SimpleNamespace(catalog=SimpleNamespace(find=lambda kind, name: known[name]))
    return Casters(room), known


def test_rays_go_in_parts_and_come_back_in_order() -> None:
    """The component may write into what it gets: it gets copies."""
    running = start(offer_of(Counting), {})
    count = 2 * RAYS_AT_ONCE + 7
    origins, directions = along_x(count)
    done: list[int] = []
    cast = cast_rays(running, BOX, origins, directions, np.inf, lambda part: not done.append(part))
    np.testing.assert_array_equal(cast.hits.distance, np.arange(count) + 1.0)
    np.testing.assert_array_equal(cast.hits.normal, -directions)
    assert done == [RAYS_AT_ONCE, 2 * RAYS_AT_ONCE, count]
    assert running.calls == 3
    one = cast_rays(running, BOX, np.array([[5.0, 0.0, 0.0]]), directions, np.inf, lambda part: True)
    assert set(one.hits.distance) == {6.0}


def test_who_gives_up_waits_for_one_part() -> None:
    running = start(offer_of(Counting), {})
    with pytest.raises(KernelError, match="nobody waits"):
        cast_rays(running, BOX, *along_x(5 * RAYS_AT_ONCE), np.inf, lambda part: part < 2 * RAYS_AT_ONCE)
    assert (running.calls, running.fault) == (2, None)


class Wrong(Counting):
    """Tells an element that is not there, of the ray 3."""

    def cast(self, scene: RayScene, origins: np.ndarray, directions: np.ndarray, max_range: float, /) -> Hits:
        """Return hits."""
        hits = super().cast(scene, origins, directions, max_range)
        hits.element[3] = len(scene.shapes)
        return hits


class Refusing(Counting):
    """Refuses all rays."""

    def cast(self, scene: RayScene, origins: np.ndarray, directions: np.ndarray, max_range: float, /) -> Hits:
        """Refuse."""
        raise ArgumentError("it is too dark")


def test_nonsense_is_a_fault_with_the_ray_and_a_refusal_is_none() -> None:
    running = start(offer_of(Wrong), {})
    with pytest.raises(KernelError, match=r"the ray from \[3, 0, 0\] along \[1, 0, 0\] gives an element") as failed:
        cast_rays(running, BOX, *along_x(5), np.inf, lambda part: True)
    assert failed.value.reason is Reason.PLUGIN_FAILED
    assert running.latest is not None
    refusing = start(offer_of(Refusing), {})
    with pytest.raises(KernelError, match="it is too dark") as refused:
        cast_rays(refusing, BOX, *along_x(5), np.inf, lambda part: True)
    assert refused.value.reason is Reason.INVALID_ARGUMENT
    assert refusing.fault is None


def test_a_caster_is_kept_until_a_fault_or_another_offer() -> None:
    casters, known = casters_of(offer_of(Counting, "good"), offer_of(Wrong, "wrong"))

    def ask(name: str, scene: RayScene = BOX) -> int:
        before = Counting.made
        casters.cast(name, scene, *along_x(2 if name == "good" else 5), np.inf, lambda part: True)
        return Counting.made - before

    assert [ask("good"), ask("good")] == [1, 0]
    known["good"] = offer_of(Counting, "good")
    assert [ask("good"), ask("good")] == [1, 0]
    for _ in range(2):
        before = Counting.made
        with pytest.raises(KernelError, match="an element that is not there"):
            ask("wrong")
        assert Counting.made == before + 1
    assert [running.latest is None for running in casters.uses()] == [True, False]
    casters.close()
    assert casters.uses() == ()
    with pytest.raises(KernelError) as ended:
        ask("good")
    assert ended.value.reason is Reason.SHUTTING_DOWN


def test_one_thread_at_a_time_asks_a_caster() -> None:
    inside, most = [0], [0]
    lock = threading.Lock()

    class Lonely(Counting):
        def cast(self, scene: RayScene, origins: np.ndarray, directions: np.ndarray, max_range: float, /) -> Hits:
            with lock:
                inside[0] += 1
                most[0] = max(most[0], inside[0])
            threading.Event().wait(0.002)
            with lock:
                inside[0] -= 1
            return super().cast(scene, origins, directions, max_range)

    casters, _ = casters_of(offer_of(Lonely))
    with ThreadPoolExecutor(8) as pool:
        answers = pool.map(
            lambda n: casters.cast("tried", BOX, *along_x(n), np.inf, lambda part: True).hits.distance.sum(),
            range(1, 33),
        )
    assert list(answers) == [n * (n + 1) / 2 for n in range(1, 33)]
    assert most[0] == 1


def hits(distance: list[float], element: list[int]) -> Hits:
    return Hits(np.array(distance), np.array(element, np.int32), np.zeros((len(distance), 3)))


def test_differences_of_two_answers() -> None:
    inf = np.inf
    first = hits([1.0, 2.0, 3.0, inf, inf, 4.0], [0, 0, 1, NO_ELEMENT, NO_ELEMENT, 2])
    other = hits([1.0, 2.0 + 0.9 * EQUAL_METERS, 3.5, inf, 7.0, inf], [0, 1, 1, NO_ELEMENT, 3, NO_ELEMENT])
    # The same: rays 0 and 1, and 3, which both miss. Both hit something: 0, 1 and 2.
    agreement, other_element, median, largest = differences(other, first)
    assert (agreement, other_element) == (0.5, 0.5)
    assert (median, largest) == (pytest.approx(0.9 * EQUAL_METERS), 0.5)
    assert differences(first, first) == (1.0, 0.0, 0.0, 0.0)
    assert differences(hits([], []), hits([], [])) == (1.0, 0.0, 0.0, 0.0)
    assert differences(hits([inf], [-1]), hits([inf], [-1])) == (1.0, 0.0, 0.0, 0.0)


def test_random_rays_go_through_the_scene(rng: np.random.Generator, seed: int) -> None:
    """Two thirds pass a vertex within a few times 2 cm; origins are in the scene or a little beside it."""
    scene = random_scene(rng, 6)
    origins, directions = random_rays(scene, 900, seed)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, atol=1e-12)
    points = np.concatenate(
        [
            shape.vertices @ pose[:3, :3].T + pose[:3, 3]
            for shape, pose in zip(scene.shapes, scene.world_t_element, strict=True)
        ]
    )
    low, high = points.min(axis=0), points.max(axis=0)
    room = np.maximum(0.2 * (high - low), 0.2)
    assert (origins > low - room).all()
    assert (origins < high + room).all()
    offsets = points[None] - origins[:600, None]
    along = np.einsum("rpi,ri->rp", offsets, directions[:600])
    # A ray that begins at a vertex may go away from it.
    beside = np.linalg.norm(offsets - np.maximum(along, 0.0)[..., None] * directions[:600, None], axis=2)
    assert (beside.min(axis=1) < 0.15).all()
    again, _ = random_rays(scene, 900, seed)
    np.testing.assert_array_equal(again, origins)


def test_random_rays_of_scenes_without_anything() -> None:
    empty = make_shape(np.zeros((0, 3)), np.zeros((0, 3)))
    for scene in (NOTHING, RayScene((empty,), np.eye(4)[None])):
        origins, directions = random_rays(scene, 10, 0)
        assert np.abs(origins).max() <= 0.2
        np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, atol=1e-12)


def test_who_cannot_be_made_is_a_row_and_who_gives_up_gets_none() -> None:
    def fails() -> None:
        raise ArgumentError("no licence")

    rays = along_x(20)
    row, found = compared(offer_of(fails), BOX, *rays, None, lambda part: True)  # pyright: ignore[reportArgumentType]
    assert (row.ray_caster, found) == ("tried", None)
    assert "no licence" in row.fault
    parts: list[float] = []
    row, found = compared(offer_of(Counting), BOX, *rays, None, lambda part: not parts.append(part))
    assert (row.fault, row.agreement, parts) == ("", 1.0, [0.5, 1.0])
    assert found is not None
    with pytest.raises(KernelError, match="nobody waits"):
        compared(offer_of(Counting), BOX, *rays, None, lambda part: False)
