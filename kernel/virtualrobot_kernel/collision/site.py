"""Site of a job of a collision process: the world as it was asked about, a scene for it, and who waits for it."""

from __future__ import annotations

import threading
import time

from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.scene_transfer import TransferredWorld, as_before
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Geometry, Mesh
from virtualrobot_kernel.world.state import Snapshot, State


class GivenUp(Exception):
    """Nobody waits for the job any more."""


class Site:
    """Site of a job; one for each process, kept from job to job, so that a scene is made once.

    Attributes:
        snapshot: the world of the job: nodes with the figures that can touch, the state without motions and signals.
        scene: the scene of this process; at the job's begin it is placed at `snapshot`.
    """

    snapshot: Snapshot
    scene: CollisionScene

    def __init__(self) -> None:
        """Begin without a world; `put` gives one."""
        self.report: tuple[int, object] = 0, None
        self.gone = threading.Event()
        self.heard = time.monotonic()
        self._world: TransferredWorld | None = None
        self._state: State | None = None
        self._shapes = CollisionShapes(self._triangles)
        self.scene = CollisionScene(self._shapes)

    def put(self, world: TransferredWorld | None, state: State, tick_seconds: float) -> None:
        """Begin a job: in another world, or in the same structure as the job before (None)."""
        if world is not None:
            self._world = world
            nodes = world.structure.nodes.values()
            used: set[Geometry] = {figure.geometry for node in nodes for figure in node.figures}
            self._shapes.keep(used)
        assert self._world is not None, "no world has arrived"
        structure = self._world.structure
        self._state = state = as_before(state, self._state or state)
        self.snapshot = Snapshot(structure, state, world_poses(structure, state), 0, 0.0, tick_seconds)
        self.scene.place(self.snapshot)
        self.report = 0, None
        self.gone.clear()
        self.heard = time.monotonic()

    def told(self, value: object) -> None:
        """Report how far the job is, as plain data; of several reports the newest is heard."""
        self.heard = time.monotonic()
        self.report = self.report[0] + 1, value

    def given_up(self) -> bool:
        """Return whether nobody waits any more. Jobs ask often: it is the sign that they are alive, too."""
        self.heard = time.monotonic()
        return self.gone.is_set()

    def go_on(self) -> None:
        """Raise GivenUp when nobody waits any more."""
        if self.given_up():
            raise GivenUp

    def _triangles(self, mesh: Mesh) -> tuple[Submesh, ...]:
        assert self._world is not None, "no world has arrived"
        shape = self._world.meshes[mesh]
        return (Submesh(shape.vertices, shape.triangles),)
