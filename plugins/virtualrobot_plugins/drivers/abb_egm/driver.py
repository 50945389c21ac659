"""ABB robots by Externally Guided Motion (EGM): messages by UDP, each answered by positions of joints.

The robot's program (RAPID) opens the session and runs `EGMRunJoint`; so the controller speaks first, as a rule 250
times a second, and this driver answers. As long as nothing has been begun the answer is where the joints were as the
session began: the robot is held, and its program doesn't run into the time-out of its communication.

Packets count in the order in which the controller made them. One that comes twice or after a later one is dropped, and
so is what is no message; a number that begins anew with a later time is another session.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta
from virtualrobot_sdk.drivers import About, DriverFault, Mode, Pace, Reading, Safety
from virtualrobot_sdk.kinematics import Floats

from virtualrobot_plugins.drivers.abb_egm.messages import (
    FromRobot,
    Mci,
    MessageError,
    Motors,
    Rapid,
    read_robot,
    write_sensor,
)
from virtualrobot_plugins.drivers.datagrams import DatagramDriver, Datagrams

BEGIN_SECONDS = 8.0
"""Time (s) that `connect` waits for the first packet, and `begin` for the robot's program to let it follow."""
DEGREE, MILLIMETER = math.radians(1.0), 1e-3


@dataclass(frozen=True, slots=True)
class AbbEgmSettings:
    """Settings of ABB's Externally Guided Motion."""

    controller: Annotated[
        str, Meta(min_length=1, description="The controller's address; packets of all others are thrown away.")
    ] = "127.0.0.1"
    address: Annotated[
        str, Meta(min_length=1, description="This computer's address in the controller's network, to listen at.")
    ] = "127.0.0.1"
    port: Annotated[
        int,
        Meta(ge=1, le=65535, description="The port to listen at: that of the robot's UDPUC device, by default 6510."),
    ] = 6510
    rate: Annotated[
        float, Meta(gt=0, le=250, description="Packets a second (Hz) that the controller sends: \\SampleRate of RAPID.")
    ] = 250.0
    sliding: Annotated[
        tuple[int, ...],
        Meta(description="Which external axes slide, counted from 1, so that EGM has them in mm and not in degrees."),
    ] = ()
    silence: Annotated[
        float, Meta(ge=0.01, le=1, description="Time (s) without a packet after which the connection is lost.")
    ] = 0.1
    timeout: Annotated[
        float,
        Meta(
            ge=0,
            le=10,
            description="Time (s) without an answer after which the controller stops the robot: \\CommTimeout.",
        ),
    ] = 1.0


class AbbEgm(DatagramDriver):
    """The connection to one ABB controller."""

    def __init__(self, settings: AbbEgmSettings) -> None:
        """Keep the settings."""
        super().__init__()
        self._settings = settings
        self._newest = FromRobot()
        self._held = np.zeros(0)
        self._sent = 0
        self._digital = self._anew = False

    def connect(self) -> About:
        """Listen, wait for the controller's first packet, and take those of its sender alone from then on."""
        self.close()
        settings = self._settings
        self._socket = Datagrams(settings.address, settings.port, settings.controller)
        self._newest, self._held = FromRobot(), np.zeros(0)
        self._begun = self._anew = self._digital = False
        # More milliseconds go by than packets: a controller that hasn't noticed the end of a session drops nothing.
        self._sent = time.monotonic_ns() // 1_000_000 & 0xFFFFFFFF
        try:
            said = self._receive(BEGIN_SECONDS)
        except DriverFault as fault:
            self.close()
            raise DriverFault(
                f"{fault.text}: start the robot's program, which has to come to EGMSetupUC and EGMRunJoint"
            ) from fault
        self._socket.lock()
        self._held = _positions(said)
        if not np.isfinite(self._held).all():
            self.close()
            raise DriverFault(f"the controller tells joints that are no numbers: {self._held.tolist()}")
        external = len(said.external)
        wrong = [axis for axis in settings.sliding if not 1 <= axis <= external]
        if wrong:
            self.close()
            raise DriverFault(f"the setting sliding names the external axis {wrong[0]}; the robot has {external}")
        units = [DEGREE] * len(said.joints)
        units += [MILLIMETER if axis in settings.sliding else DEGREE for axis in range(1, external + 1)]
        return About(
            joints=len(units),
            rate=settings.rate,
            pace=Pace.CONTROLLER,
            units=tuple(units),
            watchdog=settings.timeout,
            silence=settings.silence,
            model="ABB, Externally Guided Motion",
            inputs=1,
            outputs=1,
        )

    def read(self) -> Reading:
        """Return the newest packet; until `begin` it is answered here, so that the robot is held."""
        said = self._receive(self._settings.silence)
        anew, self._anew = self._anew, False
        if anew and self._begun:
            raise DriverFault("the robot's program has ended guided motion, and begun it anew")
        positions = _positions(said)
        if len(positions) != len(self._held):
            raise DriverFault(f"the controller tells {len(positions)} joints; it had {len(self._held)} before")
        reading = _reading(said, self._begun)
        if not self._begun:
            if anew or reading.mode is not Mode.READY:
                self._held = positions  # whoever moves it until it would follow, it is held from there on
            self._answer(self._held)
        return reading

    def begin(self, held: Floats) -> None:
        """Wait until the robot's program runs EGMRunJoint, holding the robot at `held`."""
        deadline = time.monotonic() + BEGIN_SECONDS
        while True:
            reading = self.read()
            if reading.safety is not Safety.NORMAL or reading.mode in (Mode.OFF, Mode.LOCAL):
                raise DriverFault(reading.text)
            if reading.mode is Mode.READY:
                break
            if time.monotonic() > deadline:
                raise DriverFault(reading.text)
        self._begun = True
        self.send(held, np.zeros_like(held), int(self._digital))

    def send(self, positions: Floats, velocities: Floats, outputs: int) -> None:
        """Answer the newest packet with these positions. EGM's own loop makes the speed."""
        if not self._begun:
            return
        self._held, self._digital = np.array(positions, dtype=np.float64), bool(outputs & 1)
        self._answer(self._held)

    def _answer(self, positions: Floats) -> None:
        if self._socket is None or not np.isfinite(positions).all():
            return
        joints = len(self._newest.joints)
        values = positions.tolist()
        self._socket.send(
            write_sensor(self._sent, self._newest.milliseconds, values[:joints], values[joints:], self._digital)
        )
        self._sent = self._sent + 1 & 0xFFFFFFFF

    def _receive(self, seconds: float) -> FromRobot:
        """Return the newest packet that is newer than what is known."""
        if self._socket is None:
            raise DriverFault("there is no connection to the controller")
        self._socket.newest(seconds, self._take)
        return self._newest

    def _take(self, data: bytes) -> str:
        """Keep a packet that is new; return why another one is dropped."""
        try:
            said = read_robot(data)
        except MessageError as error:
            return str(error)
        if not _later(self._newest, said):
            return f"number {said.sequence} came again or late"
        self._anew |= _anew(self._newest, said)
        self._newest = said
        return ""


def _positions(said: FromRobot) -> Floats:
    return np.array([*said.joints, *said.external])


def _ahead(after: int, before: int) -> int:
    """Return by how many packets the number `after` is past `before`, which begins at 0 after 2^32 - 1."""
    return ((after - before + 0x80000000) & 0xFFFFFFFF) - 0x80000000


def _later(before: FromRobot, after: FromRobot) -> bool:
    """Return whether the controller made `after` later: it has a higher number and no earlier time, or begins anew."""
    if before.sequence < 0:
        return True
    in_order = _ahead(after.sequence, before.sequence) > 0 and _ahead(after.milliseconds, before.milliseconds) >= 0
    return in_order or _anew(before, after)


def _anew(before: FromRobot, after: FromRobot) -> bool:
    """Return whether numbers have begun anew while time went on."""
    return (
        before.sequence >= 0
        and _ahead(after.sequence, before.sequence) <= 0
        and _ahead(after.milliseconds, before.milliseconds) > 0
    )


def _reading(said: FromRobot, begun: bool) -> Reading:
    """Return what a packet says, in the driver's words."""
    mode, safety, text = Mode.RUNNING if begun else Mode.READY, Safety.NORMAL, ""
    if said.collision:
        safety, text = Safety.PROTECTIVE_STOP, "the robot's motion supervision has seen a collision"
    elif said.mci is Mci.ERROR:
        safety, text = Safety.FAULT, "EGM has an error (MCI_ERROR); the event log on the pendant says which"
    if said.motors is Motors.OFF:
        mode, text = Mode.OFF, text or "the motors are off: switch them on at the controller"
    elif said.rapid is Rapid.STOPPED:
        mode, text = Mode.LOCAL, text or "the robot's program stands: start it on the pendant"
    elif said.mci is Mci.STOPPED:
        mode, text = Mode.STARTING, text or "the robot's program is not at EGMRunJoint"
    if begun and mode is not Mode.RUNNING and safety is Safety.NORMAL:
        safety = Safety.PROTECTIVE_STOP  # it stands, and EGM doesn't say whether a door or a person was the cause
    stamp = said.seconds or said.milliseconds * 1e-3 or float(said.sequence)
    return Reading(stamp, _positions(said), mode=mode, safety=safety, inputs=int(said.digital), text=text)
