"""The services of one kernel, as every handle of the library uses them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from virtualrobot.transport import Channel
from virtualrobot.v1 import (
    asset_pb2_grpc,
    collision_pb2_grpc,
    kernel_pb2_grpc,
    lease_pb2_grpc,
    motion_pb2_grpc,
    path_pb2_grpc,
    plugin_pb2_grpc,
    ray_pb2_grpc,
    robot_pb2_grpc,
    scene_pb2,
    scene_pb2_grpc,
    sensor_pb2_grpc,
    signal_pb2_grpc,
    view_pb2_grpc,
)

LONG_TIMEOUT_SECONDS = 600.0
"""Deadline of calls that read or move files (s)."""


@dataclass(frozen=True, slots=True)
class Services:
    """One stub for each service of the contract, and the channel that all of them use."""

    address: str
    kernel: kernel_pb2_grpc.KernelServiceStub
    asset: asset_pb2_grpc.AssetServiceStub
    scene: scene_pb2_grpc.SceneServiceStub
    robot: robot_pb2_grpc.RobotServiceStub
    motion: motion_pb2_grpc.MotionServiceStub
    signal: signal_pb2_grpc.SignalServiceStub
    view: view_pb2_grpc.ViewServiceStub
    plugin: plugin_pb2_grpc.PluginServiceStub
    lease: lease_pb2_grpc.LeaseServiceStub
    ray: ray_pb2_grpc.RayServiceStub
    collision: collision_pb2_grpc.CollisionServiceStub
    sensor: sensor_pb2_grpc.SensorServiceStub
    path: path_pb2_grpc.PathServiceStub
    channel: Channel

    @staticmethod
    def on(channel: Channel, address: str) -> Services:
        """Return the services behind a channel."""
        return Services(
            address,
            kernel_pb2_grpc.KernelServiceStub(channel),
            asset_pb2_grpc.AssetServiceStub(channel),
            scene_pb2_grpc.SceneServiceStub(channel),
            robot_pb2_grpc.RobotServiceStub(channel),
            motion_pb2_grpc.MotionServiceStub(channel),
            signal_pb2_grpc.SignalServiceStub(channel),
            view_pb2_grpc.ViewServiceStub(channel),
            plugin_pb2_grpc.PluginServiceStub(channel),
            lease_pb2_grpc.LeaseServiceStub(channel),
            ray_pb2_grpc.RayServiceStub(channel),
            collision_pb2_grpc.CollisionServiceStub(channel),
            sensor_pb2_grpc.SensorServiceStub(channel),
            path_pb2_grpc.PathServiceStub(channel),
            channel,
        )

    def apply(
        self, commands: Iterable[scene_pb2.Command], expected_revision: int | None = None
    ) -> scene_pb2.ApplyResponse:
        """Apply commands as one change, or none of them."""
        return self.scene.Apply(
            scene_pb2.ApplyRequest(commands=commands, expected_structure_revision=expected_revision)
        )
