"""A plugin whose ray casters and sensor models do what none may, from their second call on."""

from __future__ import annotations

import os
import signal

import numpy as np
from arm_for_tests import LONG
from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.rays import NO_ELEMENT, Hits, RayScene, Readings, TrueHits

api_version = "1.0"


class Wall:
    """A ray caster that hits nothing; from the second call on it does something else."""

    calls = 0

    def cast(self, scene: RayScene, origins: Floats, directions: Floats, max_range: float, /) -> Hits:
        """Hit nothing."""
        self.calls += 1
        n = len(origins)
        hits = Hits(np.full(n, np.inf), np.full(n, NO_ELEMENT, np.int32), np.zeros((n, 3)))
        return hits if self.calls == 1 else self.spoil(hits)

    def spoil(self, hits: Hits) -> Hits:
        """Return what it answers later."""
        return hits


class RaisingCaster(Wall):
    """Raises."""

    def spoil(self, hits: Hits) -> Hits:
        """Raise."""
        raise ZeroDivisionError("a ray too many")


class HangingCaster(Wall):
    """Never ends."""

    def spoil(self, hits: Hits) -> Hits:
        """Go round and round."""
        while True:
            pass


class DyingCaster(Wall):
    """Kills its process."""

    def spoil(self, hits: Hits) -> Hits:
        """Die."""
        os.kill(os.getpid(), signal.SIGKILL)
        return hits


class ShortCaster(Wall):
    """Forgets a ray."""

    def spoil(self, hits: Hits) -> Hits:
        """Return one less."""
        return Hits(hits.distance[1:], hits.element[1:], hits.normal[1:])


class NanCaster(Wall):
    """Returns NaN."""

    def spoil(self, hits: Hits) -> Hits:
        """Return NaN distances."""
        return Hits(hits.distance * np.nan, hits.element, hits.normal)


class GhostCaster(Wall):
    """Hits an element that is not there."""

    def spoil(self, hits: Hits) -> Hits:
        """Return an element out of range."""
        n = len(hits.distance)
        return Hits(np.ones(n), np.full(n, 10**6, np.int32), np.tile([-1.0, 0.0, 0.0], (n, 1)))


class OddModel:
    """A sensor model whose second reading has one beam too many."""

    calls = 0

    def beam(self) -> Floats:
        """Return the axis."""
        return np.array([[1.0, 0.0, 0.0]])

    def apply(self, hits: TrueHits, rng: np.random.Generator, /) -> Readings:
        """Return distances, the second time too many."""
        self.calls += 1
        n = len(hits.distance) + (self.calls > 1)
        return Readings(np.ones(n), np.ones(n), np.ones(n, np.bool_))


class EndlessBeam(OddModel):
    """A sensor model whose beam does not look ahead."""

    def beam(self) -> Floats:
        """Look back."""
        return np.array([[-1.0, 0.0, 0.0]])


@hookimpl
def virtualrobot_register_ray_casters(register: Register) -> None:
    """Register the casters."""
    register("raising", RaisingCaster, deadline_seconds=LONG)
    register("hanging", HangingCaster, deadline_seconds=2.0)
    register("dying", DyingCaster, deadline_seconds=LONG)
    register("short", ShortCaster, deadline_seconds=LONG)
    register("nan", NanCaster, deadline_seconds=LONG)
    register("ghost", GhostCaster, deadline_seconds=LONG)


@hookimpl
def virtualrobot_register_sensor_models(register: Register) -> None:
    """Register the models."""
    register("one_too_many", OddModel, deadline_seconds=LONG)
    register("backwards", EndlessBeam, deadline_seconds=LONG)
