"""KUKA robots by the Robot Sensor Interface (RSI): XML by UDP, each message answered by corrections of the axes.

The robot's program (KRL) switches RSI on; so the controller speaks first, each 4 or 12 ms, and every message must be
answered within the cycle with its own stamp (IPOC). One that isn't counts as late (Delay), and after some of them RSI
breaks off and the robot stops.

Corrections are *absolute* by default: they are counted from where the robot stood as RSI was switched on, so that a
lost one costs nothing and silence means standing. Relative ones are added up by the controller; where its configuration
holds the last one (HOLDON) they go on when nobody speaks.

So the driver has to know where RSI was switched on, or the robot would jump: it listens before that. A controller that
has been without answers already, or that it has corrected before, gets none until it breaks off and begins anew.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import pairwise
from math import radians
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.drivers import About, DriverFault, Mode, Pace, Reading
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.drivers.datagrams import DatagramDriver, Datagrams
from virtualrobot_plugins.drivers.kuka_rsi.messages import MessageError, number, read_robot, whole, write_sensor

BEGIN_SECONDS = 8.0
"""Time (s) that `connect` waits for a message."""
FIRST = 5
"""Number of messages from which `connect` learns how far apart they are."""
UNDER_WAY = 2
"""Number of messages that may be missing and not yet be counted as late."""

Tag = Annotated[str, Meta(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=32)]


@dataclass(frozen=True, slots=True)
class KukaRsiSettings:
    """Settings of KUKA's Robot Sensor Interface; tags are those of the sensor's configuration on the controller."""

    controller: Annotated[
        str, Meta(min_length=1, description="The controller's address; packets of all others are thrown away.")
    ] = "127.0.0.1"
    address: Annotated[
        str, Meta(min_length=1, description="This computer's address in the controller's network: IP_NUMBER.")
    ] = "127.0.0.1"
    port: Annotated[int, Meta(ge=1, le=65535, description="The port to listen at: PORT.")] = 49152
    sentype: Annotated[Tag, Meta(description="What answers call themselves: SENTYPE.")] = "ImFree"
    cycle: Annotated[
        Literal[4, 12], Meta(description="Milliseconds between two messages: 4 with IPO_FAST, 12 with IPO.")
    ] = 4
    joints: Annotated[int, Meta(ge=1, le=6, description="Axes of the robot: A1, A2, ... of AIPos.")] = 6
    external: Annotated[int, Meta(ge=0, le=6, description="External axes that go along: E1, E2, ... of EIPos.")] = 0
    sliding: Annotated[tuple[int, ...], Meta(description="Which external axes slide (mm), counted from 1.")] = ()
    corrections: Annotated[
        Literal["absolute", "relative"],
        Meta(
            description="Whether AXISCORR counts corrections from where RSI was switched on, or adds them up. Relative "
            "ones that are held (HOLDON) go on when this computer falls silent."
        ),
    ] = "absolute"
    axis_tag: Annotated[Tag, Meta(description="The tag of the robot's corrections.")] = "AK"
    external_tag: Annotated[Tag, Meta(description="The tag of the external axes' corrections.")] = "EK"
    outputs_tag: Annotated[
        str,
        Meta(
            pattern=r"^([A-Za-z_][A-Za-z0-9_]*)?$",
            description="The tag (LONG) by which digital outputs are set; empty: none.",
        ),
    ] = ""
    inputs_tag: Annotated[
        str,
        Meta(
            pattern=r"^([A-Za-z_][A-Za-z0-9_]*)?$",
            description="The tag (LONG) by which digital inputs are told; empty: none.",
        ),
    ] = ""
    late: Annotated[
        int, Meta(ge=1, le=10000, description="Late answers after which RSI breaks off: Timeout of ETHERNET.")
    ] = 100
    silence: Annotated[
        float, Meta(ge=0.01, le=1, description="Time (s) without a message after which the connection is lost.")
    ] = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class FromRobot:
    """Parts of a message that are read: its stamp (ms), late answers, positions (degrees, mm), digital inputs."""

    stamp: int
    late: int
    positions: Floats
    commanded: Floats
    inputs: int


class KukaRsi(DatagramDriver):
    """The connection to one KUKA controller."""

    def __init__(self, settings: KukaRsiSettings) -> None:
        """Keep the settings."""
        super().__init__()
        self._settings = settings
        self._newest: FromRobot | None = None
        self._base = self._wanted = self._applied = np.zeros(0)
        self._answered = -1
        self._outputs = 0
        self._anew = False

    def connect(self) -> About:
        """Listen, wait for the first message, and learn from some more how far they are apart."""
        before = self._newest
        self.close()
        settings = self._settings
        wrong = [axis for axis in settings.sliding if not 1 <= axis <= settings.external]
        if wrong:
            raise DriverFault(f"the setting sliding names the external axis {wrong[0]}; there are {settings.external}")
        self._socket = Datagrams(settings.address, settings.port, settings.controller)
        self._newest = None
        try:
            self._learn(before)
        except DriverFault:
            self.close()
            raise
        return About(
            joints=settings.joints + settings.external,
            rate=1000.0 / settings.cycle,
            pace=Pace.CONTROLLER,
            units=(
                *[radians(1.0)] * settings.joints,
                *[1e-3 if axis in settings.sliding else radians(1.0) for axis in range(1, settings.external + 1)],
            ),
            watchdog=settings.late * settings.cycle * 1e-3,
            silence=settings.silence,
            model="KUKA, Robot Sensor Interface",
            inputs=32 if settings.inputs_tag else 0,
            outputs=32 if settings.outputs_tag else 0,
        )

    def _learn(self, before: FromRobot | None) -> None:
        """Take where the robot is as that from which corrections are counted; find how far messages are apart."""
        assert self._socket is not None
        said = self._first(before)
        self._socket.lock()
        if not np.isfinite(said.commanded).all():
            raise DriverFault(f"the controller tells positions that are no numbers: {said.commanded.tolist()}")
        self._start(said)
        stamps = [said.stamp]
        while len(stamps) < FIRST:
            self._answer()
            stamps.append(self._receive(BEGIN_SECONDS).stamp)
        self._anew = False
        step = min(after - first for first, after in pairwise(stamps))
        if step != self._settings.cycle:
            raise DriverFault(f"messages are {step} ms apart; the setting cycle says {self._settings.cycle}")

    def _first(self, before: FromRobot | None) -> FromRobot:
        """Return a message of RSI that has been without answers and corrections; one that has not isn't answered."""
        deadline, said, settings = time.monotonic() + BEGIN_SECONDS, None, self._settings
        while said is None or said.late or _is_going_on(before, said, settings):
            if said is not None and time.monotonic() >= deadline:
                raise DriverFault(
                    f"RSI is on already, with {said.late} messages unanswered, so that nobody knows from where it "
                    "counts corrections: stop the robot's program, connect, and then start it"
                )
            try:
                said = self._receive(max(0.0, deadline - time.monotonic()))
            except DriverFault as fault:
                if said is None:
                    words = f"{fault.text}: start the robot's program, which has to switch RSI on"
                    raise DriverFault(words) from fault
        return said

    def read(self) -> Reading:
        """Return the newest message; until `begin` it is answered here, so that the robot is held."""
        before = self._newest
        said = self._receive(self._settings.silence)
        if self._anew:
            if self._begun:
                raise DriverFault("RSI was switched off and on again on the controller")
            self._anew = False
            self._start(said)
        text = ""
        if before is not None and said.late > before.late:
            text = f"{said.late} of {self._settings.late} answers came late"
            if self._begun and self._settings.corrections == "relative":
                raise DriverFault(f"{text}: relative corrections were lost, so the robot is not where it should be")
        if not self._begun:
            self._answer()
        return Reading(
            stamp=said.stamp * 1e-3,
            positions=said.positions,
            mode=Mode.RUNNING if self._begun else Mode.READY,
            inputs=said.inputs,
            text=text,
        )

    def begin(self, held: Floats) -> None:
        """Follow from the next message on. RSI corrects as long as the robot's program has it switched on."""
        self.read()
        self._begun = True

    def send(self, positions: Floats, velocities: Floats, outputs: int) -> None:
        """Answer the newest message with these positions, as corrections from where RSI was switched on."""
        if not self._begun:
            return
        self._wanted, self._outputs = np.array(positions, dtype=np.float64), outputs
        self._answer()

    def _start(self, said: FromRobot) -> None:
        """Count corrections from where the robot is commanded to be now, without any."""
        self._base = self._wanted = self._applied = said.commanded

    def _answer(self) -> None:
        """Answer the newest message, once: another answer would count as a wrong one."""
        settings, said = self._settings, self._newest
        if self._socket is None or said is None or said.stamp == self._answered or not np.isfinite(self._wanted).all():
            return
        relative = settings.corrections == "relative"
        values = (self._wanted - (self._applied if relative else self._base)).tolist()
        robot, external = values[: settings.joints], values[settings.joints :]
        corrections = {settings.axis_tag: {f"A{axis}": value for axis, value in enumerate(robot, 1)}}
        if external:
            corrections[settings.external_tag] = {f"E{axis}": value for axis, value in enumerate(external, 1)}
        outputs = {settings.outputs_tag: self._outputs & 0xFFFFFFFF} if settings.outputs_tag else {}
        self._socket.send(write_sensor(settings.sentype, corrections, outputs, said.stamp))
        self._applied, self._answered = self._wanted, said.stamp

    def _receive(self, seconds: float) -> FromRobot:
        """Return the newest message that is newer than what is known."""
        if self._socket is None:
            raise DriverFault("there is no connection to the controller")
        self._socket.newest(seconds, self._take)
        assert self._newest is not None
        return self._newest

    def _take(self, data: bytes) -> str:
        """Keep a message that is new; return why another one is dropped."""
        try:
            said = self._read(data)
        except MessageError as error:
            return str(error)
        known = self._newest
        if known is not None and said.stamp <= known.stamp:
            return f"IPOC {said.stamp} came again or late"
        if known is not None:
            # What is missing has been counted as late, but for what is under way; else RSI has been off meanwhile.
            missing = (said.stamp - known.stamp) // self._settings.cycle - 1
            self._anew |= not 0 <= said.late - known.late >= missing - UNDER_WAY
        self._newest = said
        return ""

    def _read(self, data: bytes) -> FromRobot:
        said, settings = read_robot(data), self._settings
        measured = [number(said, "AIPos", f"A{axis}") for axis in range(1, settings.joints + 1)]
        measured += [number(said, "EIPos", f"E{axis}") for axis in range(1, settings.external + 1)]
        commanded = list(measured)
        if "ASPos" in said and (not settings.external or "ESPos" in said):
            commanded = [number(said, "ASPos", f"A{axis}") for axis in range(1, settings.joints + 1)]
            commanded += [number(said, "ESPos", f"E{axis}") for axis in range(1, settings.external + 1)]
        inputs = whole(said, settings.inputs_tag) & 0xFFFFFFFF if settings.inputs_tag else 0
        return FromRobot(
            whole(said, "IPOC"), whole(said, "Delay", "D"), np.array(measured), np.array(commanded), inputs
        )


def _is_going_on(before: FromRobot | None, said: FromRobot, settings: KukaRsiSettings) -> bool:
    """Return whether RSI may still be as it was at the message `before`: it has had no time to break off."""
    return before is not None and 0 <= said.stamp - before.stamp <= settings.late * settings.cycle
