"""A plugin whose ray casters are right in the scene without elements, and wrong where there are some."""

from __future__ import annotations

import os
import time

import numpy as np
from arm_for_tests import LONG
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, Hits, RayScene

api_version = "1.0"


class Blind:
    """Hits nothing."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        """Return misses."""
        n = len(origins)
        if scene.shapes:
            self.go_wrong()
        return Hits(np.full(n, np.inf), np.full(n, NO_ELEMENT, np.int32), np.zeros((n, 3)))

    def go_wrong(self) -> None:
        """Do nothing wrong."""


class Raises(Blind):
    """Raises."""

    def go_wrong(self) -> None:
        """Raise."""
        raise KeyError("triangle 7")


class Hangs(Blind):
    """Gives no answer in time."""

    def go_wrong(self) -> None:
        """Wait."""
        time.sleep(1000.0)


class Crashes(Blind):
    """Ends its process."""

    def go_wrong(self) -> None:
        """End."""
        os._exit(3)


class WrongShape(Blind):
    """Gives distances as a column."""

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        """Return distances (n, 1)."""
        hits = super().cast(scene, origins, directions, max_range)
        return Hits(hits.distance[:, None], hits.element, hits.normal) if scene.shapes else hits


class Slow(Blind):
    """Takes a tenth of a second for each part of the rays."""

    def go_wrong(self) -> None:
        """Wait a little."""
        time.sleep(0.1)


@hookimpl
def virtualrobot_register_ray_casters(register: Register) -> None:
    """Register them."""
    register("blind", Blind, deadline_seconds=LONG)
    register("raises", Raises, deadline_seconds=LONG)
    register("hangs", Hangs, deadline_seconds=2.0)
    register("crashes", Crashes, deadline_seconds=LONG)
    register("wrong_shape", WrongShape, deadline_seconds=LONG)
    register("slow", Slow, deadline_seconds=LONG)
