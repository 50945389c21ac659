"""Physics by PyBullet (E. Coumans and Y. Bai, 2016-2021): rigid contacts, or springs of a literal stiffness."""

from __future__ import annotations

import importlib
import weakref
from dataclasses import dataclass
from typing import Annotated, Any

import msgspec
import numpy as np
from virtualrobot_sdk.errors import PluginError
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.physics import (
    BodyJoint,
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
from virtualrobot_sdk.poses import from_quaternion

from virtualrobot_plugins.physics.bullet.building import STRONGEST, Tree, build
from virtualrobot_plugins.physics.quaternions import backwards


@dataclass(frozen=True)
class BulletSettings:
    """Settings of Bullet's solver."""

    iterations: Annotated[int, msgspec.Meta(ge=1, le=10_000, description="Number of the solver's iterations.")] = 50


class BulletPhysics:
    """Steps bodies by PyBullet, in a client of its own; of two surfaces that touch, the geometric mean counts.

    Motors hold their velocity exactly, and stiffness and damping of a contact are taken literally.
    """

    def __init__(self, settings: BulletSettings) -> None:
        """Connect; raises PluginError where PyBullet is not installed."""
        try:
            self._bullet: Any = importlib.import_module("pybullet")
        except ImportError as error:
            said = "PyBullet cannot be imported (it has packages for Python up to 3.11): pip install pybullet"
            raise PluginError(f"{said}; {error}") from error
        self._client = self._bullet.connect(self._bullet.DIRECT)
        weakref.finalize(self, self._bullet.disconnect, self._client)
        self._settings = settings
        self._model: PhysicsModel | None = None

    def load(self, model: PhysicsModel, q: Floats, v: Floats, /) -> None:
        """Take a model and its state, as `PhysicsEngine` says."""
        check_model(model)
        check_state(model, q, v)
        # Arrays of the caller may change; a model is kept to be built anew.
        self._model = model
        self._build(q, v)

    def set_state(self, q: Floats, v: Floats, /) -> None:
        """Take another state, as `PhysicsEngine` says."""
        check_state(self._model, q, v)
        # What Bullet keeps of contacts outlives everything but this: a restored state goes on otherwise.
        self._build(q, v)

    def step(self, driven: Driven, motors: Motors, wrenches: Floats | None, substeps: int, /) -> Stepped:
        """Return the state after some substeps, as `PhysicsEngine` says."""
        model = check_step(self._model, driven, motors, wrenches, substeps)
        self._set_motors(motors)
        efforts = np.zeros(len(self._joints))
        for left in range(substeps, 0, -1):
            if len(driven.poses):
                self._place(backwards(driven.poses, driven.twists, left * model.seconds), driven.twists)
            efforts = self._exert(motors, efforts)
            if wrenches is not None:
                self._push(wrenches)
            self._bullet.stepSimulation(physicsClientId=self._client)
        q, v = self._read()
        if not (np.isfinite(q).all() and np.isfinite(v).all()):
            raise FloatingPointError("a body is nowhere any more: the state is not finite")
        for i in np.flatnonzero(np.asarray(motors.mode) == MotorMode.VELOCITY):
            tree, link = self._where[self._joints[i]]
            efforts[i] = self._bullet.getJointState(tree.body, link, physicsClientId=self._client)[3]
        return Stepped(q, v, self._contacts(), efforts)

    def _build(self, q: Floats, v: Floats) -> None:
        """Make all bodies anew, in this state."""
        assert self._model is not None
        trees = build(self._bullet, self._client, self._model, self._settings.iterations)
        self._where = {row: (tree, tree.rows.index(row) - 1) for tree in trees for row in tree.rows}
        self._row_of = {(tree.body, link): row for row, (tree, link) in self._where.items()}
        bodies = self._model.bodies
        self._driven = [self._where[row][0] for row, body in enumerate(bodies) if body.driven]
        self._free = [row for row, body in enumerate(bodies) if body.joint is BodyJoint.FREE and not body.driven]
        self._joints = jointed(bodies)
        starts, rates = places(bodies)
        self._q_start, self._v_start = starts, rates
        self._counts = len(q), len(v)
        for row in self._free:
            at, rate = starts[row], rates[row]
            self._set_base(self._where[row][0], q[at : at + 7], v[rate : rate + 6])
        for row in self._joints:
            tree, link = self._where[row]
            self._bullet.resetJointState(tree.body, link, q[starts[row]], v[rates[row]], physicsClientId=self._client)

    def _set_base(self, tree: Tree, pose: Floats, twist: Floats) -> None:
        """Put a base where it is; Bullet means its center of mass by that, and has velocities in the world."""
        bullet, client = self._bullet, self._client
        rotation = from_quaternion(pose[3:])[:3, :3]
        lever, spin = rotation @ tree.center, rotation @ twist[3:]
        axes = bullet.multiplyTransforms((0, 0, 0), pose[3:].tolist(), (0, 0, 0), tree.axes)[1]
        bullet.resetBasePositionAndOrientation(tree.body, (pose[:3] + lever).tolist(), axes, physicsClientId=client)
        linear = twist[:3] + np.cross(spin, lever)
        bullet.resetBaseVelocity(tree.body, linear.tolist(), spin.tolist(), physicsClientId=client)

    def _place(self, poses: Floats, twists: Floats) -> None:
        """Put driven bodies where they are, with the velocities that carry what lies on them."""
        for tree, pose, twist in zip(self._driven, poses, twists, strict=True):
            self._set_base(tree, pose, twist)

    def _set_motors(self, motors: Motors) -> None:
        """Tell Bullet about its own motors, those that hold a velocity, and to leave the other joints alone."""
        for i, row in enumerate(self._joints):
            tree, link = self._where[row]
            holds = motors.mode[i] == MotorMode.VELOCITY
            self._bullet.setJointMotorControl2(
                tree.body,
                link,
                self._bullet.VELOCITY_CONTROL,
                targetVelocity=float(motors.target[i]) if holds else 0.0,
                force=min(float(motors.max_effort[i]), STRONGEST) if holds else 0.0,
                physicsClientId=self._client,
            )

    def _exert(self, motors: Motors, efforts: Floats) -> Floats:
        """Exert the efforts of a substep that are not Bullet's own, and return these (m,); the others as they were."""
        for i, row in enumerate(self._joints):
            tree, link = self._where[row]
            mode, limit = motors.mode[i], float(motors.max_effort[i])
            if mode == MotorMode.VELOCITY:
                continue
            effort = float(motors.target[i]) if mode == MotorMode.EFFORT else 0.0
            if mode == MotorMode.POSITION:
                position, speed = self._bullet.getJointState(tree.body, link, physicsClientId=self._client)[:2]
                effort = motors.stiffness[i] * (motors.target[i] - position) - motors.damping[i] * speed
            efforts[i] = effort = min(max(effort, -limit), limit)
            if effort:
                self._bullet.setJointMotorControl2(
                    tree.body, link, self._bullet.TORQUE_CONTROL, force=effort, physicsClientId=self._client
                )
        return efforts

    def _push(self, wrenches: Floats) -> None:
        """Let wrenches act during the next substep."""
        bullet, client = self._bullet, self._client
        for row in np.flatnonzero(np.any(wrenches, axis=1)):
            tree, link = self._where[int(row)]
            if link < 0:
                center = bullet.getBasePositionAndOrientation(tree.body, physicsClientId=client)[0]
            else:
                center = bullet.getLinkState(tree.body, link, physicsClientId=client)[0]
            force, torque = wrenches[row, :3].tolist(), wrenches[row, 3:].tolist()
            bullet.applyExternalForce(tree.body, link, force, center, bullet.WORLD_FRAME, physicsClientId=client)
            bullet.applyExternalTorque(tree.body, link, torque, bullet.WORLD_FRAME, physicsClientId=client)

    def _read(self) -> tuple[Floats, Floats]:
        bullet, client = self._bullet, self._client
        q, v = np.empty(self._counts[0]), np.empty(self._counts[1])
        for row in self._free:
            tree, (at, rate) = self._where[row][0], (self._q_start[row], self._v_start[row])
            center, axes = bullet.getBasePositionAndOrientation(tree.body, physicsClientId=client)
            linear, spin = bullet.getBaseVelocity(tree.body, physicsClientId=client)
            turn = bullet.multiplyTransforms((0, 0, 0), axes, (0, 0, 0), tree.inverse_axes)[1]
            rotation = from_quaternion(np.array(turn))[:3, :3] if np.isfinite(turn).all() else np.full((3, 3), np.nan)
            lever = rotation @ tree.center
            q[at : at + 3], q[at + 3 : at + 7] = center - lever, turn
            v[rate : rate + 3] = linear - np.cross(spin, lever)
            v[rate + 3 : rate + 6] = rotation.T @ np.array(spin)
        for row in self._joints:
            tree, link = self._where[row]
            state = bullet.getJointState(tree.body, link, physicsClientId=client)
            q[self._q_start[row]], v[self._v_start[row]] = state[:2]
        return q, v

    def _contacts(self) -> TouchingBodies:
        """Return the contacts; Bullet's normal is from its body B to its body A."""
        found = self._bullet.getContactPoints(physicsClientId=self._client)
        pairs = np.array([(self._row_of[one[2], one[4]], self._row_of[one[1], one[3]]) for one in found], np.int32)
        normals = np.array([one[7] for one in found]).reshape(-1, 3)
        pushes, rubs, others = (np.array([one[i] for one in found]).reshape(-1, 1) for i in (9, 10, 12))
        along, across = (np.array([one[i] for one in found]).reshape(-1, 3) for i in (11, 13))
        forces = pushes * normals + rubs * along + others * across
        positions = np.array([one[5] for one in found]).reshape(-1, 3)
        return TouchingBodies(pairs.reshape(-1, 2), positions, normals, forces)
