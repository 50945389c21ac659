"""A driver of a simulated robot with two joints, and wrong ones.

The robot is one for the whole process, as a real one would be: it stays where a driver left it.
"""

from __future__ import annotations

import time

import numpy as np
from virtualrobot_sdk.drivers import TRANSITIONS, DriverState, Measured
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats

JOINTS = ("shoulder", "elbow")
SPEED = 2.0
"""The greatest speed of a joint (rad/s)."""


class Robot:
    """A robot whose joints go to their targets at a limited speed; it moves whenever somebody looks."""

    def __init__(self) -> None:
        """Stand somewhere."""
        self.q = np.array([0.3, -0.7])
        self.target = self.q.copy()
        self.moved = time.monotonic()
        self.velocity = np.zeros(2)

    def look(self) -> tuple[Floats, Floats, float]:
        """Return positions, velocities and time now."""
        now = time.monotonic()
        passed, self.moved = now - self.moved, now
        step = np.clip(self.target - self.q, -SPEED * passed, SPEED * passed)
        self.velocity = step / passed if passed > 0 else self.velocity
        self.q = self.q + step
        return self.q.copy(), self.velocity.copy(), now

    def halt(self) -> None:
        """Stay where it is."""
        self.target = self.look()[0]


ROBOT = Robot()


class Simulated:
    """Keeps all that a driver must."""

    def __init__(self) -> None:
        """Know nothing of a robot."""
        self.state = DriverState.UNCONFIGURED
        self.order = np.arange(2)
        self.is_cut = False

    def configure(self, joint_names: tuple[str, ...], /) -> None:
        """Connect."""
        self.enter("configure")
        if sorted(joint_names) != sorted(JOINTS):
            raise ArgumentError(f"the joints are {', '.join(joint_names)}; this robot has {', '.join(JOINTS)}")
        self.is_cut = False
        self.order = np.array([JOINTS.index(name) for name in joint_names])
        self.state = DriverState.INACTIVE

    def activate(self) -> None:
        """Hold."""
        self.enter("activate")
        self.hold()
        self.state = DriverState.ACTIVE

    def hold(self) -> None:
        """Forget the target."""
        ROBOT.halt()

    def read(self) -> Measured:
        """Look."""
        self.enter("read")
        self.reach()
        positions, velocities, now = ROBOT.look()
        return Measured(positions[self.order], velocities[self.order], now)

    def write(self, positions: Floats, velocities: Floats, /) -> None:
        """Go."""
        self.enter("write")
        self.reach()
        if positions.shape != (2,) or velocities.shape != (2,):
            raise ArgumentError(f"positions {positions.shape} and velocities {velocities.shape} must be (2,)")
        if not np.isfinite(positions).all() or not np.isfinite(velocities).all():
            raise ArgumentError(f"positions {positions} and velocities {velocities} must be finite")
        ROBOT.look()
        target = np.empty(2)
        target[self.order] = positions
        ROBOT.target = target

    def stop(self) -> None:
        """Halt."""
        if self.state is DriverState.ACTIVE:
            ROBOT.halt()
            self.state = DriverState.INACTIVE

    def deactivate(self) -> None:
        """Let go."""
        self.enter("deactivate")
        ROBOT.halt()
        self.state = DriverState.INACTIVE

    def cleanup(self) -> None:
        """Disconnect."""
        self.enter("cleanup")
        self.state = DriverState.UNCONFIGURED

    def cut_cable(self) -> None:
        """Break the connection; the robot halts by itself."""
        self.is_cut = True
        self.robot_is_alone()

    def robot_is_alone(self) -> None:
        """Halt, as a robot does that hears nothing."""
        ROBOT.halt()

    def reach(self) -> None:
        """Fail when the cable is cut."""
        if self.is_cut:
            self.state = DriverState.ERROR
            raise ConnectionError("the controller does not answer")

    def enter(self, call: str) -> None:
        """Refuse what is not allowed in this state."""
        if call not in TRANSITIONS[self.state]:
            allowed = ", ".join(TRANSITIONS[self.state])
            raise ArgumentError(f"{call} is not allowed in {self.state.value}; there is {allowed}")


class Watched(Simulated):
    """Counts how often any driver of this process let the robot follow."""

    count = 0

    def activate(self) -> None:
        """Hold, and count."""
        super().activate()
        Watched.count += 1

    def activations(self) -> int:
        """Return how often."""
        return Watched.count


class TakesAnyCall(Simulated):
    """Wrong: may be written to before it is active."""

    def enter(self, call: str) -> None:
        """Refuse less than it should."""
        if call != "write":
            super().enter(call)


class RefusesInError(Simulated):
    """Wrong: whoever gives it a wrong argument must begin anew."""

    def write(self, positions: Floats, velocities: Floats, /) -> None:
        """Go."""
        try:
            super().write(positions, velocities)
        except ArgumentError:
            self.state = DriverState.ERROR
            raise


class OwnOrder(Simulated):
    """Wrong: its values are in the robot's order, whatever order was asked for."""

    def configure(self, joint_names: tuple[str, ...], /) -> None:
        """Connect."""
        super().configure(joint_names)
        self.order = np.arange(2)


class WritesInOwnOrder(Simulated):
    """Wrong: it reads in the order that was asked for, and writes in the robot's."""

    def write(self, positions: Floats, velocities: Floats, /) -> None:
        """Go."""
        super().write(positions[np.argsort(self.order)] if positions.shape == (2,) else positions, velocities)


class NoVelocities(Simulated):
    """Wrong: it knows no velocities and says 0."""

    def read(self) -> Measured:
        """Look."""
        said = super().read()
        return Measured(said.positions, np.zeros(2), said.seconds)


class VelocitiesBackwards(Simulated):
    """Wrong: its velocities have the other sign."""

    def read(self) -> Measured:
        """Look."""
        said = super().read()
        return Measured(said.positions, -said.velocities, said.seconds)


class Degrees(Simulated):
    """Wrong: it reads and takes degrees."""

    def read(self) -> Measured:
        """Look."""
        said = super().read()
        return Measured(np.degrees(said.positions), np.degrees(said.velocities), said.seconds)

    def write(self, positions: Floats, velocities: Floats, /) -> None:
        """Go."""
        super().write(np.radians(positions), np.radians(velocities))


class Milliseconds(Simulated):
    """Wrong: the time of its readings is in milliseconds."""

    def read(self) -> Measured:
        """Look."""
        said = super().read()
        return Measured(said.positions, said.velocities, 1e3 * said.seconds)


class ClockStands(Simulated):
    """Wrong: the time of its readings is always the same."""

    def read(self) -> Measured:
        """Look."""
        said = super().read()
        return Measured(said.positions, said.velocities, 1.0)


class Deaf(Simulated):
    """Wrong: nothing that is written reaches the robot."""

    def write(self, positions: Floats, velocities: Floats, /) -> None:
        """Go nowhere."""
        self.enter("write")


class GoesOn(Simulated):
    """Wrong: goes on to the old target when it is active again."""

    wanted: Floats | None = None

    def write(self, positions: Floats, velocities: Floats, /) -> None:
        """Go."""
        super().write(positions, velocities)
        self.wanted = ROBOT.target.copy() + 0.01

    def hold(self) -> None:
        """Go on."""
        ROBOT.look()
        ROBOT.target = ROBOT.target if self.wanted is None else self.wanted


class NoStop(Simulated):
    """Wrong: a stop is said to have been made, and the robot goes on."""

    def stop(self) -> None:
        """Do nothing."""
        if self.state is DriverState.ACTIVE:
            ROBOT.target = ROBOT.target + 0.05
            self.state = DriverState.INACTIVE


class KeepsSilent(Simulated):
    """Wrong: a broken connection shows nowhere."""

    def reach(self) -> None:
        """See nothing."""
