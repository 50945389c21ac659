"""The viewer: one thread that keeps a picture of the newest snapshot in every open browser."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Mapping

import numpy as np
import viser

from virtualrobot_kernel.background import give_way
from virtualrobot_kernel.collision.clearances import Measure, Measured
from virtualrobot_kernel.drawing.alarm import Touching, contact_points, red_nodes, shown
from virtualrobot_kernel.drawing.annotations import AnnotationLayer, BoxLayer, ContactLayer
from virtualrobot_kernel.drawing.batches import BatchLayer
from virtualrobot_kernel.drawing.cameras import Cameras
from virtualrobot_kernel.drawing.clearance_meter import ClearanceMeter
from virtualrobot_kernel.drawing.coat_layer import CoatLayer
from virtualrobot_kernel.drawing.ghosts import ghost_figures
from virtualrobot_kernel.drawing.inventory import Inventory, figures_only, joint_axes, take, world_bounds
from virtualrobot_kernel.drawing.library import ShapeLibrary
from virtualrobot_kernel.drawing.measurements import MeasurementLayer
from virtualrobot_kernel.drawing.page_server import quiet, serve
from virtualrobot_kernel.drawing.program_panel import ProgramPanel
from virtualrobot_kernel.drawing.replay_panel import ReplayPanel
from virtualrobot_kernel.drawing.sensor_overlays import SensorLayer
from virtualrobot_kernel.drawing.stage import Stage
from virtualrobot_kernel.drawing.twin_ghosts import TwinGhost
from virtualrobot_kernel.drawing.twin_layer import TwinLayer
from virtualrobot_kernel.drawing.view import ViewSettings, ViewStore
from virtualrobot_kernel.drawing.work_note import WorkNote
from virtualrobot_kernel.sensing.coats import Shown
from virtualrobot_kernel.sensing.reading import Reading
from virtualrobot_kernel.shapes.submesh import Meshes
from virtualrobot_kernel.world.past_world import PastWorld
from virtualrobot_kernel.world.state import Snapshot

AFTER_ERROR = 1.0
"""Time (s) for which a picture that failed is not tried again."""

Readings = Callable[[], Mapping[int, Reading]]
"""Gives the latest reading of each sensor, by the uid of its node."""

log = logging.getLogger(__name__)


class Viewer:
    """Serves a page that shows the world, and draws into it while a browser has it open.

    The thread takes the newest snapshot at most `rate` times a second: what came in between is never drawn, and when
    nothing has changed nothing is sent. Without a browser the thread sleeps.
    """

    def __init__(
        self,
        snapshot: Callable[[], Snapshot],
        view: ViewStore,
        meshes: Meshes,
        host: str = "127.0.0.1",
        port: int = 0,
        rate: float = 30.0,
        readings: Readings = dict,
        touching: Callable[[], Touching] = tuple,
        clearances: Measure = lambda snapshot, wanted: {},
        twins: Callable[[Snapshot], tuple[TwinGhost, ...]] = lambda snapshot: (),
        coats: Callable[[], Shown] = dict,
        replay: PastWorld | None = None,
    ) -> None:
        """Prepare a viewer; `start` opens its port.

        Args:
            snapshot: gives the newest snapshot.
            view: how the picture is set up.
            meshes: gives the triangles of a mesh.
            host: the address to serve on; the page knows no password, so keep it on this machine. Requests must
                name it, or this machine (`drawing/page_server.py`).
            port: the port to serve on; when it is in use the next ones are tried; 0 takes any that is free.
            rate: how often the picture changes at most, per second.
            readings: gives what sensors have said last.
            touching: gives what the collision monitor has found last.
            clearances: measures least distances, in another thread.
            twins: gives the ghosts of robots that are commanded or measured elsewhere.
            coats: gives the coats of nodes.
            replay: the world, if it is a replay; then the page has a panel to play it.
        """
        self._snapshot = snapshot
        self._view = view
        self._meshes = meshes
        self._readings = readings
        self._touching = touching
        self._meter = ClearanceMeter(clearances)
        self._twins = twins
        self._coats = coats
        self._replay = replay
        self._host, self._port = host, port
        self._period = 1.0 / rate
        self._server: viser.ViserServer | None = None
        self._thread: threading.Thread | None = None
        self._awake = threading.Event()
        self._closing = threading.Event()

    def start(self) -> None:
        """Open the port and start to draw; raise KernelError when no port is free."""
        server = self._server = serve(self._host, self._port)
        server.on_client_connect(lambda client: self._awake.set())
        self._thread = threading.Thread(target=self._run, args=(server,), name="drawing", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop drawing and free the port; harmless when it is not open."""
        self._closing.set()
        self._awake.set()
        if self._thread is not None:
            self._thread.join(timeout=5.0)
        self._meter.close()
        if self._server is not None:
            with quiet():
                self._server.stop()
            self._server = None

    @property
    def url(self) -> str:
        """Return the address of the page, or "" when it is not served."""
        server = self._server
        return f"http://{self._host}:{server.get_port()}" if server else ""

    @property
    def viewer_count(self) -> int:
        """Return how many browsers show the page."""
        server = self._server
        return len(server.get_clients()) if server else 0

    def _run(self, server: viser.ViserServer) -> None:
        give_way()
        picture, note = Picture(server, self._meshes), WorkNote()
        panel = ReplayPanel(server, self._replay) if self._replay is not None else None
        told = ""
        while not self._closing.is_set():
            if not server.get_clients():
                self._awake.clear()
                # Asked again after the clearing, so that a browser that comes in between is not slept over.
                if not server.get_clients():
                    self._awake.wait()
                continue
            started, pause = time.monotonic(), self._period
            try:
                snapshot, settings = self._snapshot(), self._view.get()
                clearances = self._meter.latest(snapshot, settings.clearances)
                with server.atomic():
                    picture.draw(snapshot, settings, self._readings(), self._touching(), clearances)
                    picture.twins.draw(snapshot, self._twins(snapshot))
                    picture.coats.draw(snapshot, self._coats())
                if panel is not None:
                    panel.show(snapshot)
                note.show(server.get_clients(), self._view.under_way.long())
                for message in self._view.take_messages():
                    for client in server.get_clients().values():
                        client.add_notification("Warning", message, color="yellow")
            except Exception as error:  # a picture that fails must neither end the thread nor fill the log
                if (text := f"{type(error).__name__}: {error}") != told:
                    log.exception("a picture failed; the next ones are tried")
                    told = text
                pause = AFTER_ERROR
            self._closing.wait(max(0.0, pause - (time.monotonic() - started)))


class Picture:
    """Picture that one viser server shows. Each drawing changes only what differs from the one before.

    Attributes:
        twins: ghosts of robots that are elsewhere, too.
        coats: what lies on nodes.
    """

    def __init__(self, server: viser.ViserServer, meshes: Meshes) -> None:
        """Draw on `server`; `meshes` gives the triangles of a mesh."""
        self._library = ShapeLibrary(meshes)
        self._stage = Stage(server)
        self._batches = BatchLayer(server, self._library)
        self._ghosts = BatchLayer(server, self._library, "ghost")
        self.twins = TwinLayer(server, self._library)
        self.coats = CoatLayer(server)
        self._annotations = AnnotationLayer(server)
        self._boxes = BoxLayer(server, self._library)
        self._measurements = MeasurementLayer(server)
        self._sensors = SensorLayer(server)
        self._contacts = ContactLayer(server)
        self._cameras = Cameras(server)
        self._programs = ProgramPanel(server)
        self._inventory: Inventory | None = None
        self._bounds: np.ndarray | None = None
        self._last: tuple[Snapshot, ViewSettings] | None = None
        self._touching: Touching = ()
        self._red: frozenset[int] = frozenset()

    def draw(
        self,
        snapshot: Snapshot,
        settings: ViewSettings,
        readings: Mapping[int, Reading],
        touching: Touching,
        clearances: Measured,
    ) -> None:
        """Show a snapshot, and what is asked for of the latest readings, of what touches and of least distances."""
        touching = shown(settings, touching)
        if self._last is None or settings is not self._last[1] or bool(touching) != bool(self._touching):
            self._stage.show(settings, bool(touching))
        if touching != self._touching:
            self._contacts.draw(contact_points(touching))
            self._touching = touching
        arranged = self._arranged(snapshot, settings)
        world_t_node = snapshot.world_t_node
        if (
            arranged
            or self._last is None
            or not (
                world_t_node is self._last[0].world_t_node or np.array_equal(world_t_node, self._last[0].world_t_node)
            )
        ):
            self._batches.pose(world_t_node)
            self._ghosts.pose(world_t_node)
            self._annotations.pose(world_t_node)
            assert self._inventory is not None  # arranged with the first picture
            self._boxes.draw(snapshot.structure, self._inventory, world_t_node, settings.bounding_boxes)
        self._measurements.draw(snapshot, settings.measurements, clearances)
        self._sensors.draw(snapshot, settings.sensors, readings)
        self._cameras.follow(settings.camera, snapshot, self._bounds)
        self._programs.show(snapshot)
        self._last = snapshot, settings

    def _arranged(self, snapshot: Snapshot, settings: ViewSettings) -> bool:
        """Take over what there is to draw; return whether that was needed."""
        structure, tool_states, red = snapshot.structure, snapshot.state.tool_states, red_nodes(self._touching)
        if self._inventory is not None and self._last is not None:
            before, shown = self._last
            same_world = structure is before.structure and tool_states == before.state.tool_states
            if (
                same_world
                and red == self._red
                and (settings.joint_axes, settings.bounding_boxes, settings.ghosts)
                == (
                    shown.joint_axes,
                    shown.bounding_boxes,
                    shown.ghosts,
                )
            ):
                return False
        axes = joint_axes(structure, settings.joint_axes, self._library)
        self._inventory = take(structure, tool_states, axes, self._inventory, red)
        self._red = red
        self._library.keep({shape for shape, _ in self._inventory.used})
        self._batches.arrange(self._inventory)
        self._ghosts.arrange(figures_only(structure, ghost_figures(snapshot, settings.ghosts)))
        self._annotations.arrange(structure, self._inventory)
        self._bounds = world_bounds(self._inventory, snapshot.world_t_node, self._library)
        return True
