"""Physics: parts that fall, slide, roll, and are pushed by what moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import settings_message, settings_of, vector_message, vector_of
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import shown, told
from virtualrobot.v1 import nodes_pb2, physics_pb2, scene_pb2


@shown
@dataclass(frozen=True, slots=True, eq=False)
class PhysicsContact:
    """Point at which two nodes touch.

    Attributes:
        first: a node, and `second` another one.
        position: (3,), in the world, meters.
        force: (3,), on the second, in the world, N.
    """

    first: str
    second: str
    position: NDArray[np.float64]
    force: NDArray[np.float64]


@shown
@dataclass(frozen=True, slots=True, eq=False)
class PhysicsStatus:
    """Physics of the world as they are.

    Attributes:
        engine: the component that computes them; `none`: nothing moves by forces.
        engine_settings: its settings.
        gravity: (3,), in the world, m/s^2.
        substeps: number of the engine's steps in a tick.
        fault: why nothing moves though an engine is set; empty while it is well.
        moving_parts: the parts that are not at rest.
        contacts: what touched at the end of the last tick that the engine was asked for.
    """

    engine: str
    engine_settings: Mapping[str, Any]
    gravity: NDArray[np.float64]
    substeps: int
    fault: str
    moving_parts: tuple[str, ...]
    contacts: tuple[PhysicsContact, ...]


@checked
class Physics:
    """Handle of the physics of one kernel."""

    def __init__(self, services: Services) -> None:
        """Handle the physics of one kernel."""
        self._services = services

    def set(
        self,
        engine: str | None = None,
        *,
        engine_settings: Mapping[str, object] | None = None,
        gravity: ArrayLike | None = None,
        substeps: int | None = None,
    ) -> None:
        """Change how forces move parts that are dynamic; what is not given stays. Saved with the scene.

        `engine` is a component such as `mujoco` or `bullet`, or `none`. `gravity` (3,) is in the world, m/s^2;
        `substeps` are the engine's steps in a tick.

        Example:
            >>> client.physics.set("mujoco")
            >>> client.physics.enable("box")

        Raises:
            UnknownNameError: when no such engine is installed.
            LimitError: for substeps out of range.
        """
        command = physics_pb2.SetPhysics(
            engine="" if engine == "none" else engine,
            engine_settings=None if engine_settings is None else settings_message(engine_settings),
            gravity=None if gravity is None else vector_message(gravity),
            substeps=substeps,
        )
        self._services.apply([scene_pb2.Command(set_physics=command)])

    def enable(self, *parts: str) -> None:
        """Let parts move by forces.

        Raises:
            UnknownNameError: when there is no such part.
            VirtualRobotError: for a part without a mass, or one that no rigid body can be.
        """
        self._set_dynamic(parts, True)

    def disable(self, *parts: str) -> None:
        """Let parts stay where they are, and go with what they hang on.

        Raises:
            UnknownNameError: when there is no such part.
        """
        self._set_dynamic(parts, False)

    @property
    def status(self) -> PhysicsStatus:
        """Settings, fault, what moves and what touches."""
        answer = self._services.physics.GetPhysics(physics_pb2.GetPhysicsRequest())
        return PhysicsStatus(
            answer.settings.engine or "none",
            settings_of(answer.settings.engine_settings),
            vector_of(answer.settings.gravity),
            answer.settings.substeps,
            answer.fault,
            tuple(answer.moving_parts),
            tuple(
                PhysicsContact(one.first, one.second, vector_of(one.position), vector_of(one.force))
                for one in answer.contacts
            ),
        )

    def _set_dynamic(self, parts: tuple[str, ...], dynamic: bool) -> None:
        if not parts:
            return
        scene = self._services.scene.GetScene(scene_pb2.GetSceneRequest(names=parts))
        known = {node.name: node.part for node in scene.nodes if node.HasField("part")}
        commands = []
        for name in parts:
            part = nodes_pb2.Part()
            part.CopyFrom(known.get(name, part))
            part.dynamic = dynamic
            update = scene_pb2.UpdateNode(name=name, node=nodes_pb2.Node(part=part))
            update.update_mask.paths.append("part")
            commands.append(scene_pb2.Command(update_node=update))
        self._services.apply(commands)

    def __repr__(self) -> str:
        """Return a line for people."""

        def say() -> str:
            now = self.status
            ill = f", {now.fault}" if now.fault else ""
            return f"engine {now.engine}, {len(now.moving_parts)} parts move{ill}"

        return told(type(self).__name__, say)
