"""Interface of physics engines: bodies that fall, roll, slide and push, one tick after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from typing import Protocol

import numpy as np

from virtualrobot_sdk.kinematics import Floats, Integers

WORLD = -1
"""Parent of bodies that hang on the world itself."""


class ShapeKind(Enum):
    """Shapes that touch, all about the origin of their frame; `size` says their measures in meters."""

    BOX = "box"
    """Half the lengths along x, y and z."""
    SPHERE = "sphere"
    """The radius."""
    CYLINDER = "cylinder"
    """The radius, and half the length along z."""
    CAPSULE = "capsule"
    """The radius, and half the length along z of the part between the half spheres."""
    HULL = "hull"
    """None: the convex hull of `vertices`."""
    HEIGHTS = "heights"
    """The lengths of a cell along x and y: ground, touched from above, of `heights`. It is the only shape of a body
    that nothing moves."""


class BodyJoint(Enum):
    """Joint by which a body hangs on its parent."""

    FIXED = "fixed"
    REVOLUTE = "revolute"
    """Turns about `axis`."""
    PRISMATIC = "prismatic"
    """Slides along `axis`."""
    FREE = "free"
    """None: the body moves anywhere in the world."""


class MotorMode(IntEnum):
    """Mode of a joint's motor."""

    OFF = 0
    EFFORT = 1
    """Its effort is the target (N m, N)."""
    VELOCITY = 2
    """It holds the target velocity (rad/s, m/s) with as much effort as it takes."""
    POSITION = 3
    """Its effort is `stiffness` times the way to the target (rad, m) less `damping` times the velocity."""


@dataclass(frozen=True, slots=True, eq=False)
class BodyShape:
    """One shape of a body; `body_t_shape` (4, 4) is its pose in the body."""

    kind: ShapeKind
    size: tuple[float, ...] = ()
    body_t_shape: Floats = field(default_factory=lambda: np.eye(4))
    vertices: Floats | None = None
    """(n, 3) in meters, of a hull."""
    heights: Floats | None = None
    """(rows, columns) in meters along z, rows along y and columns along x, about the origin.

    Each cell is two triangles, parted from its corner of least x and y to the opposite one.
    """


@dataclass(frozen=True, slots=True)
class Surface:
    """Surface of a body.

    Of two that touch, the one with the smaller sliding friction says how they rub, if the engine can do so; engines
    that join both in another way say it. What stiffness and damping become, each engine says too.
    """

    friction: float = 0.5
    """Coefficient of sliding friction (mu)."""
    spinning: float = 0.0
    """Coefficient of the torque against spinning about the normal, per normal force (m)."""
    rolling: float = 0.0
    """Coefficient of the torque against rolling, per normal force (m)."""
    restitution: float = 0.0
    """Speed after a normal impact as a part of that before, 0 to 1."""
    stiffness: float = 0.0
    """Stiffness of a contact (N/m); 0: as stiff as the engine likes."""
    damping: float = 0.0
    """Damping of a contact (N s/m); counts with `stiffness` alone."""


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One rigid body. Moments of inertia are about the center of mass, in the axes of the body."""

    name: str
    parent: int = WORLD
    """Row of the body that it hangs on, which comes before it; WORLD for one that is free, driven or fixed to it."""
    joint: BodyJoint = BodyJoint.FIXED
    parent_t_body: Floats = field(default_factory=lambda: np.eye(4))
    """(4, 4) its pose in its parent where the joint is at 0; not counted for one that is free."""
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Unit vector in the body's frame, of a joint that turns or slides."""
    driven: bool = False
    """True for a free body that is moved from outside and yields to nothing; nothing hangs on it by a joint."""
    mass: float = 0.0
    """In kg: above 0 for what a joint moves, except driven bodies; 0 where it has none."""
    center_of_mass: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """In the body's frame (m)."""
    inertia: Floats = field(default_factory=lambda: np.zeros((3, 3)))
    """(3, 3) in kg m^2: positive definite, no moment above the sum of the others; 0 where it has no mass."""
    lower: float = -np.inf
    upper: float = np.inf
    """Limits of the joint (rad, m)."""
    shapes: tuple[BodyShape, ...] = ()
    surface: Surface = Surface()


@dataclass(frozen=True, slots=True)
class Coupling:
    """Gear between two joints that turn or slide: q of the follower = ratio * q of the leader + offset.

    Both ways: what holds the follower up loads the leader. A follower's own motor adds to that of its leader.
    """

    follower: int
    """Row of the body whose joint follows; it follows one, and leads none."""
    leader: int
    """Row of the body whose joint it follows."""
    ratio: float = 1.0
    """Not 0; in rad or m of the follower for each of the leader."""
    offset: float = 0.0
    """In rad or m."""


@dataclass(frozen=True, slots=True, eq=False)
class PhysicsModel:
    """Bodies of a scene, parents first. Those of one tree do not touch each other, nor do those that nothing moves.

    Trees whose joints are coupled count as one.

    A body that is free and not driven has 7 coordinates in q: x, y, z of its origin in the world (m) and a unit
    quaternion x, y, z, w; and 6 in v: the velocity of its origin in the axes of the world (m/s), and the angular
    velocity in its own axes (rad/s). A joint that turns or slides has one in each. Bodies come in the order of rows;
    driven ones and fixed ones have none.
    """

    bodies: tuple[Body, ...]
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    """In the world (m/s^2)."""
    seconds: float = 0.001
    """Length of a substep."""
    couplings: tuple[Coupling, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Driven:
    """Poses and velocities of the k driven bodies, in the order of rows."""

    poses: Floats
    """(k, 7) at the end of the step, as in q."""
    twists: Floats
    """(k, 6) velocities during the step, as in v; a belt that stands has one too."""


@dataclass(frozen=True, slots=True, eq=False)
class Motors:
    """Settings of the motors of the m joints that turn or slide, for one step, in the order of rows: arrays (m,)."""

    mode: Integers
    """Values of MotorMode."""
    target: Floats
    stiffness: Floats
    """N m/rad, N/m; 0 or more; of the mode POSITION."""
    damping: Floats
    """N m s/rad, N s/m; 0 or more. Of the mode VELOCITY a hint for engines without exact motors; 0: none."""
    max_effort: Floats
    """Largest effort (N m, N), 0 or more; inf where there is no limit."""


@dataclass(frozen=True, slots=True, eq=False)
class TouchingBodies:
    """The c contacts of the last substep."""

    bodies: Integers
    """(c, 2) rows of the two bodies."""
    positions: Floats
    """(c, 3) in the world (m)."""
    normals: Floats
    """(c, 3) unit vectors in the world, from the first to the second."""
    forces: Floats
    """(c, 3) on the second body, in the world (N)."""


@dataclass(frozen=True, slots=True, eq=False)
class Stepped:
    """State that a step has led to, and the forces of its end."""

    q: Floats
    v: Floats
    contacts: TouchingBodies
    efforts: Floats
    """(m,) of the motors in the last substep (N m, N)."""


class PhysicsEngine(Protocol):
    """A physics engine. The world owns q and v; an engine is asked for the next ones. One thread calls it.

    Equal calls since `load` give equal bits, in another process too, and so do equal calls since `set_state`: nothing
    that is hidden lives on beyond it. What comes out is finite, or an exception that is no ArgumentError.
    """

    def load(self, model: PhysicsModel, q: Floats, v: Floats, /) -> None:
        """Take a model, in place of the one before, and the state that it is in.

        Raises ArgumentError for a body that cannot be as it says, by its name, and for other shapes of arrays.
        """
        ...

    def set_state(self, q: Floats, v: Floats, /) -> None:
        """Take another state of the model that is loaded, and forget all that came before.

        Raises ArgumentError for other shapes of arrays, for values that are not finite and for a quaternion that has
        not length 1 (to 1e-6).
        """
        ...

    def step(self, driven: Driven, motors: Motors, wrenches: Floats | None, substeps: int, /) -> Stepped:
        """Return the state after `substeps` (1 or more) substeps.

        `wrenches` (b, 6) act on the b bodies meanwhile: force (N) at the center of mass and torque (N m), both in the
        world; None: nothing acts. Raises ArgumentError for other shapes of arrays and values that make no sense; the
        state is the same then as before. Raises any other error where the state is no longer finite.
        """
        ...


def places(bodies: Sequence[Body]) -> tuple[Integers, Integers]:
    """Return where in q and in v (n,) the coordinates of each body begin; -1 for those without."""
    q_start, v_start = np.full(len(bodies), -1, np.int32), np.full(len(bodies), -1, np.int32)
    q = v = 0
    for row, body in enumerate(bodies):
        if body.joint is BodyJoint.FIXED or body.driven:
            continue
        q_start[row], v_start[row] = q, v
        q, v = (q + 7, v + 6) if body.joint is BodyJoint.FREE else (q + 1, v + 1)
    return q_start, v_start


def sizes(bodies: Sequence[Body]) -> tuple[int, int]:
    """Return how many coordinates and how many velocities bodies have."""
    moving = [body.joint is BodyJoint.FREE for body in bodies if body.joint is not BodyJoint.FIXED and not body.driven]
    return sum(7 if free else 1 for free in moving), sum(6 if free else 1 for free in moving)


def jointed(bodies: Sequence[Body]) -> tuple[int, ...]:
    """Return the rows of the bodies whose joints turn or slide, those that have motors."""
    return tuple(row for row, body in enumerate(bodies) if body.joint in (BodyJoint.REVOLUTE, BodyJoint.PRISMATIC))


def roots(model: PhysicsModel) -> tuple[int, ...]:
    """Return for each body the row of the one that its tree begins with; trees that are coupled are one."""
    found: list[int] = []
    for row, body in enumerate(model.bodies):
        found.append(row if body.parent == WORLD else found[body.parent])
    for one in model.couplings:
        first, last = sorted((found[one.follower], found[one.leader]))
        found = [first if root == last else root for root in found]
    return tuple(found)


def motors_off(count: int) -> Motors:
    """Return motors of `count` joints that do nothing."""
    zeros = np.zeros(count)
    return Motors(np.zeros(count, np.int32), zeros, zeros, zeros, np.full(count, np.inf))
