"""Starts, pauses, stops and cancels of several clients at once, in stepped time: every motion ends in time."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait

import grpc
import numpy as np
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA, joints, load, refusal, start
from tests.api.moving import PAUSED, joint_jog, motion
from tests.api.reading import step
from tests.kernels import KernelProcess, Stubs
from tests.tiers import Draws

EXPECTED = {"WRONG_STATE", "UNKNOWN_NAME", "ROBOT_BUSY", "PLAN_OUTDATED", "LIMIT_EXCEEDED"}
"""Reasons for which calls may be refused that meet another's motion, or none."""

STOPPING = motion_pb2.MOTION_PHASE_STOPPING

LONGEST_TICKS = 5000
"""Ticks in which each of these motions ends by itself, and brakes many times over."""

CLIENTS = 2


class Interrupter:
    """Client that starts motions of two robots and gets in the way of all, its own and others'."""

    def __init__(self, stubs: Stubs, seed: int) -> None:
        """Act by the random numbers of `seed`."""
        self._stubs = stubs
        self._rng = np.random.default_rng(seed)
        self.started: list[str] = []

    def act(self, times: int) -> None:
        """Do something at random, again and again; refusals that are to be expected are none."""
        acts: tuple[Callable[[], object], ...] = (self._start, self._start, self._pause, self._resume, self._cancel)
        for _ in range(times):
            one = (*acts, self._stop)[self._rng.integers(len(acts) + 1)]
            try:
                one()
            except grpc.RpcError as error:
                told = refusal(lambda error=error: _raise(error))
                assert told.reason in EXPECTED, told

    def _start(self) -> None:
        robots = [("a",), ("b",), ("a", "b")][self._rng.integers(3)]
        speed = float(self._rng.choice([0.3, 0.6, 1.0]))
        goals = ({"lbr_iiwa_joint_1": float(self._rng.uniform(-2, 2))} for _ in robots)
        if self._rng.integers(3):
            moves = [joints(robot, speed, **goal) for robot, goal in zip(robots, goals, strict=True)]
        else:
            moves = [joint_jog(robots[0], "lbr_iiwa_joint_2", speed)]
        busy = (motion_pb2.BUSY_POLICY_REJECT, motion_pb2.BUSY_POLICY_PREEMPT)[self._rng.integers(2)]
        self.started.append(start(self._stubs, *moves, busy=busy).id)

    def _any(self) -> str:
        """Return a motion of anybody's, perhaps one that has ended."""
        running = self._stubs.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions
        return running[-1 - self._rng.integers(min(3, len(running)))].id if running else "none"

    def _pause(self) -> None:
        self._stubs.motion.PauseMotion(motion_pb2.PauseMotionRequest(id=self._any()))

    def _resume(self) -> None:
        self._stubs.motion.ResumeMotion(motion_pb2.ResumeMotionRequest(id=self._any()))

    def _cancel(self) -> None:
        self._stubs.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=self._any()))

    def _stop(self) -> None:
        self._stubs.motion.Stop(motion_pb2.StopRequest(robots=[(), ("a",), ("b",)][self._rng.integers(3)]))


def _raise(error: grpc.RpcError) -> None:
    raise error


def test_every_motion_ends_whatever_clients_do_to_it(
    stepped: Stubs, stepped_kernel: KernelProcess, seed: int, draws: Draws
) -> None:
    for name in ("a", "b"):
        load(stepped, IIWA, name)
    rng = np.random.default_rng(seed)
    running = motion_pb2.ListMotionsRequest(running_only=True)
    stopping: dict[str, int] = {}
    clients = [Interrupter(stepped_kernel.stubs(), seed + i) for i in range(CLIENTS)]
    with ThreadPoolExecutor(CLIENTS) as pool:
        acting: list[Future[None]] = [pool.submit(client.act, draws(200)) for client in clients]
        while wait(acting, 0.0).not_done:
            step(stepped, int(rng.integers(1, 40)))
            now = stepped.motion.ListMotions(running)
            for one in now.motions:
                if one.phase == STOPPING:
                    assert now.stamp.tick - stopping.setdefault(one.id, now.stamp.tick) < LONGEST_TICKS, one
        for act in acting:
            act.result()
    assert all(client.started for client in clients)
    for paused in stepped.motion.ListMotions(running).motions:
        if motion(stepped, paused.id).phase == PAUSED:
            stepped.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=paused.id))
    step(stepped, LONGEST_TICKS)
    left = stepped.motion.ListMotions(running).motions
    assert all(one.phase == PAUSED for one in left), left  # it was pausing before
