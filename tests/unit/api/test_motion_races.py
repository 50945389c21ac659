"""What happens between two awaits: motions that end, and clients that vanish, at the worst moment."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from types import SimpleNamespace
from typing import Any

import pytest
from virtualrobot.v1 import motion_pb2
from virtualrobot_kernel.api import motion as api
from virtualrobot_kernel.api.keyed_limiter import KeyedLimiter
from virtualrobot_kernel.api.publications import Publications
from virtualrobot_kernel.api.shown_plans import ShownPlans
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import AppendMotion, CancelMotion, Command, StartMotion
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Motion
from virtualrobot_kernel.world.store import Applied, World

from tests.unit.world.builders import arm

CLIENT: Any = SimpleNamespace(invocation_metadata=lambda: (), peer=lambda: "a test")


class SteeredWorld(World):
    """A world in which `before` and `after` are called around commands of the API."""

    def before(self, commands: Sequence[Command]) -> None:
        """Do nothing."""

    def after(self, commands: Sequence[Command]) -> None:
        """Do nothing."""

    def submit(
        self, commands: Sequence[Command], author: str = "", expected_revision: int | None = None
    ) -> Future[Applied]:
        """Queue a batch, and wait until it is applied."""
        self.before(commands)
        done = super().submit(commands, author, expected_revision)
        done.exception()
        self.after(commands)
        return done


@pytest.fixture
def world() -> Iterator[SteeredWorld]:
    world = SteeredWorld(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
    world.start()
    world.submit([arm()])
    yield world
    world.close()


def served(world: World) -> api.MotionServicer:
    """Return the servicer on this world, for the running loop."""
    publications = Publications(world, asyncio.get_running_loop())
    solvers = SimpleNamespace(of=None)  # goals in joints need none, nor anything to keep away from
    kernel: Any = SimpleNamespace(
        world=world,
        publications=publications,
        limiter=KeyedLimiter(),
        solvers=solvers,
        collisions=None,
        links=SimpleNamespace(is_executing=lambda robots: False),
        plans=ShownPlans(),
        monitor=SimpleNamespace(latest=SimpleNamespace(touching=())),
        in_worker=asyncio.to_thread,
    )
    kernel.submit = lambda commands, context, expected_revision=None: world.submit(
        commands, "a test", expected_revision
    )
    kernel.submitting = lambda context: (
        lambda commands, expected_revision=None: kernel.submit(commands, context, expected_revision)
    )
    return api.MotionServicer(kernel)


def start(goal: float, policy: motion_pb2.BusyPolicy = motion_pb2.BUSY_POLICY_REJECT) -> motion_pb2.StartMotionRequest:
    joints = motion_pb2.JointGoal(joint_positions={"a": goal})
    move = motion_pb2.Move(robot="arm", point_to_point=motion_pb2.PointToPoint(joints=joints))
    return motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=[move]), busy_policy=policy)


async def until(world: World, fact: Callable[[Motion], object]) -> float:
    """Wait until something is true of the motion that runs, or has ended; return the loop's time."""
    while not fact((*world.snapshot.state.motions, *world.snapshot.state.ended)[0]):
        await asyncio.sleep(0.005)
    return asyncio.get_running_loop().time()


def test_a_motion_that_ends_as_it_is_preempted_is_in_nobody_s_way(world: SteeredWorld) -> None:
    def end_first(commands: Sequence[Command]) -> None:
        if isinstance(commands[0], CancelMotion):
            world.step(2000).result()

    async def run() -> motion_pb2.Motion:
        servicer = served(world)
        await servicer.StartMotion(start(1.0), CLIENT)
        world.before = end_first
        return (await servicer.StartMotion(start(-1.0, motion_pb2.BUSY_POLICY_PREEMPT), CLIENT)).motion

    assert asyncio.run(run()).id == "motion-2"


def test_a_client_that_vanishes_as_its_motion_starts_leaves_none_behind(
    world: SteeredWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(api, "GRACE_SECONDS", 0.01)

    async def run() -> None:
        call = asyncio.ensure_future(served(world).StartMotion(start(1.0), CLIENT))

        def vanish(commands: Sequence[Command]) -> None:
            if isinstance(commands[0], StartMotion):
                call.cancel()

        world.after = vanish
        with pytest.raises(asyncio.CancelledError):
            await call
        await until(world, lambda motion: motion.cancellation)

    asyncio.run(run())


def test_a_client_that_vanishes_while_its_program_is_planned_ends_the_planning(
    world: SteeredWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, ended = threading.Event(), threading.Event()

    def plan(*arguments: object, open: bool) -> None:
        given_up = arguments[3]
        assert callable(given_up)
        begun.set()
        while not given_up():
            time.sleep(0.001)
        ended.set()
        raise KernelError("nobody waits for this plan any more")

    monkeypatch.setattr(api, "plan_motion", plan)

    async def run() -> None:
        call = asyncio.ensure_future(served(world).StartMotion(start(1.0), CLIENT))
        await asyncio.to_thread(begun.wait, 30)
        call.cancel()
        with pytest.raises(asyncio.CancelledError):
            await call

    asyncio.run(run())
    assert ended.wait(30)
    assert not world.snapshot.state.motions


@pytest.mark.parametrize("hold", [False, True])
def test_the_grace_begins_when_the_last_watch_ends(
    world: SteeredWorld, monkeypatch: pytest.MonkeyPatch, hold: bool
) -> None:
    """A longer grace is that of what runs only while it is held."""
    monkeypatch.setattr(api, "GRACE_SECONDS", 0.01 if hold else 0.3)
    monkeypatch.setattr(api, "HELD_GRACE_SECONDS", 0.3)

    async def run() -> float:
        servicer = served(world)
        asked = start(1.0)
        asked.hold = hold
        id = (await servicer.StartMotion(asked, CLIENT)).motion.id
        watch: Any = servicer.WatchMotion(motion_pb2.WatchMotionRequest(id=id), CLIENT)
        await anext(watch)
        await asyncio.sleep(0.2)
        await watch.aclose()
        left = asyncio.get_running_loop().time()
        return await until(world, lambda motion: motion.cancellation) - left

    assert asyncio.run(run()) >= 0.29


def test_a_watch_sleeps_between_its_messages_and_is_told_the_end_at_once(
    world: SteeredWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def run() -> tuple[list[object], list[motion_pb2.MotionPhase]]:
        servicer = served(world)
        id = (await servicer.StartMotion(start(1.0), CLIENT)).motion.id
        watch: Any = servicer.WatchMotion(motion_pb2.WatchMotionRequest(id=id, max_rate_hertz=0.001), CLIENT)
        told = [await anext(watch)]
        next = asyncio.ensure_future(anext(watch))
        await asyncio.sleep(0.0)
        with monkeypatch.context() as watched:
            wakings: list[object] = []
            watched.setattr(asyncio.get_running_loop(), "call_soon_threadsafe", wakings.append)
            for _ in range(50):
                world.step(1).result()
        world.step(5000).result()
        told.append(await asyncio.wait_for(next, 30.0))
        await watch.aclose()
        return wakings, [message.motion.phase for message in told]

    assert asyncio.run(run()) == ([], [motion_pb2.MOTION_PHASE_RUNNING, motion_pb2.MOTION_PHASE_SUCCEEDED])


def test_an_append_that_comes_too_late_is_planned_again_and_begins_from_rest(world: SteeredWorld) -> None:
    def step(goal: float) -> motion_pb2.ProgramStep:
        move = start(goal).spec.moves[0]
        return motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[move], blend_percent=30.0))

    submitted: list[float | None] = []

    def go_on_first(commands: Sequence[Command]) -> None:
        if isinstance(commands[0], AppendMotion):
            submitted.append(commands[0].cut)
            world.step(120).result()

    async def run() -> motion_pb2.AppendMotionResponse:
        servicer = served(world)
        spec = motion_pb2.MotionSpec(steps=[step(1.0)])
        id = (await servicer.StartMotion(motion_pb2.StartMotionRequest(spec=spec, open=True), CLIENT)).motion.id
        world.before = go_on_first
        return await servicer.AppendMotion(motion_pb2.AppendMotionRequest(id=id, steps=[step(1.5)]), CLIENT)

    answer = asyncio.run(run())
    assert submitted[0] is not None and submitted[-1] is None and len(submitted) == 2
    assert answer.motion.step_count == 2 and not world.snapshot.state.motions[0].running.ended
    assert [(note.step, note.kind) for note in answer.notes] == [(0, motion_pb2.PLAN_NOTE_KIND_ZONE_DROPPED)]
    assert "too near" in answer.notes[0].message
