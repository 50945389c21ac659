"""Range sensors: one component finds what the rays hit, another makes a reading of it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from time import perf_counter
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.answers import checked_beam
from virtualrobot_sdk.errors import ComponentFault
from virtualrobot_sdk.rays import TrueHits
from virtualrobot_sdk.registration import ComponentKind

from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.running import ComponentHandle, start
from virtualrobot_kernel.errors import LimitError
from virtualrobot_kernel.numeric import scan
from virtualrobot_kernel.sensing import answers
from virtualrobot_kernel.sensing.elements import Elements, elements_of
from virtualrobot_kernel.sensing.patterns import beams_of, rays_of
from virtualrobot_kernel.sensing.range_content import RangeContent
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.sensing.settings import Presets, range_settings
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.sensing import RangeSensor
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node, Structure

MOST_RAYS = 8_000_000
"""The most rays of one reading, those of all beams together."""
OWN_SECONDS = 20.0
"""Longest time (s) of a reading beside its components' own deadlines, of which they may wait for a core."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]
Answer = TypeVar("Answer")


class RangeReader:
    """Makes the readings of one range sensor; owns its two components."""

    def __init__(self, node: Node, catalog: Catalog, shapes: ShapeLibrary, presets: Presets) -> None:
        """Start the components; raise KernelError for settings or components that cannot be."""
        assert isinstance(node.data, RangeSensor)
        self._settings = settings = range_settings(node.data, presets)
        self._uid, self._shapes = node.uid, shapes
        self._elements: Elements | None = None
        self._beams = beams = beams_of(settings.pattern)
        user = f" of the sensor {node.name!r}"
        with ExitStack() as begun:
            offer = catalog.find(ComponentKind.RAY_CASTER, settings.ray_caster)
            self.caster = start(offer, settings.ray_caster_settings, user=user)
            begun.callback(self.caster.close)
            offer = catalog.find(ComponentKind.SENSOR_MODEL, settings.sensor_model)
            self.model = start(offer, settings.sensor_model_settings, user=user)
            begun.callback(self.model.close)
            answer = self.model.call("beam")
            beam = _looked_at(self.model, lambda: checked_beam(answer))
            n, k = len(beams.directions), len(beam)
            if n * k > MOST_RAYS:
                raise LimitError(
                    f"{n:,} beams of {k} rays are {n * k:,} rays a reading; at most {MOST_RAYS:,} are cast", rays=n * k
                )
            begun.pop_all()
        self._k = k
        self._rays = rays_of(beams.directions, beam).reshape(*beams.shape, k, 3)
        # Where all begin at one place, it is (1, 1, 1, 3), and else as the rays.
        starts = beams.origins.reshape(*(beams.shape if len(beams.origins) > 1 else (1, 1)), 1, 3)
        self._origins = np.repeat(starts, k, axis=2) if starts.size > 3 else starts
        self._named: tuple[Structure, tuple[int, ...], tuple[str, ...]] | None = None
        self._last: tuple[Floats, Floats, Floats] | None = None
        self.cast_seconds = 0.0
        self.model_seconds = 0.0

    @property
    def ray_count(self) -> int:
        """Return how many rays a reading casts."""
        return self._rays.size // 3

    @property
    def history_seconds(self) -> float:
        """Return the length of a turn where columns are measured one after the other."""
        return 1.0 / self._settings.rate_hertz if self._settings.motion_distortion else 0.0

    @property
    def deadline_seconds(self) -> float:
        """Return how long a reading may take; each call of a component has a deadline of its own."""
        return OWN_SECONDS + self.caster.offer.about.deadline_seconds + self.model.offer.about.deadline_seconds

    @property
    def takes_turns(self) -> bool:
        """Return whether both components run in this process."""
        return self.caster.process_id == self.model.process_id == 0

    def read(self, moment: Moment, kinds: object | None = None) -> RangeContent:
        """Return what the sensor says; raise KernelError (PLUGIN_FAILED) where a component fails."""
        began = perf_counter()
        seen, node_of, uids, ages = (
            self._distorted(moment) if self._settings.motion_distortion else self._at_once(moment)
        )
        settings, k = self._settings, self._k
        hits = TrueHits(
            seen.distance.reshape(-1, k),
            seen.incidence.reshape(-1, k),
            seen.reflectance.reshape(-1, k),
            seen.element.reshape(-1, k),
            settings.min_range_meters,
            settings.max_range_meters,
        )
        cast = perf_counter()
        answer = self.model.call("apply", hits, moment.rng)
        told = _looked_at(self.model, lambda: answers.told(answer, hits.element, node_of))
        self.cast_seconds, self.model_seconds = cast - began, perf_counter() - cast
        shape = self._beams.shape
        return RangeContent(
            distances=told.distances.reshape(shape),
            valid=told.valid.reshape(shape),
            intensities=told.intensities.reshape(shape),
            elements=told.nodes.reshape(shape),
            element_names=self._names_of(moment.snapshot.structure, uids),
            beams=self._beams,
            ages=ages,
        )

    def close(self) -> None:
        """End both components."""
        self.caster.close()
        self.model.close()

    def _at_once(self, moment: Moment) -> tuple[answers.Seen, Integers, tuple[int, ...], None]:
        """Return what all rays hit in the world as it is."""
        seen, elements = self._cast(moment.snapshot, self._rays, self._origins)
        return seen, elements.node_of, elements.nodes, None

    def _distorted(self, moment: Moment) -> tuple[answers.Seen, Integers, tuple[int, ...], NDArray[np.float32]]:
        """Return what each column's rays hit in the world as it was when it was measured, and how long ago that was."""
        shape, now = (*self._beams.shape, self._k), moment.snapshot
        seen = answers.Seen(np.empty(shape), np.empty(shape, np.int32), np.empty(shape), np.empty(shape))
        ages = np.empty(shape[1], np.float32)
        tables: list[Integers] = []
        places: dict[int, int] = {}
        last: Elements | None = None
        count = base = 0
        for then, columns in self._turn(moment):
            starts = self._origins[:, columns] if self._origins.size > 3 else self._origins
            part, elements = self._cast(then, self._rays[:, columns], starts)
            if elements is not last:
                # Nodes came or went within the turn: the elements of both worlds stand side by side.
                last, base = elements, count
                count += len(elements.node_of)
                named = [places.setdefault(uid, len(places)) for uid in elements.nodes]
                tables.append(np.array(named, np.int32)[elements.node_of])
            into = (shape[0], columns.stop - columns.start, self._k)
            for name in ("distance", "incidence", "reflectance"):
                getattr(seen, name)[:, columns] = getattr(part, name).reshape(into)
            element = part.element.reshape(into)
            seen.element[:, columns] = np.where(element < 0, element, element + base)
            ages[columns] = (now.state.tick - then.state.tick) * now.tick_seconds
        return seen, np.concatenate(tables), tuple(places), ages

    def _turn(self, moment: Moment) -> Iterator[tuple[Snapshot, slice]]:
        """Yield the columns that were measured in each tick, in order, with the world as it was then."""
        now = moment.snapshot
        worlds = [*(one for one in moment.history if self._uid in one.structure.rows), now]
        ticks = np.array([one.state.tick for one in worlds])
        back = self._beams.before_end / (self._settings.rate_hertz * now.tick_seconds)
        # The last world at or before the instant; where the past does not reach back that far, the first.
        chosen = np.maximum(np.searchsorted(ticks, now.state.tick - back + 1e-9, side="right") - 1, 0)
        edges = [0, *(np.flatnonzero(np.diff(chosen)) + 1).tolist(), len(chosen)]
        for first, end in itertools.pairwise(edges):
            yield worlds[chosen[first]], slice(first, end)

    def _cast(self, snapshot: Snapshot, rays: Floats, starts: Floats) -> tuple[answers.Seen, Elements]:
        """Return what rays in the sensor's frame, directions and origins of shape (..., 3), hit in a world."""
        # All but the sensor's own figures.
        unseen = frozenset({self._uid})
        self._elements = elements = elements_of(snapshot, self._shapes, self._elements, unseen)
        origins, directions = self._placed(np.ascontiguousarray(snapshot.world_t(self._uid)), rays, starts)
        scene = elements.scene(snapshot.world_t_node)
        answer = self.caster.call("cast", scene, origins, directions, self._settings.max_range_meters)
        seen = _looked_at(self.caster, lambda: answers.seen(answer, scene, origins, directions, elements.reflectance))
        return seen, elements

    def _names_of(self, structure: Structure, uids: tuple[int, ...]) -> tuple[str, ...]:
        """Return the names of nodes, empty for one that is no more; those of before while the structure is the same."""
        if self._named is None or self._named[0] is not structure or self._named[1] != uids:
            nodes = structure.nodes
            self._named = structure, uids, tuple(nodes[uid].name if uid in nodes else "" for uid in uids)
        return self._named[2]

    def _placed(self, pose: Floats, rays: Floats, starts: Floats) -> tuple[Floats, Floats]:
        """Return origins and directions (n, 3) in the world; while the sensor stays where it is, those of before."""
        if rays is self._rays and self._last is not None and np.array_equal(self._last[0], pose):
            return self._last[1:]
        directions, origins = (np.empty((rays.size // 3, 3)) for _ in range(2))
        frames = (np.ascontiguousarray(one).reshape(-1, 3) for one in (starts, rays))
        scan.placed(pose, *frames, origins, directions)
        if rays is self._rays:
            # A component may be handed them again.
            for array in (origins, directions):
                array.setflags(write=False)
            self._last = pose, origins, directions
        return origins, directions


def _looked_at(running: ComponentHandle, look: Callable[[], Answer]) -> Answer:
    """Return what a look at a component's answer gives; nonsense is its fault, and it is not asked again."""
    try:
        return look()
    except ComponentFault as fault:
        raise running.failed(fault) from fault
