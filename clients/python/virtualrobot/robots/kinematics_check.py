"""Check of a kinematics component on a robot."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot.v1 import robot_pb2


@dataclass(frozen=True, slots=True, repr=False)
class KinematicsCheck:
    """A component's answers on one robot, at random postures, against the robot's own tree; the largest deviations.

    Attributes:
        postures: number of postures that were tried.
        forward_position_error: of the tip from where the tree has it.
        forward_rotation_error: of the tip from where the tree has it.
        inverse_position_error: of a solution's tip from its target.
        inverse_rotation_error: of a solution's tip from its target.
        jacobian_error: from finite differences, relative to the Jacobian's largest entry, without unit.
        forward_time: the mean time of a call of `forward`.
        jacobian_time: the mean time of a call of `jacobian`.
        inverse_time: the mean time of a call of `inverse`.
    """

    postures: int
    forward_position_error: float
    forward_rotation_error: float
    inverse_position_error: float
    inverse_rotation_error: float
    jacobian_error: float
    forward_time: float
    jacobian_time: float
    inverse_time: float

    @staticmethod
    def of(message: robot_pb2.KinematicsCheck) -> KinematicsCheck:
        """Return the numbers that a message tells."""
        return KinematicsCheck(*(getattr(message, field.name) for field in message.DESCRIPTOR.fields))

    def __repr__(self) -> str:
        """Return the numbers as a table."""
        from virtualrobot.tables import aligned

        rows = [
            [f"{self.postures} postures", "position", "rotation", "a call"],
            [
                "forward",
                f"{self.forward_position_error:.1e} m",
                f"{self.forward_rotation_error:.1e} rad",
                f"{1e3 * self.forward_time:.3f} ms",
            ],
            [
                "inverse",
                f"{self.inverse_position_error:.1e} m",
                f"{self.inverse_rotation_error:.1e} rad",
                f"{1e3 * self.inverse_time:.3f} ms",
            ],
            ["jacobian, relative", f"{self.jacobian_error:.1e}", "", f"{1e3 * self.jacobian_time:.3f} ms"],
        ]
        return "\n".join(aligned(rows))
