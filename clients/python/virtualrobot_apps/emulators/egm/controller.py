r"""An ABB controller that runs EGM in a loop: it speaks first, and goes where it is answered to go.

Its program is emulated so:

    WHILE TRUE DO
      EGMSetupUC ROB_1, egm, "default", "pc" \Joint \CommTimeout:=timeout;
      EGMActJoint egm \SampleRate:=4;
      EGMRunJoint egm, EGM_STOP_HOLD \J1 \J2 \J3 \J4 \J5 \J6;   ! until nothing has come for the time-out
    ENDWHILE

or with EGMActPose and EGMRunPose, where poses are asked for; programs in RAPID run it with their own words
(`virtualrobot_apps.languages.rapid.guided`). So numbers of packets begin anew after each time-out. What
it can't follow (a wrong count of joints, no numbers, a pose out of reach, a position out of range, whatever the twin in
a kernel refuses) makes EGM say MCI_ERROR until the time-out has passed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from google.protobuf.message import DecodeError
from virtualrobot.errors import VirtualRobotError
from virtualrobot.geometry import pose_from_quaternion, quaternion_of

from virtualrobot_apps.emulators.body import Body, Floats
from virtualrobot_apps.emulators.cyclic import Datagrams
from virtualrobot_apps.emulators.egm.messages import (
    DATA,
    MCI_ERROR,
    MCI_RUNNING,
    MCI_STOPPED,
    MOTORS_OFF,
    MOTORS_ON,
    RAPID_RUNNING,
    RAPID_STOPPED,
    EgmRobot,
    EgmSensor,
)

ROBOT_JOINTS = 6
"""Number of joints that are the robot's own; the others are external axes, as ABB counts."""


class EgmController:
    """The controller; whoever has it calls `cycle` as often as its rate says, each time once.

    Attributes:
        motors_on, program_runs, collision: what it tells of itself; a robot without motors or program follows nothing.
        silent: whether it does nothing, as one whose network is gone.
        answered: packets that have come in this session.
        convergence_met: whether the arm is where it was asked to be, as it has told last.
        base_t_frame: the frame of poses, 4x4, in the base's.
        poses: whether it takes poses alone, or joints alone (False); None: what comes.
    """

    def __init__(
        self,
        body: Body,
        to: tuple[str, int],
        rate: float = 250.0,
        timeout: float = 1.0,
        tell: Callable[[str], None] = lambda words: None,
    ) -> None:
        """Speak to the computer at `to` (host, port) `rate` times a second, about `body`, which it moves.

        Args:
            body: the arm.
            to: where the computer listens.
            rate: packets a second (Hz).
            timeout: seconds without an answer after which the robot stops.
            tell: is called with a sentence when something begins or ends.
        """
        self.period = 1.0 / rate
        self.motors_on = self.program_runs = True
        self.collision = self.silent = self.convergence_met = False
        self.answered = 0
        self.base_t_frame = np.eye(4)
        self.poses: bool | None = None
        self._body, self._timeout, self._tell = body, timeout, tell
        self._datagrams = Datagrams(to)
        self._cycles = self._sequence = self._began = 0
        self._heard: int | None = None
        self._last_number: int | None = None
        self._wrong, self._stood = "", False
        self._planned, self._pose = body.read()[0], None
        self._rapid: tuple[bool, list[float]] = (False, [])
        self._unit = np.array([1e3 if slides else math.degrees(1.0) for slides in body.sliding])

    def cycle(self) -> None:
        """Take the newest answer, move the arm for a cycle, and tell where it is."""
        if self.silent:
            return
        self._cycles += 1
        for data in self._datagrams.received():
            self._take(data)
        if self._heard is not None and self.silence > self._timeout:
            self._tell(f"nothing has come for {self._timeout:g} s: the robot stops, and EGM begins anew")
            self._begin_anew()
        if self._runs() and self._stood:
            self._begin_anew()  # what was asked before is no longer meant
        self._stood = not self._runs()
        if self._runs() and not self._wrong:
            if self._pose is not None:
                self._solve(self._pose)
            if self.answered and not self._wrong:
                self._body.follow(self.setpoint(self._planned))
            if self._body.complaint:
                self._refuse(self._body.complaint)
        else:
            self._body.halt()
        self._body.advance(self.period)
        self._send()

    def close(self) -> None:
        """Stop the arm, and give the socket back."""
        self._body.close()
        self._datagrams.close()

    @property
    def silence(self) -> float:
        """Time (s) since something has come, or else since the session began."""
        return (self._cycles - (self._began if self._heard is None else self._heard)) * self.period

    @property
    def refused(self) -> str:
        """Words that say what it could not follow; empty as long as it could."""
        return self._wrong

    def setpoint(self, planned: Floats) -> Floats:
        """Return where the arm is sent to in this cycle, which is asked to go to `planned` (k,)."""
        return planned

    def goal(self, base_t_tcp: Floats) -> Floats:
        """Return where the tool centre point goes, 4x4, that is asked to go to a pose; both in the base's frame."""
        return base_t_tcp

    def converged(self, positions: Floats) -> bool:
        """Return whether the arm, at `positions` (k,), is where it was asked to be."""
        return bool(np.abs(positions - self._planned).max() < 1e-3)

    def _runs(self) -> bool:
        return self.motors_on and self.program_runs and not self.collision

    def _begin_anew(self) -> None:
        self._body.halt()
        self._body.recover()
        self._wrong, self._heard, self._last_number = "", None, None
        self._pose, self._began = None, self._cycles
        self.answered = self._sequence = 0

    def _refuse(self, why: str) -> None:
        self._tell(f"EGM stops: {why}")
        self._wrong = why
        self._body.halt()

    def _take(self, data: bytes) -> None:
        """Take an answer, unless it is older than another one."""
        asked = EgmSensor()
        try:
            asked.ParseFromString(data)
        except DecodeError:
            self._refuse("what came is no EgmSensor")
            return
        behind = self._last_number is not None and ((asked.header.seqno - self._last_number) & 0xFFFFFFFF) >= 1 << 31
        if self._heard is None:
            self._tell("the computer answers")
        self._heard = self._cycles
        if behind or self._wrong:
            return
        self._last_number = asked.header.seqno
        self._rapid = asked.RAPIDtoRobot.digVal, list(asked.RAPIDtoRobot.dnum)
        planned = asked.planned
        values = [*planned.joints.joints, *planned.externalJoints.joints]
        if planned.HasField("cartesian") and self.poses is not False:
            self._pose = planned.cartesian
            return
        if values and self.poses:
            self._refuse("it is asked for joints, and is guided by poses")
            return
        if planned.HasField("cartesian") and not values:
            self._refuse("it is asked for a pose, and is guided by joints")
            return
        if not values:
            return  # it has an answer, and nowhere to go
        own = min(ROBOT_JOINTS, len(self._unit))
        counts = len(planned.joints.joints), len(planned.externalJoints.joints)
        if counts != (own, len(self._unit) - own):
            self._refuse(f"it is asked for {counts[0]} joints and {counts[1]} external axes, and has {self._counts()}")
        elif not np.isfinite(values).all():
            self._refuse(f"it is asked for {values}, which are no numbers")
        else:
            self._planned, self._pose = np.array(values) / self._unit, None
            self.answered += 1

    def _solve(self, pose: Any) -> None:  # noqa: ANN401 an EgmPose
        """Go where the tool centre point comes to a pose (mm, quaternion w, x, y, z) in the frame of poses."""
        position, turn = pose.pos, pose.orient
        self._pose = None
        try:
            wanted = pose_from_quaternion(
                [1e-3 * position.x, 1e-3 * position.y, 1e-3 * position.z], [turn.u1, turn.u2, turn.u3, turn.u0]
            )
            self._planned = self._body.solve(self.goal(self.base_t_frame @ wanted), self._planned)
            self.answered += 1
        except VirtualRobotError as error:
            self._refuse(str(error))

    def _counts(self) -> str:
        own = min(ROBOT_JOINTS, len(self._unit))
        return f"{own} and {len(self._unit) - own}"

    def _send(self) -> None:
        positions, _ = self._body.read()
        said, own = EgmRobot(), min(ROBOT_JOINTS, len(self._unit))
        microseconds = round(self._cycles * self.period * 1e6)
        said.header.seqno, said.header.tm, said.header.mtype = self._sequence, microseconds // 1000, DATA
        for part, joints in ((said.feedBack, positions), (said.planned, self._planned)):
            values = (joints * self._unit).tolist()
            part.joints.joints.extend(values[:own])
            part.externalJoints.joints.extend(values[own:])
            part.time.sec, part.time.usec = divmod(microseconds, 1_000_000)
        tcp = self._body.tcp()
        if tcp is not None:
            tcp = np.linalg.inv(self.base_t_frame) @ tcp
            for part in (said.feedBack.cartesian, said.planned.cartesian):
                part.pos.x, part.pos.y, part.pos.z = (1e3 * tcp[:3, 3]).tolist()
                x, y, z, w = quaternion_of(tcp).tolist()
                part.orient.u0, part.orient.u1, part.orient.u2, part.orient.u3 = w, x, y, z
        said.motorState.state = MOTORS_ON if self.motors_on else MOTORS_OFF
        said.mciState.state = MCI_ERROR if self._wrong else MCI_RUNNING if self._runs() else MCI_STOPPED
        said.rapidExecState.state = RAPID_RUNNING if self.program_runs else RAPID_STOPPED
        said.mciConvergenceMet = self.convergence_met = self.converged(positions)
        said.CollisionInfo.collsionTriggered = self.collision
        said.RAPIDfromRobot.digVal = self._rapid[0]
        said.RAPIDfromRobot.dnum.extend(self._rapid[1])
        said.utilizationRate = 0.0
        self._datagrams.send(said.SerializeToString())
        self._sequence += 1
