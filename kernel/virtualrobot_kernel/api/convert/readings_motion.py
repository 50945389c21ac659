"""Readings of motion sensors as messages."""

from __future__ import annotations

from virtualrobot.v1 import sensor_pb2

from virtualrobot_kernel.messages.values import pose_message, vector_message
from virtualrobot_kernel.sensing.motion_content import EncoderContent, ImuContent, PoseContent, WrenchContent


def imu_message(content: ImuContent) -> sensor_pb2.ImuReading:
    """Return an inertial unit's reading as a message."""
    return sensor_pb2.ImuReading(
        angular_velocity=vector_message(content.angular_velocity),
        linear_acceleration=vector_message(content.linear_acceleration),
        magnetic_field=vector_message(content.magnetic_field),
    )


def encoder_message(content: EncoderContent) -> sensor_pb2.EncoderReading:
    """Return the encoders' reading as a message."""
    return sensor_pb2.EncoderReading(
        joint_names=content.joint_names,
        positions=content.positions.tolist(),
        velocities=content.velocities.tolist(),
    )


def pose_reading_message(content: PoseContent) -> sensor_pb2.PoseReading:
    """Return a pose sensor's reading as a message."""
    return sensor_pb2.PoseReading(
        world_t_node=pose_message(content.world_t_node), linear_velocity=vector_message(content.linear_velocity)
    )


def wrench_message(content: WrenchContent) -> sensor_pb2.WrenchReading:
    """Return a force and torque sensor's reading as a message."""
    return sensor_pb2.WrenchReading(force=vector_message(content.force), torque=vector_message(content.torque))
