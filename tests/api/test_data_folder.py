"""A kernel with a folder over TCP: killed and started again it goes on from where it was told."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import grpc
import numpy as np
import pytest
from virtualrobot.v1 import geometry_pb2, history_pb2, motion_pb2, robot_pb2, scene_pb2, signal_pb2

from tests.api.asking import IIWA, apply, box, create, joints, load, set_signals, start
from tests.api.moving import ABORTED, READY, RUNNING, motion
from tests.api.reading import state, step
from tests.kernels import KernelProcess, StartKernel, Stubs

GUARD = 120.0
Work = Callable[[], geometry_pb2.Stamp]
OTHER = {**READY, "lbr_iiwa_joint_1": -1.2}


def kill(kernel: KernelProcess) -> None:
    """Kill a kernel as nothing else can be killed."""
    os.kill(kernel.process.pid, signal.SIGKILL)
    kernel.process.wait(GUARD)


def refused(*options: str) -> str:
    """Return what a kernel says that does not start."""
    command = [sys.executable, "-m", "virtualrobot_kernel.serve", "--port", "0", "--headless", "--no-token", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=5 * GUARD, check=False)
    assert done.returncode == 1 and "listening" not in done.stdout
    return done.stderr


def names(stubs: Stubs) -> set[str]:
    """Return the names of all nodes."""
    return {node.name for node in stubs.scene.GetScene(scene_pb2.GetSceneRequest()).nodes}


def signals(stubs: Stubs) -> dict[str, int]:
    """Return the values of all signals."""
    found = stubs.signal.GetSignals(signal_pb2.GetSignalsRequest()).signals
    return {one.name: one.value.integer for one in found}


def arm_and_stamp(stubs: Stubs) -> tuple[robot_pb2.RobotState, geometry_pb2.Stamp]:
    """Return the arm's state and when it is."""
    answer = stubs.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest(names=["arm"]))
    return answer.robots[0], answer.stamp


def signal_created(name: str) -> scene_pb2.Command:
    """Return the command that adds a counter."""
    made = signal_pb2.Signal(name=name, value=signal_pb2.SignalValue(integer=0))
    return scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=made))


@pytest.mark.parametrize("durability", ["process", pytest.param("power", marks=pytest.mark.long)])
def test_a_killed_kernel_goes_on_from_where_it_was_told(
    tmp_path: Path, start_kernel: StartKernel, durability: str
) -> None:
    folder = ("--stepped", "--data", str(tmp_path / "cell"), "--durability", durability)
    kernel = start_kernel(*folder)
    stubs = kernel.stubs()
    load(stubs, IIWA, "arm")
    apply(stubs, signal_created("count"), create(box("cube")))
    running = start(stubs, joints("arm", **READY)).id
    step(stubs, 40)
    stubs.history.CreateCheckpoint(history_pb2.CreateCheckpointRequest(name="lunch"))
    set_signals(stubs, {"count": 3})
    stamp = step(stubs, 23).stamp
    assert motion(stubs, running).phase == RUNNING
    was = np.array(state(stubs, "arm").positions)
    kill(kernel)

    kernel = start_kernel(*folder)
    stubs = kernel.stubs()
    arm, now = arm_and_stamp(stubs)
    assert np.array_equal(arm.positions, was) and not any(arm.velocities)
    assert now.tick == stamp.tick and now.epoch > stamp.epoch
    ended = motion(stubs, running)
    assert (ended.phase, ended.end_cause) == (ABORTED, motion_pb2.END_CAUSE_KERNEL_RESTARTED)
    assert signals(stubs) == {"count": 3} and "cube" in names(stubs)
    step(stubs, 10)
    assert np.array_equal(np.array(state(stubs, "arm").positions), was)
    assert start(stubs, joints("arm", **READY)).phase == RUNNING, "with the robot's meshes and kinematics"

    undone = stubs.history.Undo(history_pb2.UndoRequest()).undone
    assert "'cube'" in undone.label and "cube" not in names(stubs)
    (lunch,) = stubs.history.ListCheckpoints(history_pb2.ListCheckpointsRequest()).checkpoints
    stubs.history.RestoreCheckpoint(history_pb2.RestoreCheckpointRequest(name=lunch.name))
    assert signals(stubs) == {"count": 0} and "cube" in names(stubs)


CLOCK = """
import os, time

real = time.time


def set_by_the_test():
    with open(os.environ["TEST_CLOCK"]) as file:
        return real() + float(file.read())


time.time = set_by_the_test
"""


def test_a_clock_that_is_set_back_changes_no_order(tmp_path: Path, start_kernel: StartKernel) -> None:
    clock, day = tmp_path / "clock", 86_400.0
    (tmp_path / "sitecustomize.py").write_text(CLOCK)  # python runs it before the kernel
    environment = {"TEST_CLOCK": str(clock), "PYTHONPATH": str(tmp_path)}
    folder = ("--stepped", "--data", str(tmp_path / "cell"), "--keep-history", "12h")
    clock.write_text("0")
    kernel = start_kernel(*folder, environment=environment)
    stubs = kernel.stubs()
    for number, offset in enumerate((0.0, -day, -2.0 * day)):
        clock.write_text(str(offset))
        apply(stubs, create(box(f"box{number}")))
        stubs.history.CreateCheckpoint(history_pb2.CreateCheckpointRequest(name=f"after box{number}"))
    kill(kernel)

    clock.write_text(str(-3.0 * day))
    kernel = start_kernel(*folder, environment=environment)
    stubs = kernel.stubs()
    assert {"box0", "box1", "box2"} <= names(stubs)
    steps = stubs.history.ListSteps(history_pb2.ListStepsRequest(kinds=[history_pb2.STEP_KIND_EDIT])).steps
    assert [one.nodes[0] for one in steps] == ["box2", "box1", "box0"], "in their order, not by their times"
    days = np.array([one.time.ToSeconds() for one in steps]) / day
    np.testing.assert_allclose(np.diff(days), [1.0, 1.0], atol=0.01)
    found = stubs.history.ListCheckpoints(history_pb2.ListCheckpointsRequest()).checkpoints
    assert [one.name for one in found] == ["after box0", "after box1", "after box2"]
    for number in (2, 1, 0):
        assert f"'box{number}'" in stubs.history.Undo(history_pb2.UndoRequest()).undone.label
    stubs.history.RestoreCheckpoint(history_pb2.RestoreCheckpointRequest(name="after box1"))
    assert {"box0", "box1"} <= names(stubs) and "box2" not in names(stubs)


@pytest.mark.long
def test_what_a_folder_is_not_for_is_said_in_words(tmp_path: Path, start_kernel: StartKernel) -> None:
    folder = ("--data", str(tmp_path / "cell"))
    scene = tmp_path / "scene.yaml"
    scene.write_text("schema_version: 1\nnodes: [{name: table, object: {}}]\n")
    kernel = start_kernel(*folder, str(scene))
    assert "table" in names(kernel.stubs())
    said = refused(*folder)
    assert f"another kernel uses the folder {tmp_path / 'cell'}, the process {kernel.process.pid}" in said
    assert kernel.end() == 0
    said = refused(*folder, str(scene))
    assert f"{tmp_path / 'cell'} has a world already, which began with scene.yaml; leave out the scene file" in said
    assert "ticks of 4 ms, not of 2 ms" in refused(*folder, "--tick-milliseconds", "2")
    new = ("--data", str(tmp_path / "new"))
    assert "such as 500MB" in refused(*new, "--keep-history", "some")
    assert "limit" in refused(*new, "--limit", "nothing=1")
    assert not (tmp_path / "new").exists()


class Load:
    """Clients that do all at once what they may, and note what was answered."""

    def __init__(self, kernel: KernelProcess, seed: int) -> None:
        """Begin; they go on until the kernel has gone."""
        self.sent: dict[str, int] = {}
        self.answered: dict[str, int] = {}
        self.boxes: set[str] = set()
        self.gone: set[str] = set()
        self.tick = self.answers = 0
        self._stubs = kernel.stubs()
        self._known = names(self._stubs)
        here = signals(self._stubs)
        work = [self._count("a", here), self._count("b", here), self._edit(seed), self._move]
        self._threads = [threading.Thread(target=self._until_gone, args=(one,)) for one in work]
        for thread in self._threads:
            thread.start()

    def end(self) -> None:
        """Wait until all have noticed that the kernel has gone."""
        for thread in self._threads:
            thread.join(GUARD)
        self._stubs.channel.close()

    def _until_gone(self, work: Work) -> None:
        try:
            while True:
                stamp = work()
                self.tick = max(self.tick, stamp.tick)
                self.answers += 1
        except grpc.RpcError as error:
            assert error.code() in (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.CANCELLED), error  # pyright: ignore

    def _count(self, name: str, here: dict[str, int]) -> Work:
        self.answered[name] = self.sent[name] = here[name]

        def once() -> geometry_pb2.Stamp:
            self.sent[name] += 1
            stamp = set_signals(self._stubs, {name: self.sent[name]}).stamp
            self.answered[name] = self.sent[name]
            return stamp

        return once

    def _edit(self, seed: int) -> Work:
        number = 0

        def once() -> geometry_pb2.Stamp:
            nonlocal number
            number += 1
            name = f"box {seed} {number}"
            self.gone.discard(name)
            stamp = apply(self._stubs, create(box(name))).stamp
            self.boxes.add(name)
            if number % 3 == 0:
                gone = f"box {seed} {number - 1}"
                self.gone.add(gone)
                self.boxes.discard(gone)
                stamp = apply(self._stubs, scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name=gone))).stamp
            return stamp

        return once

    def _move(self) -> geometry_pb2.Stamp:
        goal = READY if self.answers % 2 else OTHER
        request = motion_pb2.StartMotionRequest(
            spec=motion_pb2.MotionSpec(moves=[joints("arm", **goal)]),
            busy_policy=motion_pb2.BUSY_POLICY_PREEMPT,
            on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE,
        )
        return self._stubs.motion.StartMotion(request).stamp


def killed_again_and_again(
    folder: Path, start_kernel: StartKernel, rng: np.random.Generator, until: float, most: int
) -> int:
    """Kill kernels on a folder at random moments under load; return how many answers there were, none of them lost."""
    kernel = start_kernel("--data", str(folder))
    stubs = kernel.stubs()
    load(stubs, IIWA, "arm")
    apply(stubs, signal_created("a"), signal_created("b"))
    answers = kills = 0
    while kills < most and time.monotonic() < until:
        work = Load(kernel, kills)
        threading.Event().wait(rng.uniform(0.05, 2.0))
        kill(kernel)
        work.end()
        kernel = start_kernel("--data", str(folder))
        stubs = kernel.stubs()
        here, nodes = signals(stubs), names(stubs)
        for name in "ab":
            assert work.answered[name] <= here[name] <= work.sent[name]
        assert work.boxes <= nodes, f"{work.boxes - nodes} are lost"
        arm, now = arm_and_stamp(stubs)
        assert not any(arm.velocities) and now.tick >= work.tick
        motions = stubs.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions
        assert not any(one.phase == RUNNING for one in motions)
        answers += work.answers
        kills += 1
    assert kernel.end() == 0
    print(f"{kills} kills, {answers} answers")
    return answers


@pytest.mark.long
def test_a_killed_kernel_whose_database_cannot_be_opened_goes_on_once_it_is_repaired(
    tmp_path: Path, start_kernel: StartKernel
) -> None:
    """With what was in the database, beside it (-wal) and in the tail: nothing of it is lost."""
    folder = tmp_path / "cell"
    kernel = start_kernel("--stepped", "--data", str(folder))
    load(kernel.stubs(), IIWA, "arm")
    assert kernel.end() == 0
    kernel = start_kernel("--stepped", "--data", str(folder))
    stubs = kernel.stubs()
    apply(stubs, signal_created("count"), create(box("cube")))
    start(stubs, joints("arm", **READY))
    for count in range(50):
        set_signals(stubs, {"count": count})
        stamp = step(stubs, 1).stamp
    was = np.array(state(stubs, "arm").positions)
    kill(kernel)
    for name, head in (("journal.db", 4096), ("journal.db-wal", 32)):
        data = (folder / name).read_bytes()
        (folder / name).write_bytes(bytes(head) + data[head:])
    left = [path for name in ("journal.db", "journal.db-wal", "tail.?") for path in folder.glob(name)]
    spoiled = {path.name: path.read_bytes() for path in left}
    assert "virtualrobot repair" in refused("--data", str(folder))
    command = [sys.executable, "-m", "virtualrobot", "repair", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=GUARD, check=False)
    assert done.returncode == 0, done.stderr
    assert "0 entries, 0 ticks and 0 checkpoints are lost" in done.stdout
    assert {name: (folder / "damaged" / name).read_bytes() for name in spoiled} == spoiled

    again = start_kernel("--stepped", "--data", str(folder)).stubs()
    arm, now = arm_and_stamp(again)
    assert now.tick == stamp.tick
    assert np.array_equal(arm.positions, was)
    assert signals(again) == {"count": 49} and "cube" in names(again)
    told = subprocess.run(command, capture_output=True, text=True, timeout=GUARD, check=False)
    assert told.returncode == 1 and "another kernel uses the folder" in told.stderr


@pytest.mark.long
def test_ten_kills_under_load_lose_nothing(tmp_path: Path, start_kernel: StartKernel, rng: np.random.Generator) -> None:
    assert killed_again_and_again(tmp_path, start_kernel, rng, time.monotonic() + 3600.0, 10) > 100


@pytest.mark.hunted
@pytest.mark.timeout(0)
def test_kills_under_load_lose_nothing(
    tmp_path: Path, start_kernel: StartKernel, rng: np.random.Generator, hunt_seconds: float
) -> None:
    assert killed_again_and_again(tmp_path, start_kernel, rng, time.monotonic() + hunt_seconds, 10_000) > 100
