"""Faults of drivers, as errors of calls."""

from __future__ import annotations

from virtualrobot_sdk.drivers import DriverFault

from virtualrobot_kernel.errors import KernelError, Reason


def told(error: BaseException, robot: str) -> BaseException:
    """Return the error that tells of a driver's fault in its own words; any other as it is."""
    if not isinstance(error, DriverFault):
        return error
    said = f"the driver of {robot!r}: {error}"
    return KernelError(said, reason=Reason.DRIVER_FAULT, robot=robot, code=error.code, clears=error.clears)
