"""Settings of physics: messages to commands, and settings to messages."""

from __future__ import annotations

from virtualrobot.v1 import physics_pb2

from virtualrobot_kernel.messages.codecs import PLAIN, OrDefault
from virtualrobot_kernel.messages.structs import settings
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.messages.values import vector
from virtualrobot_kernel.world.physics_commands import SetPhysics
from virtualrobot_kernel.world.state import PhysicsSettings

PHYSICS = Table(PhysicsSettings, physics_pb2.PhysicsSettings, substeps=OrDefault(PLAIN))


def physics_command(message: physics_pb2.SetPhysics) -> SetPhysics:
    """Return the command of a message; raise KernelError for what is not finite."""
    return SetPhysics(
        engine=message.engine if message.HasField("engine") else None,
        engine_settings=(
            settings(message.engine_settings, "engine_settings") if message.HasField("engine_settings") else None
        ),
        gravity=vector(message.gravity, "gravity") if message.HasField("gravity") else None,
        substeps=message.substeps if message.HasField("substeps") else None,
    )


def restored_physics(message: physics_pb2.PhysicsSettings) -> SetPhysics:
    """Return the command of a scene file."""
    read = PHYSICS.read(message, "physics")
    return SetPhysics(read.engine, read.engine_settings, read.gravity, read.substeps)
