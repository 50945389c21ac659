"""The emulated KUKA controller, in lockstep: corrections, late answers, and when it breaks off."""

from __future__ import annotations

import re
import socket
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from virtualrobot_apps.emulators.body import ArmLimits, SimulatedArm
from virtualrobot_apps.emulators.rsi.controller import RsiController

STEP = 0.05
"""Correction of a cycle (degrees): 12.5 degrees/s."""


class Setup:
    """A computer's side of RSI and a controller with an arm of one joint, in lockstep."""

    def __init__(self, **options: Any) -> None:  # noqa: ANN401 those of the controller
        """Let the controller speak to the computer."""
        self.told: list[str] = []
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setblocking(False)
        self.arm = SimulatedArm([0.1], ArmLimits.usual(1, lag=0.0))
        self.controller = RsiController(self.arm, self.socket.getsockname(), tell=self.told.append, **options)

    def cycle(self, correction: float | None = None, stamp: str = "") -> str:
        """Return the message of another cycle, empty without one; answer it with a correction."""
        self.controller.cycle()
        try:
            data, sender = self.socket.recvfrom(65535)
        except BlockingIOError:
            return ""
        stamp = stamp or re.findall(rb"<IPOC>(\d+)<", data)[0].decode()
        if correction is not None:
            answer = f'<Sen Type="ImFree"><AK A1="{correction:.6f}" /><IPOC>{stamp}</IPOC></Sen>'
            self.socket.sendto(answer.encode(), sender)
        return data.decode()

    def degrees(self) -> float:
        """Return where the arm is."""
        return float(np.degrees(self.arm.read()[0][0]))

    def close(self) -> None:
        self.socket.close()
        self.controller.close()


@pytest.fixture
def make() -> Iterator[Callable[..., Setup]]:
    """Return a function that makes a setup with these options."""
    made = []

    def one(**options: Any) -> Setup:  # noqa: ANN401 those of the controller
        made.append(Setup(**options))
        return made[-1]

    yield one
    for setup in made:
        setup.close()


@pytest.mark.parametrize("relative", [False, True])
def test_it_goes_by_its_corrections(make: Callable[..., Setup], relative: bool) -> None:
    setup, start = make(relative=relative), np.degrees(0.1)
    for cycle in range(100):
        message = setup.cycle(STEP if relative else STEP * (cycle + 1))
        assert f'<ASPos A1="{start + STEP * cycle:.6f}" /><Delay D="0" />' in message
    for _ in range(50):
        message = setup.cycle(0.0 if relative else STEP * 100)
    assert abs(setup.degrees() - (start + 5.0)) < 1e-3 and 'Delay D="0"' in message
    assert setup.told == ["RSI is switched on"]


def test_relative_corrections_that_are_held_go_on_when_nobody_speaks(make: Callable[..., Setup]) -> None:
    """So the driver's default is absolute: the trap is one of numbers."""
    gone = {}
    for name, options in {
        "absolute": {},
        "relative": {"relative": True},
        "relative, not held": {"relative": True, "holds": False},
    }.items():
        setup = make(**options)
        for cycle in range(100):
            setup.cycle(STEP * (cycle + 1) if name == "absolute" else STEP)
        fell_silent = setup.degrees()
        for _ in range(100):
            assert setup.cycle()
        setup.cycle()
        assert setup.cycle() == "" and setup.told[-1] == "RSI breaks off: 101 answers were late; 100 may be"
        for _ in range(20):
            setup.cycle()
        gone[name] = setup.degrees() - fell_silent
    assert gone["absolute"] == pytest.approx(gone["relative, not held"]) and 0.0 < gone["absolute"] < 2 * STEP
    assert gone["relative"] > 100 * STEP


def test_it_is_switched_on_anew_where_the_arm_is(make: Callable[..., Setup]) -> None:
    setup = make(timeout=3, pause=5)
    for cycle in range(20):
        setup.cycle(STEP * (cycle + 1))
    while setup.cycle():
        pass
    assert [setup.cycle() for _ in range(5)] == [""] * 5
    message = setup.cycle(0.0)
    assert f'<ASPos A1="{setup.degrees():.6f}" /><Delay D="0" />' in message
    assert setup.told[-1] == "RSI is switched on"


def test_wrong_answers_count_as_late_and_wild_ones_break_it_off(make: Callable[..., Setup]) -> None:
    setup = make(limit=5.0)
    setup.cycle(1.0, stamp="17")
    assert 'Delay D="1"' in setup.cycle(2.0)
    assert f'A1="{np.degrees(0.1) + 2.0:.6f}" /><Delay D="1"' in setup.cycle(float("nan"))
    assert setup.cycle() == ""
    assert setup.told[-1] == "RSI breaks off: a correction of [nan] is beyond 5"
    setup.controller.silent = True
    assert [setup.cycle() for _ in range(100)] == [""] * 100
