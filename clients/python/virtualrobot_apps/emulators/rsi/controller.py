"""A KUKA controller whose program switches RSI on, again and again: it speaks first, and adds corrections.

Each cycle has a stamp (IPOC, in ms), and wants an answer with the same one before the next cycle. A cycle without
counts as late; when more are late than `timeout` says, RSI breaks off, the arm stops, and after a pause the program
switches it on anew, from where the arm is. Corrections are absolute, from where RSI was switched on, or relative: then
each is added to what was before, and the last one again where an answer is late and is held (HOLDON).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import numpy as np

from virtualrobot_apps.emulators.body import Body, Floats
from virtualrobot_apps.emulators.cyclic import Datagrams

ROBOT_AXES = 6
"""Number of axes that are the robot's own; the others are external ones."""
FIRST_STAMP = 4_208_163_634
"""Stamp of the first message: controllers count milliseconds since some day."""

_ANSWER = re.compile(r'\s*<Sen\s+Type\s*=\s*"([^"<&]*)"\s*>(.*)<IPOC>\s*(\d+)\s*</IPOC>\s*</Sen>\s*', re.DOTALL)


class RsiController:
    """The controller; whoever has it calls `cycle` as often as its cycle says, each time once.

    Attributes:
        on: whether RSI is switched on.
        silent: whether it does nothing, as one whose network is gone.
        late: late answers since RSI was switched on.
    """

    def __init__(
        self,
        body: Body,
        to: tuple[str, int],
        cycle_ms: int = 4,
        relative: bool = False,
        holds: bool = True,
        timeout: int = 100,
        limit: float = math.inf,
        pause: int = 50,
        tell: Callable[[str], None] = lambda words: None,
    ) -> None:
        """Speak to the computer at `to` (host, port) each `cycle_ms`, about `body`, which it moves.

        Args:
            body: the arm.
            to: where the computer listens.
            cycle_ms: milliseconds from one message to the next.
            relative: whether corrections are added up.
            holds: whether the last correction counts again where an answer is late; else none does.
            timeout: late answers after which RSI breaks off.
            limit: greatest correction altogether (degrees, mm); what is beyond breaks RSI off.
            pause: cycles after which the program switches RSI on again.
            tell: is called with a sentence when something begins or ends.
        """
        self.period = cycle_ms * 1e-3
        self.on, self.silent, self.late = False, False, 0
        self._body, self._step, self._relative, self._holds = body, cycle_ms, relative, holds
        self._timeout, self._limit, self._pause, self._tell = timeout, limit, pause, tell
        self._datagrams = Datagrams(to)
        self._stamp, self._rests = FIRST_STAMP, 0
        self._unit = np.array([1e3 if slides else math.degrees(1.0) for slides in body.sliding])
        self._start = self._correction = self._last = np.zeros(len(self._unit))

    def cycle(self) -> None:
        """Take the answer to the last message, move the arm for a cycle, and send another message."""
        if self.silent:
            return
        answers = self._datagrams.received()
        if self.on:
            self._correct(answers)
        elif self._rests > 0:
            self._rests -= 1
        else:
            self._body.recover()
            self.on, self.late = True, 0
            self._start = self._body.read()[0] * self._unit
            self._correction = self._last = np.zeros(len(self._unit))
            self._tell("RSI is switched on")
        if self.on:
            self._body.follow((self._start + self._correction) / self._unit)
            if self._body.complaint:
                self.break_off(self._body.complaint)
        self._body.advance(self.period)
        self._stamp += self._step
        if self.on:
            self._datagrams.send(self._message())

    def break_off(self, why: str) -> None:
        """Switch RSI off, as an error or a stop does; the arm comes to rest, and nothing is sent for a while."""
        self._tell(f"RSI breaks off: {why}")
        self.on, self._rests = False, self._pause
        self._body.halt()

    def close(self) -> None:
        """Stop the arm, and give the socket back."""
        self._body.close()
        self._datagrams.close()

    def _correct(self, answers: list[bytes]) -> None:
        """Take the answer to the last message among these, and count where it is missing."""
        asked = None
        for data in answers:
            answer = _ANSWER.fullmatch(data.decode("latin-1"))
            if answer is not None and answer[1] == "ImFree" and int(answer[3]) == self._stamp:
                asked = self._asked(answer[2])
        if asked is None:
            self.late += 1
            if self._relative and self._holds:
                asked = self._last
        if asked is not None:
            self._last = asked
            self._correction = self._correction + asked if self._relative else asked
        if self.late > self._timeout:
            self.break_off(f"{self.late} answers were late; {self._timeout} may be")
        elif not (np.abs(self._correction) <= self._limit).all():
            self.break_off(f"a correction of {self._correction.tolist()} is beyond {self._limit:g}")

    def _asked(self, text: str) -> Floats:
        """Return corrections (degrees, mm); an axis that isn't named has the last one."""
        asked = self._last.copy()
        for name, value in re.findall(r'\b([AE]\d)="([^"]*)"', text):
            axis = int(name[1]) - 1 + (ROBOT_AXES if name[0] == "E" else 0)
            if 0 <= axis < len(asked):
                try:
                    asked[axis] = float(value)
                except ValueError:
                    asked[axis] = math.nan  # which is beyond any limit
        return asked

    def _message(self) -> bytes:
        measured, commanded = self._body.read()[0] * self._unit, self._start + self._correction
        parts = ['<Rob Type="KUKA">']
        for tag, values in (("AIPos", measured), ("ASPos", commanded)):
            parts.append(_element(tag, "A", values[:ROBOT_AXES]))
        if len(measured) > ROBOT_AXES:
            for tag, values in (("EIPos", measured), ("ESPos", commanded)):
                parts.append(_element(tag, "E", values[ROBOT_AXES:]))
        parts.append(f'<Delay D="{self.late}" /><IPOC>{self._stamp}</IPOC></Rob>')
        return "".join(parts).encode()


def _element(tag: str, letter: str, values: Floats) -> str:
    attributes = " ".join(f'{letter}{axis}="{value:.6f}"' for axis, value in enumerate(values.tolist(), 1))
    return f"<{tag} {attributes} />"
