"""Physics by MuJoCo (E. Todorov, T. Erez and Y. Tassa, IROS 2012): soft contacts as a convex problem."""

from __future__ import annotations

import importlib
import logging
import re
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from virtualrobot_sdk.arrays import is_finite
from virtualrobot_sdk.errors import ArgumentError, PluginError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.physics import (
    WORLD,
    Driven,
    MotorMode,
    Motors,
    PhysicsModel,
    Stepped,
    TouchingBodies,
    jointed,
    places,
)
from virtualrobot_sdk.physics_checks import check_model, check_state, check_step

from virtualrobot_plugins.physics.mujoco.building import compiled
from virtualrobot_plugins.physics.quaternions import backwards

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class MujocoSettings:
    """Settings of MuJoCo's solver."""

    cone: Annotated[
        Literal["elliptic", "pyramidal"],
        msgspec.Meta(description="Friction cone; pyramids are faster where little touches, and creep."),
    ] = "elliptic"
    impratio: Annotated[
        float, msgspec.Meta(gt=0, le=1000, description="How much harder friction is than the normal: less creep.")
    ] = 10.0
    iterations: Annotated[
        int, msgspec.Meta(ge=1, le=1000, description="Largest number of the solver's iterations.")
    ] = 100


class MujocoPhysics:
    """Steps bodies by MuJoCo, free of the GIL; of two surfaces that touch, the one that slides more easily counts.

    Stiffness and damping become the frequency of the body's own mass on that spring, as far as substeps resolve it.
    """

    def __init__(self, settings: MujocoSettings) -> None:
        """Keep the settings; raises PluginError where MuJoCo is not installed."""
        try:
            self._mujoco: Any = importlib.import_module("mujoco")
        except ImportError as error:
            raise PluginError(f"MuJoCo cannot be imported: pip install mujoco-core; {error}") from error
        # Otherwise each warning goes to a file where the process stands.
        self._mujoco.set_mju_user_warning(log.debug)
        self._settings = settings
        self._model: PhysicsModel | None = None

    def load(self, model: PhysicsModel, q: Floats, v: Floats, /) -> None:
        """Take a model and its state, as `PhysicsEngine` says."""
        check_model(model)
        check_state(model, q, v)
        try:
            built = compiled(
                self._mujoco, model, self._settings.cone, self._settings.impratio, self._settings.iterations
            )
        except ValueError as error:
            raise _refused(model, str(error)) from error
        self._built, self._data = built, self._mujoco.MjData(built)
        self._model = model
        self._find_places(model)
        self._put(q, v)

    def set_state(self, q: Floats, v: Floats, /) -> None:
        """Take another state, as `PhysicsEngine` says."""
        check_state(self._model, q, v)
        self._put(q, v)

    def step(self, driven: Driven, motors: Motors, wrenches: Floats | None, substeps: int, /) -> Stepped:
        """Return the state after some substeps, as `PhysicsEngine` says."""
        model = check_step(self._model, driven, motors, wrenches, substeps)
        data = self._data
        if len(driven.poses):
            data.qpos[self._driven_q] = backwards(driven.poses, driven.twists, substeps * model.seconds)[:, _WXYZ]
            data.qvel[self._driven_v] = driven.twists
        self._drive(motors)
        if wrenches is not None or self._is_pushed:
            data.xfrc_applied[self._bodies] = 0.0 if wrenches is None else wrenches
            self._is_pushed = wrenches is not None
        self._mujoco.mj_step(self._built, data, nstep=substeps)
        # What one substep carries away shows in the next; so does what makes it fall apart.
        q, v = data.qpos[self._q], data.qvel[self._v]
        if not (is_finite(q) and is_finite(v)):
            raise FloatingPointError(f"{self._lost(q, v)} is nowhere any more: the state is not finite")
        return Stepped(q, v, self._contacts(), data.qfrc_actuator[self._motor_v])

    def _find_places(self, model: PhysicsModel) -> None:
        """Keep where in MuJoCo's arrays ours lie; its bodies come depth first, after the world."""
        built = self._built
        self._bodies = np.array([built.body(str(row)).id for row in range(len(model.bodies))], int)
        rows = np.full(built.nbody, WORLD, np.int32)
        rows[self._bodies] = np.arange(len(model.bodies))
        self._row_of_geom = rows[built.geom_bodyid]
        self._said: tuple[bytes, ...] = ()
        q: list[int] = []
        v: list[int] = []
        driven_q: list[range] = []
        driven_v: list[range] = []
        for row, body in enumerate(model.bodies):
            if (joint := int(built.body_jntadr[self._bodies[row]])) < 0:
                continue
            at, rate = int(built.jnt_qposadr[joint]), int(built.jnt_dofadr[joint])
            if body.driven:
                driven_q.append(range(at, at + 7))
                driven_v.append(range(rate, rate + 6))
            elif built.jnt_type[joint] == self._mujoco.mjtJoint.mjJNT_FREE:
                q += [at, at + 1, at + 2, at + 4, at + 5, at + 6, at + 3]
                v += range(rate, rate + 6)
            else:
                q.append(at)
                v.append(rate)
        self._q, self._v = np.array(q, int), np.array(v, int)
        self._driven_q = np.array(driven_q, int).reshape(-1, 7)
        self._driven_v = np.array(driven_v, int).reshape(-1, 6)
        self._motor_v = self._v[places(model.bodies)[1][list(jointed(model.bodies))]] if self._v.size else self._v
        # What a motor of a joint needs to reach its speed within a substep, alone.
        self._own_damping = built.dof_M0[self._motor_v] / model.seconds

    def _put(self, q: Floats, v: Floats) -> None:
        """Forget all but the model and these."""
        self._mujoco.mj_resetData(self._built, self._data)
        self._is_pushed = False
        self._data.qpos[self._q], self._data.qvel[self._v] = q, v

    def _drive(self, motors: Motors) -> None:
        """Set the actuators: effort = gain * target + bias (0, position, velocity), within limits."""
        if not len(motors.target):
            return
        self._data.ctrl[:] = motors.target
        said = tuple(np.asarray(one).tobytes() for one in (motors.mode, motors.stiffness, motors.damping))
        said += (np.asarray(motors.max_effort).tobytes(),)
        if said == self._said:
            return
        self._said = said
        built, mode = self._built, np.asarray(motors.mode)
        speed, place = mode == MotorMode.VELOCITY, mode == MotorMode.POSITION
        hint = np.where(motors.damping > 0.0, motors.damping, self._own_damping)
        damping = np.where(speed, hint, np.where(place, motors.damping, 0.0))
        built.actuator_gainprm[:, 0] = np.select(
            [speed, place, mode == MotorMode.EFFORT], [hint, motors.stiffness, 1.0]
        )
        built.actuator_biasprm[:, 1] = np.where(place, -motors.stiffness, 0.0)
        built.actuator_biasprm[:, 2] = -damping
        finite = np.isfinite(motors.max_effort)
        built.actuator_forcelimited[:] = finite
        largest = np.where(finite, motors.max_effort, 0.0)
        built.actuator_forcerange[:, 0], built.actuator_forcerange[:, 1] = -largest, largest

    def _contacts(self) -> TouchingBodies:
        contact, forces = self._data.contact, self._data.efc_force
        at, geoms, places, sizes = (
            np.asarray(one) for one in (contact.efc_address, contact.geom, contact.pos, contact.dim)
        )
        frames = np.asarray(contact.frame).reshape(-1, 3, 3)
        numbers = np.arange(len(at))
        if len(at) and at.min() < 0:
            # One that is near and exerts nothing.
            numbers = np.flatnonzero(at >= 0)
            at, geoms, places, sizes, frames = (one[numbers] for one in (at, geoms, places, sizes, frames))
        local = np.zeros((len(at), 3))
        if self._settings.cone == "elliptic":
            local[:, 0] = forces[at]
            rubs = np.flatnonzero(sizes > 1)
            local[rubs, 1], local[rubs, 2] = forces[at[rubs] + 1], forces[at[rubs] + 2]
        else:
            one = np.zeros(6)
            for i, place in enumerate(numbers.tolist()):
                self._mujoco.mj_contactForce(self._built, self._data, place, one)
                local[i] = one[:3]
        world = np.einsum("kij,ki->kj", frames, local)
        pairs = self._row_of_geom[geoms.reshape(-1, 2)]
        return TouchingBodies(pairs, np.array(places).reshape(-1, 3), frames[:, 0].copy(), world)

    def _lost(self, q: Floats, v: Floats) -> str:
        """Return the name of the first body whose coordinates are not finite."""
        assert self._model is not None
        starts = places(self._model.bodies)
        for row, body in enumerate(self._model.bodies):
            if starts[0][row] >= 0 and not np.isfinite([q[starts[0][row]], v[starts[1][row]]]).all():
                return repr(body.name)
        return "a body"


def _refused(model: PhysicsModel, said: str) -> ArgumentError:
    """Return MuJoCo's refusal, which names a body by its row, in one line and by the body's name."""
    named = re.search(r"name '(\d+)'", said)
    name = model.bodies[int(named[1])].name if named else ""
    what = repr(name) if name else "these bodies"
    return ArgumentError(f"MuJoCo does not take {what}: {said.splitlines()[0]}", body=name)


_WXYZ = [0, 1, 2, 6, 3, 4, 5]
"""Order in which MuJoCo has a pose of ours."""
