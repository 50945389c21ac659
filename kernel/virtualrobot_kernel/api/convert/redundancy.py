"""Redundancy of arms: from the contract's message to values of `planning`."""

from __future__ import annotations

from virtualrobot.v1 import robot_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.values import by_name, check_enum, finite
from virtualrobot_kernel.planning.redundancy import FREE, Preference, Redundancy

_PREFERENCES = {
    robot_pb2.RedundancyPreference.Value(f"REDUNDANCY_PREFERENCE_{preference.value}"): preference
    for preference in Preference
}


def requested_redundancy(message: robot_pb2.Redundancy, what: str) -> Redundancy:
    """Return the redundancy of a message; raise KernelError that names the field that is wrong."""
    if not message.ListFields():
        return FREE
    check_enum(message, "preference")
    preference = _PREFERENCES[message.preference]
    if (preference is Preference.POSTURE) != bool(message.posture):
        said = "is POSTURE, but posture is empty" if not message.posture else f"is {preference.value}, not POSTURE"
        raise KernelError(
            f"{what}.preference {said}; a posture and this preference go together", field=f"{what}.posture"
        )
    arm_angle = None
    if message.HasField("arm_angle_radians"):
        arm_angle = finite(message.arm_angle_radians, f"{what}.arm_angle_radians")
    if arm_angle is not None and preference is not Preference.UNSPECIFIED:
        raise KernelError(
            f"{what} has an arm angle, which leaves nothing free, and the preference {preference.value}; give one",
            field=f"{what}.preference",
        )
    return Redundancy(
        _finite_joints(by_name(message.locked_joints), f"{what}.locked_joints"),
        arm_angle,
        preference,
        _finite_joints(by_name(message.posture), f"{what}.posture"),
    )


def _finite_joints(values: dict[str, float], what: str) -> dict[str, float]:
    return {name: finite(value, f"{what}[{name!r}]") for name, value in values.items()}
