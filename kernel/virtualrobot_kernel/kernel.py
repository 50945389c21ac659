"""Composition root: it alone knows every room of the house, builds them and joins them."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from virtualrobot_sdk.worker import close_all

from virtualrobot_kernel.api.convert.presets import presets
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.keyed_limiter import KeyedLimiter
from virtualrobot_kernel.api.lease_table import LeaseTable
from virtualrobot_kernel.api.limits import Limits
from virtualrobot_kernel.api.proposals import Proposals
from virtualrobot_kernel.api.publications import Publications
from virtualrobot_kernel.api.records import Records
from virtualrobot_kernel.api.server import Address, Server
from virtualrobot_kernel.api.shown_plans import ShownPlans
from virtualrobot_kernel.api.token_table import TokenTable
from virtualrobot_kernel.collision.clearances import measured
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.guard import CollisionGuard
from virtualrobot_kernel.collision.monitor import Monitor
from virtualrobot_kernel.collision.pool import ScenePool
from virtualrobot_kernel.collision.processes import Processes
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.importing import Importers
from virtualrobot_kernel.crafts.crafts import Crafts
from virtualrobot_kernel.drawing.additions import with_arrows
from virtualrobot_kernel.drawing.renderer_pool import RendererPool
from virtualrobot_kernel.drawing.twin_ghosts import twin_ghosts
from virtualrobot_kernel.drawing.view import ViewStore
from virtualrobot_kernel.drivers.links import Links
from virtualrobot_kernel.drivers.site import DriverSite
from virtualrobot_kernel.embedded import scene_commands
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.mesh_cache import MeshCache
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.history.folder import ASSETS, IN_MEMORY_SEED, Folder, Project, versions
from virtualrobot_kernel.history.history import History
from virtualrobot_kernel.history.past import PastFolder
from virtualrobot_kernel.history.player import Player
from virtualrobot_kernel.history.upkeep import Rules
from virtualrobot_kernel.inputs.mailbox import Mailbox
from virtualrobot_kernel.physics.forces import Forces
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.planning.solvers import Solvers
from virtualrobot_kernel.report import Reported, write_report
from virtualrobot_kernel.scenes.assets import check_assets
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary
from virtualrobot_kernel.sensing.casting import Casters
from virtualrobot_kernel.sensing.choices import check_choices
from virtualrobot_kernel.sensing.readers import SensingRoom
from virtualrobot_kernel.sensing.sensors import Sensors
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.history_commands import RestartWorld
from virtualrobot_kernel.world.past_world import PastWorld
from virtualrobot_kernel.world.store import World

if TYPE_CHECKING:
    from virtualrobot_kernel.drawing.viewer import Viewer

log = logging.getLogger(__name__)

WORKERS = 8
"""Number of threads for reading and writing files; many, since some wait for an importer in another process."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of a kernel.

    Attributes:
        address: where it listens.
        mode: how its time runs.
        tick_nanoseconds: the length of a tick, that of the folder where there is one.
        viewer_port: the first port that its viewer tries.
        tokens_file: the file of the tokens with roles; None: they are kept in memory, until the kernel ends.
        folder: where its world and its history are kept; None: they end with it. It closes the folder.
        rules: how much of the history is kept; None: the usual.
        power: whether what is answered survives a loss of power, and not only the end of the process.
        limits: what calls are refused by.
        folders: where files must lie that calls name, besides known packages; None: anywhere.
        past: what this kernel replays; None: it has a world of its own. It closes it.
        log: gives the newest lines of the log, for reports.
    """

    address: Address
    mode: Mode = Mode.REALTIME
    tick_nanoseconds: int = 4_000_000
    viewer_port: int = 0
    tokens_file: Path | None = None
    folder: Folder | None = None
    rules: Rules | None = None
    power: bool = False
    limits: Limits = field(default_factory=Limits)
    folders: tuple[Path, ...] | None = None
    past: PastFolder | None = None
    log: Callable[[], str] = str


class Kernel:
    """Kernel of one world with all its threads; `start` begins them and `close` ends them."""

    def __init__(self, settings: Settings, catalog: Catalog, shut_down: Callable[[], None]) -> None:
        """Build the rooms; `shut_down` is called when a client asks for the kernel's end."""
        self._settings = settings
        self._catalog = catalog
        self._solvers = Solvers(catalog)
        self._importers = Importers(catalog)
        self._tokens = TokenTable(settings.address.token, settings.tokens_file)
        self._viewer: Viewer | None = None
        self._assets = _asset_store(settings)
        self._meshes = MeshLibrary(self._assets, self._importers, folders=settings.folders, cache=MeshCache())
        self._view = ViewStore()
        load = self._meshes.load
        looks = AppearanceLibrary(with_arrows(load))
        self._sensing = SensingRoom(catalog, ShapeLibrary(load), looks, CollisionShapes(load), presets())
        self._casters = Casters(self._sensing)
        self._collisions = ScenePool(self._sensing.solids)
        self._clearances = partial(measured, self._collisions)
        self._renderers = RendererPool(self._sensing.shapes, looks, load, self._clearances)
        self._processes = Processes(self._sensing.shapes)
        self._mailbox = Mailbox()
        clock = Clock(settings.mode, 1.0, settings.tick_nanoseconds)
        self._history: History | Player
        if settings.past is not None:
            self._history = Player(settings.past, world_poses, lambda structure: check_assets(structure, self._assets))
            self.world = PastWorld(world_poses, clock, self._history)
            try:
                check_assets(self._history.newest, self._assets)
            except KernelError as error:
                raise error.at("the replay can't be shown (`--verify` needs no meshes)") from error
        else:
            self._history = self._recorded(clock)
        self._crafts = Crafts(self.world, catalog)
        self._guard = CollisionGuard(self._sensing.solids, self.world, self._crafts.carry)
        self._forces = Forces(self.world, catalog, load)
        self._leases = LeaseTable()
        site = DriverSite(catalog)
        self._links = Links(self.world, self._mailbox, world_poses, site, self._leases.has_leased)
        self._sensors = Sensors(self.world, self._sensing)
        self._monitor = Monitor(self.world, self._sensing.solids)
        self._workers = ThreadPoolExecutor(WORKERS, thread_name_prefix="worker")
        self._limiter = KeyedLimiter()
        self._server = Server(settings.address, self.world, self._services)
        self._shut_down = shut_down

    def _recorded(self, clock: Clock) -> History:
        """Make the history of a world, and the world from where it ended."""
        given = self._settings
        history = History(given.folder, clock.tick_seconds, world_poses, given.rules, given.power)
        begin = history.begin
        self.world = World(world_poses, history.journal, clock, begin.structure, begin.state, inputs=self._mailbox.take)
        check_assets(begin.structure, self._assets)
        return history

    def start(self) -> int:
        """Start the journal, the world and the API; return the port."""
        self._history.start()
        self.world.start()
        if isinstance(self._history, History) and self._history.goes_on:
            self.world.submit([RestartWorld()], "kernel").result()
            self._history.settle()
            self._history.upkeep.checkpoint()
        return self._server.start()

    def start_viewer(self) -> str:
        """Start the drawing thread and return the viewer's address."""
        # Loading it takes a second that the first call need not wait.
        from virtualrobot_kernel.drawing.viewer import Viewer

        port = self._settings.viewer_port
        viewer = Viewer(
            lambda: self.world.snapshot,
            self._view,
            self._meshes.load,
            port=port,
            readings=lambda: self._sensors.latest,
            touching=lambda: self._monitor.latest.touching,
            clearances=self._clearances,
            twins=lambda snapshot: twin_ghosts(snapshot, self._links.measured(snapshot)),
            coats=self._sensing.looks.coats.get,
            replay=self.world if isinstance(self.world, PastWorld) else None,
        )
        viewer.start()
        self._viewer = viewer
        return viewer.url

    def load(self, path: Path) -> None:
        """Load a scene file; raise KernelError when something in it is wrong, or the folder has a world already."""
        folder = self._settings.folder
        begin = self.world.snapshot
        if folder is not None and (len(begin.structure.nodes) > 1 or begin.state.signals):
            begun = f", which began with {folder.project.scene}" if folder.project.scene else ""
            raise KernelError(
                f"{folder.path} has a world already{begun}; leave out the scene file {path}, or take another folder",
                reason=Reason.WRONG_STATE,
                path=folder.path,
            )
        commands, warnings = scene_commands(path, self._meshes, self.world.snapshot, self._collisions.shapes)
        for warning in warnings:
            log.warning("%s: %s", path, warning)
        self._view.tell(warnings)
        self._solvers.check_choices(commands)
        self._crafts.check(commands)
        check_choices(commands, self._sensing)
        self._forces.check(commands)
        limits = self._settings.limits
        limits.check_triangles(self.world.snapshot, commands, self._meshes)
        self.world.submit(commands, f"scene file {path}", permit=limits.check_nodes).result()
        if folder is not None:
            folder.name_scene(path.name)

    def report(self, target: Path, most_bytes: int) -> None:
        """Write the report of a fault as a file, with about so many bytes of the journal; see `report.write_report`."""
        given = self._settings
        if given.past is not None:
            store, project = given.past.store, given.past.project
        else:
            assert isinstance(self._history, History)  # it is no replay
            nowhere = Project(f"{IN_MEMORY_SEED:08x}", given.tick_nanoseconds, versions=versions())
            self._history.settle()
            store, project = self._history.store, given.folder.project if given.folder else nowhere
        about = Reported(
            store,
            project,
            self.world.snapshot,
            self._assets,
            self._catalog.plugins,
            given.log,
            (given.address.token,),
        )
        write_report(target, about, most_bytes)

    def close(self) -> None:
        """End all calls with UNAVAILABLE, then every thread."""
        # Before the server, whose calls say why they end when what they wait for does.
        self._processes.close()
        self._server.close()
        if self._viewer is not None:
            self._viewer.close()
        self._links.close()
        # Before the world, which may be waiting for one of them in a step.
        self._sensors.close()
        self._monitor.close()
        self.world.close()
        self._forces.close()
        self._history.close()
        self._workers.shutdown(wait=False, cancel_futures=True)
        self._renderers.close()
        self._limiter.close()
        self._solvers.close()
        self._crafts.close()
        self._importers.close()
        self._casters.close()
        close_all()  # those that are being made or looked at, too: the process waits for its threads

    def _services(self, publications: Publications) -> KernelServices:
        return KernelServices(
            world=self.world,
            mailbox=self._mailbox,
            publications=publications,
            assets=self._assets,
            meshes=self._meshes,
            view=self._view,
            workers=self._workers,
            limiter=self._limiter,
            catalog=self._catalog,
            solvers=self._solvers,
            sensing=self._sensing,
            casters=self._casters,
            sensors=self._sensors,
            collisions=self._collisions,
            processes=self._processes,
            monitor=self._monitor,
            guard=self._guard,
            forces=self._forces,
            crafts=self._crafts,
            renderers=self._renderers,
            history=self._history,
            importers=self._importers,
            leases=self._leases,
            links=self._links,
            tokens=self._tokens,
            plans=(plans := ShownPlans()),
            proposals=Proposals(plans),
            records=Records(),
            limits=self._settings.limits,
            viewer_url=lambda: self._viewer.url if self._viewer else "",
            viewer_count=lambda: self._viewer.viewer_count if self._viewer else 0,
            report=self.report,
            shut_down=self._shut_down,
        )


def _asset_store(settings: Settings) -> AssetStore:
    """Return the store of assets: those of a folder where there is one, and those of a past as they are."""
    limits, past = settings.limits, settings.past
    folder = past.assets if past else settings.folder and settings.folder.path / ASSETS
    return AssetStore(limits.asset_bytes, limits.assets_bytes, folder, settings.power, read_only=past is not None)
