"""Rate limits of watches."""

from __future__ import annotations

import math

from virtualrobot_kernel.errors import KernelError


def rate(asked: float, default: float = 30.0) -> float:
    """Return the rate in hertz, the default for 0; raise KernelError for nonsense."""
    if not (math.isfinite(asked) and asked >= 0.0):
        raise KernelError(f"max_rate_hertz must be 0 (the default) or above, not {asked:g}", value=asked)
    return asked or default
