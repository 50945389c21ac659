"""RayService: a client's own rays, and random ones by several components."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

from virtualrobot.v1 import ray_pb2, ray_pb2_grpc
from virtualrobot_sdk.rays import Hits, RayScene
from virtualrobot_sdk.registration import ComponentKind

from virtualrobot_kernel.api.convert.rays import COMPARISON, cast_message, check_count, rays
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.keyed_limiter import IsGone
from virtualrobot_kernel.components.catalog import Offer
from virtualrobot_kernel.errors import LimitError
from virtualrobot_kernel.messages.values import stamp
from virtualrobot_kernel.sensing.compare import Comparison, Floats, compared, random_rays
from virtualrobot_kernel.sensing.elements import without
from virtualrobot_kernel.sensing.settings import DEFAULT_RAY_CASTER

COMPARED_RAYS = 10_000
"""Number of rays compared where a client does not say."""
MOST_COMPARED_RAYS = 1_000_000


class RayServicer(ray_pb2_grpc.RayServiceServicer):
    """Servicer of RayService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel

    async def CastRays(self, request: ray_pb2.CastRaysRequest, context: object) -> ray_pb2.CastRaysResponse:
        """Cast a client's rays, in a worker thread, on the snapshot of that moment."""
        check_count(request)
        kernel, name = self._kernel, request.ray_caster or DEFAULT_RAY_CASTER
        kernel.catalog.find(ComponentKind.RAY_CASTER, name)

        def work(is_gone: IsGone) -> ray_pb2.CastRaysResponse:
            snapshot = kernel.world.snapshot
            structure = snapshot.structure
            world_t_frame = snapshot.world_t_node[structure.rows[structure.node(request.frame).uid]]
            given = rays(request, world_t_frame)
            ignored = {node.uid for of in request.ignored for node in structure.below(structure.node(of).uid)}
            elements = without(kernel.casters.elements(snapshot), ignored)
            scene = elements.scene(snapshot.world_t_node)
            cast = kernel.casters.cast(
                name, scene, given.origins, given.directions, given.max_range, lambda _: not is_gone()
            )
            return cast_message(cast, elements, snapshot, world_t_frame)

        return await kernel.limiter.run_while_wanted([name], work)

    async def CompareRayCasters(
        self, request: ray_pb2.CompareRayCastersRequest, context: object
    ) -> AsyncIterator[ray_pb2.CompareRayCastersResponse]:
        """Cast the same random rays by one component after the other, each made for this; tell each when it is done."""
        if request.rays > MOST_COMPARED_RAYS:
            raise LimitError(
                f"{request.rays} rays are too many; compare at most {MOST_COMPARED_RAYS}",
                rays=request.rays,
                limit=MOST_COMPARED_RAYS,
            )
        kernel, offers = self._kernel, self._offers(list(request.ray_casters))
        snapshot = kernel.world.snapshot
        elements = await kernel.in_worker(kernel.casters.elements, snapshot)
        scene = elements.scene(snapshot.world_t_node)
        drawn = await kernel.in_worker(random_rays, scene, request.rays or COMPARED_RAYS, request.seed)
        answer = ray_pb2.CompareRayCastersResponse(stamp=stamp(snapshot))
        first: Hits | None = None
        for place, offer in enumerate(offers):
            done = [0.0]
            task = self._begin(offer, scene, drawn, first, done)
            try:
                while not await kernel.publications.is_done(task):
                    answer.progress = (place + done[0]) / len(offers)
                    yield answer
                comparison, hits = task.result()
            finally:
                task.cancel()
            first = hits if first is None else first
            answer.comparisons.append(COMPARISON.write(comparison))
            answer.progress = (place + 1) / len(offers)
            yield answer

    def _begin(
        self, offer: Offer, scene: RayScene, drawn: tuple[Floats, Floats], first: Hits | None, done: list[float]
    ) -> asyncio.Future[tuple[Comparison, Hits | None]]:
        """Return a task that compares a component, and keeps in `done` which part of that is done."""

        def work(is_gone: IsGone) -> tuple[Comparison, Hits | None]:
            def told(part: float) -> bool:
                done[0] = part
                return not is_gone()

            return compared(offer, scene, *drawn, first, told)

        return asyncio.ensure_future(self._kernel.limiter.run_while_wanted([offer.about.name], work))

    def _offers(self, names: list[str]) -> list[Offer]:
        """Return the components of these names; of no names all of them, the default one first."""
        catalog, kind = self._kernel.catalog, ComponentKind.RAY_CASTER
        if not names:
            names = sorted(catalog.offers(kind), key=lambda name: (name != DEFAULT_RAY_CASTER, name))
        return [catalog.find(kind, name) for name in names]
