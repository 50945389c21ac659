"""Forces in the world: once a tick, an engine computes where parts and robots go, and tells the world in one entry."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.physics import Driven, TouchingBodies
from virtualrobot_sdk.poses import rotation_vector
from virtualrobot_sdk.registration import ComponentKind

from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.running import ComponentHandle, start
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.numeric.forces import are_at
from virtualrobot_kernel.physics.answers import Answers
from virtualrobot_kernel.physics.bodies import Scene, is_dynamic, movers, moves_by_forces, scene_of
from virtualrobot_kernel.physics.engine import Asked, Engine, Question
from virtualrobot_kernel.physics.exerted import Exerted
from virtualrobot_kernel.physics.felt import felt_nodes
from virtualrobot_kernel.physics.layout import layout_of, poses_7
from virtualrobot_kernel.physics.running import UNTOUCHED, Running, equal
from virtualrobot_kernel.physics.solids import solids
from virtualrobot_kernel.shapes.submesh import Meshes
from virtualrobot_kernel.world.commands import Command, StartMotion, StartSetpointMotion, StopRobots
from virtualrobot_kernel.world.motored import under_physics
from virtualrobot_kernel.world.physics_commands import SetDynamics, SetParts, SetPhysics
from virtualrobot_kernel.world.state import Cancellation, EndCause, PhysicsSettings, Snapshot, unchanged
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Structure

Floats = NDArray[np.float64]

log = logging.getLogger(__name__)

_STILL = np.zeros(6)
_NONE = np.zeros(0)
_UNDRIVEN = Driven(np.zeros((0, 7)), np.zeros((0, 6)))


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """Point at which two nodes (names) touch: where (3,) in meters, and the force (3,) on the second in N."""

    first: str
    second: str
    position: Floats
    force: Floats


class Forces:
    """A supervisor of a world (`world/supervisor.py`), as long as an engine is set and a part or a robot is dynamic.

    The world owns where parts and robots are and how fast; the engine's own state is given up whenever somebody else
    changes them. An engine that fails is named (`fault`) and the log tells of it; what it moved stands still then,
    everything else goes on, until physics are set anew.
    """

    author = "physics"

    def __init__(self, world: World, catalog: Catalog, meshes: Meshes) -> None:
        """Listen to what the world says of physics from now on; shapes of meshes come of `meshes`."""
        self.fault = ""
        """Reason why nothing moves by forces though an engine is set; empty while it is well."""
        self.exerted = Exerted()
        """Efforts of motors in the latest ticks."""
        self._touching: tuple[Scene, TouchingBodies] | None = None
        self._world = world
        self._catalog = catalog
        self._solids = solids(meshes)
        self._engine: Engine | None = None
        self._made_of: PhysicsSettings | None = None
        self._asked: Asked | None = None
        self._running: Running | None = None
        self._carried: dict[int, Floats] = {}
        self._held: tuple[Structure | None, tuple[int, ...]] = (None, ())
        self._is_asked = self._moves = False
        self._seen: tuple[object, ...] = ()
        self._done: tuple[int, int] = (-1, -1)
        world.listen(self._published)

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """Return what touched at the end of the last tick that the engine was asked for."""
        return () if self._touching is None else _contacts(*self._touching)

    def uses(self) -> tuple[ComponentHandle, ...]:
        """Return the engine that is at work, or that failed last."""
        engine = self._engine
        return (engine.handle,) if engine is not None and engine.handle is not None else ()

    def check(self, commands: Sequence[Command]) -> None:
        """Raise UnknownNameError where commands name an engine that is not installed.

        And KernelError for settings that the engine refuses, and, by the name of the node, where an engine is set and
        something is dynamic that cannot be so. It may take as long as an engine is made.
        """
        now = self._world.snapshot
        for command in commands:
            if not isinstance(command, SetPhysics):
                continue
            before = now.state.physics_settings
            engine = before.engine if command.engine is None else command.engine
            kept = before.engine_settings if engine == before.engine else {}
            settings = kept if command.engine_settings is None else command.engine_settings
            if engine and (engine, settings) != (before.engine, before.engine_settings):
                start(self._catalog.find(ComponentKind.PHYSICS_ENGINE, engine), settings).close()
            if command.engine:
                if any(map(moves_by_forces, now.structure.nodes.values())):
                    scene_of(now, self._solids, 1.0)

    def admit(self, before: Snapshot, after: Snapshot, batch: Sequence[Command]) -> None:
        """Raise KernelError, by the name of the node, for bodies that cannot move by forces.

        And (PLUGIN_FAILED) for a motion of a robot whose engine has failed.
        """
        if before.structure is not after.structure and any(map(moves_by_forces, after.structure.nodes.values())):
            scene_of(after, self._solids, 1.0)
        if self._has_failed(after):
            self._refuse_motions(after, batch)

    def before_tick(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        """Return where forces move parts and robots in this tick, and what they touch; nothing where all rest.

        Raises Late while the engine is at it. What somebody else changes meanwhile of what it moves has the tick
        computed anew; what motions are told meanwhile, it is told with the next tick.
        """
        state = now.state
        moment = state.epoch, state.tick
        if self._done == moment:
            return ()
        commands: Sequence[Command] = ()
        if not self._moves:
            commands = () if state.contacts is None else (UNTOUCHED,)
        elif not self._has_failed(now):
            try:
                commands = self._moved(now, later)
            except Exception as error:
                if not isinstance(error, KernelError):
                    log.exception("physics failed inside the kernel")
                self._failed(str(error))
                commands = _stood(now, str(error))
        self._done = moment
        return commands

    def after_change(self, now: Snapshot) -> Sequence[Command]:
        """Return nothing: what has changed is seen in the next tick."""
        return ()

    def close(self) -> None:
        """End the engine."""
        if self._engine is not None:
            self._engine.close()
        self._engine = self._made_of = self._asked = self._running = self._touching = None
        self.exerted.forget()

    def _published(self) -> None:
        """Oversee the world while there is an engine, which is at work while there is something that it moves."""
        now = self._world.snapshot
        seen = now.structure, now.state.physics_settings
        if unchanged(self._seen, seen):
            return
        self._seen = seen
        engine = bool(now.state.physics_settings.engine)
        self._moves = engine and any(map(moves_by_forces, now.structure.nodes.values()))
        if not self._moves:
            self.close()
            self.fault = ""
        if engine != self._is_asked:
            self._is_asked = engine
            (self._world.supervise if engine else self._world.unsupervise)(self)

    def _has_failed(self, now: Snapshot) -> bool:
        """Return whether the engine has failed that is set."""
        return bool(self.fault) and self._made_of is now.state.physics_settings

    def _moved(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        """Return the commands of this tick; raise Late while the engine is at it."""
        engine = self._at_work(now.state.physics_settings)
        if self._asked is not None and not self._is_as_told(self._asked.running, now):
            self._asked.running.is_astray = True
            self._asked = None
        if self._asked is None:
            self._asked = self._begun(engine, now, later)
        asked = self._asked
        found = None if asked is None else engine.awaited(asked.answer)
        self._carry(now, later)
        if asked is None:
            return ()
        self._asked, running = None, asked.running
        answer = running.answers.checked(found)
        self._touching = running.scene, answer.contacts
        joints = running.layout.joints
        self.exerted.keep(now.state.tick + 1, joints.names, answer.efforts[joints.slots])
        return running.told(now, answer, asked.same)

    def _begun(self, engine: Engine, now: Snapshot, later: Snapshot) -> Asked | None:
        """Ask the engine for this tick, or return None where everything rests."""
        running, questions = self._loaded(now)
        layout = running.layout
        driven = _UNDRIVEN
        if len(rows := layout.driven_rows):
            driven = Driven(poses_7(later.world_t_node[rows]), _twists(now, later, rows.tolist()))
        same = running.command(later.state)
        if running.stands and same and not driven.twists.any():
            return None
        motors = layout.motors(now.state, *running.commanded, now.tick_seconds)
        step = ("step", driven, motors, None, running.settings.substeps)
        return Asked(running, same, engine.ask([*questions, step]))

    def _at_work(self, settings: PhysicsSettings) -> Engine:
        """Return the engine that is set; one of other settings ends."""
        if self._engine is None or self._made_of is not settings:
            self.close()
            self._made_of, self.fault = settings, ""
            offer = self._catalog.find(ComponentKind.PHYSICS_ENGINE, settings.engine)
            self._engine = Engine(offer, settings.engine_settings)
        return self._engine

    def _is_as_told(self, running: Running, now: Snapshot) -> bool:
        """Return whether the world is as the engine knows it: nobody else has changed what it moves."""
        if running.structure is not now.structure or running.settings is not now.state.physics_settings:
            return False
        state, layout = now.state, running.layout
        there = are_at(state.q, layout.q, running.q) and are_at(state.v, layout.v, running.v)
        there &= equal(state.parent_t_node, running.poses)
        return there and equal(self._part_twists(running.scene, now), running.twists)

    def _loaded(self, now: Snapshot) -> tuple[Running, Sequence[Question]]:
        """Return the scene that the engine has, as the world is, and what to tell the engine for that.

        It is loaded anew where anything but what moves has changed.
        """
        state, running = now.state, self._running
        same = running is not None and running.structure is now.structure and running.settings is state.physics_settings
        if same and running is not None:
            layout = running.layout
            if not running.is_astray and self._is_as_told(running, now):
                return running, ()
            changed = set(np.flatnonzero(np.any(state.parent_t_node != running.poses, (1, 2))).tolist())
            if changed <= set(layout.part_rows.tolist()):
                twists = self._part_twists(running.scene, now)
                running.poses, running.twists = state.parent_t_node, twists
                running.q, running.v = state.q[layout.q], state.v[layout.v]
                running.slow_ticks[:], running.still_ticks = 0, 0
                running.stands = running.is_astray = False
                return running, [("set_state", *layout.engine_state(now, twists))]
        scene = scene_of(now, self._solids, now.tick_seconds / state.physics_settings.substeps)
        layout = layout_of(now, scene)
        twists = self._part_twists(scene, now)
        felt = felt_nodes(now.structure)
        felt_bodies = np.array([uid in felt for uid in scene.nodes], np.bool_)
        self._running = Running(
            scene=scene,
            layout=layout,
            structure=now.structure,
            settings=state.physics_settings,
            poses=state.parent_t_node,
            twists=twists,
            q=state.q[layout.q],
            v=state.v[layout.v],
            commanded=(np.zeros(0), np.zeros(0)),
            efforts=({}, np.zeros(len(layout.joints.exerts))),
            felt=felt_bodies if felt_bodies.any() else None,
            slow_ticks=np.zeros(len(scene.parts), np.int64),
            answers=Answers(state.physics_settings.engine, scene.model),
        )
        return self._running, [("load", scene.model, *layout.engine_state(now, twists))]

    def _part_twists(self, scene: Scene, now: Snapshot) -> Floats:
        """Return the velocities (k, 6) of the free parts of a scene: the world's, or those of what just let go."""
        twists = {**self._carried, **now.state.twists} if self._carried else now.state.twists
        return _known(twists, scene.parts)

    def _carry(self, now: Snapshot, later: Snapshot) -> None:
        """Keep the velocities of dynamic parts that something else moves, for when it lets them go."""
        structure = now.structure
        if self._held[0] is not structure:
            mover_of = movers(structure)
            dynamic = (uid for uid, node in structure.nodes.items() if is_dynamic(node))
            self._held = structure, tuple(uid for uid in dynamic if mover_of[uid] != uid)
        uids = self._held[1]
        if not uids:
            self._carried = {}
            return
        twists = _twists(now, later, [structure.rows[uid] for uid in uids])
        self._carried = dict(zip(uids, twists, strict=True))

    def _refuse_motions(self, after: Snapshot, batch: Sequence[Command]) -> None:
        robots = {node.name for node in under_physics(after.structure, after.state)}
        for command in batch:
            names = [command.robot] if isinstance(command, StartSetpointMotion) else []
            names += [robot for robot, _ in command.joints] if isinstance(command, StartMotion) else []
            for name in robots.intersection(names):
                raise KernelError(
                    f"the robot {name!r} stands: {self.fault}; set physics anew",
                    reason=Reason.PLUGIN_FAILED,
                    robot=name,
                )

    def _failed(self, reason: str) -> None:
        self.fault, self._running, self._asked = reason, None, None
        log.error("nothing moves by forces until physics are set anew: %s", reason)


def _stood(now: Snapshot, why: str) -> Sequence[Command]:
    """Return commands by which all that forces move stands where it is and feels nothing, and its motions end."""
    structure, state = now.structure, now.state
    commands: list[Command] = [] if state.contacts is None else [UNTOUCHED]
    uids = np.array([uid for uid in state.twists if uid in structure.nodes], np.int64)
    if len(uids):
        poses = state.parent_t_node[[structure.rows[uid] for uid in uids.tolist()]]
        commands.append(SetParts(uids, poses, np.zeros((len(uids), 6))))
    robots = tuple(node.uid for node in under_physics(structure, state))
    if robots:
        slices = [structure.robots[uid].v_slice for uid in robots]
        at = np.array(sorted(place for one in slices for place in range(one.start, one.stop)), np.int32)
        nothing = np.zeros(0, np.int32), np.zeros(0)
        commands.append(SetDynamics(*nothing, at, np.zeros(len(at)), robots))
        commands.append(StopRobots(robots, Cancellation(EndCause.FAILED, why)))
    return commands


def _known(twists: Mapping[int, Floats], uids: Sequence[int]) -> Floats:
    """Return the velocities (k, 6) of parts, 0 of those that have none."""
    return np.concatenate([_NONE, *(twists.get(uid, _STILL) for uid in uids)]).reshape(-1, 6)


def _twists(now: Snapshot, later: Snapshot, rows: Sequence[int]) -> Floats:
    """Return the velocities (k, 6) of nodes in a tick: of origins in the axes of the world, and about their own."""
    twists = np.zeros((len(rows), 6))
    if not len(rows):
        return twists
    before, after = now.world_t_node[list(rows)], later.world_t_node[list(rows)]
    for at in np.flatnonzero((before != after).any(axis=(1, 2))):
        twists[at, :3] = after[at, :3, 3] - before[at, :3, 3]
        twists[at, 3:] = rotation_vector(before[at, :3, :3].T @ after[at, :3, :3])
    return twists / now.tick_seconds


def _contacts(scene: Scene, found: TouchingBodies) -> tuple[Contact, ...]:
    names = [body.name for body in scene.model.bodies]
    return tuple(
        Contact(names[first], names[second], position, force)
        for (first, second), position, force in zip(found.bodies.tolist(), found.positions, found.forces, strict=True)
    )
