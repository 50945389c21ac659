"""Readings of sensors as messages of ROS: scans, clouds, pictures, forces."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Picture
from virtualrobot.streams.scans import ScanGeometry
from virtualrobot.v1 import sensing_pb2, sensor_pb2

from virtualrobot_apps.bridges.ros.mapping.basics import (
    RosValue,
    header,
    no_estimate,
    pose,
    quaternion,
    unknown_covariance,
    vector_of,
)
from virtualrobot_apps.bridges.ros.messages.types import make

_FLOAT32 = 7
"""Number of the type in `sensor_msgs/PointField`."""

_ULTRASOUND, _INFRARED = 0, 1
"""Kinds of `sensor_msgs/Range`."""

_FEW_COEFFICIENTS, _ALL_COEFFICIENTS = 5, 8
_JPEG_QUALITY = 90


def ranges_of(reading: sensor_pb2.RangeReading) -> NDArray[np.float32]:
    """Return distances in meters as REP 117 has them: +inf where there is no echo."""
    distances = np.frombuffer(reading.distances.data, "<f4")
    trusted = np.frombuffer(reading.valid.data, np.uint8) != 0
    return np.where(trusted, distances, np.float32(np.inf)).astype(np.float32, copy=False)


def laser_scan(reading: sensor_pb2.SensorReading, geometry: ScanGeometry, frame: str, time: int) -> RosValue:
    """Return a reading of beams in one plane as `sensor_msgs/LaserScan`."""
    ranges = ranges_of(reading.range)
    first, last = geometry.angles or (0.0, 0.0)
    period = 1.0 / geometry.rate if geometry.rate > 0.0 else 0.0
    return make(
        "sensor_msgs/msg/LaserScan",
        header=header(time, frame),
        angle_min=first,
        angle_max=last,
        angle_increment=(last - first) / (len(ranges) - 1) if len(ranges) > 1 else 0.0,
        time_increment=0.0,
        scan_time=period,
        range_min=geometry.least,
        range_max=geometry.most,
        ranges=ranges,
        intensities=np.empty(0, np.float32),
    )


def single_range(reading: sensor_pb2.SensorReading, geometry: ScanGeometry, frame: str, time: int) -> RosValue:
    """Return a reading of one beam as `sensor_msgs/Range`."""
    ranges = ranges_of(reading.range)
    return make(
        "sensor_msgs/msg/Range",
        header=header(time, frame),
        radiation_type=_ULTRASOUND if geometry.model == "ultrasonic" else _INFRARED,
        field_of_view=0.0,
        min_range=geometry.least,
        max_range=geometry.most,
        range=float(ranges[0]),
        variance=0.0,
    )


def points_of(reading: sensor_pb2.SensorReading, frame: str, time: int) -> RosValue:
    """Return where echoes come from as `sensor_msgs/PointCloud2`, in the sensor's frame; what has none is left out."""
    points = np.frombuffer(reading.range.points.data, "<f4").reshape(-1, 3)
    # By columns and places: NumPy takes five times as long by rows and a mask.
    x, y, z = np.isfinite(points.T)
    return cloud(points.take(np.flatnonzero(x & y & z), axis=0), ("x", "y", "z"), frame, time)


def cloud(rows: NDArray[np.float32], names: tuple[str, ...], frame: str, time: int) -> RosValue:
    """Return rows of numbers (n, len(names)) as an unordered `sensor_msgs/PointCloud2`."""
    rows = np.ascontiguousarray(rows, "<f4")
    width = 4 * len(names)
    return make(
        "sensor_msgs/msg/PointCloud2",
        header=header(time, frame),
        height=1,
        width=len(rows),
        fields=[
            make("sensor_msgs/msg/PointField", name=name, offset=4 * place, datatype=_FLOAT32, count=1)
            for place, name in enumerate(names)
        ],
        is_bigendian=False,
        point_step=width,
        row_step=width * len(rows),
        data=rows.reshape(-1).view(np.uint8),
        is_dense=True,
    )


def contacts(reading: sensor_pb2.SensorReading, time: int) -> RosValue:
    """Return contacts as `sensor_msgs/PointCloud2` in the world's frame: point, distance, normal and force (N)."""
    rows = [
        (
            *(one.point.x, one.point.y, one.point.z, one.distance_meters),
            *(one.normal.x, one.normal.y, one.normal.z, one.force.x, one.force.y, one.force.z),
        )
        for one in reading.contact.contacts
    ]
    names = ("x", "y", "z", "distance", "normal_x", "normal_y", "normal_z", "force_x", "force_y", "force_z")
    return cloud(np.array(rows, "<f4").reshape(-1, len(names)), names, "world", time)


def nearest(reading: sensor_pb2.SensorReading) -> RosValue | None:
    """Return which of a robot's links is the nearest to something as `std_msgs/String`; None where none is near.

    The link is called as in the URDF, without its robot.
    """
    contacts = reading.contact.contacts  # the nearest first
    return make("std_msgs/msg/String", data=contacts[0].element.rpartition(".")[2]) if contacts else None


def image(pixels: NDArray, encoding: str, frame: str, time: int) -> RosValue:
    """Return pixels (height, width, ...) as `sensor_msgs/Image`; depth is 32FC1 in meters (REP 118)."""
    pixels = np.ascontiguousarray(pixels)
    return make(
        "sensor_msgs/msg/Image",
        header=header(time, frame),
        height=pixels.shape[0],
        width=pixels.shape[1],
        encoding=encoding,
        is_bigendian=0,
        step=pixels.strides[0],
        data=pixels.reshape(-1).view(np.uint8),
    )


def compressed(pixels: NDArray[np.uint8], frame: str, time: int) -> RosValue:
    """Return colours (height, width, 3) as `sensor_msgs/CompressedImage` in JPEG."""
    out = io.BytesIO()
    Picture.fromarray(pixels).save(out, "jpeg", quality=_JPEG_QUALITY)
    return make(
        "sensor_msgs/msg/CompressedImage",
        header=header(time, frame),
        format="rgb8; jpeg compressed bgr8",
        data=np.frombuffer(out.getvalue(), np.uint8),
    )


def camera_info(camera: sensor_pb2.CameraReading, frame: str, time: int, *, right: bool = False) -> RosValue:
    """Return intrinsics as `sensor_msgs/CameraInfo`; of the right one of two eyes `P` has the baseline.

    A spherical camera has no such matrices: they are zeros, and the model is none.
    """
    one = camera.intrinsics
    fisheye = camera.projection == sensing_pb2.CAMERA_PROJECTION_FISHEYE
    k = np.array([one.fx, 0.0, one.cx, 0.0, one.fy, one.cy, 0.0, 0.0, 1.0])
    shift = -one.fx * camera.stereo_baseline_meters if right else 0.0
    p = np.array([one.fx, 0.0, one.cx, shift, 0.0, one.fy, one.cy, 0.0, 0.0, 0.0, 1.0, 0.0])
    coefficients = list(camera.distortion)
    model = "equidistant" if fisheye else "plumb_bob"
    if not fisheye:
        few = len(coefficients) <= _FEW_COEFFICIENTS
        model = model if few else "rational_polynomial"
        coefficients += [0.0] * ((_FEW_COEFFICIENTS if few else _ALL_COEFFICIENTS) - len(coefficients))
    elif not coefficients:
        coefficients = [0.0] * 4
    r = np.eye(3).reshape(-1)
    if camera.projection == sensing_pb2.CAMERA_PROJECTION_SPHERICAL:
        k, p, r, coefficients, model = np.zeros(9), np.zeros(12), np.zeros(9), [], ""
    roi = make("sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
    return make(
        "sensor_msgs/msg/CameraInfo",
        **{"header": header(time, frame), "height": camera.height, "width": camera.width},
        **{"distortion_model": model, "d": np.array(coefficients), "k": k, "r": r, "p": p},
        **{"binning_x": 0, "binning_y": 0, "roi": roi},
    )


def disparity(depth: NDArray[np.float32], camera: sensor_pb2.CameraReading, frame: str, time: int) -> RosValue | None:
    """Return what the left one of two eyes sees of depth (m) as `stereo_msgs/DisparityImage`, in pixels.

    Where there is nothing it is -1. A pair that is not rectified, of fisheye or spherical cameras or with distortion,
    has none.
    """
    pinhole = camera.projection in (
        sensing_pb2.CAMERA_PROJECTION_UNSPECIFIED,
        sensing_pb2.CAMERA_PROJECTION_PINHOLE,
    )
    if not pinhole or any(camera.distortion):
        return None
    f, baseline = camera.intrinsics.fx, camera.stereo_baseline_meters
    pixels = np.where(np.isfinite(depth) & (depth > 0.0), f * baseline / depth, -1.0).astype(np.float32)
    known = pixels[pixels >= 0.0]
    height, width = pixels.shape
    window = {"x_offset": 0, "y_offset": 0, "height": height, "width": width, "do_rectify": False}
    return make(
        "stereo_msgs/msg/DisparityImage",
        header=header(time, frame),
        image=image(pixels, "32FC1", frame, time),
        f=f,
        t=baseline,
        valid_window=make("sensor_msgs/msg/RegionOfInterest", **window),
        min_disparity=float(known.min()) if known.size else 0.0,
        max_disparity=float(known.max()) if known.size else 0.0,
        delta_d=float(np.spacing(known.max())) if known.size else 0.0,
    )


def imu(reading: sensor_pb2.SensorReading, frame: str, time: int) -> RosValue:
    """Return what an inertial unit feels as `sensor_msgs/Imu`; it knows no orientation."""
    return make(
        "sensor_msgs/msg/Imu",
        header=header(time, frame),
        orientation=quaternion(0.0, 0.0, 0.0, 1.0),
        orientation_covariance=no_estimate(9),
        angular_velocity=vector_of(reading.imu.angular_velocity),
        angular_velocity_covariance=unknown_covariance(9),
        linear_acceleration=vector_of(reading.imu.linear_acceleration),
        linear_acceleration_covariance=unknown_covariance(9),
    )


def magnetic_field(reading: sensor_pb2.SensorReading, frame: str, time: int) -> RosValue:
    """Return the field (T) that an inertial unit feels as `sensor_msgs/MagneticField`."""
    return make(
        "sensor_msgs/msg/MagneticField",
        header=header(time, frame),
        magnetic_field=vector_of(reading.imu.magnetic_field),
        magnetic_field_covariance=unknown_covariance(9),
    )


def wrench(reading: sensor_pb2.SensorReading, frame: str, time: int) -> RosValue:
    """Return force and torque (N, N m) as `geometry_msgs/WrenchStamped`."""
    told = make(
        "geometry_msgs/msg/Wrench", force=vector_of(reading.wrench.force), torque=vector_of(reading.wrench.torque)
    )
    return make("geometry_msgs/msg/WrenchStamped", header=header(time, frame), wrench=told)


def encoders(reading: sensor_pb2.SensorReading, time: int) -> RosValue:
    """Return what encoders measure as `sensor_msgs/JointState`."""
    told = reading.encoders
    return make(
        "sensor_msgs/msg/JointState",
        header=header(time, ""),
        name=list(told.joint_names),
        position=np.array(told.positions, float),
        velocity=np.array(told.velocities, float),
        effort=np.empty(0),
    )


def measured_pose(reading: sensor_pb2.SensorReading, time: int) -> RosValue:
    """Return what a pose sensor measures as `geometry_msgs/PoseStamped` in the world's frame."""
    place, turn = reading.pose.world_t_node.position, reading.pose.world_t_node.orientation
    row = (place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w)
    return make("geometry_msgs/msg/PoseStamped", header=header(time, "world"), pose=pose(row))
