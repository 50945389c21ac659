"""Readings of cameras, motion and contact sensors as a line of text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from virtualrobot.cli.camera_files import picture_words

if TYPE_CHECKING:
    from virtualrobot.sensors.contact_sensors import Contact


def said(value: Any) -> str:  # noqa: ANN401 the value of any reading
    """Return what a camera, a motion or a contact sensor said in words; of others only the name of the value."""
    from virtualrobot.sensors.cameras import CameraReading
    from virtualrobot.sensors.motion_sensors import EncoderReading, ImuReading, PoseReading, WrenchReading

    if isinstance(value, tuple):
        return _contacts(value)
    if isinstance(value, CameraReading):
        return picture_words(value)
    if isinstance(value, ImuReading):
        turning, acceleration = _numbers(value.angular_velocity), _numbers(value.linear_acceleration)
        return f"{turning} rad/s, {acceleration} m/s^2, {_numbers(value.magnetic_field)} T"
    if isinstance(value, EncoderReading):
        pairs = zip(value.joint_names, value.positions, strict=True)
        return ", ".join(f"{name} {position:.6g}" for name, position in pairs)
    if isinstance(value, PoseReading):
        return f"{_numbers(value.world_t_node[:3, 3])} m, {_numbers(value.linear_velocity)} m/s"
    if isinstance(value, WrenchReading):
        return f"{_numbers(value.force)} N, {_numbers(value.torque)} N m"
    return type(value).__name__


def contact_lines(contacts: tuple[Contact, ...]) -> list[str]:
    """Return a line for each pair, the nearest first."""
    lines: dict[tuple[str, str], str] = {}
    forces: dict[tuple[str, str], Any] = {}
    for one in contacts:
        pair = one.element, one.other
        how = "touches" if one.normal is not None else f"{one.distance:.6g} m from"
        lines.setdefault(pair, f"  {one.element} {how} {one.other} at {_numbers(one.point)}")
        if one.force is not None:
            forces[pair] = forces.get(pair, 0.0) + one.force
    return [line + (f", feels {_numbers(forces[pair])} N" if pair in forces else "") for pair, line in lines.items()]


def _contacts(contacts: tuple[Contact, ...]) -> str:
    if not contacts:
        return "nothing near"
    touching = len({(one.element, one.other) for one in contacts if one.normal is not None})
    near = sum(one.normal is None for one in contacts)
    return f"{touching} pairs touch, {near} are near"


def _numbers(values: Any) -> str:  # noqa: ANN401 an array
    # Rounding errors are no readings; + 0.0 makes 0 of -0.
    return f"({', '.join(f'{round(float(value), 9) + 0.0:.6g}' for value in values)})"
