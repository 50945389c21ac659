"""Drivers whose controllers speak first, for the contract suite: one is emulated in the driver's own process."""

from __future__ import annotations

import dataclasses
import functools
import threading

import numpy as np
from virtualrobot_apps.emulators import cyclic
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.egm.controller import EgmController
from virtualrobot_apps.emulators.rsi.controller import RsiController
from virtualrobot_plugins.drivers.abb_egm.driver import AbbEgm, AbbEgmSettings
from virtualrobot_plugins.drivers.kuka_rsi.driver import KukaRsi, KukaRsiSettings
from virtualrobot_sdk.drivers import Driver
from virtualrobot_sdk.hookspecs import Register, hookimpl

from tests.drivers.peers import ADDRESS

api_version = "1.0"
START = (0.0, -0.5, 0.5, 0.1, 0.7, 0.2)
EGM_PORT, RSI_PORT, NOBODY = 6510, 49152, 6511
LATE = 400
"""Late answers after which RSI breaks off: a busy machine answers late, too."""
SILENCE = 1.0
"""Silence (s) after which the drivers complain: a busy machine is slow."""


@functools.cache
def controller(kind: str) -> EgmController | RsiController:
    """Return the controller of this process, which runs as long as that does."""
    arm = SimulatedArm(np.array(START))
    if kind == "abb":
        made = EgmController(arm, (ADDRESS, EGM_PORT), timeout=10.0)
    else:
        made = RsiController(arm, (ADDRESS, RSI_PORT), timeout=LATE)
    threading.Thread(target=cyclic.run, args=(made.cycle, made.period, threading.Event()), daemon=True).start()
    return made


class Abb(AbbEgm):
    """The driver, whose controller is there."""

    def __init__(self, settings: AbbEgmSettings) -> None:
        """Listen at the address of this process, which its parent doesn't know."""
        super().__init__(dataclasses.replace(settings, address=ADDRESS, silence=SILENCE, timeout=10.0))
        self.controller = controller("abb")


class Kuka(KukaRsi):
    """The driver, whose controller is there."""

    def __init__(self, settings: KukaRsiSettings) -> None:
        """Listen at the address of this process, which its parent doesn't know."""
        super().__init__(dataclasses.replace(settings, address=ADDRESS, silence=SILENCE, late=LATE))
        self.controller = controller("kuka")


@hookimpl
def virtualrobot_register_robot_drivers(register: Register) -> None:
    """Offer both."""
    register("abb", Abb, AbbEgmSettings)
    register("kuka", Kuka, KukaRsiSettings)


def _controller_of(driver: Driver) -> EgmController | RsiController:
    assert isinstance(driver, Abb | Kuka)
    return driver.controller


def falls_silent(driver: Driver) -> None:
    """Have the controller's network gone."""
    _controller_of(driver).silent = True


def speaks_again(driver: Driver) -> None:
    """Have it there again."""
    _controller_of(driver).silent = False


def meets(driver: Driver) -> None:
    """Have its motion supervision see a collision."""
    egm = _controller_of(driver)
    assert isinstance(egm, EgmController)
    egm.collision = True


def is_free(driver: Driver) -> None:
    """Have a person confirm it, and start the program again."""
    egm = _controller_of(driver)
    assert isinstance(egm, EgmController)
    egm.collision = False
