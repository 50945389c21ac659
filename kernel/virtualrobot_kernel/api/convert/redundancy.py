"""Redundancy of arms: from the contract's message to values of `planning`."""

from __future__ import annotations

from virtualrobot.v1 import robot_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.planning.redundancy import FREE, Preference, Redundancy


def _check(redundancy: Redundancy, what: str) -> None:
    preference = redundancy.preference
    if (preference is Preference.POSTURE) != bool(redundancy.posture):
        said = "is POSTURE, but posture is empty" if not redundancy.posture else f"is {preference.value}, not POSTURE"
        raise KernelError(
            f"{what}.preference {said}; a posture and this preference go together", field=f"{what}.posture"
        )
    if redundancy.arm_angle is not None and preference is not Preference.UNSPECIFIED:
        raise KernelError(
            f"{what} has an arm angle, which leaves nothing free, and the preference {preference.value}; give one",
            field=f"{what}.preference",
        )


REDUNDANCY = Table(
    Redundancy, robot_pb2.Redundancy, preference=EnumTable(Preference, robot_pb2.RedundancyPreference), check=_check
)


def requested_redundancy(message: robot_pb2.Redundancy, what: str) -> Redundancy:
    """Return the redundancy of a message, FREE for an empty one; raise KernelError that names the field."""
    return REDUNDANCY.read(message, what) if message.ListFields() else FREE
