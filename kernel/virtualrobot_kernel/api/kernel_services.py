"""Services of the kernel as the servicers reach them; `kernel.py` fills them in."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import ParamSpec, TypeVar

from virtualrobot_kernel.api.author import author
from virtualrobot_kernel.api.keyed_limiter import KeyedLimiter
from virtualrobot_kernel.api.lease_table import CARRIED, LeaseTable
from virtualrobot_kernel.api.limits import Limits
from virtualrobot_kernel.api.proposals import Proposals
from virtualrobot_kernel.api.publications import Publications
from virtualrobot_kernel.api.records import Records
from virtualrobot_kernel.api.shown_plans import ShownPlans
from virtualrobot_kernel.api.token_table import CALLER, TokenTable
from virtualrobot_kernel.collision.guard import CollisionGuard
from virtualrobot_kernel.collision.monitor import Monitor
from virtualrobot_kernel.collision.pool import ScenePool
from virtualrobot_kernel.collision.processes import Processes
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.importing import Importers
from virtualrobot_kernel.components.running import ComponentHandle
from virtualrobot_kernel.crafts.crafts import Crafts
from virtualrobot_kernel.drawing.renderer_pool import RendererPool
from virtualrobot_kernel.drawing.view import ViewStore
from virtualrobot_kernel.drivers.links import Links
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.history.history import History
from virtualrobot_kernel.history.player import Player
from virtualrobot_kernel.inputs.mailbox import Mailbox
from virtualrobot_kernel.physics.forces import Forces
from virtualrobot_kernel.planning.solvers import Solvers
from virtualrobot_kernel.sensing.casting import Casters
from virtualrobot_kernel.sensing.readers import SensingRoom
from virtualrobot_kernel.sensing.sensors import Sensors
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import Applied, Permit, World

P = ParamSpec("P")
Result = TypeVar("Result")

MAX_SENT_BYTES = 256 * 1024 * 1024
"""Greatest message that the server sends: pictures and clouds go in one piece. The client library takes as much."""


@dataclass(frozen=True, slots=True)
class KernelServices:
    """Parts of the kernel that the API opens. Long work goes to `workers` or `limiter`, never to the API's thread."""

    world: World
    mailbox: Mailbox
    publications: Publications
    assets: AssetStore
    meshes: MeshLibrary
    view: ViewStore
    workers: Executor
    limiter: KeyedLimiter
    catalog: Catalog
    solvers: Solvers
    sensing: SensingRoom
    casters: Casters
    sensors: Sensors
    collisions: ScenePool
    processes: Processes
    monitor: Monitor
    guard: CollisionGuard
    forces: Forces
    crafts: Crafts
    renderers: RendererPool
    history: History | Player
    importers: Importers
    leases: LeaseTable
    links: Links
    tokens: TokenTable
    plans: ShownPlans
    proposals: Proposals
    records: Records
    limits: Limits
    viewer_url: Callable[[], str]
    viewer_count: Callable[[], int]
    report: Callable[[Path, int], None]
    shut_down: Callable[[], None]

    async def in_worker(self, work: Callable[P, Result], *args: P.args, **named: P.kwargs) -> Result:
        """Return what `work` returns in a worker thread; the API's thread answers others meanwhile."""
        return await asyncio.get_running_loop().run_in_executor(self.workers, partial(work, *args, **named))

    async def with_component(
        self, component: ComponentHandle, work: Callable[P, Result], *args: P.args, **named: P.kwargs
    ) -> Result:
        """Return what `work` returns, which asks a component.

        At once where that runs in this process, and else in a worker thread, so that nobody waits for a late one.
        """
        if component.process_id:
            return await self.in_worker(work, *args, **named)
        return work(*args, **named)

    async def read(self, work: Callable[[Callable[[], None]], Result]) -> Result:
        """Return what `work` returns in a worker thread; what it is given raises when the call has ended meanwhile."""
        gone = threading.Event()

        def check() -> None:
            if gone.is_set():
                raise KernelError("nobody waits for this file any more", reason=Reason.SHUTTING_DOWN)

        try:
            return await self.in_worker(work, check)
        finally:
            gone.set()

    def submitting(self, context: object, *checks: Permit) -> Callable[..., Future[Applied]]:
        """Return what queues the commands of a client's call, from any thread: (commands, expected revision or None).

        Commands are refused when they touch robots that others have leased; an operator's also when nobody has, and
        where one of the `checks` raises.
        """
        # Asked for here and now: what a call carries is known to its own task only.
        who, permit = author(context), self.permit(*checks)

        def submit(commands: Sequence[Command], expected_revision: int | None = None) -> Future[Applied]:
            return self.world.submit(commands, who, expected_revision, permit)

        return submit

    def permit(self, *checks: Permit) -> Permit:
        """Return what lets those commands into the world that this task's call may give, where they pass the checks."""
        leased = self.leases.permit(CARRIED.get(), CALLER.get().moves_leased_only)

        def check(snapshot: Snapshot, commands: Sequence[Command]) -> None:
            self.limits.check_nodes(snapshot, commands)
            leased(snapshot, commands)
            for one in checks:
                one(snapshot, commands)

        return check

    def submit(
        self, commands: Sequence[Command], context: object, expected_revision: int | None = None
    ) -> Future[Applied]:
        """Queue commands of a client's call from its own task; see `submitting`."""
        return self.submitting(context)(commands, expected_revision)
