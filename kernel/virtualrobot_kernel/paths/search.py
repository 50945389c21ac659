"""Path search by OMPL; the only file that sees the library, whose calls hold the interpreter's lock.

Source of the default: J. Kuffner, S. LaValle, RRT-Connect: an efficient approach to single-query path planning, IEEE
ICRA 2000. Library: I. Sucan, M. Moll, L. Kavraki, The Open Motion Planning Library, IEEE Robotics & Automation Magazine
19(4), 2012.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, Reason

if TYPE_CHECKING:
    from virtualrobot_kernel.paths.space import PathSpace

Floats = NDArray[np.float64]

DEFAULT = "RRTConnect"

FIRST = (DEFAULT, "RRT", "KPIECE1", "BKPIECE1", "LBKPIECE1")
"""Planners that end with the first path, by OMPL's names. PRM and PRMstar are none of them: in version 2.0.1 their
second thread waits for ever for the interpreter's lock."""

BETTER = ("RRTstar", "InformedRRTstar")
"""Planners that make the path shorter until their time is over. BITstar and AORRTC would be, but never give back the
memory of a search."""

PLANNERS = (*FIRST, *BETTER)

TOLD_SECONDS = 0.2
"""Period (s) at which the size of the tree is told."""


def library() -> tuple[Any, Any, Any]:
    """Return OMPL's modules base, geometric and util; raise KernelError when it is not installed."""
    try:
        from ompl import base, geometric, util
    except ImportError as error:
        raise KernelError(
            f"looking for a path needs the library ompl, which the kernel does not have ({error}): "
            "pip install 'virtualrobot[planning]'",
            reason=Reason.WRONG_STATE,
        ) from error
    util.setLogLevel(util.LogLevel.LOG_NONE)
    return base, geometric, util


def search(
    space: PathSpace,
    bounds: tuple[Floats, Floats],
    goals: Floats,
    line_is_free: Callable[[Floats, Floats], bool],
    *,
    planner: str,
    seed: int,
    seconds: float,
    go_on: Callable[[int], bool],
) -> Floats | None:
    """Return a path (n, k) from the start of a space to one of its goals; None when there was none in time.

    Equal for equal seeds, where the planner ends with the first path: one search at a time in a process, since OMPL
    draws its seeds from one place. It ends by time, so a path that is made better until then depends on the machine.

    Args:
        space: where it is looked for.
        bounds: (k,) and (k,) from where to where joints go.
        goals: (m, k), all free.
        line_is_free: whether the line from a configuration (k,), which is free, to another one is, its end too.
        planner: one of `PLANNERS`.
        seed: above 0.
        seconds: how long at the most.
        go_on: is told how many configurations the tree has, and returns whether to go on.
    """
    base, geometric, util = library()
    util.RNG.setSeed(seed)
    width = goals.shape[1]
    real = base.RealVectorStateSpace(width)
    box = base.RealVectorBounds(width)
    for joint, (lower, upper) in enumerate(zip(*bounds, strict=True)):
        box.setLow(joint, float(lower))
        box.setHigh(joint, float(upper))
    real.setBounds(box)
    information = base.SpaceInformation(real)

    def free(state: Any) -> bool:  # noqa: ANN401  OMPL's states have no type in Python
        return space.free(np.array(state[0:width]))

    class Lines(base.MotionValidator):
        def checkMotion(self, first: Any, last: Any) -> bool:  # noqa: ANN401
            return line_is_free(np.array(first[0:width]), np.array(last[0:width]))

    def state_of(q: Floats) -> Any:  # noqa: ANN401
        state = information.allocState()
        state[0:width] = q.tolist()
        return state

    lines = Lines(information)
    information.setStateValidityChecker(free)
    information.setMotionValidator(lines)
    information.setup()
    problem = base.ProblemDefinition(information)
    problem.addStartState(state_of(space.start))
    reached = base.GoalStates(information)
    for goal in goals:
        reached.addState(state_of(goal))
    problem.setGoal(reached)
    algorithm = getattr(geometric, planner)(information)
    algorithm.setProblemDefinition(problem)
    algorithm.setup()
    size, told = [0], [0.0]
    end = time.monotonic() + seconds

    def over() -> bool:
        now = time.monotonic()
        if now > told[0] + TOLD_SECONDS:
            told[0] = now
            size[0] = _size(base, information, algorithm)
        return now > end or not go_on(size[0])

    algorithm.solve(base.PlannerTerminationCondition(over))
    found = problem.getSolutionPath() if problem.hasExactSolution() else None
    waypoints = None if found is None else np.array([state[0:width] for state in found.getStates()])
    go_on(_size(base, information, algorithm))
    return waypoints


def _size(base: Any, information: Any, algorithm: Any) -> int:  # noqa: ANN401
    data = base.PlannerData(information)
    algorithm.getPlannerData(data)
    return data.numVertices()
