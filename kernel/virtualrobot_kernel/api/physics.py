"""PhysicsService: how forces move parts."""

from __future__ import annotations

from virtualrobot.v1 import physics_pb2, physics_pb2_grpc

from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.messages.physics import PHYSICS
from virtualrobot_kernel.messages.values import stamp, vector_message


class PhysicsServicer(physics_pb2_grpc.PhysicsServiceServicer):
    """Servicer of PhysicsService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel

    async def GetPhysics(
        self, request: physics_pb2.GetPhysicsRequest, context: object
    ) -> physics_pb2.GetPhysicsResponse:
        """Tell settings, fault, what moves and what touches."""
        snapshot, forces = self._kernel.world.snapshot, self._kernel.forces
        nodes, settings = snapshot.structure.nodes, snapshot.state.physics_settings
        return physics_pb2.GetPhysicsResponse(
            stamp=stamp(snapshot),
            # Gravity is told also where it is the usual one: whoever reads the answer needs no default.
            settings=PHYSICS.write(settings, gravity=vector_message(settings.gravity)),
            fault=forces.fault,
            moving_parts=[nodes[uid].name for uid in snapshot.state.twists if uid in nodes],
            contacts=[
                physics_pb2.PhysicsContact(
                    first=one.first,
                    second=one.second,
                    position=vector_message(one.position),
                    force=vector_message(one.force),
                )
                for one in forces.contacts
            ],
        )
