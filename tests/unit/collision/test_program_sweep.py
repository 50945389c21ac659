"""Checked motions that touch something: when and where by formulas, several robots, zones, tools, thin walls."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.api.motion_plans import contact_of
from virtualrobot_kernel.collision.scene import CollisionScene, Detail
from virtualrobot_kernel.collision.swept import RESOLUTION
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.planning.check import Checked, check_motion
from virtualrobot_kernel.planning.moves import JointTrajectory, Move, PointToPoint, ToolStateMove
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.program import DwellStep, MotionSpec, MoveStep, Zone
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.planning.sampling import joint_states
from virtualrobot_kernel.planning.violations import Contact, Violation, ViolationKind
from virtualrobot_kernel.world.commands import (
    AttachNode,
    CreateNodes,
    SelectTool,
    SetAllowedPairs,
    SetToolState,
    StartMotion,
)
from virtualrobot_kernel.world.figures import Box, Sphere
from virtualrobot_kernel.world.state import Snapshot

from tests.unit.collision.sweepers import (
    BALL,
    LEVER,
    body,
    contact_angle,
    growing,
    slider,
    sweeper,
    turning,
)
from tests.unit.collision.worlds import SHAPES, after, somewhere, with_robots, world
from tests.unit.planning.cell import chain
from tests.unit.world.builders import part, shifted


def waiting() -> bool:
    """Tell that somebody waits for the answer."""
    return False


def checked(snapshot: Snapshot, *wishes: Move | MoveStep | DwellStep, resolution: float = RESOLUTION) -> Checked:
    """Return what a check finds of moves that go together, or of steps."""
    moves = tuple(wish for wish in wishes if not isinstance(wish, MoveStep | DwellStep))
    steps = tuple(wish for wish in wishes if isinstance(wish, MoveStep | DwellStep))

    def first_contact(snapshot: Snapshot, command: StartMotion, until: float) -> Contact | None:
        return contact_of(CollisionScene(SHAPES), snapshot, command, until, resolution, waiting)

    return check_motion(snapshot, MotionSpec(moves, steps), chain, 0.0, waiting, first_contact)


def told(snapshot: Snapshot, *wishes: Move | MoveStep | DwellStep) -> Violation:
    """Return the collision that a check finds."""
    found = checked(snapshot, *wishes).first_violation
    assert found is not None and found.kind is ViolationKind.COLLISION
    return found


def position(snapshot: Snapshot, time: float, *moves: Move) -> np.ndarray:
    """Return where the joints of a motion are at a time."""
    program = plan_motion(snapshot, MotionSpec(moves), chain, waiting).command.program
    return joint_states(program, np.array([time]))[0][0]


def test_a_ball_that_is_turned_meets_another_one_by_the_formula(rng: np.random.Generator) -> None:
    """Anywhere in the plane, at any angle on its way, with any radius."""
    radius, angle = float(rng.uniform(0.001, 0.2)), float(rng.uniform(0.5, 2.5))
    base = shifted(*rng.uniform(-1.0, 1.0, 3)) @ turning(float(rng.uniform(-3.0, 3.0)))
    ball = body("ball", Sphere(radius), base @ turning(angle) @ shifted(x=LEVER))
    snapshot = world(CreateNodes((*sweeper(pose=base), ball)))
    move = PointToPoint("sweeper", {"turn": 3.0})
    found = told(snapshot, move)
    assert found.time is not None and found.contact is not None
    meets = angle - contact_angle(radius)
    (reached,) = position(snapshot, found.time, move)
    assert 0.0 <= meets - reached <= 1.01 * RESOLUTION / LEVER
    assert found.path_fraction == pytest.approx(reached / 3.0, abs=1e-6)
    assert (found.robot, found.joint, found.step) == ("sweeper", "", 0)
    (first, first_point), (second, second_point) = found.contact
    assert (first, second) == ("sweeper.ball", "ball")
    assert found.value == pytest.approx(float(np.linalg.norm(first_point - second_point)), abs=1e-9)
    assert 0.0 <= found.value <= found.limit == RESOLUTION
    centre = base @ turning(reached) @ shifted(x=LEVER)
    assert np.linalg.norm(first_point - centre[:3, 3]) == pytest.approx(BALL, abs=1e-9)
    assert found.world_t_tcp is not None
    np.testing.assert_allclose(found.world_t_tcp, base @ turning(reached), atol=1e-9)
    assert f"'sweeper.ball' touches 'ball' after {found.time:.4g} s, with the tool centre point at x" in found.message
    assert checked(snapshot, PointToPoint("sweeper", {"turn": meets - 1e-3})).first_violation is None


def test_two_that_move_meet_where_both_are_then(rng: np.random.Generator) -> None:
    """Two slides towards each other on one line; each alone would meet the other later."""
    gap, ratio = float(rng.uniform(0.5, 1.5)), float(rng.uniform(0.2, 1.0))
    snapshot = world(CreateNodes((*slider("left"), *slider("right", shifted(x=gap) @ turning(np.pi)))))
    seconds = float(rng.uniform(3.0, 5.0))

    def slid(robot: str, way: float) -> JointTrajectory:
        return JointTrajectory(robot, ("slide",), np.array([0.0, seconds]), np.array([[0.0], [way]]))

    moves = slid("left", gap), slid("right", ratio * gap)
    found = told(snapshot, *moves)
    assert found.time is not None
    left, right = position(snapshot, found.time, *moves)
    assert 0.0 <= gap - 2.0 * BALL - left - right <= 1.01 * RESOLUTION
    assert told(snapshot, moves[0]).time > found.time  # pyright: ignore[reportOptionalOperand]


@pytest.mark.parametrize("thickness", [1e-3, 1e-5])
def test_no_wall_is_too_thin(thickness: float) -> None:
    """At its 1 m/s the slide goes 4 mm in a tick."""
    wall = body("wall", Box((thickness, 1.0, 1.0)), shifted(x=1.0))
    snapshot = world(CreateNodes((*slider(), wall)))
    move = PointToPoint("slider", {"slide": 3.0})
    found = told(snapshot, move)
    assert found.time is not None
    (reached,) = position(snapshot, found.time, move)
    assert 0.0 <= 1.0 - thickness / 2.0 - BALL - reached <= 1.01 * RESOLUTION


def test_what_is_rounded_off_counts_and_not_the_corner() -> None:
    """Two slides across each other go round a corner; a ball stands in the corner, out of the rounded way."""
    along = slider("along")
    across = slider("across", turning(np.pi / 2.0))
    attached = AttachNode("across", "along.ball")
    corner = body("corner", Sphere(0.01), shifted(x=1.0 + BALL))
    snapshot = world(CreateNodes((*along, *across, corner)), attached)

    def steps(zone: Zone | None) -> tuple[MoveStep, ...]:
        return (
            MoveStep((PointToPoint("along", {"slide": 1.0}),), zone),
            MoveStep((PointToPoint("across", {"slide": 1.0}),)),
        )

    allowed = after(snapshot, SetAllowedPairs((("along.ball", "across.ball", ""), ("along.ball", "corner", ""))))
    exact = told(allowed, *steps(None))
    assert (exact.step, exact.robot) == (0, "along")
    assert exact.path_fraction is not None and exact.path_fraction > 0.98
    zoned = checked(allowed, *steps(Zone(percent=40.0)))
    assert zoned.first_violation is None and zoned.duration > 0.0


def test_the_step_and_the_time_are_those_of_the_program() -> None:
    wall = body("wall", Box((0.1, 1.0, 1.0)), shifted(x=-1.0))
    snapshot = world(CreateNodes((*slider(), wall)))
    there = MoveStep((PointToPoint("slider", {"slide": 1.0}),))
    back = MoveStep((PointToPoint("slider", {"slide": -1.5}),))
    free = checked(snapshot, there, DwellStep(0.7))
    assert free.first_violation is None
    found = told(snapshot, there, DwellStep(0.7), back)
    assert found.step == 2 and found.time is not None and found.time > free.duration
    assert found.path_fraction == pytest.approx((1.0 + 0.95 - BALL) / 2.5, abs=2e-4)


def test_a_tool_looks_as_the_program_has_left_it() -> None:
    """It is let grow when the slide has gone 0.2 m: small it reaches 0.2 m ahead of the slide, large 0.6 m."""
    wall = body("wall", Box((0.2, 1.0, 1.0)), shifted(x=1.4))
    snapshot = world(CreateNodes((*slider(), growing("tool", "slider.ball"), wall)))
    snapshot = after(snapshot, SelectTool("slider", "tool", "tip"), SetToolState("tool", "small"))
    first = MoveStep((PointToPoint("slider", {"slide": 0.2}),))
    grow = MoveStep((ToolStateMove("slider", "tool", "large"),))
    on = MoveStep((PointToPoint("slider", {"slide": 1.0}),))
    assert checked(snapshot, first, on).first_violation is None
    found = told(snapshot, first, grow, on)
    assert found.step == 2 and found.contact is not None
    assert found.contact[0][0] == "tool"
    assert found.path_fraction == pytest.approx((1.3 - 0.6 - 0.2) / 0.8, abs=1e-3)
    backwards = told(after(snapshot, SetToolState("tool", "large")), on)
    assert backwards.path_fraction == pytest.approx(0.7, abs=1e-3)


def test_a_part_that_is_carried_touches_in_its_robot_s_name() -> None:
    wall = body("wall", Box((0.1, 1.0, 1.0)), shifted(x=1.0))
    snapshot = world(CreateNodes((*slider(), wall, part("load", shifted(x=0.3)))), AttachNode("load", "slider.ball"))
    found = told(snapshot, PointToPoint("slider", {"slide": 2.0}))
    assert found.robot == "slider" and found.contact is not None
    assert {name for name, _ in found.contact} == {"wall", "load"}
    assert found.path_fraction == pytest.approx((0.95 - 0.35) / 2.0, abs=1e-4)


def test_what_touches_already_is_told_at_the_start_unless_it_may() -> None:
    floor = body("floor", Box((4.0, 4.0, 0.1)), shifted(z=-0.1))
    snapshot = world(CreateNodes((*slider(), floor)))
    move = PointToPoint("slider", {"slide": 1.0})
    found = told(snapshot, move)
    assert (found.time, found.path_fraction, found.value) == (0.0, 0.0, 0.0)
    assert "touches 'floor' where the motion starts, with" in found.message
    allowed = after(snapshot, SetAllowedPairs((("slider.ball", "floor", "it rolls"),)))
    assert checked(allowed, move).first_violation is None


def test_what_the_motion_does_not_move_does_not_count() -> None:
    """The other slide is in a collision all the time."""
    others = (*slider("other", shifted(y=2.0)), body("ball", Sphere(0.5), shifted(y=2.0)))
    snapshot = world(CreateNodes((*slider(), *others)))
    assert checked(snapshot, PointToPoint("slider", {"slide": 1.0})).first_violation is None
    assert told(snapshot, PointToPoint("other", {"slide": 1.0})).time == 0.0


@pytest.mark.parametrize(("at", "kind"), [(2.5, ViolationKind.COLLISION), (4.0, ViolationKind.JOINT_POSITION)])
def test_the_sooner_of_two_violations_is_told(at: float, kind: ViolationKind) -> None:
    """The slide ends at 3 m; a wall before its end, or behind it, on a way of 5 m that a start would refuse."""
    wall = body("wall", Box((0.1, 1.0, 1.0)), shifted(x=at))
    snapshot = world(CreateNodes((*slider(), wall)))
    found = checked(snapshot, PointToPoint("slider", {"slide": 5.0})).first_violation
    assert found is not None and found.kind is kind


def test_nothing_is_looked_for_that_nobody_asks_for() -> None:
    wall = body("wall", Box((0.1, 1.0, 1.0)), shifted(x=1.0))
    snapshot = world(CreateNodes((*slider(), wall)))
    wish = MotionSpec((PointToPoint("slider", {"slide": 2.0}),))
    assert check_motion(snapshot, wish, chain, 0.0, waiting).first_violation is None


def test_a_resolution_makes_contacts_sooner_by_no_more(rng: np.random.Generator) -> None:
    resolution = float(rng.uniform(0.001, 0.05))
    wall = body("wall", Box((0.1, 1.0, 1.0)), shifted(x=1.05 + BALL))
    snapshot = world(CreateNodes((*slider(), wall)))
    move = PointToPoint("slider", {"slide": 2.0})
    found = checked(snapshot, move, resolution=resolution).first_violation
    assert found is not None and found.time is not None
    (reached,) = position(snapshot, found.time, move)
    assert 0.0 <= 1.0 - reached <= 1.01 * resolution
    assert found.limit == resolution and 0.0 <= found.value <= resolution


def test_a_caller_who_gives_up_ends_the_check() -> None:
    wall = body("wall", Box((0.1, 1.0, 1.0)), shifted(x=1.0))
    snapshot = world(CreateNodes((*slider(), wall)))
    command = plan_motion(snapshot, MotionSpec((PointToPoint("slider", {"slide": 2.0}),)), chain, waiting).command
    with pytest.raises(KernelError, match="nobody waits"):
        contact_of(CollisionScene(SHAPES), snapshot, command, np.inf, RESOLUTION, lambda: True)


@pytest.mark.parametrize("kind", ["iiwa", "panda"])
def test_real_arms_among_boxes_touch_when_it_was_told_and_not_before(kind: str, rng: np.random.Generator) -> None:
    """Random programs with zones: each 2 ms of what was told to be free is asked of the collision scene."""
    seconds = 0.002
    arm = with_robots(kind)
    # None touches the arm's base: that does not move, so it does not count.
    places = rng.uniform((0.35, -0.8, -0.8), 0.8, (8, 3)) * rng.choice((-1.0, 1.0), (8, 1))
    boxes = [
        body(f"box {row}", Box(tuple(rng.uniform(0.05, 0.2, 3).tolist())), shifted(*place))
        for row, place in enumerate(places)
    ]
    index = next(iter(arm.structure.robots.values()))
    scene = CollisionScene(SHAPES)
    for _ in range(6):
        snapshot = somewhere(after(arm, CreateNodes(tuple(boxes))), rng)
        here = snapshot.state.q[list(index.q_start)]
        lower = np.array([joint.limits.lower for joint in index.joints])
        upper = np.array([joint.limits.upper for joint in index.joints])
        steps = []
        for _ in range(2):
            goal = np.clip(here + rng.uniform(-0.5, 0.5, len(here)), lower, upper)
            move = PointToPoint(kind, dict(zip(index.joint_names, goal.tolist(), strict=True)))
            steps.append(MoveStep((move,), Zone(percent=30.0)))
        program = plan_motion(snapshot, MotionSpec(steps=tuple(steps)), chain).command.program
        told = checked(snapshot, *steps).first_violation
        if told is not None and told.kind is not ViolationKind.COLLISION:
            continue
        until = program.duration if told is None or told.time is None else told.time - 1e-9
        times = np.arange(0.0, until, seconds)
        moving = np.array(index.q_start, np.int32)
        for q in joint_states(program, times)[0]:
            scene.place(standing_at(snapshot, moving, q))
            assert not scene.collisions(Detail.FIRST)
        if told is not None and told.contact is not None:
            scene.place(standing_at(snapshot, moving, joint_states(program, np.array([told.time]))[0][0]))
            nodes = [snapshot.structure.node(name).uid for name, _ in told.contact]
            (near,) = scene.distances(nodes[:1], nodes[1:], 0.0)
            assert near.distance == pytest.approx(told.value, abs=1e-9)
            assert near.distance <= RESOLUTION


def test_steps_are_done_when_the_next_ones_begin() -> None:
    """Of a program's own times: those at which `ProgramRun.steps_done` grows."""
    snapshot = world(CreateNodes(slider()))
    moves = [MoveStep((PointToPoint("slider", {"slide": way}),)) for way in (1.0, 0.0)]
    program = plan_motion(snapshot, MotionSpec(steps=(moves[0], DwellStep(0.5), moves[1])), chain).command.program
    assert [program.done_at(step) for step in range(3)] == list(program.begins[1:])
    assert program.done_at(7) == program.duration
