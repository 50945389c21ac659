"""The driver `crs` against a controller that is computed, which plans by itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_plugins.drivers.crs import Crs, CrsSettings
from virtualrobot_sdk.drivers import DriverFault, Mode, Pace, Reading

from tests.drivers.cables import Cable
from tests.drivers.rapl import PULSES, Controller

TOLERANCE = CrsSettings("").tolerance_degrees
POINTS = [np.array(point) for point in ((10.0, -5, 3, 0, 20, 1), (12.0, -5, 3, 0, 20, 40), (0.0, 0, 0, 0, 0, 0))]


@pytest.fixture
def controller(cable: Cable) -> Controller:
    """Return a controller on the cable."""
    controller = Controller()
    cable.serve(controller)
    return controller


@pytest.fixture
def settings(cable: Cable) -> CrsSettings:
    """Return the settings of a driver that has patience."""
    return CrsSettings(str(cable.path), silence_seconds=20.0)


@pytest.fixture
def driver(settings: CrsSettings, controller: Controller) -> Iterator[Crs]:
    """Return a driver of the controller."""
    driver = Crs(settings)
    yield driver
    driver.close()


def wait_until(driver: Crs, there: Callable[[Reading], bool]) -> Reading:
    """Return the first reading of which `there` is true; the test's own timeout ends what never comes."""
    while not there(reading := driver.read()):
        pass
    return reading


def test_it_says_what_it_is(driver: Crs) -> None:
    about = driver.connect()
    assert (about.joints, about.pace, about.units, about.watchdog) == (6, Pace.JOBS, math.radians(1.0), 0.0)
    assert (about.model, about.version) == ("A465 Robot", "RAPL-II Version 2.60")
    # 960 bytes a second, and 1500 a cycle.
    assert about.rate == pytest.approx(0.64)
    assert driver.read().mode is Mode.READY


def test_it_goes_from_point_to_point(driver: Crs, controller: Controller) -> None:
    driver.connect()
    driver.begin(np.zeros(6))
    driver.run(POINTS[:2], [1.0, 0.5], 0)
    assert driver.read().done == 0
    driver.run(POINTS[2:], [0.5], 0)
    seen: list[int] = []
    there = wait_until(driver, lambda reading: seen.append(reading.done) or reading.done == 3)
    assert sorted(seen) == seen
    assert there.positions == pytest.approx(np.zeros(6), abs=TOLERANCE)
    assert there.mode is Mode.RUNNING
    moves = [command for command in controller.typed if command.partition(" ")[0] in ("SPEED", "MA")]
    assert moves == [
        *("SPEED 100", "MA 0.17453,-0.08727,0.05236,0.00000,0.34907,0.01745"),
        *("SPEED 50", "MA 0.20944,-0.08727,0.05236,0.00000,0.34907,0.69813"),
        "MA 0.00000,0.00000,0.00000,0.00000,0.00000,0.00000",
    ]
    driver.end()


def test_points_are_told_in_pulses_where_these_are_known(settings: CrsSettings, controller: Controller) -> None:
    driver = Crs(replace(settings, pulses_per_degree=tuple(PULSES)))
    driver.connect()
    driver.begin(np.zeros(6))
    driver.run(POINTS[:1], [1.0], 0)
    there = wait_until(driver, lambda reading: reading.done == 1)
    assert there.positions == pytest.approx(POINTS[0], abs=TOLERANCE)
    assert "POINT #VROBOT -666, 333, -200, 0, -5556, -140" in controller.typed
    assert "MOVE #VROBOT" in controller.typed
    driver.close()
    with pytest.raises(DriverFault, match=r"pulses_per_degree has 2 numbers; the controller tells 6 joints"):
        Crs(replace(settings, pulses_per_degree=(1.0, 2.0))).connect()


def test_an_arm_of_five_joints(settings: CrsSettings, cable: Cable) -> None:
    controller = Controller(joints=5)
    cable.serve(controller)
    driver = Crs(settings)
    assert driver.connect().joints == 5
    assert driver.read().positions == pytest.approx(np.zeros(5))
    driver.close()


def test_a_stop_halts_it_at_once_and_forgets_the_points(driver: Crs, controller: Controller) -> None:
    driver.connect()
    driver.stop()
    driver.begin(np.zeros(6))
    controller.speed = 20.0
    driver.run([np.full(6, 170.0), np.zeros(6)], [1.0, 1.0], 0)
    wait_until(driver, lambda reading: reading.positions[0] > 0.1)
    driver.stop()
    rest = driver.read()
    assert rest.positions[0] < 170.0
    driver.run([np.zeros(6)], [1.0], 0)
    for _ in range(5):
        reading = driver.read()
        assert reading.mode is Mode.READY
    assert reading.positions == pytest.approx(rest.positions)
    assert (reading.done, reading.mode) == (0, Mode.READY)
    driver.begin(rest.positions)
    controller.speed = 400.0
    driver.run([np.zeros(6)], [1.0], 0)
    assert wait_until(driver, lambda reading: reading.done == 1).positions == pytest.approx(np.zeros(6), abs=TOLERANCE)


def test_the_controllers_own_words_are_told(driver: Crs) -> None:
    driver.connect()
    driver.begin(np.zeros(6))
    driver.run([np.array([0.0, 0, 180, 0, 0, 0])], [1.0], 0)
    with pytest.raises(DriverFault, match=r"^051: JOINT 3 OUT OF RANGE\. \(to MA 0\.00000,.*\)$"):
        driver.read()
    driver.begin(np.zeros(6))
    driver.run([np.zeros(4)], [1.0], 0)
    with pytest.raises(DriverFault, match=r"^012: COMMAND ERROR\. \(to MA "):
        driver.read()


def test_an_arm_that_stands_before_its_point_is_told(driver: Crs, controller: Controller) -> None:
    driver.connect()
    driver.begin(np.zeros(6))
    controller.speed = 5.0
    driver.run([np.full(6, 90.0)], [1.0], 0)
    wait_until(driver, lambda reading: reading.positions[0] > 0.1)
    controller.error = "052-COLLISION."
    controller.do_halt("")
    with pytest.raises(DriverFault, match=r"^052: the arm stands at .* and not at point 1, 90, .* is 052-COLLISION\.$"):
        wait_until(driver, lambda reading: False)


def test_power_that_goes_away_is_seen(driver: Crs, controller: Controller) -> None:
    driver.connect()
    driver.begin(np.zeros(6))
    controller.limp = True
    off = wait_until(driver, lambda reading: reading.mode is not Mode.RUNNING)
    assert (off.mode, off.text) == (Mode.OFF, "joints are limp: switch ARM POWER on at the controller, and type NOLIMP")


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"limp": True}, "joints are limp: switch ARM POWER on at the controller, and type NOLIMP"),
        ({"homed": False}, "the arm is not homed: home it at the controller"),
        ({"manual": True}, "the teach pendant has the arm: end MANUAL there"),
    ],
)
def test_an_arm_that_is_not_ready_does_not_begin(
    driver: Crs, controller: Controller, wrong: dict[str, bool], said: str
) -> None:
    driver.connect()
    controller.__dict__.update(wrong)
    with pytest.raises(DriverFault) as fault:
        driver.begin(np.zeros(6))
    assert fault.value.text == said


def test_silence_and_nonsense_are_told(settings: CrsSettings, controller: Controller) -> None:
    driver = Crs(replace(settings, silence_seconds=1.0))
    driver.connect()
    controller.says = False
    with pytest.raises(DriverFault, match=r"the controller on .*ttyROBOT was silent for 1 s after W2"):
        driver.read()
    controller.says = True
    controller.do_w2 = lambda rest: ["JOINTS +000.0 +nan", "WORLD"]
    with pytest.raises(DriverFault, match=r"answers W2 by .*, which tells 1 joints"):
        driver.read()
    controller.do_status = lambda rest: ["HELLO"]
    with pytest.raises(DriverFault, match=r"answers STATUS by .*: there is no row 'LIMP'"):
        driver.connect()
    driver.close()


def test_what_was_typed_before_does_no_harm(driver: Crs, controller: Controller) -> None:
    """Somebody left half a command at the prompt, and two answers are on their way."""
    controller.held = "STAT"
    driver.connect()
    driver.stop()
    driver.stop()
    assert driver.read().positions == pytest.approx(np.zeros(6))


def test_unplugged_is_told_and_replugged_connects_again(driver: Crs, controller: Controller, cable: Cable) -> None:
    driver.connect()
    driver.begin(np.zeros(6))
    driver.run(POINTS, [1.0] * 3, 0)
    driver.read()
    cable.unplug()
    with pytest.raises(DriverFault, match=r"ttyROBOT is gone"):
        driver.read()
    cable.plug()
    cable.serve(controller)
    controller.typed.clear()
    assert driver.connect().joints == 6
    # What was not told before is forgotten.
    for _ in range(10):
        assert driver.read().mode is Mode.READY
    assert set(controller.typed) == {"STATUS", "W2"}
