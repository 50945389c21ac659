"""Kinematics components of robots and groups: made and tried when first asked for, kept until these change."""

from __future__ import annotations

import logging
import queue
import threading
import weakref
from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, TypeGuard, TypeVar

import numpy as np
from virtualrobot_sdk.answers import (
    check_solution,
    check_solutions,
    checked_frames,
    checked_jacobian,
    checked_many,
    checked_name,
    checked_result,
    checked_results,
)
from virtualrobot_sdk.errors import ComponentFault
from virtualrobot_sdk.kinematics import Floats, InverseMany, InverseOptions, InverseResult, SerialChain
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.selfcheck import SelfCheck, self_check

from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.running import ComponentHandle, start
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.robots import Arm, Tips, tip_of, tips_of
from virtualrobot_kernel.world.commands import Command, CreateNodes, SetGroups, SetKinematics, UpdateNode
from virtualrobot_kernel.world.groups import WHOLE, Group, named_group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import Applied
from virtualrobot_kernel.world.structure import JointGroup, Node, NodeSpec, RobotData, Structure

AUTOMATIC = ("closed_form", "arm_angle", "chain")
"""Components tried in order for a robot that names none: the first that takes it; the last one's refusal is told."""
MOST_ENDS = 3
"""Number of ends of its process after which a component is not made anew."""
FORGIVEN_CALLS = 100
"""Number of calls after which the ends before them do not count."""
PASSING_ARMS = 32
"""Number of components kept ready for arms with locked joints and for chains that are chosen by links."""
CHECK_SEED = 20061
"""Seed of a self-check's random postures: the same component on the same robot is always judged alike."""

log = logging.getLogger(__name__)

_DEFAULTS = InverseOptions()

Answer = TypeVar("Answer")

_Key = tuple[int, str]
"""Robot (uid) and the name of its group; empty for the robot itself."""

Tip = Callable[[Floats], Floats]
"""Forward kinematics of a robot: base_t_tip (4, 4) at q (k,)."""


class Solver:
    """Kinematics component of a robot, every answer of which is checked before anybody relies on it.

    It gets copies: one that runs in this process could write into what it is given.
    """

    def __init__(self, running: ComponentHandle, chain: SerialChain, tip: Tip | None, tips: Tips | None = None) -> None:
        """Take a component that was made for `chain`; the robot's own tree has the chain's tip at `tip(q)`.

        `tips` says the same of many postures. Without them solutions are not compared with the tree: while it is tried,
        by how much it misses is to be told.
        """
        self.running = running
        self.chain = chain
        self._tip = tip
        self._tips = tips

    def forward(self, q: Floats, /) -> Floats:
        """Return the poses (m, 4, 4) of the component's frames at q (k,), the last one the tip's."""
        return self._asked(checked_frames, "forward", q.copy())

    def jacobian(self, q: Floats, /) -> Floats:
        """Return the geometric Jacobian (6, k) at the tip, linear rows first, in the base frame."""
        return self._asked(lambda answer: checked_jacobian(answer, self.chain), "jacobian", q.copy())

    def inverse(self, base_t_tip: Floats, options: InverseOptions = _DEFAULTS, /) -> InverseResult:
        """Return the postures that put the tip at `base_t_tip` (4, 4), or the reason why there is none."""

        def checked(answer: object) -> InverseResult:
            result = checked_result(answer, self.chain, options)
            if self._tip is not None:
                for solution in result.solutions:
                    check_solution(self._tip(solution), base_t_tip, options)
            return result

        seed = None if options.seed is None else options.seed.copy()
        return self._asked(checked, "inverse", base_t_tip.copy(), replace(options, seed=seed))

    def configuration(self, q: Floats, /) -> str:
        """Return the name of the configuration that q (k,) is in; empty where the component has none for it."""
        if self.running.has("configuration"):
            return self._asked(checked_name, "configuration", q.copy())
        found = self.inverse(self.forward(q)[-1], InverseOptions(seed=q, respect_limits=False))
        return found.configurations[0] if found.configurations else ""

    def inverse_each(self, base_t_tip: Floats, options: InverseOptions = _DEFAULTS, /) -> list[InverseResult]:
        """Return what `inverse` does for each of many poses (n, 4, 4), whose answers are checked together.

        A fault in one of them is told when all were asked for.
        """
        seed = options.seed
        answers = [
            self.running.call("inverse", pose.copy(), options if seed is None else replace(options, seed=seed.copy()))
            for pose in base_t_tip
        ]
        try:
            results = checked_results(answers, self.chain, options)
            if self._tips is not None and results:
                target = np.repeat(base_t_tip, [len(result.solutions) for result in results], axis=0)
                postures = np.concatenate([result.solutions for result in results])
                check_solutions(self._tips(postures), target, options)
        except ComponentFault as fault:
            raise self.running.failed(fault) from fault
        return results

    def inverse_many(self, base_t_tip: Floats) -> InverseMany:
        """Return the postures within limits that `inverse` has without a seed for each of poses (n, 4, 4)."""
        if not self.running.has("inverse_many"):
            found = [result.solutions for result in self.inverse_each(base_t_tip, InverseOptions(seed=None))]
            empty = np.empty((0, len(self.chain.joint_names)))
            return InverseMany(np.repeat(np.arange(len(found)), list(map(len, found))), np.concatenate([empty, *found]))

        def checked(answer: object) -> InverseMany:
            result = checked_many(answer, self.chain, len(base_t_tip))
            if self._tips is not None:
                check_solutions(self._tips(result.solutions), base_t_tip[result.target], _DEFAULTS)
            return result

        return self._asked(checked, "inverse_many", base_t_tip.copy())

    def _asked(self, checked: Callable[[object], Answer], method: str, *arguments: object) -> Answer:
        """Return a method's answer, once it is checked; nonsense is a fault of the component."""
        answer = self.running.call(method, *arguments)
        try:
            return checked(answer)
        except ComponentFault as fault:
            raise self.running.failed(fault) from fault


@dataclass(frozen=True, slots=True, eq=False)
class Tried:
    """Component that fits its robot, and the results of its self-check."""

    chain: SerialChain
    asked: str
    """Name of the component as it was asked for; empty where it was chosen by itself."""
    kinematics: str
    settings: Mapping[str, Any]
    solver: Solver
    check: SelfCheck
    ends: int = 0
    """Number of times that a process of it has ended before this one."""
    before: str = ""
    """Latest fault of the process before this one."""

    @property
    def fault(self) -> str:
        """Return its latest fault since it was chosen; empty while there was none."""
        latest = self.solver.running.latest
        return latest.reason if latest else self.before

    @property
    def ends_so_far(self) -> int:
        """Return the number of ends of its process, this one included; long good work is not held against it."""
        running = self.solver.running
        return (running.fault is not None) + (self.ends if running.calls < FORGIVEN_CALLS else 0)


@dataclass(frozen=True, slots=True)
class Use:
    """Component at work for a robot, or for its group of this name."""

    robot: str
    group: str
    kinematics: str
    fault: str
    calls: int
    mean_call_seconds: float
    process_id: int


class Solvers:
    """Components of all robots; any thread may ask, and two that ask for the same robot wait for each other.

    A component that another one follows ends as soon as nobody uses it any more: a plan that began with it is finished.
    """

    def __init__(self, catalog: Catalog) -> None:
        """Take components from this catalog."""
        self._catalog = catalog
        self._kept: dict[_Key, Tried | _Refused] = {}
        self._passing: OrderedDict[tuple[int, Group, frozenset[tuple[int, float]]], Tried] = OrderedDict()
        self._locks: dict[int, threading.Lock] = {}
        self._lock = threading.Lock()
        self._closed = False
        # Put into by finalizers, which may run anywhere: its `put` never waits for a lock.
        self._unused: queue.SimpleQueue[ComponentHandle] = queue.SimpleQueue()
        threading.Thread(target=self._end_unused, name="components-end", daemon=True).start()

    def of(self, snapshot: Snapshot, arm: Arm) -> Solver:
        """Return the component that solves an arm, made and tried now when it has to be.

        Raises KernelError: WRONG_STATE when no joint moves the arm's tip; PLUGIN_FAILED when the component can't be
        made, does not fit or has failed, and with how to get one again where its process has ended too often; what it
        says itself when it refuses robot or settings. An arm with locked
        joints, or one that links choose, gets the component that its geometry allows, whatever the robot has.
        """
        if arm.locked or arm.group.is_ad_hoc:
            return self._of_passing(snapshot, arm)
        kept = self._kept_for(snapshot, arm)
        if isinstance(kept, _Refused):
            raise _again(kept.error)
        if (fault := kept.solver.running.fault) is not None and kept.ends_so_far >= MOST_ENDS:
            raise _given_up(kept, arm, fault)
        return kept.solver

    def _of_passing(self, snapshot: Snapshot, arm: Arm) -> Solver:
        """Return the component of an arm that no name stands for: of those used last some are kept."""
        chain, uid = arm.serial(), arm.robot.uid
        key = uid, arm.group, frozenset(arm.locked.items())
        with self._lock_of(uid):
            kept = self._passing.get(key)
            if kept is None or not _fits(kept, chain, "", {}) or kept.solver.running.fault:
                kept = self._tried(snapshot, arm, "", {})
            with self._lock:
                self._passing[key] = kept
                self._passing.move_to_end(key)
                while len(self._passing) > PASSING_ARMS:
                    self._passing.popitem(last=False)
        return kept.solver

    def name_of(self, snapshot: Snapshot, arm: Arm) -> str:
        """Return the name of the component that solves an arm, which is made and tried now when it has to be.

        Empty where no joint moves its tip; where it can't be made, the one whose refusal counts.
        """
        if arm.chain is None:
            return ""
        if arm.group.is_ad_hoc:
            return self._of_passing(snapshot, arm).running.offer.about.name
        return self._kept_for(snapshot, arm).kinematics

    def name_found(self, node: Node, group: Group = WHOLE) -> str:
        """Return the name of the component that a robot or its group has had so far, without waiting; else empty."""
        kept = self._kept_as_chosen(node, group)
        return kept.kinematics if kept is not None else ""

    def _kept_as_chosen(self, node: Node, group: Group) -> Tried | _Refused | None:
        """Return the component, or refusal, kept for a robot or its group, None where it is to have another by now."""
        kept = None if group.is_ad_hoc else self._kept.get((node.uid, group.name))
        return kept if kept is not None and (kept.asked, kept.settings) == chosen(node, group) else None

    def _kept_for(self, snapshot: Snapshot, arm: Arm) -> Tried | _Refused:
        chain = arm.serial()
        name, settings = chosen(arm.robot, arm.group)
        key = arm.robot.uid, arm.group.name
        with self._lock_of(arm.robot.uid):
            kept = before = self._kept.get(key)
            if kept is None or not _fits(kept, chain, name, settings) or _ended(kept):
                self._drop_all_but(snapshot.structure)
                try:
                    kept = self._tried(snapshot, arm, name, settings)
                    if before is not None and _ended(before) and _fits(before, chain, name, settings):
                        kept = replace(kept, ends=before.ends_so_far, before=before.fault)
                except KernelError as error:
                    # Kept too: nobody wants to wait for the same failure again.
                    kept = _Refused(chain, name, name or AUTOMATIC[-1], settings, error)
                self._kept[key] = kept
        return kept

    def swap(
        self, snapshot: Snapshot, arm: Arm, kinematics: str, settings: Mapping[str, Any], choose: Callable[[], Applied]
    ) -> tuple[Applied, SelfCheck]:
        """Try a new component on an arm, let the world choose it, and keep it; return what became of both.

        The robot keeps its own component until `choose` returns. Raises as `of` and `choose` do.
        """
        tried = self._tried(snapshot, arm, kinematics, settings)
        applied = choose()
        with self._lock_of(arm.robot.uid):
            self._retire(self._kept.get((arm.robot.uid, arm.group.name)))
            self._kept[arm.robot.uid, arm.group.name] = tried
        return applied, tried.check

    def check_choices(self, commands: Iterable[Command]) -> None:
        """Raise KernelError when a robot that a command creates or changes names a component that there isn't."""
        for command in commands:
            changed = command.specs if isinstance(command, CreateNodes) else [command]
            for one in changed:
                data = one.data if isinstance(one, NodeSpec | UpdateNode) else None
                choices = (data, *data.groups) if isinstance(data, RobotData) else (one,)
                choices = one.groups if isinstance(one, SetGroups) else choices
                for choice in choices:
                    if isinstance(choice, RobotData | JointGroup | SetKinematics) and choice.kinematics:
                        self._catalog.find(ComponentKind.KINEMATICS, choice.kinematics)

    def uses(self, structure: Structure) -> tuple[Use, ...]:
        """Return the components at work, with their robots."""
        self._drop_all_but(structure)
        found = []
        for (uid, group), kept in sorted(self._kept.copy().items(), key=lambda item: item[0]):
            node = structure.nodes.get(uid)
            if node is None:
                continue  # it is newer than the structure
            if isinstance(kept, _Refused):
                found.append(Use(node.name, group, kept.kinematics, kept.fault, 0, 0.0, 0))
                continue
            running = kept.solver.running
            process = 0 if running.fault else running.process_id
            calls, seconds = running.calls, running.mean_seconds
            found.append(Use(node.name, group, kept.kinematics, kept.fault, calls, seconds, process))
        return tuple(found)

    def fault_of(self, node: Node, group: Group = WHOLE) -> str:
        """Return the latest fault of a component of a robot or group since it was chosen; empty without any."""
        kept = self._kept_as_chosen(node, group)
        return kept.fault if kept is not None else ""

    def close(self) -> None:
        """End all components; no other is made."""
        self._closed = True
        every = [*self._kept.values(), *self._passing.values()]
        running = [kept.solver.running for kept in every if isinstance(kept, Tried)]
        self._kept.clear()
        self._passing.clear()
        with ThreadPoolExecutor(max(1, len(running))) as pool:
            list(pool.map(ComponentHandle.close, running))

    def _tried(self, snapshot: Snapshot, arm: Arm, asked: str, settings: Mapping[str, Any]) -> Tried:
        if asked:
            return self._tried_as(snapshot, arm, asked, asked, settings)
        offered = self._catalog.offers(ComponentKind.KINEMATICS)
        for name in AUTOMATIC[:-1]:
            if name not in offered:
                continue
            try:
                return self._tried_as(snapshot, arm, asked, name, settings)
            except KernelError as error:
                log.debug("%r gets no kinematics component %r: %s", arm.robot.name, name, error)
        return self._tried_as(snapshot, arm, asked, AUTOMATIC[-1], settings)

    def _tried_as(
        self, snapshot: Snapshot, arm: Arm, asked: str, kinematics: str, settings: Mapping[str, Any]
    ) -> Tried:
        if self._closed:
            raise KernelError("the kernel is ending", reason=Reason.SHUTTING_DOWN)
        offer = self._catalog.find(ComponentKind.KINEMATICS, kinematics)
        chain = arm.serial()
        running = start(offer, settings, chain, user=f" of {arm.robot.name!r}{arm.group}")
        tip = tip_of(snapshot, arm)
        try:
            check = self_check(Solver(running, chain, None), chain, tip, np.random.default_rng(CHECK_SEED))
            if failures := check.failures():
                raise KernelError(
                    f"the kinematics component {kinematics!r} does not fit {arm.robot.name!r}{arm.group}: "
                    f"{'; '.join(failures)}",
                    reason=Reason.PLUGIN_FAILED,
                    component=kinematics,
                    robot=arm.robot.name,
                    fault="NONSENSE",
                )
        except BaseException:
            running.close()
            raise
        solver = Solver(running, chain, tip, tips_of(snapshot, arm))
        weakref.finalize(solver, self._unused.put, running).atexit = False
        return Tried(chain, asked, kinematics, settings, solver, check)

    def _lock_of(self, robot: int) -> threading.Lock:
        with self._lock:
            return self._locks.setdefault(robot, threading.Lock())

    def _end_unused(self) -> None:
        while True:
            self._unused.get().close()

    def _retire(self, kept: Tried | _Refused | None) -> None:
        """End a component that another one follows, if it was at fault: errors that tell of it may keep it else."""
        if isinstance(kept, Tried) and kept.solver.running.latest is not None:
            self._unused.put(kept.solver.running)

    def _drop_all_but(self, structure: Structure) -> None:
        """Forget the components of robots that are gone; robots that the structure does not know yet are not."""
        for uid, group in self._kept.copy():
            if uid < structure.next_uid and (
                uid not in structure.robots or (group and group not in _group_names(structure.nodes[uid]))
            ):
                self._retire(self._kept.pop((uid, group), None))


@dataclass(frozen=True, slots=True, eq=False)
class _Refused:
    """Refusal of a component that could not be made or did not fit."""

    chain: SerialChain
    asked: str
    kinematics: str
    settings: Mapping[str, Any]
    error: KernelError

    @property
    def fault(self) -> str:
        """Return why."""
        return str(self.error)


def _ended(kept: Tried | _Refused) -> TypeGuard[Tried]:
    """Return whether a component's process has ended, and not so often that it is left at that."""
    return isinstance(kept, Tried) and kept.solver.running.fault is not None and kept.ends_so_far < MOST_ENDS


def _given_up(kept: Tried, arm: Arm, fault: ComponentFault) -> KernelError:
    """Return the error that tells of a component which is not made anew any more, and what brings one back."""
    group = f"{arm.robot.name!r}{arm.group}"
    return KernelError(
        f"the kinematics component {kept.kinematics!r} of {group} is not asked any more, since its process has ended "
        f"{MOST_ENDS} times, the last time: {fault.reason}; SetKinematics (`set_kinematics`) gives {group} "
        "another component, or the same one anew",
        reason=Reason.PLUGIN_FAILED,
        component=kept.kinematics,
        robot=arm.robot.name,
        fault=fault.kind.value,
        details=fault.details,
    )


def _again(error: KernelError) -> KernelError:
    """Return an equal error to raise: one that is raised twice would gather tracebacks."""
    again = KernelError(str(error), reason=error.reason)
    again.metadata.update(error.metadata)
    return again


def _group_names(node: Node) -> set[str]:
    return {group.name for group in node.data.groups} if isinstance(node.data, RobotData) else set()


def chosen(node: Node, group: Group = WHOLE) -> tuple[str, Mapping[str, Any]]:
    """Return name (empty: chosen by itself) and settings of the component that a robot or its group is to have."""
    assert isinstance(node.data, RobotData)
    data = named_group(node, group.name) if group.name else node.data
    return data.kinematics, data.kinematics_settings


def _fits(kept: Tried | _Refused, chain: SerialChain, kinematics: str, settings: Mapping[str, Any]) -> bool:
    if (kept.asked, kept.settings) != (kinematics, settings):
        return False
    if kept.chain is chain:
        return True
    return kept.chain.joint_names == chain.joint_names and all(
        np.array_equal(a, b) for a, b in zip(kept.chain[:-1], chain[:-1], strict=True)
    )
