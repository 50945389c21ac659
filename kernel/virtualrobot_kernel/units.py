"""Unit mistakes: bounds beyond which a number is rather in degrees or millimetres, and the words that ask."""

from __future__ import annotations

from math import pi

MOST_ANGLE = 4.0 * pi
"""Greatest angle (rad), and turn in one go, that is taken for meant."""
MOST_LENGTH = 100.0
"""Greatest edge, radius or length of a primitive shape (m), and distance of a goal, that is taken for meant."""
MOST_TCP_SPEED = 50.0
"""Greatest speed of a tool centre point (m/s) that is taken for meant."""
MOST_TWIST = 1000.0
"""Greatest speed (m/s, rad/s) of a craft's twist that its component is asked about."""
MOST_SPEED_RATIO = 10.0
"""Greatest ratio of a joint's speed to its limit that is taken for meant."""


def degrees_question(angle: float) -> str:
    """Return the question whether an angle is in degrees, to end a message with; empty for a small one."""
    if not abs(angle) > MOST_ANGLE:
        return ""
    return f"; {angle:g} rad is {abs(angle) / (2.0 * pi):.3g} turns: degrees? use `math.radians` or `--degrees`"


def speed_question(speed: float, limit: float) -> str:
    """Return the question whether a joint's speed is in degrees or millimetres; empty for one that may be meant."""
    if not abs(speed) > MOST_SPEED_RATIO * limit:
        return ""
    return f"; that is {abs(speed) / limit:.3g} times its limit: degrees or millimetres? speeds are in rad/s and m/s"


def millimetres_question(length: float) -> str:
    """Return the question whether a length is in millimetres, to end a message with; empty for a short one."""
    return f"; {length:g} m: millimetres? lengths are in meters" if abs(length) > MOST_LENGTH else ""
