"""Vehicles under water with arms in a world: what an arm and what it holds gain, the vehicle loses."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot_kernel.crafts.vessel import Vessel
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.world.commands import AttachNode, CreateNodes, SetSetpoint, StartSetpointMotion
from virtualrobot_kernel.world.craft_data import Craft, Water
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import (
    Inertial,
    Joint,
    JointLimits,
    JointType,
    Kind,
    LinkData,
    NodeSpec,
    PartData,
    RobotData,
)

from tests.unit.crafts.rover import Yard, yard
from tests.unit.plugins.marine.ideal import document, pusher
from tests.unit.world.builders import shifted

VACUUM = document(
    added_mass=[0.0] * 6,
    linear_damping=[0.0] * 6,
    quadratic_damping=[0.0] * 6,
    center_of_buoyancy=[0.0] * 3,
    volume=13.5,
    thrusters=[pusher("push", [1, 0, 0], [0, 0, 0])],
)
"""A vehicle that nothing but its thruster acts on: 13.5 kg, whose weight is its buoyancy, without water about it."""
HULL = 13.5
LIMITS = JointLimits(-3.0, 3.0, 2.0, 8.0, 80.0)
QUICK = JointLimits(velocity=200.0, acceleration=4e6, jerk=4e9)
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
BODIES = {"arm.upper": (2.0, 0.2), "arm.fore": (1.0, 0.15), "stone": (0.6, 0.0)}
"""Mass (kg) and centre along x (m) of the bodies that are carried."""


def rod(mass: float, centre: float) -> Inertial:
    return Inertial(mass, shifted(x=centre), (1e-3, 0.01, 0.01))


def nodes() -> CreateNodes:
    """Return a vehicle with an arm of two joints at its bow, which holds a stone, and with a mass on its own hull."""
    craft = Craft("fossen", {"vehicle": VACUUM}, water=Water(surface_height=50.0))
    hull = LinkData(Joint("base", JointType.FLOATING), Inertial(999.0, shifted()))  # its file has its mass
    screw = LinkData(Joint("push", JointType.CONTINUOUS, X, QUICK), rod(9.0, 0.0))
    upper = LinkData(Joint("shoulder", JointType.REVOLUTE, Z, LIMITS), rod(*BODIES["arm.upper"]))
    fore = LinkData(Joint("elbow", JointType.REVOLUTE, Y, LIMITS), rod(*BODIES["arm.fore"]))
    return CreateNodes(
        (
            NodeSpec("rover", Kind.ROBOT, data=RobotData(craft=craft)),
            NodeSpec("rover.hull", Kind.LINK, "rover", data=hull),
            NodeSpec("rover.screw", Kind.LINK, "rover.hull", shifted(x=-0.2), data=screw),
            NodeSpec("arm", Kind.ROBOT, "rover.hull", shifted(x=0.2, z=-0.1), data=RobotData()),
            NodeSpec("arm.upper", Kind.LINK, "arm", data=upper),
            NodeSpec("arm.fore", Kind.LINK, "arm.upper", shifted(x=0.4), data=fore),
            NodeSpec("stone", Kind.PART, "arm.fore", shifted(x=0.3), data=PartData(0.6)),
        )
    )


@pytest.fixture
def sea() -> Iterator[Yard]:
    with yard(nodes()) as made:
        yield made


def pose(snapshot: Snapshot, name: str) -> np.ndarray:
    return snapshot.world_t(snapshot.structure.node(name).uid)


def centre(snapshot: Snapshot) -> np.ndarray:
    """Return the centre of all masses (3,)."""
    masses = np.array([HULL, *(mass for mass, _ in BODIES.values())])
    places = [(pose(snapshot, name) @ shifted(x=x))[:3, 3] for name, (_, x) in BODIES.items()]
    return masses @ np.array([pose(snapshot, "rover.hull")[:3, 3], *places]) / masses.sum()


def swing(sea: Yard, *speeds: float) -> None:
    (id,) = sea.do(StartSetpointMotion("arm", ("shoulder", "elbow"), SetpointMode.VELOCITY, 60.0))
    sea.do(SetSetpoint(str(id), speeds))


def test_an_arm_moves_its_vehicle_and_their_centre_stays(sea: Yard) -> None:
    """Newton: without outer forces the centre of mass of all rests; the hull's own inertials are not counted twice."""
    before = sea.world.snapshot
    begin, hull = centre(before), pose(before, "rover.hull")[:3, 3]
    swing(sea, 1.0, -0.8)
    for _ in range(5):
        now = sea.step(50)
        assert np.linalg.norm(centre(now) - begin) < 1e-5
    assert np.linalg.norm(pose(now, "rover.hull")[:3, 3] - hull) > 0.02
    # The arm turns to the left, and the vehicle to the right.
    assert pose(now, "rover.hull")[1, 0] < -0.05


def test_an_arm_that_stands_lets_its_vehicle_stand(sea: Yard) -> None:
    before = pose(sea.world.snapshot, "rover.hull")
    np.testing.assert_array_equal(pose(sea.step(25), "rover.hull"), before)


def test_a_push_moves_all_that_hangs_together(sea: Yard) -> None:
    """F = (M + m) a of the centre: 10 N on 17.1 kg."""
    begin = centre(sea.world.snapshot)
    sea.drive(10.0, joints=("push",))
    sea.step(100)
    first = centre(sea.world.snapshot)
    sea.step(100)
    last = centre(sea.world.snapshot)
    along = (last - 2.0 * first + begin) / 0.4**2
    assert np.linalg.norm(along) == pytest.approx(10.0 / (HULL + 3.6), rel=0.01)


def test_what_is_let_go_is_carried_no_more(sea: Yard) -> None:
    def carried() -> float:
        craft = sea.crafts.of(sea.world.snapshot.structure.node("rover").uid)
        assert isinstance(craft, Vessel)
        return 0.0 if craft.burden is None else float(craft.burden.mass.sum())

    assert carried() == pytest.approx(3.6)
    sea.do(AttachNode("stone", "world"))
    assert carried() == pytest.approx(3.0)
    sea.do(AttachNode("arm", "world"))
    assert carried() == 0.0
