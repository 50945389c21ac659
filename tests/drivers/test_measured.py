"""Readings of a controller: how long its own clock may stand still, and what no joint can be."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_sdk.drivers import About, DriverFault, Mode, Reading
from virtualrobot_sdk.drivers import measured as rules
from virtualrobot_sdk.drivers.measured import Measured
from virtualrobot_sdk.drivers.robot_side import JointSide, Mapping, RobotSide

SIDE = RobotSide((JointSide("knee", 0, -1.0, 1.0, 1.0),))


@pytest.mark.parametrize(
    ("silence", "rate", "borne_ms"),
    [(0.0, 125.0, 100), (0.05, 125.0, 100), (0.5, 125.0, 500), (0.0, 10.0, 300)],
)
def test_the_longest_of_setting_cycles_and_a_tenth_of_a_second_is_borne(
    silence: float, rate: float, borne_ms: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rules, "SILENT_SECONDS", 0.1)
    about = About(1, rate, silence=silence)
    measured, mapping = Measured(1), Mapping(SIDE, about)
    reading = Reading(stamp=7.0, positions=np.zeros(1), mode=Mode.READY)
    measured.begin(0)
    measured.take(reading, 0, 0, about, mapping)
    measured.take(reading, (borne_ms - 1) * 1_000_000, 0, about, mapping)
    with pytest.raises(DriverFault, match="stood still"):
        measured.take(reading, (borne_ms + 1) * 1_000_000, 0, about, mapping)


@pytest.mark.parametrize(
    ("units", "position", "velocity"), [(1e3, 1.7e308, 0.0), (1.0, 1e12, 0.0), (1e3, 0.0, 1.7e308)]
)
def test_what_no_joint_can_be_in_its_own_units_is_nonsense(units: float, position: float, velocity: float) -> None:
    about = About(1, 100.0, units=units)
    measured = Measured(1)
    reading = Reading(1.0, np.array([position]), np.array([velocity]), mode=Mode.READY)
    with np.errstate(over="ignore"), pytest.raises(DriverFault, match="nonsense: in rad and m its joints"):
        measured.take(reading, 0, 0, about, Mapping(SIDE, about))
    assert measured.reading is None and not measured.q.any()
