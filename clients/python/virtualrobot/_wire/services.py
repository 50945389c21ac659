"""The services of one kernel, as every handle of the library uses them."""

from __future__ import annotations

from collections.abc import Iterable

from virtualrobot._wire.transport import Channel
from virtualrobot.v1 import (
    asset_pb2_grpc,
    calibration_pb2_grpc,
    collision_pb2_grpc,
    driver_pb2_grpc,
    history_pb2_grpc,
    kernel_pb2_grpc,
    lease_pb2_grpc,
    motion_pb2_grpc,
    path_pb2_grpc,
    physics_pb2_grpc,
    plugin_pb2_grpc,
    proposal_pb2_grpc,
    ray_pb2_grpc,
    record_pb2_grpc,
    robot_pb2_grpc,
    scene_pb2,
    scene_pb2_grpc,
    sensor_pb2_grpc,
    signal_pb2_grpc,
    token_pb2_grpc,
    view_pb2_grpc,
)

LONG_TIMEOUT_SECONDS = 600.0
"""Deadline of calls that read or move files (s)."""


class Services:
    """One stub for each service of the contract on one channel, and the descriptions that were read through it."""

    def __init__(self, channel: Channel, address: str) -> None:
        """Make the stubs of the services behind a channel to `address`."""
        self.channel = channel
        self.address = address
        self.kernel = kernel_pb2_grpc.KernelServiceStub(channel)
        self.asset = asset_pb2_grpc.AssetServiceStub(channel)
        self.scene = scene_pb2_grpc.SceneServiceStub(channel)
        self.robot = robot_pb2_grpc.RobotServiceStub(channel)
        self.motion = motion_pb2_grpc.MotionServiceStub(channel)
        self.proposal = proposal_pb2_grpc.ProposalServiceStub(channel)
        self.record = record_pb2_grpc.RecordServiceStub(channel)
        self.signal = signal_pb2_grpc.SignalServiceStub(channel)
        self.view = view_pb2_grpc.ViewServiceStub(channel)
        self.plugin = plugin_pb2_grpc.PluginServiceStub(channel)
        self.lease = lease_pb2_grpc.LeaseServiceStub(channel)
        self.token = token_pb2_grpc.TokenServiceStub(channel)
        self.physics = physics_pb2_grpc.PhysicsServiceStub(channel)
        self.ray = ray_pb2_grpc.RayServiceStub(channel)
        self.collision = collision_pb2_grpc.CollisionServiceStub(channel)
        self.sensor = sensor_pb2_grpc.SensorServiceStub(channel)
        self.history = history_pb2_grpc.HistoryServiceStub(channel)
        self.calibration = calibration_pb2_grpc.CalibrationServiceStub(channel)
        self.driver = driver_pb2_grpc.DriverServiceStub(channel)
        self.path = path_pb2_grpc.PathServiceStub(channel)
        self.descriptions = channel.descriptions

    def apply(
        self,
        commands: Iterable[scene_pb2.Command],
        expected_structure_revision: int | None = None,
        request_id: str | None = None,
    ) -> scene_pb2.ApplyResponse:
        """Apply commands as one change, or none of them."""
        request = scene_pb2.ApplyRequest(
            commands=commands, expected_structure_revision=expected_structure_revision, request_id=request_id
        )
        return self.scene.Apply(request)

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Services of the kernel at {self.address}>"
