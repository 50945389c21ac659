"""Forces in the world: once a tick, an engine computes where free parts go, and the world is told as one command."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.physics import Driven, Stepped, TouchingBodies, motors_off
from virtualrobot_sdk.poses import from_quaternion, inverse, quaternion, rotation_vector
from virtualrobot_sdk.registration import ComponentKind

from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.running import ComponentHandle, start
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.physics.bodies import Scene, is_dynamic, movers, scene_of
from virtualrobot_kernel.physics.solids import hulls
from virtualrobot_kernel.shapes.submesh import Meshes
from virtualrobot_kernel.world.commands import Command, SetParts, SetPhysics
from virtualrobot_kernel.world.state import PhysicsSettings, Snapshot, unchanged
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Structure

Floats = NDArray[np.float64]

log = logging.getLogger(__name__)

REST_SPEED = 2e-3
"""Speed of a part that counts as being at rest (m/s); a tenth of a turn of it in a second counts, too (rad/s)."""
REST_TURN = 1e-2
REST_SECONDS = 0.5
"""Time after which a part that was slower all the while rests."""
CREEP = 1e-4
"""Distance (m), and turn (rad), from which on a part that rests is where the engine has it."""


_STILL = np.zeros(6)


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """Point at which two nodes (names) touch: where (3,) in meters, and the force (3,) on the second in N."""

    first: str
    second: str
    position: Floats
    force: Floats


@dataclass(slots=True)
class _Running:
    """Engine with a scene, and what the world was told last."""

    scene: Scene
    structure: Structure
    settings: PhysicsSettings
    poses: Floats
    """parent_t_node (n, 4, 4) of all nodes, as it must be where nobody else has changed it."""
    twists: Floats
    """(k, 6) of the free parts, as the world has them."""
    parent_t_world: Floats
    """(k, 4, 4) of the parents of the free parts, which stand."""
    slow_ticks: NDArray[np.int64]
    """(k,) number of ticks that each of them was slow."""
    stands: bool = False
    """True where everything rests, so that the engine is not asked."""


class Forces:
    """A supervisor of a world (`world/supervisor.py`), as long as an engine is set and a part is dynamic.

    The world owns where parts are and how fast; the engine's own state is given up whenever somebody else changes
    them. An engine that fails is named (`fault`) and the log tells of it; parts stand still then, everything else goes
    on, until physics are set anew.
    """

    author = "physics"

    def __init__(self, world: World, catalog: Catalog, meshes: Meshes) -> None:
        """Listen to what the world says of physics from now on; shapes of meshes come of `meshes`."""
        self.fault = ""
        """Reason why nothing moves by forces though an engine is set; empty while it is well."""
        self._touching: tuple[Scene, TouchingBodies] | None = None
        self._world = world
        self._catalog = catalog
        self._hulls = hulls(meshes)
        self._engine: ComponentHandle | None = None
        self._made_of: PhysicsSettings | None = None
        self._running: _Running | None = None
        self._carried: dict[int, Floats] = {}
        self._held: tuple[Structure | None, tuple[int, ...]] = (None, ())
        self._is_asked = False
        self._seen: tuple[object, ...] = ()
        self._done: tuple[int, int] = (-1, -1)
        world.listen(self._published)

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """Return what touched at the end of the last tick that the engine was asked for."""
        return () if self._touching is None else _contacts(*self._touching)

    def uses(self) -> tuple[ComponentHandle, ...]:
        """Return the engine that is at work, or that failed last."""
        return (self._engine,) if self._engine is not None else ()

    def check(self, commands: Sequence[Command]) -> None:
        """Raise UnknownNameError where commands name an engine that is not installed."""
        for command in commands:
            if isinstance(command, SetPhysics) and command.engine:
                self._catalog.find(ComponentKind.PHYSICS_ENGINE, command.engine)

    def admit(self, before: Snapshot, after: Snapshot, batch: Sequence[Command]) -> None:
        """Raise KernelError, by the name of the node, for bodies that cannot move by forces."""
        if before.structure is not after.structure and any(map(is_dynamic, after.structure.nodes.values())):
            scene_of(after, self._hulls, 1.0)

    def before_tick(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        """Return where forces move parts in this tick; nothing where all rest."""
        state = now.state
        moment = state.epoch, state.tick
        if self._done == moment:
            return ()
        self._done = moment
        if self.fault and self._made_of is state.physics_settings:
            return ()
        try:
            return self._moved(now, later)
        except Exception as error:
            if not isinstance(error, KernelError):
                log.exception("physics failed inside the kernel")
            self._failed(str(error), state.physics_settings)
            uids = np.array([uid for uid in state.twists if uid in now.structure.nodes], np.int64)
            poses = state.parent_t_node[[now.structure.rows[uid] for uid in uids.tolist()]]
            return [SetParts(uids, poses, np.zeros((len(uids), 6)))] if len(uids) else ()

    def after_change(self, now: Snapshot) -> Sequence[Command]:
        """Return nothing: what has changed is seen in the next tick."""
        return ()

    def close(self) -> None:
        """End the engine."""
        if self._engine is not None:
            self._engine.close()
        self._engine = self._made_of = self._running = self._touching = None

    def _published(self) -> None:
        """Oversee the world while there is an engine and something that it moves."""
        now = self._world.snapshot
        seen = now.structure, now.state.physics_settings
        if unchanged(self._seen, seen):
            return
        self._seen = seen
        needed = bool(now.state.physics_settings.engine) and any(map(is_dynamic, now.structure.nodes.values()))
        if needed != self._is_asked:
            self._is_asked = needed
            if not needed:
                self.close()
                self.fault = ""
            (self._world.supervise if needed else self._world.unsupervise)(self)

    def _moved(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        """Return the command of this tick."""
        engine = self._at_work(now.state.physics_settings)
        running = self._loaded(engine, now)
        scene = running.scene
        twists = _twists(now, later, scene.driven)
        self._carry(now, later)
        if running.stands and not twists.any():
            return ()
        driven = Driven(_poses_7(later.world_t_node[list(scene.driven)]), twists)
        answer = engine.call("step", driven, motors_off(0), None, running.settings.substeps)
        return self._told(now, running, _checked(answer, len(scene.free)))

    def _at_work(self, settings: PhysicsSettings) -> ComponentHandle:
        """Return the engine that is set; one of other settings ends."""
        if self._made_of is settings and self._engine is not None:
            return self._engine
        self.close()
        self._made_of, self.fault = settings, ""
        offer = self._catalog.find(ComponentKind.PHYSICS_ENGINE, settings.engine)
        self._engine = start(offer, settings.engine_settings, user=" of the world")
        return self._engine

    def _loaded(self, engine: ComponentHandle, now: Snapshot) -> _Running:
        """Return the scene that the engine has, as the world is: loaded anew where anything but free parts changed."""
        state, running = now.state, self._running
        same = running is not None and running.structure is now.structure and running.settings is state.physics_settings
        if same and running is not None:
            changed = np.flatnonzero(np.any(state.parent_t_node != running.poses, (1, 2)))
            twists = _known(state.twists, running.scene.free_uids)
            if set(changed.tolist()) <= set(running.scene.free):
                if len(changed) or not np.array_equal(twists, running.twists):
                    engine.call("set_state", *_state_of(now, running.scene, twists))
                    running.poses, running.twists = state.parent_t_node, twists
                    running.slow_ticks[:], running.stands = 0, False
                return running
        scene = scene_of(now, self._hulls, now.tick_seconds / state.physics_settings.substeps)
        twists = _known({**self._carried, **state.twists}, scene.free_uids)
        engine.call("load", scene.model, *_state_of(now, scene, twists))
        nodes = now.structure.nodes
        parents = np.array([inverse(now.world_t(nodes[uid].parent)) for uid in scene.free_uids]).reshape(-1, 4, 4)
        slow_ticks = np.zeros(len(scene.free), np.int64)
        self._running = _Running(
            scene, now.structure, state.physics_settings, state.parent_t_node, twists, parents, slow_ticks
        )
        return self._running

    def _carry(self, now: Snapshot, later: Snapshot) -> None:
        """Keep the velocities of dynamic parts that something else moves, for when it lets them go."""
        structure = now.structure
        if self._held[0] is not structure:
            mover_of = movers(structure)
            dynamic = (uid for uid, node in structure.nodes.items() if is_dynamic(node))
            self._held = structure, tuple(uid for uid in dynamic if mover_of[uid] != uid)
        uids = self._held[1]
        twists = _twists(now, later, [structure.rows[uid] for uid in uids])
        self._carried = dict(zip(uids, twists, strict=True))

    def _told(self, now: Snapshot, running: _Running, answer: Stepped) -> Sequence[Command]:
        """Return the command for the parts that do not rest, and remember what the world is told."""
        scene = running.scene
        self._touching = scene, answer.contacts
        count = len(scene.free)
        q, v = answer.q.reshape(count, 7), answer.v.reshape(count, 6)
        slow = (np.linalg.norm(v[:, :3], axis=1) < REST_SPEED) & (np.linalg.norm(v[:, 3:], axis=1) < REST_TURN)
        running.slow_ticks = np.where(slow, running.slow_ticks + 1, 0)
        resting = running.slow_ticks * now.tick_seconds >= REST_SECONDS
        poses = _poses_4(q)
        stays = resting & ~running.twists.any(axis=1)
        stays &= np.abs(poses - now.world_t_node[list(scene.free)]).max(axis=(1, 2)) < CREEP
        running.stands = bool(resting.all() and stays.all())
        if stays.all():
            return ()
        uids = np.array(scene.free_uids, np.int64)
        chosen = np.flatnonzero(~stays)
        chosen = chosen[np.argsort(uids[chosen])]
        twists = np.where(resting[:, None], 0.0, v)[chosen]
        placed = running.parent_t_world[chosen] @ poses[chosen]
        running.twists = running.twists.copy()
        running.twists[chosen] = twists
        running.poses = now.state.parent_t_node.copy()
        running.poses[np.array(scene.free)[chosen]] = placed
        return [SetParts(uids[chosen], placed, twists)]

    def _failed(self, reason: str, settings: PhysicsSettings) -> None:
        self.fault, self._made_of, self._running = reason, settings, None
        log.error("nothing moves by forces until physics are set anew: %s", reason)


def _known(twists: Mapping[int, Floats], uids: Sequence[int]) -> Floats:
    """Return the velocities (k, 6) of parts, 0 of those that have none."""
    return np.array([twists.get(uid, _STILL) for uid in uids]).reshape(-1, 6)


def _state_of(now: Snapshot, scene: Scene, twists: Floats) -> tuple[Floats, Floats]:
    """Return q and v of the free parts for the engine."""
    return _poses_7(now.world_t_node[list(scene.free)]).ravel(), twists.ravel()


def _twists(now: Snapshot, later: Snapshot, rows: Sequence[int]) -> Floats:
    """Return the velocities (k, 6) of nodes in a tick: of origins in the axes of the world, and about their own."""
    before, after = now.world_t_node[list(rows)], later.world_t_node[list(rows)]
    twists = np.zeros((len(rows), 6))
    for at in np.flatnonzero((before != after).any(axis=(1, 2))):
        twists[at, :3] = after[at, :3, 3] - before[at, :3, 3]
        twists[at, 3:] = rotation_vector(before[at, :3, :3].T @ after[at, :3, :3])
    return twists / now.tick_seconds


def _poses_7(poses: Floats) -> Floats:
    """Return poses (k, 4, 4) as x, y, z and quaternions x, y, z, w (k, 7)."""
    return np.array([[*pose[:3, 3], *quaternion(pose[:3, :3])] for pose in poses]).reshape(-1, 7)


def _poses_4(poses: Floats) -> Floats:
    """Return poses (k, 7) as x, y, z and quaternions x, y, z, w as matrices (k, 4, 4)."""
    matrices = np.zeros((len(poses), 4, 4))
    matrices[:, :3, :3] = np.moveaxis(from_quaternion(poses[:, 3:].T), -1, 0)
    matrices[:, :3, 3] = poses[:, :3]
    matrices[:, 3, 3] = 1.0
    return matrices


def _contacts(scene: Scene, found: TouchingBodies) -> tuple[Contact, ...]:
    names = [body.name for body in scene.model.bodies]
    return tuple(
        Contact(names[first], names[second], position, force)
        for (first, second), position, force in zip(found.bodies.tolist(), found.positions, found.forces, strict=True)
    )


def _checked(answer: object, count: int) -> Stepped:
    """Return what an engine answered; raise KernelError where that is nonsense."""
    shapes = (7 * count,), (6 * count,)
    if isinstance(answer, Stepped) and (np.shape(answer.q), np.shape(answer.v)) == shapes:
        if np.isfinite(answer.q).all() and np.isfinite(answer.v).all():
            return answer
    raise KernelError(f"the physics engine's answer is nonsense: it must be finite, for {count} free parts")
