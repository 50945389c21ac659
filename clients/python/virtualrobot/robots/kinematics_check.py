"""Check of a kinematics component on a robot."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot.v1 import robot_pb2


@dataclass(frozen=True, slots=True, repr=False)
class KinematicsCheck:
    """A component's answers on one robot, at random postures, against the robot's own tree; the largest deviations.

    Attributes:
        postures: number of postures that were tried.
        forward_position_error_meters: of the tip from where the tree has it.
        forward_rotation_error_radians: of the tip from where the tree has it.
        inverse_position_error_meters: of a solution's tip from its target.
        inverse_rotation_error_radians: of a solution's tip from its target.
        jacobian_error: from finite differences, relative to the Jacobian's largest entry, without unit.
        forward_seconds: the mean time of a call of `forward`.
        jacobian_seconds: the mean time of a call of `jacobian`.
        inverse_seconds: the mean time of a call of `inverse`.
    """

    postures: int
    forward_position_error_meters: float
    forward_rotation_error_radians: float
    inverse_position_error_meters: float
    inverse_rotation_error_radians: float
    jacobian_error: float
    forward_seconds: float
    jacobian_seconds: float
    inverse_seconds: float

    @staticmethod
    def of(message: robot_pb2.KinematicsCheck) -> KinematicsCheck:
        """Return the numbers that a message tells."""
        return KinematicsCheck(**{field.name: getattr(message, field.name) for field in message.DESCRIPTOR.fields})

    def __repr__(self) -> str:
        """Return the numbers as a table."""
        from virtualrobot.tables import aligned

        rows = [
            [f"{self.postures} postures", "position", "rotation", "a call"],
            [
                "forward",
                f"{self.forward_position_error_meters:.1e} m",
                f"{self.forward_rotation_error_radians:.1e} rad",
                f"{1e3 * self.forward_seconds:.3f} ms",
            ],
            [
                "inverse",
                f"{self.inverse_position_error_meters:.1e} m",
                f"{self.inverse_rotation_error_radians:.1e} rad",
                f"{1e3 * self.inverse_seconds:.3f} ms",
            ],
            ["jacobian, relative", f"{self.jacobian_error:.1e}", "", f"{1e3 * self.jacobian_seconds:.3f} ms"],
        ]
        return "\n".join(aligned(rows))
