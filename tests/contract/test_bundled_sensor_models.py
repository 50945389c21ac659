"""The bundled sensor models under the test kit, each as it comes and as another device."""

from __future__ import annotations

import pytest
from virtualrobot_sdk.testing import SensorModelContract
from virtualrobot_sdk.testing.sensor_models import SensorFacts

PLUGIN = "virtualrobot_plugins.sensor_models"


class TestIdeal(SensorModelContract):
    component = f"{PLUGIN}/ideal"


class TestLaser(SensorModelContract):
    component = f"{PLUGIN}/laser"


@pytest.mark.long
class TestScannerWithSpot(SensorModelContract):
    component = f"{PLUGIN}/laser"
    settings = {  # noqa: RUF012  the class attribute is the kit's interface
        "relative_deviation": 0.01,
        "noise_limit": "thermal",
        "detection_range_meters": 12.0,
        "dropout_rate": 0.02,
        "divergence_radians": [0.01, 0.005],
        "rays": 7,
        "echo": "first",
        "without_echo": "zero",
    }


class TestUltrasonic(SensorModelContract):
    component = f"{PLUGIN}/ultrasonic"
    facts = SensorFacts(nearest=0.02, farthest=4.5)


@pytest.mark.long
class TestUltrasonicAmongOthers(SensorModelContract):
    component = f"{PLUGIN}/ultrasonic"
    settings = {"false_echo_rate": 0.05, "roughness": 0.1, "without_echo": "farthest"}  # noqa: RUF012  as above
    facts = SensorFacts(nearest=0.02, farthest=4.0, valid_misses=0.05)


class TestSonar(SensorModelContract):
    component = f"{PLUGIN}/sonar"
    facts = SensorFacts(nearest=0.3, farthest=50.0)


@pytest.mark.long
class TestSonarOfManyBeams(SensorModelContract):
    component = f"{PLUGIN}/sonar"
    settings = {  # noqa: RUF012  as above
        "width_radians": 0.0175,
        "height_radians": 0.349,
        "frequency_kilohertz": 750.0,
        "detection_range_meters": 60.0,
        "speckle": True,
        "salinity": 0.0,
        "without_echo": "zero",
    }
    facts = SensorFacts(nearest=0.1, farthest=40.0)


class TestInfrared(SensorModelContract):
    component = f"{PLUGIN}/infrared"
    facts = SensorFacts(nearest=0.1, farthest=0.8)
