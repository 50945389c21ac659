"""Laws of motion under random steering: limits held, paths kept, progress that never falls."""

from __future__ import annotations

import grpc
import numpy as np
import pytest
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA, PANDA, joints, load, start
from tests.api.moving import ABORTED, CANCELLED, SUCCEEDED, TICK, motion
from tests.api.reading import state, step
from tests.api.test_motion import pause, resume, slowed
from tests.api.test_robot import drawn, put, robot
from tests.kernels import Stubs

ENDED = (SUCCEEDED, CANCELLED, ABORTED)


class Steering:
    """Pauses, resumes and slows a motion at random; in the end lets it go on or cancels it."""

    def __init__(self, stubs: Stubs, rng: np.random.Generator, id: str) -> None:
        """Steer the motion with this id."""
        self.stubs, self.rng, self.id = stubs, rng, id
        self.ticks = 0

    def steer(self) -> None:
        """Do something to the motion every 40 ticks or so; after 600 ticks let it go on."""
        self.ticks += 1
        if self.ticks == 600:
            slowed(self.stubs, 1.0)
            slowed(self.stubs, 1.0, "arm")
        try:
            if self.ticks == 600:
                resume(self.stubs, self.id)
            elif self.ticks < 600 and self.rng.random() < 1 / 40:
                kind = self.rng.integers(5)
                if kind == 0:
                    pause(self.stubs, self.id)
                elif kind <= 2:
                    slowed(self.stubs, float(self.rng.uniform(0.05, 1.0)), str(self.rng.choice(["", "arm"])))
                else:
                    resume(self.stubs, self.id)
        except grpc.RpcError as error:
            assert "cannot be" in str(error) or "has ended" in str(error), "it stops or has ended"

    def rows(self) -> tuple[np.ndarray, np.ndarray]:
        """Run to the end; return positions and velocities of all joints after each tick, (n, k) each."""
        positions, velocities = [], []
        while True:
            answer = step(self.stubs)
            positions.append(list(answer.robots[0].positions))
            velocities.append(list(answer.robots[0].velocities))
            if any(one.id == self.id and one.phase in ENDED for one in answer.motions):
                return np.array(positions), np.array(velocities)
            self.steer()


def limits(stubs: Stubs) -> dict[str, np.ndarray]:
    told = [joint.limits for joint in robot(stubs, "arm").joints]
    names = ("lower", "upper", "velocity", "acceleration", "jerk")
    return {name: np.array([getattr(one, name) for one in told]) for name in names}


def assert_limits_are_kept(stubs: Stubs, first: np.ndarray, positions: np.ndarray, velocities: np.ndarray) -> None:
    """Finite differences over a tick are means of a derivative, which its greatest value bounds; 1% for the ramps."""
    bound = limits(stubs)
    assert np.all(positions >= bound["lower"] - 1e-6)
    assert np.all(positions <= bound["upper"] + 1e-6)
    assert np.all(np.abs(velocities) <= bound["velocity"] * 1.001)
    all_positions = np.vstack([first, positions])
    all_velocities = np.vstack([np.zeros_like(first), velocities])
    means = np.diff(all_positions, axis=0) / TICK
    assert np.all(np.abs(means) <= bound["velocity"] * 1.001)
    assert np.all(np.abs(np.diff(all_velocities, axis=0)) / TICK <= bound["acceleration"] * 1.01)
    step_of_velocity = np.abs(means - (all_velocities[1:] + all_velocities[:-1]) / 2)
    # The trapezoid rule's error is at most h^2/12 times the jerk: velocities are those of the positions.
    assert np.all(step_of_velocity <= TICK**2 / 12 * bound["jerk"] * 1.1 + 1e-9)


@pytest.mark.parametrize("uri", [IIWA, PANDA])
def test_random_steering_keeps_joint_limits_and_the_path(stepped: Stubs, rng: np.random.Generator, uri: str) -> None:
    load(stepped, uri, "arm")
    put(stepped, "arm", drawn(stepped, "arm", rng))
    first = np.array(state(stepped, "arm").positions)
    goal = drawn(stepped, "arm", rng)
    ask = start(stepped, joints("arm", float(rng.uniform(0.5, 1.0)), **goal))
    positions, velocities = Steering(stepped, rng, ask.id).rows()
    assert_limits_are_kept(stepped, first, positions, velocities)
    travel = np.array(list(goal.values())) - first
    share = (positions - first) @ travel / (travel @ travel)
    assert np.abs(positions - first - share[:, None] * travel).max() < 1e-9, "on the line in joint space"
    assert np.all(np.diff(share) > -1e-12), "never backwards"
    assert share[-1] == pytest.approx(1.0, abs=1e-9)
    assert not np.any(velocities[-1])


@pytest.mark.long
def test_progress_never_falls(stepped: Stubs, rng: np.random.Generator) -> None:
    load(stepped, IIWA, "arm")
    ask = start(stepped, joints("arm", 0.5, **drawn(stepped, "arm", rng)))
    steering = Steering(stepped, rng, ask.id)
    progress = [0.0]
    while (now := motion(stepped, ask.id)).phase not in ENDED:
        progress.append(now.progress)
        step(stepped)
        steering.steer()
    assert np.all(np.diff(progress) >= 0.0)
    assert now.progress == 1.0
    assert now.phase == motion_pb2.MOTION_PHASE_SUCCEEDED
