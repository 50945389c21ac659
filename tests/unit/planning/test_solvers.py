"""The components of robots: which robots they are tried on, who may still use one that another follows, and the end."""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.components.catalog import Catalog, Offer
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning import solvers as module
from virtualrobot_kernel.planning.free_joints import solve_inverse
from virtualrobot_kernel.planning.robots import arm_of, world_poses
from virtualrobot_kernel.planning.solvers import FORGIVEN_CALLS, MOST_ENDS, Solvers
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import CreateNodes, RemoveNode, SetKinematics
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import Applied
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, NodeSpec, RobotData
from virtualrobot_sdk.errors import ComponentFault, FaultKind
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult

from tests.tiers import every_fifth
from tests.unit.world.builders import after, arm, empty, link, shifted

REVOLUTE, PRISMATIC = JointType.REVOLUTE, JointType.PRISMATIC
LARGEST = np.finfo(float).max


class Instance:
    """Passes calls on to a component; tells when it is closed, and lets a test into each call."""

    process_id = 0
    is_in_process = False
    has_ended = False

    def __init__(self, component: Any) -> None:  # noqa: ANN401  any component
        """Take the component."""
        self.component = component
        self.closed = threading.Event()
        self.before: Callable[[], object] = lambda: None

    def has(self, method: str) -> bool:
        return self.component.has(method)

    def call(self, method: str, *arguments: object) -> Any:  # noqa: ANN401  what a method returns is its own matter
        self.before()
        assert not self.closed.is_set(), "it is asked after its end"
        return self.component.call(method, *arguments)

    def close(self) -> None:
        self.closed.set()


@pytest.fixture
def instances(monkeypatch: pytest.MonkeyPatch) -> list[Instance]:
    """Return the components that are made from now on, as they come."""
    made: list[Instance] = []
    begin = module.start

    def start(offer: Offer, settings: dict, *arguments: object, user: str = "") -> module.ComponentHandle:
        running = begin(offer, {}, *arguments, user=user)
        made.append(Instance(running._instance))
        running._instance = made[-1]
        return running

    monkeypatch.setattr(module, "start", start)
    return made


@pytest.fixture
def solvers() -> Iterator[Solvers]:
    solvers = Solvers(Catalog())
    yield solvers
    solvers.close()


def pictured(change: Change) -> Snapshot:
    return Snapshot(change.structure, change.state, world_poses(change.structure, change.state), 1, 0.0, 0.004)


def swap(solvers: Solvers, cell: Change, settings: dict) -> Change:
    """Give the arm of a cell its component anew, as SetKinematics does."""
    changed = after(cell, SetKinematics("arm", "chain", settings))
    snapshot = pictured(cell)
    node = cell.structure.node("arm")
    solvers.swap(snapshot, arm_of(snapshot, node), "chain", settings, lambda: Applied(pictured(changed), (), ()))
    return changed


def solve(solvers: Solvers, cell: Change, name: str = "arm") -> InverseResult:
    snapshot = pictured(cell)
    node = cell.structure.node(name)
    return solve_inverse(snapshot, node, shifted(0.8, 0.2, 0.3), {}, solvers.of)[1]


@pytest.mark.parametrize(
    "limits", [(-1e16, 1e16), (-LARGEST, LARGEST), (-1e16, 1.0), (0.5, 1e16), (1e5, 1e5 + 1.0), (0.5, 0.5)]
)
@pytest.mark.parametrize("kind", every_fifth([REVOLUTE, PRISMATIC]))
def test_a_robot_may_have_limits_that_mean_none(solvers: Solvers, kind: JointType, limits: tuple[float, float]) -> None:
    """SDF writes 1e16 where a joint has no limit."""
    joint = Joint("a", kind, (0.0, 0.0, 1.0), JointLimits(*limits, 1.0, 4.0, 40.0))
    other = Joint("b", REVOLUTE, (0.0, 1.0, 0.0), JointLimits(-1.0, 1.0, 1.0, 4.0, 40.0))
    specs = [NodeSpec("r", Kind.ROBOT, data=RobotData()), link("r.one", "r", joint)]
    cell = after(empty(), CreateNodes((*specs, link("r.two", "r.one", other, shifted(0.3, 0.2, 0.1)))))
    snapshot = pictured(cell)
    solvers.of(snapshot, arm_of(snapshot, cell.structure.node("r")))
    assert [(use.robot, use.fault) for use in solvers.uses(cell.structure)] == [("r", "")]


def test_who_solves_is_not_disturbed_by_a_swap(solvers: Solvers, instances: list[Instance]) -> None:
    cell = after(empty(), arm())
    solve(solvers, cell)
    (first,) = instances
    begun, go_on = threading.Event(), threading.Event()
    first.before = lambda: (begun.set(), go_on.wait())
    with ThreadPoolExecutor() as pool:
        solving = pool.submit(solve, solvers, cell)
        begun.wait()
        changed = swap(solvers, cell, {"any": 1})
        assert not first.closed.is_set()
        go_on.set()
        solving.result()
    del solving
    gc.collect()
    assert first.closed.wait(10.0)
    solve(solvers, changed)
    assert len(instances) == 2
    assert not instances[1].closed.is_set()


def test_a_component_that_the_world_refuses_ends_and_the_robot_keeps_its_own(
    solvers: Solvers, instances: list[Instance]
) -> None:
    cell = after(empty(), arm())
    solve(solvers, cell)
    snapshot = pictured(cell)

    def refuse() -> Applied:
        raise KernelError("the robot is gone", reason=Reason.UNKNOWN_NAME)

    with pytest.raises(KernelError, match="the robot is gone"):
        solvers.swap(snapshot, arm_of(snapshot, cell.structure.node("arm")), "chain", {}, refuse)
    gc.collect()
    first, second = instances
    assert second.closed.wait(10.0)
    solve(solvers, cell)
    assert not first.closed.is_set()
    assert len(instances) == 2


def test_a_component_that_ended_is_made_anew_three_times_in_a_row(solvers: Solvers, instances: list[Instance]) -> None:
    cell = after(empty(), arm())
    crash = ComponentFault(FaultKind.DIED, "its process ended with SIGSEGV in inverse")

    def ends() -> None:
        instances[-1].has_ended = True
        raise crash

    for made in range(1, MOST_ENDS + 1):
        solve(solvers, cell)  # answered
        assert len(instances) == made
        instances[-1].before = ends
        with pytest.raises(KernelError, match="SIGSEGV"):
            solve(solvers, cell)
        assert "SIGSEGV" in solvers.fault_of(cell.structure.node("arm"))
    told = (
        r"of 'arm' is not asked any more, since its process has ended 3 times, the last time: .*SIGSEGV.*; "
        r"SetKinematics \(`set_kinematics`\) gives 'arm' another component, or the same one anew"
    )
    with pytest.raises(KernelError, match=told) as refused:
        solve(solvers, cell)
    assert refused.value.metadata["fault"] == "DIED"
    assert len(instances) == MOST_ENDS


def test_much_good_work_is_held_against_no_end(solvers: Solvers, instances: list[Instance]) -> None:
    cell = after(empty(), arm())
    for made in range(1, MOST_ENDS + 2):
        for _ in range(FORGIVEN_CALLS):
            solve(solvers, cell)
        assert len(instances) == made
        instances[-1].has_ended = True
        instances[-1].before = raising(ComponentFault(FaultKind.HUNG, "inverse gave no answer within 1 s"))
        with pytest.raises(KernelError, match="no answer"):
            solve(solvers, cell)


def test_one_wrong_answer_costs_one_call(solvers: Solvers, instances: list[Instance]) -> None:
    cell = after(empty(), arm())
    solve(solvers, cell)
    (instance,) = instances
    for _ in range(2 * MOST_ENDS):
        instance.before = raising(ComponentFault(FaultKind.RAISED, "KeyError: 'elbow up'"))
        with pytest.raises(KernelError, match="elbow up"):
            solve(solvers, cell)
        instance.before = lambda: None
        solve(solvers, cell)  # answered
    assert instances == [instance]
    assert solvers.fault_of(cell.structure.node("arm")) == "KeyError: 'elbow up'"


def raising(error: Exception) -> Callable[[], object]:
    """Return a function that raises `error`."""

    def function() -> None:
        raise error

    return function


def test_only_robots_that_are_gone_lose_their_components(solvers: Solvers, instances: list[Instance]) -> None:
    """A client may still look at a world that is older than a robot."""
    old = after(empty(), arm("left"), arm("arm"))
    new = after(old, arm("new"))
    solve(solvers, new, "new")
    solve(solvers, old, "left")
    assert [use.robot for use in solvers.uses(old.structure)] == ["left"]
    assert [use.robot for use in solvers.uses(new.structure)] == ["left", "new"]
    assert not any(one.closed.is_set() for one in instances)
    newer = after(new, RemoveNode("left"))
    assert [use.robot for use in solvers.uses(newer.structure)] == ["new"]
    gc.collect()
    assert instances[1].closed.wait(10.0)
    assert not instances[0].closed.is_set()


def test_a_component_cannot_write_into_what_others_see(solvers: Solvers, instances: list[Instance]) -> None:
    cell = after(empty(), arm())
    snapshot = pictured(cell)
    solver = solvers.of(snapshot, arm_of(snapshot, cell.structure.node("arm")))
    (one,) = instances
    right = one.component

    class Writing:
        """Uses what it is given as its own, and its answer's buffer again."""

        buffer = right.call("forward", np.zeros(2)).copy()

        def call(self, method: str, *arguments: object) -> Any:  # noqa: ANN401  what a method returns is its own matter
            return getattr(self, method)(*arguments)

        def forward(self, q: Floats) -> Floats:
            self.buffer[:] = right.call("forward", q)
            q[:] = 9.0
            return self.buffer

        def jacobian(self, q: Floats) -> Floats:
            jacobian = right.call("jacobian", q)
            q[:] = 9.0
            return np.asfortranarray(jacobian)[::-1][::-1]

        def inverse(self, base_t_tip: Floats, options: InverseOptions) -> InverseResult:
            """Return what is wrong, and make the target fit it."""
            result = right.call("inverse", base_t_tip, options)
            wrong = result.solutions + 0.1
            base_t_tip[:] = right.call("forward", wrong[0])[-1]
            if options.seed is not None:
                options.seed[:] = 9.0
            return result._replace(solutions=wrong)

    one.component = Writing()
    q = np.array([0.3, -0.4])
    frames = solver.forward(q)
    kept = frames.copy()
    solver.forward(np.zeros(2))
    np.testing.assert_array_equal(frames, kept)
    assert solver.jacobian(q).flags.c_contiguous
    with pytest.raises(KernelError, match="misses its target by"):
        solver.inverse(kept[-1].copy(), InverseOptions(seed=q))
    np.testing.assert_array_equal(q, [0.3, -0.4])


def test_nothing_is_made_after_the_end(solvers: Solvers, instances: list[Instance]) -> None:
    cell = after(empty(), arm("arm"), arm("other"))
    solve(solvers, cell)
    solvers.close()
    assert instances[0].closed.is_set()
    with pytest.raises(KernelError) as refused:
        solve(solvers, cell, "other")
    assert refused.value.reason is Reason.SHUTTING_DOWN
    assert len(instances) == 1
