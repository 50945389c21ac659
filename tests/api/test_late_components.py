"""Physics engines and mobile kinematics that hang: a stop goes through meanwhile, and so does every other change."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot.motions.state import Phase

from tests.api.test_replay import told
from tests.kernels import KernelProcess, StartKernel
from tests.plugins.install import environment, install
from tests.waiting import PATIENCE_SECONDS, until

pytestmark = pytest.mark.long

G = 9.81
TICK = 0.004
ENGINES = ("late", "late_inside")
"""The engine in a process of its own, and in the kernel's."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return install(tmp_path_factory.mktemp("site"), "late")


@pytest.fixture(scope="module")
def kernel(start_kernel: StartKernel, site: Path) -> KernelProcess:
    return start_kernel(environment=environment(site))


@pytest.fixture
def client(kernel: KernelProcess) -> Iterator[Client]:
    with virtualrobot.connect(kernel.address) as client:
        client.clock.set_realtime()
        client.scene.clear()
        yield client


@pytest.fixture
def hold(tmp_path: Path) -> Iterator[Path]:
    """Return the file that components wait for to go; it goes at the end."""
    file = tmp_path / "hold"
    yield file
    file.unlink(missing_ok=True)


def let_hang(kernel: KernelProcess, hold: Path) -> None:
    """Have components hang from now on; return once one does."""
    before = len(kernel.lines)
    hold.touch()
    until(lambda: any(line.endswith("hangs") for line in kernel.lines[before:]))


def falling(client: Client, hold: Path, engine: str = "late") -> None:
    """Put a part that falls, and an arm, into a world with an engine."""
    client.load_robot("model://ur5e", name="arm")
    client.scene.add_part("ball", virtualrobot.sphere(0.1), pose=virtualrobot.pose(z=50.0), mass=1.0, dynamic=True)
    client.physics.set(engine, engine_settings={"while_there": str(hold)})


@pytest.mark.parametrize("engine", ENGINES)
def test_a_stop_and_an_edit_do_not_wait_for_an_engine(
    kernel: KernelProcess, client: Client, hold: Path, engine: str
) -> None:
    falling(client, hold, engine)
    arm = client.robot("arm")
    motion = arm.move_joints([1.0, -1.0, 1.0, 0.0, 0.0, 0.0], speed_factor=0.02, wait=False)
    until(lambda: client.scene.pose("ball")[2, 3] < 50.0)
    let_hang(kernel, hold)
    tick = client.clock.read().stamp.tick
    assert [one.id for one in client.stop()] == [motion.id]
    client.cell.stop("tests")
    client.scene.set_pose("ball", virtualrobot.pose(3.0, 0.0, 20.0))
    client.scene.add_object("new", virtualrobot.box(1.0, 1.0, 1.0))
    assert client.clock.read().stamp.tick == tick
    assert client.physics.status.fault == ""
    hold.unlink()
    until(lambda: motion.phase is Phase.CANCELLED and client.clock.read().stamp.tick > tick + 10)
    client.cell.release()
    x, _, z = client.scene.pose("ball")[:3, 3]
    assert x == 3.0 and z < 20.0


def test_what_is_let_go_keeps_its_speed_however_late_the_engine_is(
    kernel: KernelProcess, client: Client, hold: Path
) -> None:
    """A ball on a belt is let go while the engine hangs: it goes on as fast as the belt was, as it would without."""
    client.clock.set_stepped()
    belt = client.load_robot("model://conveyor", name="belt")
    ball = virtualrobot.sphere(0.1)
    client.scene.add_part("ball", ball, pose=virtualrobot.pose(z=1.0), parent="belt.belt", mass=1.0, dynamic=True)
    client.physics.set("late", engine_settings={"while_there": str(hold)})
    belt.move_joints([1.0], wait=False)
    client.clock.step(100)
    start = client.scene.pose("ball")[0, 3]
    client.clock.step(1)
    client.scene.attach("ball", "world")
    before, lines = client.scene.pose("ball")[0, 3], len(kernel.lines)
    hold.touch()
    with ThreadPoolExecutor() as pool:
        stepped = pool.submit(client.clock.step, 10)
        until(lambda: any(line.endswith("hangs") for line in kernel.lines[lines:]))
        client.stop()  # answered once the world waits no more for the engine
        hold.unlink()
        stepped.result(PATIENCE_SECONDS)
    assert before - start > 0.1 * TICK
    assert client.scene.pose("ball")[0, 3] - before == pytest.approx(10.0 * (before - start), rel=1e-6)


@pytest.mark.parametrize("engine", ENGINES)
def test_another_engine_ends_one_that_hangs(kernel: KernelProcess, client: Client, hold: Path, engine: str) -> None:
    falling(client, hold, engine)
    let_hang(kernel, hold)
    tick = client.clock.read().stamp.tick
    client.physics.set("mujoco")
    until(lambda: client.clock.read().stamp.tick > tick + 10)
    assert hold.exists() and client.physics.status.fault == ""


@pytest.mark.parametrize(("wrong", "said"), [("object", "q is an array (7,) of object"), ("nan", "q[0] is nan")])
def test_an_engine_whose_answers_make_no_sense_is_named(
    kernel: KernelProcess, client: Client, wrong: str, said: str
) -> None:
    client.scene.add_part("ball", virtualrobot.sphere(0.1), mass=1.0, dynamic=True)
    client.physics.set("wrong", engine_settings={"wrong": wrong})
    until(lambda: client.physics.status.fault)
    fault = client.physics.status.fault
    assert fault.startswith(f"what the physics engine 'wrong' answers is nonsense: {said}")
    assert not any("failed inside the kernel" in line for line in kernel.lines)


def test_a_stop_does_not_wait_for_mobile_kinematics(kernel: KernelProcess, client: Client, hold: Path) -> None:
    """Neither while it is asked where the craft is, nor while a client sends twists."""
    ugv = client.load_robot("model://ugv", base="planar")
    settings = {"track_meters": 0.4, "wheel_radius_meters": 0.1, "while_there": str(hold)}
    client.scene.set_craft("ugv", "late_differential", settings)
    with ugv.stream_twist(timeout=1e6) as stream:
        stream.send((0.1, 0.0, 0.0))
        until(lambda: client.scene.pose("ugv.base")[0, 3] > 0.0)
        let_hang(kernel, hold)
        stream.send((0.2, 0.0, 0.0))
        tick = client.clock.read().stamp.tick
        assert len(client.stop()) == 1
        assert client.clock.read().stamp.tick == tick
        hold.unlink()
        stream.cancel()
    until(lambda: client.clock.read().stamp.tick > tick)


def test_a_step_waits_for_an_engine_and_lets_a_stop_in(
    start_kernel: StartKernel, site: Path, hold: Path, tmp_path: Path
) -> None:
    """And a replay, which needs no engine, gives the same bits."""
    folder = tmp_path / "cell"
    kernel = start_kernel("--stepped", "--data", str(folder), no_token=True, environment=environment(site))
    with virtualrobot.connect(kernel.address) as client, ThreadPoolExecutor() as pool:
        falling(client, hold)
        motion = client.robot("arm").move_joints([1.0, -1.0, 1.0, 0.0, 0.0, 0.0], speed_factor=0.02, wait=False)
        client.clock.step(10)
        before = client.scene.pose("ball")[2, 3]
        stepped = pool.submit(client.clock.step, 40)
        let_hang(kernel, hold)
        assert [one.id for one in client.stop()] == [motion.id]
        assert not stepped.done()
        hold.unlink()
        assert stepped.result(PATIENCE_SECONDS).stamp.tick == 50
        # Free fall by steps of a fourth of a tick: z falls by g h^2 n (n + 1) / 2 (Euler-Cromer), as it would without.
        h = TICK / 4.0
        fallen = G * h * h * (200 * 201 - 40 * 41) / 2.0
        assert before - client.scene.pose("ball")[2, 3] == pytest.approx(fallen, rel=1e-6)
        assert motion.phase is Phase.CANCELLED
        np.testing.assert_array_equal(client.robot("arm").state.velocities, 0.0)
    assert kernel.end() == 0
    code, text = told("replay", folder, "--verify")
    assert (code, text) == (0, "50 ticks are the same\n")
