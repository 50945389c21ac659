"""Tools and belts that signals drive: a boolean becomes motions, and another one tells what has come of it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping

from virtualrobot import Client
from virtualrobot.errors import UnknownNameError, VirtualRobotError
from virtualrobot.motions.motion import Motion
from virtualrobot.motions.state import MotionState, Phase

from virtualrobot_apps.connections.expressions import Value
from virtualrobot_apps.connections.file import BeltDevice, ConnectionFile, ToolDevice

Say = Callable[[str], None]


class Device(ABC):
    """Something that moves as a signal says: what it shall do is a state of a tool or a velocity, one motion at a time.

    What comes while it moves waits until that motion has braked, so that it is the same in stepped time, where nothing
    waits in a call.
    """

    def __init__(self, name: str, told: str, say: Say) -> None:
        """Drive what errors call `name`; `told` is the boolean that tells about it, empty for none."""
        self._name, self._told, self._say = name, told, say
        self._wanted: str | float | None = None
        self._motion: Motion | None = None
        self._cancelled = False

    @property
    def waiting(self) -> bool:
        """True while it has to be looked at though no signal changes."""
        return self._motion is not None

    def update(self, values: Mapping[str, Value]) -> dict[str, Value]:
        """Act on the values of signals; return the value of the one that tells about it."""
        try:
            self._act(self.wanted(values))
        except VirtualRobotError as error:
            self._say(f"{self._name} cannot do as its signal says: {error}")
        return {self._told: self.telling()} if self._told else {}

    def _act(self, wanted: str | float) -> None:
        if self._motion is not None and (now := self._motion.state).phase.ended:
            self._motion = None
            self.ended(now)
        if wanted == self._wanted:
            return
        if self._motion is not None:
            if not self._cancelled:
                self._motion.cancel("a signal says otherwise")
            self._cancelled = True
            return
        self._wanted, self._cancelled = wanted, False
        self._motion = self.begin(wanted)

    def stop(self) -> None:
        """Leave nothing moving."""
        if self._motion is not None:
            self._motion.cancel("connections end")
            self._motion = None

    @abstractmethod
    def wanted(self, values: Mapping[str, Value]) -> str | float:
        """Return what the signals say that it shall do."""

    @abstractmethod
    def begin(self, wanted: str | float) -> Motion | None:
        """Start that."""

    @abstractmethod
    def ended(self, state: MotionState) -> None:
        """Look at how a motion of it has ended."""

    @abstractmethod
    def telling(self) -> bool:
        """Return the value of the signal that tells about it."""


class DrivenTool(Device):
    """A tool that goes into one of two states."""

    def __init__(self, client: Client, device: ToolDevice, say: Say) -> None:
        """Drive it; nothing moves before the first update.

        Raises:
            UnknownNameError: when there is no such robot or tool.
            MalformedFileError: when the tool has no such state.
        """
        self._device = device
        self._tool = client.robot(device.robot).tool(device.tool or None)
        super().__init__(f"the tool {self._tool.name!r}", device.done, say)
        states = self._tool.states
        for state in (device.on, device.off):
            if state not in states:
                known = ", ".join(map(repr, states))
                raise device.item.error(f"the tool {self._tool.name!r} has no state {state!r}; it has {known}")
        self._reached = ""

    def wanted(self, values: Mapping[str, Value]) -> str:
        """Return the state that the signal chooses."""
        return self._device.on if values[self._device.signal] else self._device.off

    def begin(self, wanted: str | float) -> Motion:
        """Go into a state."""
        self._reached = ""
        return self._tool.set(str(wanted), wait=False)

    def ended(self, state: MotionState) -> None:
        """Keep the state where it is reached."""
        if state.phase is Phase.SUCCEEDED:
            self._reached = str(self._wanted)
        elif not self._cancelled:
            self._say(f"{self._name} is not {self._wanted!r}: {state.end_reason}")

    def telling(self) -> bool:
        """Return whether the state of `on` is reached."""
        return self._reached == self._device.on


class DrivenBelt(Device):
    """A joint that runs while a signal is on."""

    def __init__(self, client: Client, device: BeltDevice, say: Say) -> None:
        """Drive it; nothing moves before the first update.

        Raises:
            UnknownNameError: when there is no such robot.
            MalformedFileError: when the robot has no such joint.
        """
        super().__init__(f"{device.robot}/{device.joint}", device.moving, say)
        self._device = device
        self._robot = client.robot(device.robot)
        if device.joint not in self._robot.joint_names:
            known = ", ".join(map(repr, self._robot.joint_names))
            raise device.item.error(f"{device.robot!r} has no joint {device.joint!r}; it has {known}")

    def wanted(self, values: Mapping[str, Value]) -> float:
        """Return the velocity that the signals say."""
        speed = self._device.velocity
        given = values[speed] if isinstance(speed, str) else speed
        return float(given) if values[self._device.signal] and not isinstance(given, str | tuple) else 0.0

    def begin(self, wanted: str | float) -> Motion | None:
        """Run with a velocity."""
        if not wanted:
            return None
        return self._robot.start(self._robot.joint_jog(self._device.joint, float(wanted)), wait=False)

    def ended(self, state: MotionState) -> None:
        """Tell what has stopped it but its signal."""
        if not self._cancelled:
            self._say(f"{self._name} has stopped: {state.end_reason or 'its joint is at its limit'}")

    def telling(self) -> bool:
        """Return whether it moves."""
        return self._motion is not None


def fitted(client: Client, file: ConnectionFile, world: Mapping[str, Value], say: Say) -> list[Device]:
    """Check a file against a kernel and its signals; return its tools and belts, which move at the first update.

    Raises MalformedFileError, with the line, for the first signal, type, robot, tool, state or joint that does not fit.
    """
    file.check_signals(world)
    devices: list[Device] = []
    for one in (*file.tools, *file.belts):
        try:
            devices.append(
                DrivenTool(client, one, say) if isinstance(one, ToolDevice) else DrivenBelt(client, one, say)
            )
        except UnknownNameError as error:
            raise one.item.error(str(error)) from error
    return devices
