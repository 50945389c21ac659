"""The asynchronous client: the library's own orders, each in a thread, against a real kernel over TCP."""

from __future__ import annotations

import asyncio
import gc

import numpy as np
import pytest
import virtualrobot
from virtualrobot import aio
from virtualrobot.aio import faces

from tests.api.client.conftest import IIWA
from tests.kernels import KernelProcess, StartKernel, Stubs
from tools import generate_aio, generate_functions

GOAL = [0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0]
GUARD_SECONDS = 120.0


@pytest.fixture
def address(stepped_kernel: KernelProcess, stepped: Stubs) -> str:
    """Return the address of a kernel with an empty world whose time goes on by steps."""
    return stepped_kernel.address


async def _load(client: aio.Client, *names: str) -> list[aio.Robot]:
    """Return arms of these names, a meter apart."""
    loads = (
        client.load_robot(IIWA, name=name, pose=virtualrobot.pose(y=float(place))) for place, name in enumerate(names)
    )
    return list(await asyncio.gather(*loads))


async def _step_until_ended(client: aio.Client, *motions: aio.Motion) -> None:
    """Let time go on, a tick after the other, until motions have ended; everything else goes on between them."""
    while not all([(await motion.state).phase.ended for motion in motions]):
        await client.clock.step(20)


def test_arms_move_at_once_while_the_loop_goes_on(address: str) -> None:
    """Two tasks wait for two motions, a third one lets time go on: none stands in another one's way."""

    async def cell() -> list[np.ndarray]:
        async with aio.connect(address) as client:
            arms = await _load(client, "left", "right")
            motions = [await arm.move_joints(GOAL, wait=False) for arm in arms]
            waits = [motion.wait(timeout=GUARD_SECONDS) for motion in motions]
            ended = await asyncio.gather(*waits, _step_until_ended(client, *motions))
            assert [type(one) for one in ended[:2]] == [type(one) for one in motions]
            return [await arm.positions for arm in arms]

    for positions in asyncio.run(cell()):
        np.testing.assert_allclose(positions, GOAL, atol=1e-9)


def test_what_tasks_see_is_what_the_library_tells(address: str, steps: virtualrobot.Client) -> None:
    async def cell() -> None:
        async with aio.connect(address) as client:
            (arm,) = await _load(client, "arm")
            known = steps.robots["arm"]
            assert arm.name == "arm" and isinstance(arm, aio.Robot)
            assert await arm.joint_names == known.joint_names
            np.testing.assert_array_equal(await arm.tcp, known.tcp)
            assert [one.name for one in await client.robots()] == ["arm"]
            assert [name async for name in client.robots] == ["arm"]
            assert (await client.robots["arm"]).name == "arm"
            await arm.set_speed_factor(0.5)
            assert known.speed_factor == 0.5
            await arm.postures.add("home", GOAL)
            assert list((await arm.postures["home"]).values()) == GOAL
            moves = [await arm.ptp(GOAL)]
            assert (await client.plan(moves)).duration == steps.plan([known.ptp(GOAL)]).duration
            program = client.program().move(*moves).dwell(0.5)
            assert len(program) == 2
            motion = await program.start(wait=False)
            assert motion.robots == ("arm",)
            await client.clock.run(motion)
            assert (await motion.phase).name == "SUCCEEDED"

    asyncio.run(cell())


def test_changes_are_made_as_one(address: str, steps: virtualrobot.Client) -> None:
    async def cell() -> None:
        async with aio.connect(address) as client:
            async with client.scene.batch() as batch:
                batch.add_part("box", virtualrobot.box(0.1, 0.1, 0.1))
                batch.set_pose("box", virtualrobot.pose(z=0.2))
                assert "box" not in steps.scene
            assert steps.scene["box"].parent_t_node[2, 3] == 0.2
            node = await client.scene.node("box")
            await node.set_parent_t_node(virtualrobot.pose(z=0.3))
            assert (await node.pose)[2, 3] == 0.3
            assert "0.10 m" in (await client.undo()).label
            assert (await node.pose)[2, 3] == 0.2
            with pytest.raises(virtualrobot.NameTakenError, match="box"):
                await client.scene.add_part("box", virtualrobot.box(0.1, 0.1, 0.1))

    asyncio.run(cell())


def test_a_task_that_is_cancelled_cancels_the_move_it_waits_for(address: str, steps: virtualrobot.Client) -> None:
    """As Ctrl-C does; nobody but the task's end tells the kernel."""

    async def cell() -> None:
        async with aio.connect(address) as client:
            (arm,) = await _load(client, "arm")
            motion = await arm.move_joints(GOAL, wait=False)
            waiting = asyncio.create_task(motion.wait(timeout=GUARD_SECONDS))
            await client.clock.step(10)
            assert steps.motions()[0].phase.name == "RUNNING"
            waiting.cancel()
            with pytest.raises(asyncio.CancelledError):
                await waiting
            with pytest.raises(virtualrobot.MotionCancelledError):
                await client.clock.run(motion)
            assert (await motion.state).end_reason == "the task that waited for it was cancelled"

    asyncio.run(cell())


def test_a_block_that_fails_stops_its_motion(address: str) -> None:
    async def cell() -> None:
        async with aio.connect(address) as client:
            (arm,) = await _load(client, "arm")
            with pytest.raises(ZeroDivisionError):
                async with arm.move_joints(GOAL, wait=False) as motion:
                    await client.clock.step(10)
                    raise ZeroDivisionError
            with pytest.raises(virtualrobot.MotionCancelledError, match="failed"):
                await client.clock.run(motion)

    asyncio.run(cell())


def test_a_hundred_tasks_wait_at_once(address: str) -> None:
    names = [f"gate {number}" for number in range(100)]

    async def cell() -> None:
        async with aio.connect(address) as client:
            async with client.scene.batch() as batch:
                for name in names:
                    batch.create_signal(name)
            async with asyncio.timeout(GUARD_SECONDS), asyncio.TaskGroup() as tasks:
                for name in names:
                    tasks.create_task(client.signals.wait_for(name))
                await client.signals.set(dict.fromkeys(names, True))

    asyncio.run(cell())


def test_watches_are_read_by_async_for(address: str) -> None:
    async def cell() -> None:
        async with aio.connect(address) as client:
            await client.signals.create("count", 0)
            told = []
            async with client.signals.follow(["count"]) as watch:
                async for change in watch:
                    told.append(change.values["count"])
                    if len(told) == 4:
                        break
                    await client.signals.set({"count": len(told)})
            assert told == [0, 1, 2, 3]
            async for values in client.signals.watch(["count"]):
                assert values == {"count": 3}
                break

    asyncio.run(cell())


def test_a_cancelled_watch_leaves_the_client_as_it_is(address: str) -> None:
    async def cell() -> None:
        async with aio.connect(address) as client:
            await client.signals.create("silent")
            begun = asyncio.Event()

            async def read() -> None:
                async for _ in client.signals.watch(["silent"]):
                    begun.set()

            reading = asyncio.create_task(read())
            await begun.wait()
            reading.cancel()
            with pytest.raises(asyncio.CancelledError):
                await reading
            assert [one.name for one in await client.signals.read()] == ["silent"]

    asyncio.run(cell())


def test_time_that_is_over_takes_an_order_back(address: str) -> None:
    """The order is the library's own, `asyncio.timeout` what programs have."""

    async def cell() -> None:
        async with aio.connect(address) as client:
            await client.signals.create("never")
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.05):
                    await client.signals.wait_for("never")
            assert not (await client.signals["never"])

    asyncio.run(cell())


def test_a_lease_is_released_at_the_end_of_its_block(address: str, steps: virtualrobot.Client) -> None:
    async def cell() -> None:
        async with aio.connect(address) as client:
            await _load(client, "arm")
            async with client.lease("arm", owner="a task") as lease:
                assert lease.owner == "a task"
                with pytest.raises(virtualrobot.LeasedError, match="a task"):
                    steps.robots["arm"].move_joints(GOAL, wait=False)
            assert not steps.leases()

    asyncio.run(cell())


def test_setpoints_stream(address: str) -> None:
    async def cell() -> float:
        async with aio.connect(address) as client:
            (arm,) = await _load(client, "arm")
            stream = await arm.stream("velocity", ["lbr_iiwa_joint_1"])
            await stream.send([0.5], wait=True)
            await client.clock.step(40)
            turned = (await arm.positions)[0]
            closing = asyncio.create_task(stream.close())
            while not closing.done():
                await client.clock.step()
            await closing
            return turned

    assert asyncio.run(cell()) > 0.0


def test_a_kernel_that_is_killed_is_told_to_all_who_wait(start_kernel: StartKernel) -> None:
    own = start_kernel("--stepped")

    async def cell() -> None:
        async with aio.connect(own.address) as client:
            (arm,) = await _load(client, "arm")
            motion = await arm.move_joints(GOAL, wait=False)
            waits = [asyncio.create_task(motion.wait(timeout=GUARD_SECONDS)) for _ in range(3)]
            await client.clock.step()
            own.process.kill()
            for wait in waits:
                with pytest.raises(virtualrobot.KernelGoneError):
                    await wait

    asyncio.run(cell())


def test_what_would_stop_the_loop_is_refused(address: str) -> None:
    async def cell() -> None:
        async with aio.connect(address) as client:
            with pytest.raises(virtualrobot.WrongStateError, match=r"await it by virtualrobot\.aio"):
                client._one.scene.nodes()
            for name in ("services", "keys"):
                with pytest.raises(AttributeError, match=f"'Signals' of virtualrobot.aio has no '{name}'"):
                    getattr(client.signals, name)

    asyncio.run(cell())


def test_an_order_that_nobody_awaits_is_warned_about(address: str) -> None:
    async def cell() -> None:
        async with aio.connect(address) as client:
            (arm,) = await _load(client, "arm")
            with pytest.warns(RuntimeWarning, match=r"move_joints was never awaited"):
                arm.move_joints(GOAL)
                gc.collect()
            assert not await client.motions()

    asyncio.run(cell())


def test_wrong_arguments_are_refused_in_the_library_s_words(address: str) -> None:
    async def cell() -> None:
        async with aio.connect(address) as client:
            (arm,) = await _load(client, "arm")
            with pytest.raises(virtualrobot.UnknownNameError, match="nobody"):
                await client.robots["nobody"]
            with pytest.raises(virtualrobot.InvalidArgumentError, match="3 values for the robot 'arm'"):
                await arm.move_joints([0.0, 1.0, 2.0])

    asyncio.run(cell())
    with pytest.raises(virtualrobot.KernelGoneError, match=r"127\.0\.0\.1:1"):
        asyncio.run(aio.connect("127.0.0.1:1"))


def test_every_class_of_the_function_table_has_a_face() -> None:
    """Values, such as plans and figures, ask nobody: they are the same for tasks."""
    values = {"motions.plans:MotionPlan", "scene.figures:Figure", "kernel_process:KernelProcess"}
    listed = {place for group in generate_functions.GROUPS for place in group.python.values()}
    assert listed - values <= set(faces.CLASSES)


def test_types_are_fresh() -> None:
    committed = generate_aio.STUB.read_text("utf-8")
    assert generate_aio.stub() == committed, "run `python tools/generate_aio.py` and commit"
