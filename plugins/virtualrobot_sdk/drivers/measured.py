"""Measured joints of a robot: readings of its controller, each looked at before anything is done with it."""

from __future__ import annotations

import numpy as np

from virtualrobot_sdk.drivers.driver import About, DriverFault, Reading, finite, wrong_reading
from virtualrobot_sdk.drivers.robot_side import Mapping
from virtualrobot_sdk.drivers.shared import Floats
from virtualrobot_sdk.errors import PluginError

SILENT_SECONDS = 0.1
"""Shortest time (s) for which the controller's own clock may stand still; three cycles where they are longer."""

MOST = 1e6
"""Greatest joint position (rad, m) and velocity (per s) that is believed: no robot's joint goes so far or so fast."""


class Measured:
    """Newest reading of one connection, in the robot's joints.

    Attributes:
        reading: the reading; None before the first one.
        q, v: (k,) where the joints were measured, rad and m, per s; 0 before.
    """

    def __init__(self, joints: int) -> None:
        """Begin without a reading of so many joints."""
        self.reading: Reading | None = None
        self.q: Floats = np.zeros(joints)
        self.v: Floats = np.zeros(joints)
        self._stamp, self._stamp_ns = float("nan"), 0

    def begin(self, ns: int) -> None:
        """Take it that the controller has told its time just now (ns)."""
        self._stamp, self._stamp_ns = float("nan"), ns

    def take(self, reading: Reading, ns: int, late_ns: int, about: About, mapping: Mapping) -> None:
        """Take a reading that came at a time, and so long after it was due (ns).

        Raises PluginError for what is no Reading, or one of other types than it says; DriverFault for one that is no
        number, and where the controller's own clock stands still.
        """
        if wrong := wrong_reading(reading):
            raise PluginError(wrong)
        if wrong := finite(reading, about.joints):
            raise DriverFault(f"the controller sent nonsense: {wrong}")
        if reading.stamp != self._stamp:
            self._stamp, self._stamp_ns = reading.stamp, ns
        silent = (ns - self._stamp_ns) * 1e-9
        if silent > max(SILENT_SECONDS, about.silence, 3.0 / about.rate):
            raise DriverFault(f"the controller's own time has stood still for {silent:.2f} s; it hangs, or is gone")
        q, v = mapping.joints(reading)
        for told, what in ((q, "are at"), (v, "go at")):
            if told is not None and not np.abs(told).max(initial=0.0) <= MOST:  # inf and NaN neither
                raise DriverFault(f"the controller sent nonsense: in rad and m its joints {what} {told.tolist()}")
        seconds = max(late_ns * 1e-9, 0.0) + 1.0 / about.rate
        self.v = v if v is not None else (q - self.q) / seconds if self.reading is not None else np.zeros_like(q)
        self.q, self.reading = q, reading
