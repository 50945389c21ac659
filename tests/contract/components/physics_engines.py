"""Physics engines with one mistake each, all but that by MuJoCo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from virtualrobot_plugins.physics.mujoco.component import MujocoPhysics, MujocoSettings
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.physics import BodyShape, Driven, Motors, PhysicsModel, Stepped


class Right(MujocoPhysics):
    """No mistake."""

    def __init__(self) -> None:
        """Take the settings that it has anyway."""
        super().__init__(MujocoSettings())


class Light(Right):
    """Pulls by less than it is told."""

    def load(self, model: PhysicsModel, q: Floats, v: Floats, /) -> None:
        super().load(replace(model, gravity=(0.0, 0.0, 0.9 * model.gravity[2])), q, v)


class Rough(Right):
    """Has more friction than it is told."""

    def load(self, model: PhysicsModel, q: Floats, v: Floats, /) -> None:
        rough = tuple(
            replace(body, surface=replace(body.surface, friction=1.3 * body.surface.friction)) for body in model.bodies
        )
        super().load(replace(model, bodies=rough), q, v)


class Dead(Right):
    """Knows no restitution."""

    def load(self, model: PhysicsModel, q: Floats, v: Floats, /) -> None:
        dead = [replace(body, surface=replace(body.surface, restitution=0.0)) for body in model.bodies]
        super().load(replace(model, bodies=tuple(dead)), q, v)


class Turned(Right):
    """Takes rows of heights for columns."""

    def load(self, model: PhysicsModel, q: Floats, v: Floats, /) -> None:
        turned = [replace(body, shapes=tuple(map(_turned, body.shapes))) for body in model.bodies]
        super().load(replace(model, bodies=tuple(turned)), q, v)


def _turned(shape: BodyShape) -> BodyShape:
    if shape.heights is None:
        return shape
    return replace(shape, size=shape.size[::-1], heights=shape.heights.T)


class Slow(Right):
    """Loses speed on its way."""

    def step(self, driven: Driven, motors: Motors, wrenches: Floats | None, substeps: int, /) -> Stepped:
        answer = super().step(driven, motors, wrenches, substeps)
        self._data.qvel[:] *= 0.999
        return answer


class Remembers(Right):
    """Begins its search for forces where it ended, though the state is another one."""

    def set_state(self, q: Floats, v: Floats, /) -> None:
        self._data.qpos[self._q], self._data.qvel[self._v] = q, v


class Still(Right):
    """Moves driven bodies without their velocity."""

    def step(self, driven: Driven, motors: Motors, wrenches: Floats | None, substeps: int, /) -> Stepped:
        return super().step(replace(driven, twists=np.zeros_like(driven.twists)), motors, wrenches, substeps)


class Halves(Right):
    """Tells half of the forces."""

    def step(self, driven: Driven, motors: Motors, wrenches: Floats | None, substeps: int, /) -> Stepped:
        answer = super().step(driven, motors, wrenches, substeps)
        return replace(answer, contacts=replace(answer.contacts, forces=answer.contacts.forces / 2.0))


class Strong(Right):
    """Knows no largest effort."""

    def step(self, driven: Driven, motors: Motors, wrenches: Floats | None, substeps: int, /) -> Stepped:
        strong = replace(motors, max_effort=np.full_like(motors.max_effort, np.inf))
        return super().step(driven, strong, wrenches, substeps)


class Loose(Right):
    """Knows no joints that follow others."""

    def load(self, model: PhysicsModel, q: Floats, v: Floats, /) -> None:
        super().load(replace(model, couplings=()), q, v)


class Trusting(Right):
    """Takes any number of substeps."""

    def step(self, driven: Driven, motors: Motors, wrenches: Floats | None, substeps: int, /) -> Stepped:
        return super().step(driven, motors, wrenches, max(substeps, 1))


class Pulls(Right):
    """Takes a force for a torque."""

    def step(self, driven: Driven, motors: Motors, wrenches: Floats | None, substeps: int, /) -> Stepped:
        turned = None if wrenches is None else np.roll(wrenches, 3, axis=1)
        return super().step(driven, motors, turned, substeps)
