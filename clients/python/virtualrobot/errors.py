"""Exceptions of calls: one class for each reason that programs branch on."""

from __future__ import annotations

from collections.abc import Mapping


class VirtualRobotError(Exception):
    """A call that was refused or could not be made; nothing has changed in the world.

    Attributes:
        message: the fault and the remedy in words, for people.
        reason: the name of the reason, such as `UNKNOWN_NAME` (`ErrorReason` of the contract), for programs.
        metadata: the bad and the valid values as strings, by name.
        code: the name of the gRPC status, such as `NOT_FOUND`; empty when the client itself refused.
    """

    default_reason = "UNKNOWN"

    def __init__(
        self, message: str, reason: str = "", metadata: Mapping[str, str] | None = None, code: str = ""
    ) -> None:
        """Keep the message and what programs want to know."""
        super().__init__(message)
        self.message = message
        self.reason = reason or self.default_reason
        self.metadata = dict(metadata or {})
        self.code = code

    def __str__(self) -> str:
        """Return the message alone."""
        return self.message


class InvalidArgumentError(VirtualRobotError, ValueError):
    """A value is missing, not finite, of the wrong shape or impossible."""

    default_reason = "INVALID_ARGUMENT"


class UnknownNameError(VirtualRobotError, KeyError):
    """A name that nothing has; `metadata["nearest"]` is like it, `metadata["valid"]` lists right ones, one a line."""

    default_reason = "UNKNOWN_NAME"


class NameTakenError(VirtualRobotError):
    """A name that another thing has."""

    default_reason = "NAME_TAKEN"


class StaleRevisionError(VirtualRobotError):
    """The structure has changed since the revision that the call assumes: read again and retry."""

    default_reason = "STALE_REVISION"


class PlanOutdatedError(VirtualRobotError):
    """A plan whose assumptions have changed since, such as the position of a joint: plan again."""

    default_reason = "PLAN_OUTDATED"


class LimitError(VirtualRobotError):
    """A joint, speed or time outside its limits."""

    default_reason = "LIMIT_EXCEEDED"


class UnreachableError(VirtualRobotError):
    """A pose that the robot cannot reach."""

    default_reason = "UNREACHABLE"


class SingularityError(VirtualRobotError):
    """A path that passes a singular posture."""

    default_reason = "SINGULARITY"


class RobotBusyError(VirtualRobotError):
    """Joints that move already; `metadata` names the motion. Start with `preempt=True` to take over."""

    default_reason = "ROBOT_BUSY"


class WrongStateError(VirtualRobotError):
    """The thing exists but is not in a state that allows the call."""

    default_reason = "WRONG_STATE"


class MalformedFileError(VirtualRobotError):
    """A file that says something impossible; `metadata` has file, line and path where known."""

    default_reason = "MALFORMED_FILE"


class MissingFileError(VirtualRobotError, FileNotFoundError):
    """A file that is nowhere; the message lists the places that were tried."""

    default_reason = "MISSING_FILE"


class AssetError(VirtualRobotError):
    """An upload whose bytes do not match, or a SHA-256 that the kernel does not hold."""

    default_reason = "MALFORMED_ASSET"


class TooLargeError(VirtualRobotError):
    """A message or file over the limit; `metadata` has both sizes."""

    default_reason = "TOO_LARGE"


class AuthenticationError(VirtualRobotError):
    """No token or a wrong one."""

    default_reason = "UNAUTHENTICATED"


class KernelGoneError(VirtualRobotError, ConnectionError):
    """No kernel answers: it was not started, is ending, has ended, or the network is cut.

    `reason` is `NOT_RUNNING` where nothing listens at the address, `SHUTTING_DOWN` where the kernel says that it ends,
    and `NO_CONNECTION` where the connection was lost or cannot be made.
    """

    default_reason = "SHUTTING_DOWN"


class KernelFaultError(VirtualRobotError):
    """A fault of the kernel's own; its log has the traceback."""

    default_reason = "INTERNAL"


class PluginFailedError(VirtualRobotError):
    """A plugin's component raised, hung, died, returned nonsense or does not fit the robot; choose another one."""

    default_reason = "PLUGIN_FAILED"


class LeasedError(VirtualRobotError):
    """A robot that somebody else has leased; `metadata` has `robot`, `owner` and `since`. Wait, or take it over."""

    default_reason = "LEASED"


class LeaseEndedError(VirtualRobotError):
    """A lease that this client still carries has expired or was taken over; the message says by whom or why."""

    default_reason = "LEASE_ENDED"


class CollisionError(VirtualRobotError):
    """It would bring a robot into touch with something; `metadata` has `first` and `second` where both are known."""

    default_reason = "COLLISION"


class ConflictError(VirtualRobotError):
    """An undo of what is not as it was left; `metadata` tells `step`, `author` and `label` of who changed it since."""

    default_reason = "CONFLICT"


class TooManyCallsError(VirtualRobotError):
    """More calls a second, or more streams at a time, than this client may have; `metadata` names the limit."""

    default_reason = "TOO_MANY_CALLS"


class DriverFaultError(VirtualRobotError):
    """A real robot's controller refuses, complains or is silent: `metadata` has `robot`, `code` and `clears`."""

    default_reason = "DRIVER_FAULT"


class RoleTooLowError(VirtualRobotError, PermissionError):
    """A call or command that this client's role may not give; `metadata` has `needs` and `has`, the roles."""

    default_reason = "ROLE_TOO_LOW"


class CallTimeoutError(VirtualRobotError, TimeoutError):
    """The kernel did not answer, or what was waited for did not happen, in time."""

    default_reason = "TIMEOUT"


class VersionError(VirtualRobotError):
    """The kernel speaks another version of the contract than this client."""

    default_reason = "VERSION"


class ClientClosedError(VirtualRobotError):
    """This client was closed; connect again."""

    default_reason = "CLIENT_CLOSED"


class MotionEndedError(VirtualRobotError):
    """A motion that ended before its goal: somebody cancelled it, or the kernel had to abort it.

    `metadata` has `motion`, its name, `end_cause`, such as `stop` or `collision`, and `end_reason`, the same in words.
    """

    default_reason = "MOTION_ENDED"


class MotionCancelledError(MotionEndedError):
    """A motion that somebody ended before its goal; it stands still on its path, and the message says why."""

    default_reason = "MOTION_CANCELLED"


class MotionAbortedError(MotionEndedError):
    """A motion that the kernel had to end before its goal: a fault, a collision, a watchdog, a lost tracked joint."""

    default_reason = "MOTION_ABORTED"


BY_REASON: dict[str, type[VirtualRobotError]] = {
    error.default_reason: error
    for error in VirtualRobotError.__subclasses__()
    if error not in (CallTimeoutError, VersionError, ClientClosedError, MotionEndedError)
} | {"UNKNOWN_ASSET": AssetError}
"""The exception class of each reason of the contract."""
