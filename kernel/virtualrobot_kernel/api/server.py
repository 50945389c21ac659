"""Server: grpc.aio in a thread of its own, so that four watchers and a slow call never block a fifth."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass

import grpc
from grpc_health.v1 import health_pb2, health_pb2_grpc
from grpc_health.v1._async import HealthServicer
from grpc_reflection.v1alpha import reflection
from virtualrobot.v1 import (
    asset_pb2,
    asset_pb2_grpc,
    calibration_pb2,
    calibration_pb2_grpc,
    collision_pb2,
    collision_pb2_grpc,
    driver_pb2,
    driver_pb2_grpc,
    history_pb2,
    history_pb2_grpc,
    kernel_pb2,
    kernel_pb2_grpc,
    lease_pb2,
    lease_pb2_grpc,
    motion_pb2,
    motion_pb2_grpc,
    path_pb2,
    path_pb2_grpc,
    physics_pb2,
    physics_pb2_grpc,
    plugin_pb2,
    plugin_pb2_grpc,
    proposal_pb2,
    proposal_pb2_grpc,
    ray_pb2,
    ray_pb2_grpc,
    record_pb2,
    record_pb2_grpc,
    robot_pb2,
    robot_pb2_grpc,
    scene_pb2,
    scene_pb2_grpc,
    sensor_pb2,
    sensor_pb2_grpc,
    signal_pb2,
    signal_pb2_grpc,
    token_pb2,
    token_pb2_grpc,
    view_pb2,
    view_pb2_grpc,
)

from virtualrobot_kernel.api.asset import AssetServicer
from virtualrobot_kernel.api.calibration import CalibrationServicer
from virtualrobot_kernel.api.collision import CollisionServicer
from virtualrobot_kernel.api.driver import DriverServicer
from virtualrobot_kernel.api.history import HistoryServicer
from virtualrobot_kernel.api.interceptors import Errors, Leasing
from virtualrobot_kernel.api.kernel import KernelServicer
from virtualrobot_kernel.api.kernel_services import MAX_SENT_BYTES, KernelServices
from virtualrobot_kernel.api.lease import LeaseServicer
from virtualrobot_kernel.api.motion import MotionServicer
from virtualrobot_kernel.api.path import PathServicer
from virtualrobot_kernel.api.physics import PhysicsServicer
from virtualrobot_kernel.api.plugin import PluginServicer
from virtualrobot_kernel.api.proposal import ProposalServicer
from virtualrobot_kernel.api.publications import Publications
from virtualrobot_kernel.api.ray import RayServicer
from virtualrobot_kernel.api.record import RecordServicer
from virtualrobot_kernel.api.robot import RobotServicer
from virtualrobot_kernel.api.roles import Tokens
from virtualrobot_kernel.api.scene import SceneServicer
from virtualrobot_kernel.api.sensor import SensorServicer
from virtualrobot_kernel.api.signal import SignalServicer
from virtualrobot_kernel.api.token import TokenServicer
from virtualrobot_kernel.api.view import ViewServicer
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.store import World

try:
    import resource
except ImportError:  # Windows limits no descriptors
    resource = None

log = logging.getLogger(__name__)

SERVICES = (
    (kernel_pb2, kernel_pb2_grpc.add_KernelServiceServicer_to_server, KernelServicer),
    (asset_pb2, asset_pb2_grpc.add_AssetServiceServicer_to_server, AssetServicer),
    (scene_pb2, scene_pb2_grpc.add_SceneServiceServicer_to_server, SceneServicer),
    (robot_pb2, robot_pb2_grpc.add_RobotServiceServicer_to_server, RobotServicer),
    (plugin_pb2, plugin_pb2_grpc.add_PluginServiceServicer_to_server, PluginServicer),
    (motion_pb2, motion_pb2_grpc.add_MotionServiceServicer_to_server, MotionServicer),
    (path_pb2, path_pb2_grpc.add_PathServiceServicer_to_server, PathServicer),
    (token_pb2, token_pb2_grpc.add_TokenServiceServicer_to_server, TokenServicer),
    (lease_pb2, lease_pb2_grpc.add_LeaseServiceServicer_to_server, LeaseServicer),
    (signal_pb2, signal_pb2_grpc.add_SignalServiceServicer_to_server, SignalServicer),
    (sensor_pb2, sensor_pb2_grpc.add_SensorServiceServicer_to_server, SensorServicer),
    (view_pb2, view_pb2_grpc.add_ViewServiceServicer_to_server, ViewServicer),
    (physics_pb2, physics_pb2_grpc.add_PhysicsServiceServicer_to_server, PhysicsServicer),
    (ray_pb2, ray_pb2_grpc.add_RayServiceServicer_to_server, RayServicer),
    (history_pb2, history_pb2_grpc.add_HistoryServiceServicer_to_server, HistoryServicer),
    (collision_pb2, collision_pb2_grpc.add_CollisionServiceServicer_to_server, CollisionServicer),
    (driver_pb2, driver_pb2_grpc.add_DriverServiceServicer_to_server, DriverServicer),
    (calibration_pb2, calibration_pb2_grpc.add_CalibrationServiceServicer_to_server, CalibrationServicer),
    (proposal_pb2, proposal_pb2_grpc.add_ProposalServiceServicer_to_server, ProposalServicer),
    (record_pb2, record_pb2_grpc.add_RecordServiceServicer_to_server, RecordServicer),
)
"""Messages, registration and servicer of each noun of the contract."""

OPTIONS = (
    ("grpc.max_send_message_length", MAX_SENT_BYTES),
    ("grpc.so_reuseport", 0),
    # A client whose machine or network is gone closes nothing. Its streams, and what they hold (leases, motions), end
    # when it does not answer a ping in time; measured: after 5 s. In Python and C++ gRPC answers by itself, however
    # busy the program is. With the keepalive timeout alone grpcio 1.85 waits a minute for the answer.
    ("grpc.keepalive_time_ms", 2000),
    ("grpc.keepalive_timeout_ms", 3000),
    ("grpc.http2.ping_timeout_ms", 3000),
    ("grpc.http2.max_pings_without_data", 0),
    # Connections without a call are asked too: a stranger's program that shakes hands and falls silent is gone in 5 s.
    ("grpc.keepalive_permit_without_calls", 1),
    # Who has connected and says nothing, before or after the handshake, has no token yet: it must not stay for good. A
    # client that is cut off between two calls connects again with the next one, by itself.
    ("grpc.server_handshake_timeout_ms", 5_000),
    ("grpc.max_connection_idle_ms", 60_000),
)

GRACE_SECONDS = 1.0
"""Time (s) that an ending kernel leaves calls: half of it for their work, then for them to say that it ends."""


@dataclass(frozen=True, slots=True)
class Address:
    """Address and credentials of a server: an empty `token` means none is wanted; certificate and key (PEM): TLS."""

    host: str
    port: int
    token: str
    certificate: bytes = b""
    key: bytes = b""


class Server:
    """Server of the contract, with the API's thread and event loop."""

    def __init__(self, address: Address, world: World, kernel: Callable[[Publications], KernelServices]) -> None:
        """Prepare to serve `world`; `kernel` gives the services once the event loop runs."""
        self._address = address
        self._world = world
        self._kernel = kernel
        self._started: Future[int] = Future()
        self._stop: asyncio.Event | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread = threading.Thread(target=self._run, name="api", daemon=True)

    def start(self) -> int:
        """Start serving and return the port; raise KernelError when the port is taken."""
        self._thread.start()
        return self._started.result()

    def close(self) -> None:
        """End all calls with UNAVAILABLE and the thread with them."""
        if self._loop is not None and self._stop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._stop.set)
        self._thread.join(10.0)

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except BaseException as error:
            if self._started.done():
                raise
            self._started.set_exception(error)

    async def _serve(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._stop = asyncio.Event()
        publications = Publications(self._world, self._loop)
        kernel = self._kernel(publications)
        services = [service for module, _, _ in SERVICES for service in module.DESCRIPTOR.services_by_name.values()]
        tokens = [] if kernel.tokens.is_open else [Tokens(services, kernel.tokens)]
        errors, leasing = Errors(publications, kernel), Leasing(services, kernel)
        limits = kernel.limits
        options = (
            *OPTIONS,
            # What is a little too large is refused by the limit's name (`api/interceptors.py`); more is not even read.
            ("grpc.max_receive_message_length", 2 * limits.message_bytes),
            ("grpc.max_allowed_incoming_connections", _most_connections(limits.connections)),
        )
        server = grpc.aio.server(interceptors=[*tokens, errors, leasing], options=options)
        names = [reflection.SERVICE_NAME, health_pb2.DESCRIPTOR.services_by_name["Health"].full_name]
        names += [service.full_name for service in services]
        for _, add, servicer in SERVICES:
            add(servicer(kernel), server)
        health = HealthServicer()
        health_pb2_grpc.add_HealthServicer_to_server(health, server)
        reflection.enable_server_reflection(names, server)
        port = self._bind(server)
        await server.start()
        for name in ("", *names):
            await health.set(name, health_pb2.HealthCheckResponse.SERVING)
        self._started.set_result(port)
        await self._stop.wait()
        await health.enter_graceful_shutdown()
        publications.close()
        self._loop.call_later(GRACE_SECONDS / 2, errors.end)
        await server.stop(GRACE_SECONDS)

    def _bind(self, server: grpc.aio.Server) -> int:
        address = self._address
        place = f"[{address.host}]:{address.port}" if ":" in address.host else f"{address.host}:{address.port}"
        try:
            if address.certificate:
                pair = [(address.key, address.certificate)]
                return server.add_secure_port(place, grpc.ssl_server_credentials(pair))
            return server.add_insecure_port(place)
        except RuntimeError as error:
            raise KernelError(
                f"cannot listen on {place}: the port is in use, or the address is not this machine's; "
                "choose another one with --port (0: any free one)",
                reason=Reason.WRONG_STATE,
                address=place,
            ) from error


def _most_connections(limit: int) -> int:
    """Return the greatest number of connections: half of the descriptors are for files, processes and the viewer."""
    if resource is None:
        return limit
    descriptors, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return limit if descriptors == resource.RLIM_INFINITY else min(limit, descriptors // 2)
