"""All crafts of a world: a supervisor that moves their bases as their drives go, once a tick.

What it finds enters the world as one `SetDynamics`, so that a replay needs no component. A component that raises, hangs
or returns nonsense stops its own craft, with its name; all else goes on.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.registration import ComponentKind

from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.running import ComponentHandle, start
from virtualrobot_kernel.crafts.carrying import At, CarriedBase, CarriedBases, Travel
from virtualrobot_kernel.crafts.craft import CraftAtWork, at_work
from virtualrobot_kernel.crafts.fitting import Moved
from virtualrobot_kernel.crafts.vessel import Vessel, vessel
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.lateness import Late
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode, SetpointMotion
from virtualrobot_kernel.world.commands import (
    CancelMotion,
    Command,
    CreateNodes,
    SetCraft,
    SetSetpoint,
    StartMotion,
    StartSetpointMotion,
    StopRobots,
    UpdateNode,
)
from virtualrobot_kernel.world.craft_data import Craft
from virtualrobot_kernel.world.crafts import crafts
from virtualrobot_kernel.world.motored import COMMANDED, motor_of, under_physics
from virtualrobot_kernel.world.physics_commands import SetDynamics
from virtualrobot_kernel.world.state import Cancellation, EndCause, Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Node, NodeSpec, RobotData, Structure

log = logging.getLogger(__name__)

Floats = NDArray[np.float64]


class _Twist(NamedTuple):
    """Twist (3,) that a craft (uid) follows, and the tick at which it came."""

    uid: int
    twist: Floats
    tick: int


def crafts_made(commands: Iterable[Command]) -> list[tuple[Craft, str]]:
    """Return the crafts that commands make, and the name of the robot where they make one of it that is there."""
    made: list[tuple[Craft | None, str]] = []
    for command in commands:
        if isinstance(command, SetCraft):
            made.append((command.craft, command.robot))
            continue
        for one in command.specs if isinstance(command, CreateNodes) else [command]:
            if isinstance(one, NodeSpec | UpdateNode) and isinstance(one.data, RobotData):
                made.append((one.data.craft, ""))
    return [(craft, robot) for craft, robot in made if craft is not None]


class Crafts:
    """A supervisor of a world; asked by the world thread alone, but for `check`, `fault_of`, `of` and `carried`."""

    author = "crafts"

    def __init__(self, world: World, catalog: Catalog) -> None:
        """Move from now on the crafts that the world has."""
        self._world, self._catalog = world, catalog
        self._structure: Structure | None = None
        self._supervises = False
        self._at_work: dict[int, CraftAtWork | Vessel] = {}
        self._faults: dict[int, tuple[Craft, str]] = {}
        self._made: dict[int, tuple[Craft, ComponentHandle]] = {}
        self._asked: dict[int, tuple[int, bytes]] = {}
        self._twists: dict[str, _Twist] = {}
        self._told: dict[str, tuple[bytes, tuple[float, ...]]] = {}
        """Of each motion that follows a twist: of what its commands were made in this structure, and these."""
        world.listen(self._published)
        self._published()

    def close(self) -> None:
        """End the components."""
        for _, component in self._made.values():
            component.close()

    def of(self, uid: int) -> CraftAtWork | Vessel:
        """Return a craft at work by its robot (uid), for its names, twists and commands.

        Raises KernelError for a robot that is none, and PLUGIN_FAILED where its component has failed.
        """
        structure = self._world.snapshot.structure
        node = structure.nodes[uid]
        if fault := self.fault_of(uid):
            raise KernelError(
                _stands(node, fault),
                reason=Reason.PLUGIN_FAILED,
                robot=node.name,
            )
        craft = self._at_work.get(uid)
        if craft is None:
            raise KernelError(
                f"{node.name!r} is no craft; make it one with set_craft", reason=Reason.WRONG_STATE, robot=node.name
            )
        return craft

    def driven(self, uid: int) -> CraftAtWork:
        """Return a craft at work that drives by twists; raise KernelError as `of` does, and for a vessel."""
        craft = self.of(uid)
        if isinstance(craft, CraftAtWork):
            return craft
        raise KernelError(
            f"{craft.node.name!r} is pushed by its thrusters and has no twist at once; give setpoints to these",
            reason=Reason.WRONG_STATE,
            robot=craft.node.name,
        )

    def to_drive(self, uid: int) -> CraftAtWork:
        """Return a craft at work that twists and ways drive.

        Raises KernelError as `driven` does, and for one under physics whose passive wheels are held by motors.
        """
        craft, now = self.driven(uid), self._world.snapshot
        if not craft.passive.joints or not any(node.uid == uid for node in under_physics(now.structure, now.state)):
            return craft
        node, robot = now.structure.nodes[uid], now.structure.robots[uid]
        wholes = [robot.joints[robot.coordinates[name].place] for name in craft.passive.joints]
        if held := [joint.name for joint in wholes if motor_of(node, joint).mode in COMMANDED]:
            raise KernelError(
                f"{node.name!r} can't roll: under physics motors hold its passive wheels, {', '.join(held)}; give "
                "these motors the mode 'free'",
                reason=Reason.WRONG_STATE,
                robot=node.name,
            )
        return craft

    @contextmanager
    def believed(self, uid: int, settings: Mapping[str, object]) -> Iterator[CraftAtWork]:
        """Lend a craft as it would be with other settings of its component (none: its own); any thread may ask.

        Raises KernelError as `driven` does, and for settings that the component refuses.
        """
        craft = self.driven(uid)
        if not settings:
            yield craft
            return
        other = replace(craft.craft, settings={**craft.craft.settings, **settings})
        component = self._started(other)
        try:
            yield at_work(self._world.snapshot.structure, craft.node, craft.craft, component)
        finally:
            component.close()

    def check_told(self, uid: int, mode: SetpointMode, joints: Sequence[str], values: Sequence[float]) -> None:
        """Raise LimitError for a setpoint of joints that no drive of a vessel follows; any thread may ask."""
        craft = self._at_work.get(uid)
        if isinstance(craft, Vessel) and mode in (SetpointMode.POSITION, SetpointMode.VELOCITY):
            craft.check_told(mode, joints, values)

    def fault_of(self, uid: int) -> str:
        """Return why a craft stands, in words; empty where it may move."""
        fault = self._faults.get(uid)
        return fault[1] if fault else ""

    def check(self, commands: Iterable[Command]) -> None:
        """Raise KernelError for a command that makes a craft by no component, or by settings that it refuses.

        And where the drives of the component are none of a robot that is there already.
        """
        structure = self._world.snapshot.structure
        for craft, robot in crafts_made(commands):
            component = self._started(craft)
            try:
                uid = structure.uid_by_name.get(robot)
                if uid is not None and isinstance(known := structure.nodes[uid].data, RobotData):
                    node = replace(structure.nodes[uid], data=replace(known, craft=craft))
                    _at_work(structure, node, craft, component)
            finally:
                component.close()

    def follow(self, motion: str, uid: int, twist: Floats) -> tuple[float, ...]:
        """Return the setpoint of a motion of a craft's drives for a twist (3,), and steer on to it from now on.

        A twist that is as old as the motion's timeout is followed no more. Raises as `to_drive` and `commands` of it
        do, and for drives beyond their limits; the motion is then steered to none but the twists before.
        """
        now = self._world.snapshot
        values = tuple(self.to_drive(uid).commands(twist, now.state.q, now.tick_seconds).tolist())
        run = next((one.running for one in now.state.motions if one.id == motion), None)
        if isinstance(run, SetpointMotion):
            run.set(values)  # changes nothing: it raises for what it refuses
            self._twists[motion] = _Twist(uid, twist, now.state.tick)
        return values

    def carry(self, now: Snapshot, positions: Floats) -> None:
        """Put into the coordinates of a brake (n, nq), a row for each tick, where drives take the bases of crafts."""
        for uid, craft in self._at_work.items():
            if uid not in self._faults:
                try:
                    craft.carry(positions, now.tick_seconds)
                except KernelError as error:
                    self._fail(craft, error)

    def carried(
        self,
        structure: Structure,
        at: At,
        travel: Travel,
        times: Sequence[float],
        given_up: Callable[[], bool] = lambda: False,
    ) -> CarriedBases | None:
        """Return a way of all coordinates with bases where drives take them; None where it moves no craft.

        Any thread may ask. Raises KernelError for a craft whose component fails.

        Args:
            structure: that of the world.
            at: the way, on which bases stand: coordinates (nq,) at a time.
            travel: how far each coordinate goes at the most between two times.
            times: rising ones, from its begin to its end, between which the way is smooth.
            given_up: whether nobody waits for it any more.
        """
        moved = travel(times[0], times[-1])
        bases: list[CarriedBase] = []
        for craft in self._of_structure(structure):
            if moved[craft.drives.q].any():
                self.of(craft.node.uid)
                bases.append(CarriedBase(craft, at, travel, times, given_up))
        return CarriedBases(at, travel, bases, len(moved)) if bases else None

    def _of_structure(self, structure: Structure) -> list[CraftAtWork]:
        """Return the crafts on wheels of a structure, which may be another one than that of the world as it is."""
        if structure is self._structure:
            return [craft for craft in list(self._at_work.values()) if isinstance(craft, CraftAtWork)]
        made = dict(self._made)
        found = (
            _at_work(structure, node, craft, made[node.uid][1])
            for node, _, craft in crafts(structure)
            if node.uid in made and made[node.uid][0] == craft
        )
        return [craft for craft in found if isinstance(craft, CraftAtWork)]

    def admit(self, before: Snapshot, after: Snapshot, batch: Sequence[Command]) -> None:
        """Raise KernelError (PLUGIN_FAILED) for a motion that a craft should make whose component has failed."""
        if not self._faults:
            return
        for command in batch:
            names = [command.robot] if isinstance(command, StartSetpointMotion) else []
            names += [robot for robot, _ in command.joints] if isinstance(command, StartMotion) else []
            for uid in {after.structure.robot(name)[0].uid for name in names} & self._faults.keys():
                self.of(uid)

    def before_tick(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        """Return where crafts are at the end of the tick, unless that was said already.

        Raises Late once nothing is left to say but of crafts whose components are late.
        """
        if self._twists and (steered := self._steered(now)):
            return steered
        found: list[Moved] = []
        stopped: list[Command] = []
        late: Late | None = None
        by_forces = {node.uid for node in under_physics(now.structure, now.state)}
        for uid, craft in self._at_work.items():
            if uid in self._faults or uid in now.state.commanded or uid in by_forces:
                continue
            key = (now.state.tick, craft.key(now, later))
            asked = self._asked.get(uid)
            if asked == key:
                continue
            try:
                moved = craft.moved(now, later)
            except KernelError as error:
                self._fail(craft, error)
                why = Cancellation(EndCause.FAILED, _stands(craft.node, str(error)))
                stopped.append(StopRobots((uid,), why))
                found.append(craft.at_rest(now.state.q))
                continue
            except Late as missing:
                late = missing
                continue
            said = asked is not None and asked[0] == now.state.tick
            if moved is None and (said or craft.is_moving(now)):
                moved = craft.at_rest(now.state.q)
            if moved is not None:
                self._asked[uid] = key
                found.append(moved)
        if late is not None and not found:
            raise late
        return [*stopped, _command(found)] if found else ()

    def after_change(self, now: Snapshot) -> Sequence[Command]:
        """Return nothing: crafts move with ticks."""
        return ()

    def _steered(self, now: Snapshot) -> list[Command]:
        """Return the setpoints of motions that follow twists, where steering angles have come nearer to them."""
        commands: list[Command] = []
        late: Late | None = None
        motions = {motion.id: motion.running for motion in now.state.motions}
        for id, (uid, twist, tick) in list(self._twists.items()):
            run, craft = motions.get(id), self._at_work.get(uid)
            if not isinstance(run, SetpointMotion) or not isinstance(craft, CraftAtWork) or uid in self._faults:
                self._twists.pop(id, None)
                self._told.pop(id, None)
                continue
            if run.closed or run.phase is not Phase.RUNNING:
                continue
            if (now.state.tick - tick) * now.tick_seconds > run.timeout:
                why = f"no setpoint came for {run.timeout:g} s"
                commands.append(CancelMotion(id, Cancellation(EndCause.SETPOINT_TIMEOUT, why)))
                continue
            made_of = twist.tobytes() + now.state.q[craft.drives.q].tobytes()
            known, values = self._told.get(id, (b"", ()))
            if known != made_of:
                try:
                    values = tuple(craft.commands(twist, now.state.q, now.tick_seconds).tolist())
                    run.set(values)  # changes nothing: a refusal in the tick would cost all crafts theirs
                except KernelError as error:
                    commands.append(CancelMotion(id, Cancellation(EndCause.SETPOINT_REFUSED, str(error))))
                    continue
                except Late as missing:
                    late = missing
                    continue
                self._told[id] = made_of, values
            if values != run.newest:
                commands.append(SetSetpoint(id, values))
        if late is not None and not commands:
            raise late
        return commands

    def _fail(self, craft: CraftAtWork | Vessel, error: KernelError) -> None:
        log.error("the craft %r stops: %s", craft.node.name, error)
        self._faults[craft.node.uid] = craft.craft, str(error)

    def _published(self) -> None:
        """Know the crafts of a new structure; told in the world thread of all that is published."""
        structure = self._world.snapshot.structure
        if structure is self._structure:
            return
        self._structure = structure
        made, self._made, self._at_work, self._asked, self._told = self._made, {}, {}, {}, {}
        faults, self._faults = self._faults, {}
        for node, _, craft in crafts(structure):
            self._begin(structure, node, craft, made.pop(node.uid, None), faults.get(node.uid))
        for _, component in made.values():
            component.close()
        if bool(self._at_work or self._faults) != self._supervises:
            self._supervises = not self._supervises
            if self._supervises:
                self._world.supervise(self, first=True)
            else:
                self._world.unsupervise(self)

    def _begin(
        self,
        structure: Structure,
        node: Node,
        craft: Craft,
        kept: tuple[Craft, ComponentHandle] | None,
        fault: tuple[Craft, str] | None,
    ) -> None:
        """Take up a craft, with the component that it had where that is the same choice."""
        if kept is not None and kept[0] is not craft:
            kept[1].close()
            kept = None
        try:
            component = kept[1] if kept else self._started(craft)
            self._made[node.uid] = craft, component
            self._at_work[node.uid] = _at_work(structure, node, craft, component)
            if fault is not None and fault[0] is craft:
                self._faults[node.uid] = fault
        except KernelError as error:
            log.error("the craft %r stands: %s", node.name, error)
            self._faults[node.uid] = craft, str(error)

    def _started(self, craft: Craft) -> ComponentHandle:
        is_vessel = craft.kinematics in self._catalog.offers(ComponentKind.VEHICLE_DYNAMICS)
        kind = ComponentKind.VEHICLE_DYNAMICS if is_vessel else ComponentKind.MOBILE_KINEMATICS
        return start(self._catalog.find(kind, craft.kinematics), craft.settings)


def _stands(node: Node, fault: str) -> str:
    return f"the craft {node.name!r} stands: {fault}; choose another component with set_craft, or the same anew"


def _at_work(structure: Structure, node: Node, craft: Craft, component: ComponentHandle) -> CraftAtWork | Vessel:
    is_vessel = component.offer.about.kind is ComponentKind.VEHICLE_DYNAMICS
    return (vessel if is_vessel else at_work)(structure, node, craft, component)


def _command(found: Sequence[Moved]) -> SetDynamics:
    q = {place: value for one in found for place, value in one.q.items()}
    v = {place: value for one in found for place, value in one.v.items()}
    q_index, v_index = (np.array(sorted(values), np.int32) for values in (q, v))
    return SetDynamics(
        q_index,
        np.array([q[place] for place in q_index.tolist()]),
        v_index,
        np.array([v[place] for place in v_index.tolist()]),
    )
