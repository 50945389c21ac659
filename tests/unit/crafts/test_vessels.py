"""Crafts under water in a world: a component moves them, water carries them, and a replay needs neither."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.components.running import ComponentHandle
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.commands import CancelMotion, CreateNodes, SetCraft, SetSetpoint, StartSetpointMotion
from virtualrobot_kernel.world.craft_data import Craft, CraftDrive, Water
from virtualrobot_kernel.world.journal import replay
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, LinkData, NodeSpec, RobotData
from virtualrobot_plugins.marine.component import FossenDynamics, FossenSettings
from virtualrobot_sdk.vehicles import Surroundings

from tests.unit.crafts.rover import Yard, yard
from tests.unit.journals import entries_of
from tests.unit.world.builders import TICK, empty, link, shifted

QUICK = JointLimits(velocity=400.0, acceleration=4e6, jerk=4e9)
REMUS = Craft(
    "fossen",
    {"vehicle": "remus100"},
    (CraftDrive("propeller", "screw", -2.0),),
    water=Water(density=1026.0, surface_height=50.0),
)
START = shifted(x=1.0, y=2.0, z=3.0)


def torpedo(craft: Craft | None = REMUS, base: JointType = JointType.FLOATING) -> CreateNodes:
    """Return a REMUS 100 at (1, 2, 3), turned to the left, whose screw turns twice as fast, the other way."""
    turned = START.copy()
    turned[:2, :2] = [[0.0, -1.0], [1.0, 0.0]]
    hull = NodeSpec("rover.hull", Kind.LINK, "rover", data=LinkData(Joint("base", base, (0.0, 0.0, 1.0))))
    fin = JointLimits(-0.2618, 0.2618, 5.0, 5e4, 5e7)
    drives = (
        link("rover.screw", "rover.hull", Joint("screw", JointType.CONTINUOUS, limits=QUICK), shifted(x=-0.8)),
        link("rover.rudder", "rover.hull", Joint("rudder", JointType.REVOLUTE, limits=fin), shifted(x=-0.7)),
        link("rover.plane", "rover.hull", Joint("stern_plane", JointType.REVOLUTE, limits=fin), shifted(x=-0.7)),
    )
    return CreateNodes((NodeSpec("rover", Kind.ROBOT, "world", turned, data=RobotData(craft=craft)), hull, *drives))


@pytest.fixture
def sea() -> Iterator[Yard]:
    with yard(torpedo()) as made:
        yield made


def hull(sea: Yard) -> np.ndarray:
    snapshot = sea.world.snapshot
    return snapshot.world_t(snapshot.structure.node("rover.hull").uid)


def steer(sea: Yard, angle: float) -> None:
    """Have the rudder follow an angle (rad)."""
    (id,) = sea.do(StartSetpointMotion("rover", ("rudder",), SetpointMode.POSITION, 60.0))
    sea.do(SetSetpoint(str(id), (angle,)))


def test_it_goes_where_its_component_says(sea: Yard) -> None:
    """Bit for bit but for rounding it is the component on its own, told the same speeds."""
    sea.drive(-200.0, joints=("screw",))
    steer(sea, 0.1)
    sea.step(500)
    own = FossenDynamics(FossenSettings("remus100"))
    pose = START.copy()
    pose[:2, :2] = [[0.0, -1.0], [1.0, 0.0]]
    at = pose, np.zeros(6), np.zeros(3)
    for _ in range(500):
        at = own.step(*at, np.array([100.0, 0.1, 0.0]), TICK, Surroundings(density=1026.0, surface=50.0))
    found = hull(sea)
    # The joints need some ticks to their speeds, which the propeller's lag of a second hides.
    np.testing.assert_allclose(found, at[0], atol=2e-2)
    assert found[1, 3] - 2.0 > 0.5
    v = sea.world.snapshot.state.v
    assert v[6] == pytest.approx(-200.0 * (1.0 - math.exp(-2.0)), rel=1e-2)
    assert sea.world.snapshot.state.q[8] == pytest.approx(0.1, abs=1e-6)


@pytest.mark.long
def test_the_screw_lags_behind_what_it_is_told_and_runs_out(sea: Yard) -> None:
    id = sea.drive(-200.0, joints=("screw",))
    sea.step(250)
    turning = sea.world.snapshot.state.v[6]
    assert -200.0 * (1.0 - math.exp(-1.0)) == pytest.approx(turning, rel=0.02)
    sea.do(CancelMotion(id))
    sea.step(250)
    assert 0.2 * turning > sea.world.snapshot.state.v[6] > 0.5 * turning
    assert sea.base[1] > 2.1


@pytest.mark.long
def test_a_current_carries_it(sea: Yard) -> None:
    sea.choose(replace(REMUS, water=Water((0.0, 0.5, 0.0), 1026.0, 50.0)))
    sea.step(1000)
    before = sea.base
    sea.step(250)
    way = sea.base - before
    assert 0.05 < way[1] < 0.5
    assert abs(way[0]) < 1e-6


def test_a_replay_needs_no_component(sea: Yard) -> None:
    sea.drive(-150.0, joints=("screw",))
    steer(sea, 0.1)
    last = sea.step(150)
    begin = empty()
    again = replay(begin.structure, begin.state, entries_of(sea.world), last.state.tick, TICK, world_poses)
    np.testing.assert_array_equal(again.state.q, last.state.q)
    np.testing.assert_array_equal(again.state.v, last.state.v)


@pytest.mark.long
def test_quaternions_stay_of_length_1_on_a_long_way(sea: Yard) -> None:
    sea.drive(-300.0, joints=("screw",))
    steer(sea, 0.2)
    q = sea.step(1000).state.q[3:7]
    assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.long
@pytest.mark.parametrize(
    ("craft", "base", "said"),
    [
        (REMUS, JointType.PLANAR, "the base joint 'base' of 'rover' is planar; 'fossen' moves a floating one"),
        (replace(REMUS, drives=()), JointType.FLOATING, "has the drive 'propeller', and 'rover' no such joint"),
        (
            replace(REMUS, drives=(*REMUS.drives, CraftDrive("sail", "rudder"))),
            JointType.FLOATING,
            "has no drive 'sail'; its drives are propeller, rudder, stern_plane",
        ),
    ],
)
def test_a_craft_that_fits_not_stands_and_says_why(craft: Craft, base: JointType, said: str) -> None:
    with yard(torpedo(craft, base)) as made:
        uid = made.world.snapshot.structure.node("rover").uid
        with pytest.raises(KernelError, match=said):
            made.crafts.of(uid)


@pytest.mark.long
def test_a_component_without_drives_is_named(sea: Yard, monkeypatch: pytest.MonkeyPatch) -> None:
    called = ComponentHandle.call
    monkeypatch.setattr(
        ComponentHandle, "call", lambda self, name, *given: () if name == "drives" else called(self, name, *given)
    )
    sea.choose(replace(REMUS))
    monkeypatch.undo()
    with pytest.raises(KernelError, match=r"drives is \(\); it must be VehicleDrives"):
        sea.crafts.of(sea.world.snapshot.structure.node("rover").uid)


@pytest.mark.long
def test_a_vehicle_that_is_none_is_refused(sea: Yard) -> None:
    with pytest.raises(KernelError, match="no vehicle 'nautilus'"):
        sea.crafts.check([SetCraft("rover", Craft("fossen", {"vehicle": "nautilus"}))])


@pytest.mark.long
def test_setpoints_of_drives_are_followed_and_twists_refused(sea: Yard) -> None:
    id = sea.drive(0.0, joints=("screw",))
    sea.do(SetSetpoint(id, (-50.0,)))
    sea.step(500)
    assert hull(sea)[1, 3] > 2.0
    uid = sea.world.snapshot.structure.node("rover").uid
    with pytest.raises(KernelError, match="'rover' is pushed by its thrusters"):
        sea.crafts.driven(uid)


@pytest.mark.long
@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ((np.eye(4), np.full(6, np.nan), np.zeros(3)), r"step returned \[nan, nan"),
        ((np.eye(4), np.zeros(5), np.zeros(3)), r"it must be a float64 array \(6,\)"),
        ((np.diag([2.0, 1.0, 1.0, 1.0]), np.zeros(6), np.zeros(3)), "a pose that is not rigid"),
        (None, "step returned NoneType; it must be pose, twist and states of drives"),
    ],
)
def test_nonsense_of_a_component_stops_its_vehicle(
    sea: Yard, monkeypatch: pytest.MonkeyPatch, answer: object, said: str
) -> None:
    sea.drive(-100.0, joints=("screw",))
    sea.step(50)
    called = ComponentHandle.call
    monkeypatch.setattr(
        ComponentHandle, "call", lambda self, name, *given: answer if name == "step" else called(self, name, *given)
    )
    there = sea.base
    snapshot = sea.step(50)
    monkeypatch.undo()
    np.testing.assert_array_equal(sea.base, there)
    assert not snapshot.state.v.any()
    assert not snapshot.state.motions
    with pytest.raises(KernelError, match=said):
        sea.crafts.of(snapshot.structure.node("rover").uid)
    sea.choose(replace(REMUS))
    sea.drive(-100.0, joints=("screw",))
    sea.step(100)
    assert sea.base[1] > there[1]
